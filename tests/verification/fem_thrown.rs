//! Problem: a laterally held elastic bar thrown against a stop.
//!
//! ```text
//!   top     .-.
//!           | |  | v       H = 20 mm, c = sqrt(M/rho), M the confined modulus
//!   bottom  '-'  v
//!           === stop       held in y from t = 0 on
//! ```
//!
//! Exact (Saint-Venant; d'Alembert's waves): from the stop a front runs up at c. Behind it the bar is at rest under the stress
//! rho c v. The front returns from the free top as a release and reaches the stop at 2 H/c. The middle moves with -v until H/2c,
//! rests until 3 H/2c, and then moves with +v. The stop pushes with rho c v times the area until 2 H/c.
//!
//! A block without supports keeps its initial velocity, and no energy changes.
//!
//! Tolerance: 200 elements without numerical damping spread a front over some 200^(1/3) = 6 elements, 3 % of H/c. Means over
//! intervals that end a tenth of H/c away from fronts keep a ripple of 1 %. Rigid motion: rounding.

use fem_node::FemNode;
use protocol::{FaultCode, Node, NodeError};
use serde_json::{Value, json};

use crate::fem_bodies::{
    block, confined_modulus, node, node_on, reported, setting, strip, window, with,
};
use crate::fem_wheel::balance;

const HEIGHT: f64 = 20e-3;
const SIZE: f64 = 1e-4;
const SPEED: f64 = 2.0;

/// Travel time of a wave from one end to the other (s).
fn passage() -> f64 {
    HEIGHT / (confined_modulus() / 7800.0).sqrt()
}

fn thrown() -> FemNode {
    node(&with(
        strip(SIZE, HEIGHT, SIZE),
        json!({
            "base": "free",
            "initial": {"body": {"velocity_m_per_s": [0.0, -SPEED]}},
            "boundary": {"bottom": {"velocity_m_per_s": ["free", 0.0]}},
            // The probe is between nodes in both directions.
            "probes": [{"name": "middle", "x_m": 0.3 * SIZE, "y_m": -100.4 * SIZE}],
        }),
    ))
}

/// Mean of a signal between two times (s).
fn mean_between(name: &str, [from, until]: [f64; 2]) -> f64 {
    let mut bar = thrown();
    let step = bar.model.scheme.step;
    let (mut sum, mut count) = (0.0, 0.0);
    for index in 0..(until / step) as u64 {
        let report = bar.advance_alone(&window(index, 1)).expect("stable");
        assert!(balance_of(&bar, &report) < 1e-10);
        if index as f64 * step >= from {
            sum += reported(&bar, &report, name);
            count += 1.0;
        }
    }
    sum / count
}

/// |dE| over the initial energy; no force does work.
fn balance_of(bar: &FemNode, report: &[f64]) -> f64 {
    let start = 0.5 * 7800.0 * SIZE * HEIGHT * 1e-3 * SPEED * SPEED;
    let sum: f64 = ["strain", "kinetic", "numerical_loss"]
        .map(|name| reported(bar, report, name))
        .iter()
        .sum();
    sum.abs() / start
}

#[test]
fn a_thrown_bar_stops_and_rebounds_with_its_waves() {
    let t = passage();
    for (from, until, velocity) in [(0.0, 0.4, -1.0), (0.65, 1.35, 0.0), (1.65, 2.0, 1.0)] {
        let mean = mean_between("middle_vy_m_per_s", [from * t, until * t]);
        assert!(
            (mean / SPEED - velocity).abs() < 0.02,
            "{from} to {until}: {mean}"
        );
    }
    let exact = confined_modulus() * SPEED * t / HEIGHT * SIZE * 1e-3;
    let push = mean_between("bottom_reaction_y_n", [0.1 * t, 1.9 * t]);
    assert!((push / exact - 1.0).abs() < 0.01, "{push} against {exact}");
    let after = mean_between("middle_uy_m", [t, 1.3 * t]);
    // The probe is 100.4 of 200 elements from the top and moves until the front arrives.
    let moved = -SPEED * t * 99.6 / 200.0;
    assert!(
        (after / moved - 1.0).abs() < 0.01,
        "{after} against {moved}"
    );
}

#[test]
fn the_last_reaction_is_a_result_and_survives_a_checkpoint() {
    let (mut bar, mut resumed) = (thrown(), thrown());
    for index in 0..40 {
        bar.advance_alone(&window(index, 5)).expect("stable");
    }
    let state = bar.checkpoint().expect("it is a state");
    resumed.restore(&state).expect("of the same bar");
    let report = bar.advance_alone(&window(40, 5)).expect("stable");
    assert_eq!(
        report,
        resumed.advance_alone(&window(40, 5)).expect("stable")
    );
    let results = [bar, resumed].map(|mut bar| bar.finish().expect("it ends").results);
    assert_eq!(results[0], results[1]);
    let names: Vec<&str> = results[0].keys().map(String::as_str).collect();
    assert!(names.contains(&"bottom_reaction_y_n") && !names.contains(&"top_reaction_y_n"));
    assert!(results[0]["bottom_reaction_y_n"] > 0.0);
}

/// The distance (m) that a body of 12 mm travels in windows of 300 steps, some 12 us each, or its fault.
fn flight(change: Value, threads: usize) -> Result<f64, NodeError> {
    let mut body = node_on(
        &with(with(block(), json!({"base": "free"})), change),
        threads,
    );
    let distance = |body: &FemNode| body.state().u[body.model.body.layout.index([6, 3], 0)].abs();
    for index in 0..20 {
        body.advance_alone(&window(index, 300))?;
    }
    // A checkpoint collects the state from the threads.
    body.checkpoint()?;
    Ok(distance(&body))
}

#[test]
fn a_body_may_travel_farther_than_its_size() {
    let thrown = json!({"initial": {"body": {"velocity_m_per_s": [300.0, -20.0]}}});
    let carried = json!({"boundary": {"left": {"velocity_m_per_s": [300.0, 0.0], "ramp_s": 3e-5}}});
    let turning = json!({"kinematics": "corotational"});
    for (change, threads) in [
        (thrown.clone(), 1),
        (thrown.clone(), 2),
        (with(thrown.clone(), turning), 1),
        (carried, 1),
    ] {
        let distance = flight(change.clone(), threads).expect("it is stable");
        assert!(distance > 2.0 * 12e-3, "{change}: {distance}");
    }
    let auto = node(&with(block(), json!({"base": "free"})));
    let step = 1.02 * auto.model.step_limit;
    let unstable = json!({"time": {"step_s": step, "unsafe_step": true},
                          "boundary": {"top": {"traction_pa": [0.0, -1e5]}}});
    for threads in [1, 2] {
        let error = flight(with(thrown.clone(), unstable.clone()), threads);
        assert_eq!(error.expect_err("it is unstable").code, FaultCode::Diverged);
    }
}

#[test]
fn a_free_block_keeps_its_initial_velocity() {
    let velocity = [3.0, -2.0];
    let material = json!({"yield_pa": 1e5});
    for material in [json!({}), material] {
        let mut body = node(&with(
            block(),
            json!({"base": "free", "material": material,
                   "initial": {"body": {"velocity_m_per_s": velocity}}}),
        ));
        let report = body.advance_alone(&window(0, 200)).expect("stable");
        let t = 200.0 * body.model.scheme.step;
        let layout = body.model.body.layout;
        for node in body.model.mesh.nodes() {
            for (k, velocity) in velocity.iter().enumerate() {
                let moved = body.state().u[layout.index(node, k)];
                assert!(
                    (moved - velocity * t).abs() < 1e-12 * t,
                    "{node:?} {moved:e}"
                );
            }
        }
        for name in ["strain", "kinetic"] {
            assert!(reported(&body, &report, name).abs() < 1e-12, "{name}");
        }
        assert!(balance(&body, &report).is_nan() || balance(&body, &report) < 1e-9);
    }
}

/// The velocity of a set overrides the body's.
#[test]
fn a_set_has_its_own_initial_velocity() {
    let config = with(
        block(),
        json!({"base": "free", "initial": {"body": {"velocity_m_per_s": [1.0, 0.0]},
                                           "top": {"velocity_m_per_s": [0.0, 5.0]}}}),
    );
    let body = node(&config);
    let v = |node, k| body.state().v[body.model.body.layout.index(node, k)];
    assert_eq!([v([3, 0], 0), v([3, 0], 1)], [0.0, 5.0]);
    assert_eq!([v([3, 1], 0), v([3, 1], 1)], [1.0, 0.0]);
}

#[test]
fn impossible_velocities_and_probes_are_refused_by_name() {
    let thrown = |set: &str| json!({"initial": {set: {"velocity_m_per_s": [1.0, 0.0]}}});
    let probe = |name: &str, y: f64| json!({"name": name, "x_m": 0.0, "y_m": y});
    let cases: [(Value, &str, &str); 9] = [
        (thrown("roof"), "initial.roof", "not a set of the mesh"),
        (thrown("bottom"), "initial.bottom", "supports"),
        (
            json!({"initial": {"top": {"velocity_m_per_s": [1.0, 0.0]},
                               "left": {"velocity_m_per_s": [2.0, 0.0]}}}),
            "initial.top",
            "another velocity",
        ),
        (
            with(thrown("top"), json!({"analysis": "static"})),
            "initial.top",
            "static",
        ),
        (
            with(
                thrown("top"),
                json!({"contact": {"friction": 0.0},
                       "wheel": {"load_n": 1.0, "mass_kg": 1.0, "ramp_s": 0.0, "hold_s": 1e-6}}),
            ),
            "initial.top",
            "wheel",
        ),
        (
            json!({"probes": [probe("p", -1e-3), probe("q", 1e-3)]}),
            "probes[1].x_m",
            "outside",
        ),
        (
            json!({"probes": [probe("p", -1e-3), probe("p", -2e-3)]}),
            "probes[1].name",
            "another probe",
        ),
        (
            json!({"probes": [probe("p q", -1e-3)]}),
            "probes[0].name",
            "begin the name of a signal",
        ),
        (
            json!({"probes": [probe("surface_mean", -1e-3)]}),
            "probes[0].name",
            "name of another signal",
        ),
    ];
    for (change, key, word) in cases {
        let error = fem_node::check(&with(block(), change), &setting(1)).expect_err(key);
        assert_eq!(error.key, key);
        let text = format!("{} {}", error.problem, error.help.unwrap_or_default());
        assert!(text.contains(word), "{key}: {text}");
    }
}
