//! Problem: configurations and requests that make no sense.
//! Exact: each is refused, naming the key or the set, with what to do about it.
//! Source: the documented range of each key.
//! Tolerance: none.

use protocol::{FaultCode, Node};
use serde_json::{Value, json};

use crate::fem_bodies::{block, node, setting, window, with};

fn refused(change: Value) -> protocol::ConfigError {
    let config = with(block(), change);
    fem_node::check(&config, &setting(1)).expect_err("it makes no sense")
}

/// A wheel with friction, and these of its keys changed.
fn wheel(change: Value) -> Value {
    let plain = json!({"load_n": 1.0, "mass_kg": 0.01, "ramp_s": 1e-4, "hold_s": 1e-4});
    json!({"contact": {"friction": 0.3}, "wheel": with(plain, change)})
}

/// The same in a static analysis.
fn still(change: Value, statics: Value) -> Value {
    with(
        wheel(change),
        json!({"analysis": "static", "statics": statics}),
    )
}

#[test]
fn every_number_out_of_range_is_refused_by_its_key() {
    let cases = [
        ("mesh.size_m", json!({"mesh": {"size_m": -1e-4}})),
        ("mesh.size_m", json!({"mesh": {"size_m": 1e-9}})),
        ("mesh.width_m", json!({"mesh": {"width_m": 0.0}})),
        ("mesh.height_m", json!({"mesh": {"height_m": -1.0}})),
        (
            "mesh.fine_width_m",
            json!({"mesh": {"fine_width_m": 3.1e-3}}),
        ),
        ("mesh.fine_depth_m", json!({"mesh": {"fine_depth_m": 0.0}})),
        ("mesh.side_columns", json!({"mesh": {"side_columns": 40}})),
        ("mesh.depth_rows", json!({"mesh": {"depth_rows": 1}})),
        (
            "mesh.crown_radius_m",
            json!({"mesh": {"crown_radius_m": 1e-3}}),
        ),
        (
            "mesh.crown_radius_m",
            json!({"mesh": {"crown_radius_m": -0.3}}),
        ),
        ("material.young_pa", json!({"material": {"young_pa": 0.0}})),
        ("material.poisson", json!({"material": {"poisson": 0.5}})),
        ("material.poisson", json!({"material": {"poisson": -1.0}})),
        (
            "material.density_kg_per_m3",
            json!({"material": {"density_kg_per_m3": -7800.0}}),
        ),
        ("time.damping", json!({"time": {"damping": 0.49}})),
        ("time.damping", json!({"time": {"damping": 1.01}})),
        ("time.step_s", json!({"time": {"step_s": 0.0}})),
        ("time.step_s", json!({"time": {"step_s": 1.0}})),
        ("time.step_s", json!({"time": {"step_s": "fast"}})),
        ("time.safety", json!({"time": {"safety": 1.1}})),
        (
            "time.mass_damping_per_s",
            json!({"time": {"mass_damping_per_s": -1.0}}),
        ),
        (
            "time.stiffness_damping_s",
            json!({"time": {"stiffness_damping_s": -1e-9}}),
        ),
        (
            "time.stiffness_damping_s",
            json!({"time": {"stiffness_damping_s": 1e-9}, "material": {"yield_pa": 1e8}}),
        ),
        (
            "time.stiffness_damping_s",
            json!({"time": {"stiffness_damping_s": 1e-9}, "kinematics": "corotational"}),
        ),
        ("time.end_s", json!({"time": {"end_s": 0.0}})),
        (
            "boundary.top.ramp_s",
            json!({"boundary": {"top": {"traction_pa": [0.0, 1.0], "ramp_s": -1.0}}}),
        ),
        (
            "boundary.tpo",
            json!({"boundary": {"tpo": {"traction_pa": [0.0, 1.0]}}}),
        ),
        (
            "time.start_mass_damping_per_s",
            json!({"time": {"start_mass_damping_per_s": 3e4}}),
        ),
        ("start", json!({"start": "static"})),
        ("start", json!({"start": "slow"})),
        (
            "statics.increment_n",
            json!({"statics": {"increment_n": 0.0}}),
        ),
        (
            "statics.increments_per_cycle",
            json!({"statics": {"increments_per_cycle": 3}}),
        ),
        (
            "boundary.top.ramp_s",
            with(
                wheel(json!({})),
                json!({"start": "static", "boundary": {"top": {"traction_pa": [0.0, 1.0], "ramp_s": 1e-4}}}),
            ),
        ),
        ("wheel", json!({"contact": {"friction": 0.3}})),
        ("wheel.width_m", wheel(json!({"width_m": 1.0}))),
        ("wheel.mass_kg", wheel(json!({"mass_kg": 0.0}))),
        ("wheel.load_n", wheel(json!({"load_n": -1.0}))),
        ("wheel.radius_m", wheel(json!({"radius_m": -0.4}))),
        ("wheel.amplitude_m", wheel(json!({"amplitude_m": -1e-5}))),
        ("wheel.ramp_s", wheel(json!({"ramp_s": -1e-3}))),
        ("wheel.hold_s", wheel(json!({"hold_s": -1e-3}))),
        ("wheel.cycles", wheel(json!({"cycles": -1.0}))),
        (
            "wheel.frequency_hz",
            wheel(json!({"cycles": 1.0, "frequency_hz": 0.0})),
        ),
        ("wheel.radius_m", wheel(json!({"radius_m": 1e-6}))),
        (
            "wheel.frequency_hz",
            wheel(json!({"cycles": 1.0, "frequency_hz": 1e9})),
        ),
        (
            "wheel.cycles",
            still(json!({"cycles": 1e18, "frequency_hz": 1.0}), json!({})),
        ),
        (
            "statics.increments_per_cycle",
            still(
                json!({"cycles": 1.0, "frequency_hz": 1.0}),
                json!({"increments_per_cycle": 4_000_000_000_u32}),
            ),
        ),
        ("contact", with(wheel(json!({})), json!({"contact": null}))),
        (
            "contact.friction",
            with(wheel(json!({})), json!({"contact": {"friction": -0.1}})),
        ),
        (
            "time.end_s",
            with(wheel(json!({})), json!({"time": {"end_s": 1e-3}})),
        ),
        ("element", json!({"element": "q5"})),
        ("mesh.sise_m", json!({"mesh": {"sise_m": 1.0}})),
    ];
    for (key, change) in cases {
        let error = refused(change);
        assert_eq!(error.key, key, "{error}");
    }
}

#[test]
fn a_refusal_says_what_to_do() {
    for change in [
        json!({"mesh": {"size_m": -1e-4}}),
        json!({"mesh": {"side_columns": 40}}),
        json!({"material": {"poisson": 0.5}}),
        json!({"time": {"step_s": 1.0}}),
        json!({"boundary": {"tpo": {"traction_pa": [0.0, 1.0]}}}),
    ] {
        let error = refused(change);
        assert!(error.help.is_some(), "{error}");
    }
}

#[test]
fn thickness_belongs_to_the_checks() {
    let thin = protocol::Setting {
        thickness_m: 0.0,
        ..setting(1)
    };
    let error = fem_node::check(&block(), &thin).expect_err("no thickness, no mass");
    assert_eq!(error.key, "thickness_m");
    let thick = protocol::Setting {
        thickness_m: 1e300,
        ..setting(1)
    };
    let error = fem_node::check(&block(), &thick).expect_err("its mass is no number");
    assert!(error.to_string().contains("run.thickness_m"), "{error}");
}

#[test]
fn requests_that_do_not_fit_are_faults() {
    let mut node = node(&block());
    let code =
        |result: Result<Vec<f64>, protocol::NodeError>| result.expect_err("it does not fit").code;
    assert!(node.couple("bottom").is_err(), "it does not move");
    assert!(node.couple("ballast").is_err(), "there is none");
    let points = node.couple("top").expect("a set").len();
    assert!(node.couple("top").is_err(), "it is coupled already");
    assert!(node.select(&[points]).is_err(), "one too far");
    assert!(node.select(&[1, 1]).is_err(), "twice the same");
    node.select(&[0, 2]).expect("two points");
    assert_eq!(
        code(node.advance(&window(0, 1), &[0.0; 3])),
        FaultCode::Protocol
    );
    assert_eq!(
        code(node.advance(&window(0, 0), &[0.0; 4])),
        FaultCode::Protocol
    );
    assert_eq!(code(node.columns(0)), FaultCode::Protocol);
}
