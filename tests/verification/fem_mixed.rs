//! Problem: a strip, periodic along x and clamped below, whose upper edge moves sideways by d under a pressure p.
//! Exact: a homogeneous state with the shear stress G d/H and the confined strain e = -p/M. The edge sinks by p H/M. The force of
//! the drive is G d/H times the area along x, and 0 along y.
//! Source: Hooke's law, G = E/(2 (1 + nu)), M = E (1 - nu)/((1 + nu)(1 - 2 nu)).
//! Tolerance: 1e-6, the rest of the damped first oscillation after 40 of its periods.

use protocol::Node;
use serde_json::{Value, json};

use crate::fem_bodies::{confined_modulus, node, reported, setting, window, with};

const WIDTH: f64 = 4e-3;
const HEIGHT: f64 = 2e-3;
const SHIFT: f64 = 1e-6;
const PRESSURE: f64 = 5e7;
/// Mass damping (1/s).
const DRAG: f64 = 2e6;

fn strip(top: Value) -> Value {
    json!({
        "mesh": {"width_m": WIDTH, "height_m": HEIGHT, "size_m": 5e-4, "periodic_x": true},
        "material": {"young_pa": 102.5e9, "poisson": 0.3, "density_kg_per_m3": 7800.0},
        "time": {"step_s": "auto", "damping": 0.5, "mass_damping_per_s": DRAG},
        "boundary": {"top": top},
    })
}

/// Runs the strip to 40 us under the load and this motion, both with a ramp of 10 us. Returns the time (s), the mean displacement of
/// the edge along y (m) and the force of the drive (N).
fn pressed_while(motion: Value) -> (f64, f64, [f64; 2]) {
    let traction = json!({"traction_pa": ["free", -PRESSURE], "ramp_s": 1e-5});
    let mut strip = node(&strip(with(motion, traction)));
    let step = strip.model.scheme.step;
    let steps = (40e-6 / step).round() as u32;
    let report = strip.advance_alone(&window(0, steps)).expect("stable");
    let signal = |name| reported(&strip, &report, name);
    let force = ["top_reaction_x_n", "top_reaction_y_n"].map(signal);
    (f64::from(steps) * step, signal("surface_mean_uy_m"), force)
}

fn near(value: f64, exact: f64) {
    assert!(
        (value / exact - 1.0).abs() < 1e-6,
        "{value:e} against {exact:e}"
    );
}

#[test]
fn a_set_takes_a_motion_in_one_direction_and_a_load_in_the_other() {
    let sunk = -PRESSURE * HEIGHT / confined_modulus();
    let shear = |shift: f64| 102.5e9 / 2.6 * shift / HEIGHT * WIDTH * 1e-3;

    let (_, uy, [fx, fy]) = pressed_while(json!({"displacement_m": [SHIFT, "free"]}));
    near(uy, sunk);
    near(fx, shear(SHIFT));
    assert_eq!(fy, 0.0, "nothing holds it in y");

    let speed = 0.03;
    let (t, uy, [fx, _]) = pressed_while(json!({"velocity_m_per_s": [speed, "free"]}));
    near(uy, sunk);
    // Mass damping drags the three rows between, which move with y/H of the speed. The edge's part of the drag is c v sum m (y/H)^2.
    let row = 7800.0 * WIDTH * 1e-3 * HEIGHT / 4.0;
    let drag = DRAG * speed * row * [0.25_f64, 0.5, 0.75].map(|y| y * y).iter().sum::<f64>();
    near(fx, shear(speed * (t - 5e-6)) + drag);
}

#[test]
fn a_direction_has_one_condition() {
    let cases = [
        (
            json!({"traction_pa": [0.0, -1e6], "velocity_m_per_s": [1.0, "free"]}),
            "a motion in x",
        ),
        (
            json!({"traction_pa": ["free", -1e6], "displacement_m": ["free", 0.0]}),
            "a motion in y",
        ),
        (
            json!({"pressure_pa": 1e6, "velocity_m_per_s": [1.0, "free"]}),
            "a pressure and a motion",
        ),
        (
            json!({"velocity_m_per_s": [1.0, "free"], "displacement_m": [0.0, "free"]}),
            "exactly one load or motion",
        ),
        (
            json!({"traction_pa": [1.0, 0.0], "pressure_pa": 1e6}),
            "exactly one load or motion",
        ),
        (json!({"ramp_s": 1.0}), "exactly one load or motion"),
    ];
    for (top, word) in cases {
        let error = fem_node::check(&strip(top), &setting(1)).expect_err(word);
        assert_eq!(error.key, "boundary.top");
        assert!(error.problem.contains(word), "{}", error.problem);
    }
}
