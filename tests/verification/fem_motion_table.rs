//! Problem: a table or a sine prescribes the motion of a set.
//!
//! ```text
//!   D(t)   __                 D = A sin(2 pi f (t - t_s))
//!  _______/  \___  t          rho c v in a bar until the wave comes back; M A D/L in a slow motion
//! ```
//!
//! Exact: each step ends at the displacement of the table or the sine, in every direction that is not free. On a laterally held
//! bar the drive's force is rho c A times the velocity, c = sqrt(M/rho) (d'Alembert), and its work rho c A times the integral of the
//! squared velocity. In a motion over 400 periods of the bar its force is M A D/L (Hooke), up to (pi/2 (bar's period)/(motion's
//! period))^2 / 3 = 5e-6 from the bar's inertia. A table with the corners of a ramped displacement gives the same bits.
//! Tolerance: rounding of the displacement, 1e-15 of the largest; 1 % for the force behind a front, which ripples as in `fem_motion`,
//! and for the work, which has three fronts; 1e-5 for Hooke; 1e-10 for the balance, as in `fem_energy`.

use std::f64::consts::TAU;

use fem_node::FemNode;
use protocol::{Node, Phase};
use serde_json::{Value, json};

use crate::fem_bodies::{block, confined_modulus, node, reported, setting, strip, window, with};
use crate::fem_wheel::balance;

const HEIGHT: f64 = 20e-3;
const AREA: f64 = 2e-4 * 1e-3;

fn moved(set: &str, by: Value) -> Value {
    json!({"boundary": {set: by}})
}

/// Displacement of a node (column, row) (m).
fn displacement(node: &FemNode, at: [usize; 2]) -> [f64; 2] {
    [0, 1].map(|k| node.state().u[node.model.body.layout.index(at, k)])
}

/// Piecewise linear through (t, x), by the formula of each interval; 0 before the table and constant after it.
fn along(table: &[[f64; 2]], t: f64) -> f64 {
    let pair = table.windows(2).find(|pair| t < pair[1][0]);
    match pair {
        Some([[t0, _], _]) if t < *t0 => 0.0,
        Some([[t0, x0], [t1, x1]]) => x0 + (x1 - x0) * (t - t0) / (t1 - t0),
        _ => table[table.len() - 1][1],
    }
}

#[test]
fn every_step_ends_on_the_table() {
    let x = [[1e-6, 0.0], [3e-6, 2e-6], [4e-6, 2e-6], [9e-6, -1e-6]];
    let y = [[1e-6, 0.0], [3e-6, -1e-6], [4e-6, 3e-6], [9e-6, 0.0]];
    let both: Vec<Value> = x
        .iter()
        .zip(&y)
        .map(|(x, y)| json!([x[0], x[1], y[1]]))
        .collect();
    let only_y: Vec<Value> = y.iter().map(|y| json!([y[0], "free", y[1]])).collect();
    for (table, held) in [(json!(both), true), (json!(only_y), false)] {
        let mut block = node(&with(block(), moved("top", json!({"motion_table": table}))));
        let h = block.model.scheme.step;
        let steps = (11e-6 / h) as u64;
        for index in 0..steps {
            let report = block.advance_alone(&window(index, 1)).expect("stable");
            let t = (index + 1) as f64 * h;
            let [ux, uy] = displacement(&block, [4, 0]);
            assert!(
                (uy - along(&y, t)).abs() < 1e-15 * 3e-6,
                "t = {t:e}: {uy:e}"
            );
            let off = (ux - along(&x, t)).abs();
            assert!(
                (off < 1e-15 * 3e-6) == held || t < 1e-6,
                "t = {t:e}: {ux:e}"
            );
            let force = reported(&block, &report, "top_reaction_x_n");
            assert!(held || force == 0.0, "nothing holds it in x: {force:e}");
            assert!(t < 1.5e-6 || balance(&block, &report) < 1e-10, "t = {t:e}");
        }
    }
}

#[test]
fn every_step_ends_on_the_sine() {
    let (amplitude, frequency, start) = (3e-6, 2e5, 2e-6);
    for (direction, share) in [
        (Value::Null, [Some(1.0), None]),
        (json!([0.0, -2.0]), [Some(0.0), Some(-1.0)]),
        (json!([3.0, 4.0]), [Some(0.6), Some(0.8)]),
    ] {
        let mut motion =
            json!({"amplitude_m": amplitude, "frequency_hz": frequency, "start_s": start});
        if !direction.is_null() {
            motion["direction"] = direction;
        }
        let mut block = node(&with(block(), moved("top", json!({"motion": motion}))));
        let h = block.model.scheme.step;
        for index in 0..400 {
            let report = block.advance_alone(&window(index, 1)).expect("stable");
            let t = (index + 1) as f64 * h;
            let d = amplitude * (TAU * frequency * (t - start).max(0.0)).sin();
            for (u, share) in displacement(&block, [4, 0]).into_iter().zip(share) {
                let off = share.map_or(0.0, |share| (u - share * d).abs());
                assert!(off < 1e-15 * amplitude, "t = {t:e}: {u:e} of {d:e}");
            }
            assert!(
                t < 2.0 * start || balance(&block, &report) < 1e-10,
                "t = {t:e}"
            );
        }
    }
}

/// The end of a bar moves down at 1 m/s for 2 us, rests, and moves on at 0.5 m/s. Its force is rho c A v until the wave comes back.
#[test]
fn the_force_of_the_drive_belongs_to_its_wave() {
    let table = json!([
        [0.0, "free", 0.0],
        [2e-6, "free", -2e-6],
        [4e-6, "free", -2e-6],
        [8e-6, "free", -4e-6]
    ]);
    let mut bar = node(&with(
        strip(2e-4, HEIGHT, 1e-4),
        with(
            json!({"time": {"damping": 0.75}}),
            moved("top", json!({"motion_table": table})),
        ),
    ));
    let h = bar.model.scheme.step;
    let impedance = 7800.0 * (confined_modulus() / 7800.0).sqrt() * AREA;
    let (mut found, mut report) = (Vec::new(), Vec::new());
    for index in 0..(8e-6 / h) as u64 {
        report = bar.advance_alone(&window(index, 1)).expect("stable");
        found.push(reported(&bar, &report, "top_reaction_y_n"));
    }
    // The ripple behind a front decays in about 20 steps.
    for (from, to, speed) in [(0.8e-6, 2e-6, -1.0), (3e-6, 4e-6, 0.0), (5e-6, 8e-6, -0.5)] {
        let range = (from / h) as usize..(to / h) as usize - 1;
        let mean = found[range.clone()].iter().sum::<f64>() / range.len() as f64;
        let off = (mean / impedance - speed).abs();
        assert!(
            off < 1e-2,
            "from {from:e} s: {mean:e} N of {:e}",
            speed * impedance
        );
    }
    let work = reported(&bar, &report, "drive_work");
    let exact = impedance * (1.0 * 2e-6 + 0.25 * 4e-6);
    assert!((work / exact - 1.0).abs() < 1e-2, "{work:e} {exact:e}");
}

/// Damping removes the oscillation of the sudden start. At the fifth quarter of the period the edge is at rest.
#[test]
fn a_bar_in_a_slow_motion_has_hookes_stress() {
    let height = 2e-3;
    let period = 4.0 * height / (confined_modulus() / 7800.0).sqrt();
    let (amplitude, slow) = (1e-6, 400.0 * period);
    let mut bar = node(&with(
        strip(2e-4, height, 1e-4),
        with(
            json!({"time": {"damping": 0.5, "stiffness_damping_s": 2e-8}}),
            moved(
                "top",
                json!({"motion": {"amplitude_m": amplitude, "frequency_hz": 1.0 / slow,
                                           "direction": ["free", -1.0]}}),
            ),
        ),
    ));
    let h = bar.model.scheme.step;
    let quarter = (0.25 * slow / h).round() as u32;
    let report = bar.advance_alone(&window(0, 5 * quarter)).expect("stable");
    let t = f64::from(5 * quarter) * h;
    let d = -amplitude * (TAU * t / slow).sin();
    let exact = confined_modulus() * AREA * d / height;
    let force = reported(&bar, &report, "top_reaction_y_n");
    assert!((force / exact - 1.0).abs() < 1e-5, "{force:e} {exact:e}");
    assert!(balance(&bar, &report) < 1e-10);
}

#[test]
fn a_table_with_the_corners_of_a_ramp_has_the_same_bits() {
    let life = |top: Value| {
        let mut block = node(&with(block(), moved("top", top)));
        for index in 0..20 {
            block.advance_alone(&window(index, 7)).expect("stable");
        }
        (block.state().clone(), *block.ledger())
    };
    // An interval from 0 to 1 m gives the same bits as a ramp's share.
    let ramp = life(json!({"displacement_m": [0.0, 1.0], "ramp_s": 2.0}));
    let table = life(json!({"motion_table": [[0.0, 0.0, 0.0], [2.0, 0.0, 1.0]]}));
    assert_eq!(ramp, table);
}

#[test]
fn a_load_acts_in_the_direction_that_a_motion_over_time_leaves_free() {
    let load = json!({"load_table": [[0.0, 0.0], [1e-6, -40.0]]});
    let sine = json!({"motion": {"amplitude_m": 1e-6, "frequency_hz": 1e5, "start_s": 3e-6}});
    let table = json!({"motion_table": [[3e-6, 0.0, "free"], [5e-6, 1e-6, "free"]]});
    for motion in [sine, table] {
        let free = json!({"base": "free", "time": {"end_s": 2e-5}});
        let config = with(free, moved("top", with(motion.clone(), load.clone())));
        let mut body = node(&with(block(), config));
        let h = body.model.scheme.step;
        let signals = body.describe().signals;
        let has = |name: &str| signals.iter().any(|signal| signal == name);
        assert!(has("momentum_y_kg_m_per_s") && !has("momentum_x_kg_m_per_s"));
        for index in 0..20 {
            let report = body.advance_alone(&window(index, 10)).expect("stable");
            let t = (10 * (index + 1)) as f64 * h;
            // h sum of ((1-b) F + b F'): the trapezoidal rule plus (b - 1/2) h F. A corner within a step adds an error of up to h^2 F'/8.
            let rise = 0.5 * t.min(1e-6) * t.min(1e-6) / 1e-6 + (t - 1e-6).max(0.0);
            let exact = -40.0 * (rise + 0.25 * h * (t / 1e-6).min(1.0));
            let momentum = reported(&body, &report, "momentum_y_kg_m_per_s");
            let corner = if t < 1e-6 {
                0.0
            } else {
                h * h * 40.0 / 1e-6 / 8.0
            };
            let off = (momentum - exact).abs();
            assert!(
                off <= corner + 1e-13 * 40.0 * t,
                "t = {t:e}: {momentum:e} {exact:e}"
            );
        }
        let report = body.advance_alone(&window(20, 10)).expect("stable");
        assert!(balance(&body, &report) < 1e-10, "{motion}");
    }
}

#[test]
fn keys_over_time_give_the_moments_and_phases_of_a_run() {
    let described = |top: Value| {
        let config = with(json!({"time": {"end_s": 1e-4}}), moved("top", top));
        node(&with(block(), config)).describe()
    };
    let parts = |phases: Vec<Phase>| -> Vec<(String, f64, f64)> {
        phases
            .into_iter()
            .map(|p| (p.name, p.t0_s, p.t1_s))
            .collect()
    };
    let part = |name: &str, t0, t1| (name.to_string(), t0, t1);
    let description = described(json!({"load_table": [[0.0, 0.0], [1e-5, -5.0]],
                                "motion": {"amplitude_m": 1e-6, "frequency_hz": 1e5, "start_s": 3e-5}}));
    let phases = [
        part("ramp", 0.0, 1e-5),
        part("hold", 1e-5, 3e-5),
        part("cycling", 3e-5, 1e-4),
    ];
    assert_eq!(parts(description.phases), phases);
    assert_eq!(description.moments["boundary.top.motion.start_s"], 3e-5);
    let description = described(
        json!({"motion_table": [[0.0, 0.0, 0.0], [2e-5, 1e-6, 0.0], [3e-5, 1e-6, 1e-6], [1.0, 1e-6, 1e-6]]}),
    );
    assert_eq!(
        parts(description.phases),
        [part("ramp", 0.0, 3e-5), part("hold", 3e-5, 1e-4)]
    );
    assert_eq!(description.moments["boundary.top.motion_table"], 3e-5);
}

#[test]
fn impossible_motions_over_time_are_refused_by_their_key() {
    let table = json!([[0.0, 0.0, "free"], [1e-6, 1e-6, "free"]]);
    let sine = |change: Value| json!({"motion": with(json!({"amplitude_m": 1e-6, "frequency_hz": 1e4}), change)});
    let cases: [(Value, &str, &str); 17] = [
        (
            json!({"motion_table": []}),
            ".motion_table",
            "fewer than two entries",
        ),
        (
            json!({"motion_table": [[0.0, 0.0, 0.0]]}),
            ".motion_table",
            "displacement_m = [0.0, 0.0]",
        ),
        (
            json!({"motion_table": [[0.0, "free", "free"], [1.0, "free", "free"]]}),
            ".motion_table",
            "free in both directions",
        ),
        (
            json!({"motion_table": [[0.0, 0.0, "free"], [1.0, 1e-6, 0.0]]}),
            ".motion_table",
            "entry 1 has no time, or its free directions differ",
        ),
        (
            json!({"motion_table": [[0.0, 0.0, 0.0], ["free", 1e-6, 0.0]]}),
            ".motion_table",
            "entry 1 has no time",
        ),
        (
            json!({"motion_table": [[0.0, 0.0, 0.0], [1.0, 1e-6, 0.0], [1.0, 0.0, 0.0]]}),
            ".motion_table",
            "entry 2 is at 1e0, not after",
        ),
        (
            json!({"motion_table": [[0.0, 1e-6, 0.0], [1.0, 1e-6, 0.0]]}),
            ".motion_table",
            "1e-6 m at t = 0",
        ),
        (
            json!({"motion_table": table, "ramp_s": 1e-6}),
            ".ramp_s",
            "already vary over time",
        ),
        (
            json!({"motion_table": table, "displacement_m": [0.0, 0.0]}),
            "",
            "exactly one load or motion",
        ),
        (
            json!({"motion_table": table, "traction_pa": [1e6, "free"]}),
            "",
            "a load and a motion in x",
        ),
        (
            sine(json!({"amplitude_m": 0.0})),
            ".motion.amplitude_m",
            "must be above 0",
        ),
        (
            sine(json!({"frequency_hz": -1.0})),
            ".motion.frequency_hz",
            "must be above 0",
        ),
        (
            sine(json!({"frequency_hz": 1e7})),
            ".motion.frequency_hz",
            "fewer than 20 steps",
        ),
        (
            sine(json!({"start_s": -1.0})),
            ".motion.start_s",
            "at least 0",
        ),
        (
            sine(json!({"direction": [0.0, "free"]})),
            ".motion.direction",
            "not both 0",
        ),
        (
            with(
                sine(json!({})),
                json!({"load_table": [[0.0, 1.0]], "load_direction": [1.0, -1.0]}),
            ),
            "",
            "a load and a motion in x",
        ),
        (
            with(
                sine(json!({"direction": [1.0, 0.0]})),
                json!({"load_table": [[0.0, 1.0]]}),
            ),
            ".load_table",
            "exactly one free",
        ),
    ];
    for (top, key, word) in cases {
        let config = with(block(), moved("right", top));
        let error = fem_node::check(&config, &setting(1)).expect_err(word);
        assert_eq!(error.key, format!("boundary.right{key}"), "{error}");
        let text = format!("{} {}", error.problem, error.help.unwrap_or_default());
        assert!(text.contains(word), "{text}");
    }
    let still = json!({"analysis": "static"});
    let config = with(
        with(block(), still),
        moved("right", json!({"motion_table": table})),
    );
    let error = fem_node::check(&config, &setting(1)).expect_err("it takes time");
    assert_eq!(error.key, "boundary.right");
}
