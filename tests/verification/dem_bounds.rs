//! Bounds on the step and on the keys.
//!
//! t_i = d sqrt(rho/P): d = 2 mm, rho = 7800 kg/m3 x 4, P = 1 MPa give 3.533e-4 s by hand; a step above t_i is refused, and
//! a step above 0.05 t_i raises a warning. The mass scale counts; the wheel's travel per step has its own bound of 0.01 r.

use dem_node::check;
use protocol::Node;
use serde_json::{Value, json};

use crate::dem_support::{build, close, refusal, scene, setting};

const T_I: f64 = 3.532_704_347e-4;

fn one_disk(step_s: f64) -> Value {
    let sample = json!({
        "kind": "disks",
        "disks": [{"x_m": 0.0, "y_m": 1e-3, "radius_m": 1e-3}],
        "walls": [{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}],
    });
    let mut config = scene(
        json!({"kind": "signorini"}),
        step_s,
        sample,
        json!({"mass_scale": 4.0}),
    );
    config["time"]["pressure_pa"] = json!(1e6);
    config
}

#[test]
fn a_step_above_the_inertial_time_is_refused_and_named() {
    let message = refusal(&one_disk(1.01 * T_I));
    assert!(message.contains("inertial time"), "{message}");
    let error = check(&one_disk(1.01 * T_I), &setting(1)).expect_err("check refuses it too");
    assert_eq!(error.key, "time.step_s");

    let mut forced = one_disk(1.01 * T_I);
    forced["time"]["unsafe_step"] = json!(true);
    assert_eq!(build(&forced).describe().step_limit_s, None);
}

#[test]
fn a_step_above_a_twentieth_of_the_inertial_time_raises_a_warning() {
    let below = build(&one_disk(0.049 * T_I)).describe();
    assert!(below.warnings.is_empty(), "{:?}", below.warnings);
    close(
        "limit",
        below.step_limit_s.expect("there is one"),
        T_I,
        1e-9 * T_I,
    );
    let above = build(&one_disk(0.051 * T_I)).describe();
    assert!(above.warnings[0].contains("0.051"), "{:?}", above.warnings);
}

#[test]
fn a_fast_wheel_raises_a_warning() {
    let mut config = one_disk(1e-6);
    config["wheel"] = json!({
        "load_n": 1.0, "mass_kg": 1.0, "amplitude_m": 1e-2, "frequency_hz": 300.0,
        "ramp_s": 1e-3, "hold_s": 1e-3, "cycles": 1.0,
    });
    let warnings = build(&config).describe().warnings;
    assert!(
        warnings.len() == 1 && warnings[0].contains("smallest radius"),
        "{warnings:?}"
    );
}

/// By hand: H = d = 2 mm, V = 2 pi 300 x 0.01 = 18.8496 m/s, rho = 31 200 kg/m3, P = 1 MPa; I = V/H x t_i = 3.329495,
/// rho H (2 pi 300)^2 A = 62.4 x 3 553 057.6 x 0.01 = 2.217108 MPa.
#[test]
fn scaled_masses_are_reported_by_inertial_number_and_pressure() {
    let mut config = one_disk(1e-6);
    config["wheel"] = json!({
        "load_n": 1.0, "mass_kg": 1.0, "amplitude_m": 1e-2, "frequency_hz": 300.0,
        "ramp_s": 1e-3, "hold_s": 1e-3, "cycles": 1.0,
    });
    let results = build(&config).finish().expect("it finishes").results;
    close("I", results["inertial_number"], 3.329495, 1e-5);
    close("pressure", results["inertia_pressure_pa"], 2.217108e6, 1.0);
    config["wheel"]["cycles"] = json!(0.0);
    let still = build(&config).finish().expect("it finishes").results;
    assert!(!still.contains_key("inertial_number"), "nothing moves");
}

#[test]
fn windows_have_the_same_bounds() {
    let mut config = one_disk(1e-6);
    config["time"] = json!({"pressure_pa": 1e6});
    config["sample"]["disks"]
        .as_array_mut()
        .expect("a list")
        .push(json!({"x_m": 5e-3, "y_m": 0.0, "radius_m": 1e-3, "glued": true}));
    let mut dem = build(&config);
    dem.couple("base").expect("it is glued");
    let error = dem
        .set_boundary(1.01 * T_I, &[0.0; 4])
        .expect_err("too long");
    assert!(error.message.contains("inertial time"), "{error}");
    dem.set_boundary(0.06 * T_I, &[0.0; 4])
        .expect("only a warning");
    assert_eq!(dem.describe().warnings.len(), 1);
}

#[test]
fn wrong_keys_are_named_with_their_value() {
    let cases = [
        (
            "/density_kg_per_m3",
            json!(-1.0),
            "density_kg_per_m3: must be above 0, got -1; the key means: Density of the grains (kg/m3)",
        ),
        ("/mass_scale", json!(0.5), "mass_scale: must be at least"),
        (
            "/time/theta",
            json!(0.4),
            "time.theta: must be at least 0.5 and at most 1, got 0.4",
        ),
        (
            "/time/pressure_pa",
            json!(0.0),
            "time.pressure_pa: must be above 0",
        ),
        ("/solver/tolerance", json!(0.0), "solver.tolerance"),
        ("/solver/max_iterations", json!(0), "solver.max_iterations"),
        ("/solver/kind", json!("pgc"), "solver.kind"),
        ("/law/kind", json!("coulomb"), "law.friction"),
        ("/law/friction", json!(0.3), "law.friction"),
        (
            "/sample/disks/0/radius_m",
            json!(0.0),
            "sample.disks[0].radius_m",
        ),
        ("/sample/disks", json!([]), "sample.disks"),
        ("/sample/kind", json!("heap"), "sample"),
        ("/sample/thickness_m", json!(1.0), "sample.thickness_m"),
        (
            "/wheel",
            json!({"load_n": 1.0, "mass_kg": 1.0, "radius_m": -0.4, "ramp_s": 0.0, "hold_s": 0.0}),
            "wheel.radius_m",
        ),
        ("/densty", json!(1.0), "densty"),
    ];
    for (pointer, value, expected) in cases {
        let mut config = one_disk(1e-6);
        let (parent, key) = pointer.rsplit_once('/').expect("pointers begin with /");
        match config.pointer_mut(parent).expect("the parent exists") {
            Value::Array(list) => list[key.parse::<usize>().expect("an index")] = value,
            table => table[key] = value,
        }
        let message = refusal(&config);
        assert!(message.contains(expected), "{pointer}: {message}");
    }
}

/// By hand: L sqrt(2 rho / P) = 8 mm x sqrt(2 x 7.8e6 / 1e9) = 1.0 ms of a cycle of 3.33 ms at a mass scale of 1000, 0.095 cycles at 100.
#[test]
fn grains_too_heavy_to_leave_in_time_are_reported() {
    let advice = |mass_scale: f64, flow: bool| {
        let mut config = scene(
            json!({
                "kind": "cohesion", "friction": 0.3, "contact_stiffness_pa": 2e11, "tangential_stiffness_ratio": 0.5,
                "cn_pa_per_m": 6.4e15, "ct_pa_per_m": 2.56e15, "w_j_per_m2": 156.0, "b_pa_m_s": 0.0, "p": 1.0, "h_prime": "one",
                "alert_m": 8e-6,
            }),
            1e-9,
            json!({
                "kind": "layer", "thickness_m": 1e-3, "half_width_m": 8e-3, "crown_radius_m": 0.3, "radius_min_m": 0.05e-3,
                "radius_max_m": 0.1e-3, "law": "surface_uniform",
            }),
            json!({"mass_scale": mass_scale, "wheel": {
                "load_n": 8000.0, "mass_kg": 0.01, "amplitude_m": 5e-5, "frequency_hz": 300.0, "ramp_s": 1e-3, "hold_s": 1e-3,
                "cycles": 1.0,
            }}),
        );
        config["time"]["pressure_pa"] = json!(1e9);
        if flow {
            config["flow"] = json!({"wear_s": 4e-3});
        }
        let texts = check(&config, &setting(1)).expect("it is valid");
        texts.into_iter().find(|text| text.contains("pressed out"))
    };
    let text = advice(1000.0, true).expect("1.0 ms are 0.30 of a cycle");
    assert!(text.contains("0.30 of a cycle"), "{text}");
    assert_eq!(advice(100.0, true), None);
    assert_eq!(advice(1000.0, false), None);
}
