//! Problem: impossible configurations and requests.
//! Exact: each is refused with the name of the key or the set, and with advice.
//! Source: the documented range of each key.
//! Tolerance: none.

use protocol::{FaultCode, Node};
use serde_json::{Value, json};

use crate::fem_bodies::{block, node, setting, strip, window, with};

fn refused(change: Value) -> kit::ConfigError {
    let config = with(block(), change);
    fem_node::check(&config, &setting(1)).expect_err("it is impossible")
}

/// A wheel with friction and these changes of its keys.
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

/// One key, given by its path, with a value as JSON.
fn change(key: &str, value: &str) -> Value {
    let value = serde_json::from_str(value).expect("the table holds JSON");
    key.rsplit('.')
        .fold(value, |inner, part| json!({ part: inner }))
}

/// Values that a block without a wheel refuses, with any other keys.
const OF_A_BLOCK: &[(&str, &str)] = &[
    ("mesh.size_m", "-1e-4"),
    ("mesh.size_m", "1e-9"),
    ("mesh.width_m", "0.0"),
    ("mesh.height_m", "-1.0"),
    ("mesh.fine_width_m", "3.1e-3"),
    ("mesh.fine_depth_m", "0.0"),
    ("mesh.side_columns", "40"),
    ("mesh.depth_rows", "1"),
    ("mesh.crown_radius_m", "1e-3"),
    ("mesh.crown_radius_m", "-0.3"),
    ("mesh.sise_m", "1.0"),
    ("material.young_pa", "0.0"),
    ("material.poisson", "0.5"),
    ("material.poisson", "-1.0"),
    ("material.density_kg_per_m3", "-7800.0"),
    ("time.damping", "0.49"),
    ("time.damping", "1.01"),
    ("time.step_s", "0.0"),
    ("time.step_s", "1.0"),
    ("time.step_s", "\"fast\""),
    ("time.safety", "1.1"),
    ("time.mass_damping_per_s", "-1.0"),
    ("time.start_mass_damping_per_s", "3e4"),
    ("time.stiffness_damping_s", "-1e-9"),
    ("time.end_s", "0.0"),
    ("boundary.tpo", r#"{"traction_pa": [0.0, 1.0]}"#),
    ("start", "\"static\""),
    ("start", "\"slow\""),
    ("statics.increment_n", "0.0"),
    ("statics.increments_per_cycle", "3"),
    ("element", "\"q5\""),
];

/// Values that a block under a wheel refuses.
const OF_A_WHEEL: &[(&str, &str)] = &[
    ("wheel.width_m", "1.0"),
    ("wheel.mass_kg", "0.0"),
    ("wheel.load_n", "-1.0"),
    ("wheel.radius_m", "-0.4"),
    ("wheel.radius_m", "1e-6"),
    ("wheel.amplitude_m", "-1e-5"),
    ("wheel.ramp_s", "-1e-3"),
    ("wheel.hold_s", "-1e-3"),
    ("wheel.cycles", "-1.0"),
    ("wheel.load_table", "[]"),
    ("wheel.load_table", "[[1e-4, 1.0], [0.0, 1.0]]"),
    ("wheel.load_table", "[[0.0, -1.0], [1e-4, 1.0]]"),
    ("wheel.load_table", "[[0.0, 0.0], [4e-4, 1.0]]"),
    ("contact", "null"),
    ("contact.friction", "-0.1"),
    ("time.end_s", "1e-3"),
];

fn refused_by_key(key: &str, change: Value) {
    let error = refused(change);
    assert_eq!(error.key, key, "{error}");
}

#[test]
fn every_number_out_of_range_is_refused_by_its_key() {
    for (key, value) in OF_A_BLOCK {
        refused_by_key(key, change(key, value));
    }
    for (key, value) in OF_A_WHEEL {
        refused_by_key(key, with(wheel(json!({})), change(key, value)));
    }
}

#[test]
fn keys_of_a_body_that_contradict_each_other_are_refused() {
    let damped = |other: Value| with(json!({"time": {"stiffness_damping_s": 1e-9}}), other);
    let pressed =
        |ramp_s: f64| json!({"boundary": {"top": {"traction_pa": [0.0, 1.0], "ramp_s": ramp_s}}});
    let at_rest = with(wheel(json!({})), json!({"start": "static"}));
    let table = json!({"load_table": [[0.0, 0.0], [1e-4, 1.0]]});
    let cases = [
        (
            "time.stiffness_damping_s",
            damped(json!({"material": {"yield_pa": 1e8}})),
        ),
        (
            "time.stiffness_damping_s",
            damped(json!({"kinematics": "corotational"})),
        ),
        ("boundary.top.ramp_s", pressed(-1.0)),
        ("boundary.top.ramp_s", with(at_rest, pressed(1e-4))),
        ("wheel", json!({"contact": {"friction": 0.3}})),
        ("wheel.load_table", still(table.clone(), json!({}))),
        (
            "wheel.load_table",
            with(wheel(table), json!({"start": "static"})),
        ),
    ];
    for (key, change) in cases {
        refused_by_key(key, change);
    }
}

#[test]
fn impossible_cycles_of_a_wheel_are_refused() {
    let cycles = |cycles: f64, hz: f64| json!({"cycles": cycles, "frequency_hz": hz});
    let increments = json!({"increments_per_cycle": 4_000_000_000_u32});
    let cases = [
        ("wheel.frequency_hz", wheel(cycles(1.0, 0.0))),
        ("wheel.frequency_hz", wheel(cycles(1.0, 1e9))),
        ("wheel.cycles", still(cycles(1e18, 1.0), json!({}))),
        (
            "statics.increments_per_cycle",
            still(cycles(1.0, 1.0), increments),
        ),
    ];
    for (key, change) in cases {
        refused_by_key(key, change);
    }
}

#[test]
fn a_refusal_gives_advice() {
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
    let error = fem_node::check(&block(), &thin).expect_err("it has no mass");
    assert_eq!(error.key, "thickness_m");
    let thick = protocol::Setting {
        thickness_m: 1e300,
        ..setting(1)
    };
    let error = fem_node::check(&block(), &thick).expect_err("its mass is infinite");
    assert!(error.to_string().contains("run.thickness_m"), "{error}");
}

#[test]
fn requests_that_do_not_fit_are_faults() {
    let mut node = node(&block());
    let code =
        |result: Result<Vec<f64>, protocol::NodeError>| result.expect_err("it does not fit").code;
    assert!(node.couple("bottom").is_err(), "it does not move");
    assert!(node.couple("ballast").is_err(), "there is no such set");
    let points = node.couple("top").expect("a set").len();
    assert!(node.select(&[points]).is_err(), "one too far");
    let again = node.couple("top").expect("the set may have another layer");
    assert_eq!(again.len(), points);
    assert!(node.select(&[2 * points]).is_err(), "one too far");
    assert!(node.select(&[1, 1]).is_err(), "twice the same");
    node.select(&[0, points + 2])
        .expect("two points, one of each layer");
    assert_eq!(
        code(node.advance(&window(0, 1), &[0.0; 3])),
        FaultCode::Protocol
    );
    assert_eq!(
        code(node.advance(&window(0, 0), &[0.0; 4])),
        FaultCode::Protocol
    );
    assert_eq!(code(node.columns(&window(0, 0))), FaultCode::Protocol);
}

/// The strip with these keys of a set: rollers hold its `bottom` along y, `fixed_x` its sides along x.
fn held(set: &str, keys: Value) -> Value {
    with(
        strip(4e-3, 4e-3, 1e-3),
        json!({"boundary": {set: keys}, "time": {"end_s": 1e-4}}),
    )
}

#[test]
fn motions_and_loads_of_held_sets_are_refused_by_their_key() {
    let motion = json!({"motion": {"amplitude_m": 1e-5, "frequency_hz": 1e5}});
    let table = json!({"motion_table": [[0.0, 0.0, "free"], [1e-5, 1e-6, "free"]]});
    let force = json!({"load_table": [[0.0, 0.0], [1e-5, 1.0]], "load_direction": [1.0, 0.0]});
    let cases = [
        ("left.motion", motion),
        ("left.motion_table", table),
        (
            "left.velocity_m_per_s",
            json!({"velocity_m_per_s": [1.0, "free"]}),
        ),
        (
            "left.displacement_m",
            json!({"displacement_m": [1e-6, "free"], "ramp_s": 1e-5}),
        ),
        (
            "bottom.velocity_m_per_s",
            json!({"velocity_m_per_s": ["free", 1.0]}),
        ),
        ("left.traction_pa", json!({"traction_pa": [1e8, 1e8]})),
        ("left.pressure_pa", json!({"pressure_pa": 1e8})),
        ("left.load_table", force),
        (
            "top.velocity_m_per_s",
            json!({"velocity_m_per_s": ["free", "free"]}),
        ),
        (
            "top.displacement_m",
            json!({"displacement_m": ["free", "free"]}),
        ),
        ("top.ramp_s", json!({"displacement_m": ["free", 1e-6]})),
    ];
    for (key, keys) in cases {
        let set = key.split('.').next().expect("it names a set");
        let error = fem_node::check(&held(set, keys), &setting(1)).expect_err(key);
        assert_eq!(error.key, format!("boundary.{key}"), "{error}");
        let says_so = ["moves no node", "leaves the set free", "missing"];
        assert!(
            says_so.iter().any(|word| error.problem.contains(word)),
            "{error}"
        );
    }
}

/// A set may be held twice, and a corner of a moved edge may be held, which is said.
#[test]
fn a_partly_held_motion_is_a_warning() {
    let warnings = |set: &str, velocity: Value| {
        let keys = json!({"velocity_m_per_s": velocity});
        fem_node::check(&held(set, keys), &setting(1)).expect("it is accepted")
    };
    assert_eq!(warnings("left", json!([0.0, "free"])), [""; 0]);
    assert_eq!(warnings("top", json!(["free", 1.0])), [""; 0]);
    let partly = warnings("top", json!([1.0, "free"]));
    assert!(
        partly[0].contains("hold 2 of the 5 nodes along x"),
        "{partly:?}"
    );
}

#[test]
fn keys_of_another_analysis_are_listed_in_one_warning() {
    let warnings = |change: Value| {
        let config = with(block(), change);
        let all = fem_node::check(&config, &setting(1)).expect("it is accepted");
        let unused = all
            .into_iter()
            .filter(|text| text.contains(": not used in a"));
        unused.collect::<Vec<String>>()
    };
    let time = json!({"time": {"end_s": 1.0, "safety": 0.3, "mass_damping_per_s": 1e5, "start_mass_damping_per_s": 1e5}});
    let unused = warnings(with(still(json!({}), json!({})), time));
    let listed = "time.end_s, time.safety, time.mass_damping_per_s: not used in a static analysis";
    assert!(
        unused.len() == 1 && unused[0].starts_with(listed),
        "{unused:?}"
    );
    let dynamic = warnings(json!({"statics": {"increment_n": 1.0}}));
    assert!(
        dynamic[0].starts_with("statics.increment_n: "),
        "{dynamic:?}"
    );
    let increments = json!({"increment_n": 0.1, "increments_per_cycle": 10});
    let without_cycles = warnings(still(json!({}), increments));
    assert!(
        without_cycles[0].starts_with("statics.increments_per_cycle: "),
        "{without_cycles:?}"
    );
    let cycles = json!({"amplitude_m": 1e-6, "cycles": 1.0, "frequency_hz": 1.0});
    assert_eq!(
        warnings(still(cycles, json!({"increments_per_cycle": 10}))),
        [""; 0]
    );
}
