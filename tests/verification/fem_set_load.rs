//! Problem: a set of a body under a total force from a table over time.
//!
//! ```text
//!    F(t)  /\__        u = integral of F/(rho c A) at the end of a bar until the wave comes back
//!   _____ /    \__ t   M v = integral of F in a free block
//! ```
//!
//! Exact: d'Alembert, c = sqrt(M/rho), in a laterally held bar. Newton for the block: the scheme's h [(1-b) F + b F'] sums to
//! the trapezoidal rule plus (b-1/2) h (F(t) - F(0)). A table that rises from 0 equals a ramped traction of its force over
//! the set's length and the thickness.
//! Tolerance: 0.02 % of the last displacement, for the short waves from the table's kinks; rounding of some hundred steps,
//! 1e-13, for the momentum; none for the bits of a ramp, as all sizes of that body are powers of two.

use fem_node::{FemConfig, FemNode};
use kit::read_config;
use protocol::{Node, Setting};
use serde_json::{Value, json};

use crate::fem_bodies::{
    block, confined_modulus, node, node_on, reported, setting, strip, window, with,
};
use crate::fem_msh::{Drawing, MshFile};
use crate::fem_wheel::balance;

const HEIGHT: f64 = 20e-3;

/// A pulse and the constant force after it (s, N).
const PULSE: [[f64; 2]; 4] = [[0.5e-6, 0.0], [2.5e-6, 6.0], [4.5e-6, -1.0], [6e-6, 0.5]];

/// The integral of a table from 0 to t (N s), from its value at 0 and each change of slope.
fn impulse(table: &[[f64; 2]], t: f64) -> f64 {
    let slopes = table
        .windows(2)
        .map(|p| (p[1][1] - p[0][1]) / (p[1][0] - p[0][0]));
    let slopes: Vec<f64> = [0.0].into_iter().chain(slopes).chain([0.0]).collect();
    let kinks = table.iter().zip(slopes.windows(2)).map(|([at, _], k)| {
        let s = (t - at).max(0.0);
        (k[1] - k[0]) * 0.5 * s * s
    });
    table[0][1] * t + kinks.sum::<f64>()
}

fn loaded(set: &str, load: Value) -> Value {
    json!({"boundary": {set: load}})
}

#[test]
fn the_end_of_a_bar_moves_with_the_integral_of_its_load() {
    let area = 2e-4 * 1e-3;
    let impedance = 7800.0 * (confined_modulus() / 7800.0).sqrt() * area;
    let table = json!({"load_table": PULSE, "load_direction": [0.0, -2.0]});
    let mut bar = node(&with(strip(2e-4, HEIGHT, 1e-4), loaded("top", table)));
    let h = bar.model.scheme.step;
    let last = 9e-6;
    let mut worst: f64 = 0.0;
    for index in 0..(last / h) as u64 {
        let report = bar.advance_alone(&window(index, 1)).expect("stable");
        let exact = -impulse(&PULSE, (index + 1) as f64 * h) / impedance;
        worst = worst.max((reported(&bar, &report, "surface_mean_uy_m") - exact).abs());
        // In the first steps the work is still 0, and gives no scale for the balance.
        assert!(index < 100 || balance(&bar, &report) < 1e-10);
    }
    let error = worst / (impulse(&PULSE, last) / impedance);
    assert!(error < 2e-4, "{error:e}");
}

/// Momentum of the body along x and y (N s).
fn momentum(body: &FemNode) -> [f64; 2] {
    let (mesh, layout) = (&body.model.mesh, body.model.body.layout);
    [0, 1].map(|k| {
        let nodes = mesh.nodes().map(|node| layout.index(node, k));
        nodes
            .map(|index| body.model.body.mass[index] * body.state().v[index])
            .sum()
    })
}

#[test]
fn a_free_block_has_the_momentum_of_the_integral_of_its_load() {
    for b in [0.5, 0.75] {
        let free = with(block(), json!({"base": "free", "time": {"damping": b}}));
        let h = node(&free).model.scheme.step;
        // The corners are at ends of steps, where the trapezoidal rule is exact. Some are inside a window.
        let table = [[0.0, 2.0], [17.0, 30.0], [45.0, -10.0], [80.0, 5.0]].map(|[k, n]| [k * h, n]);
        let load = json!({"load_table": table, "load_direction": [3.0, -4.0]});
        let mut body = node(&with(free, loaded("top", load)));
        for index in 0..10 {
            body.advance_alone(&window(index, 10)).expect("stable");
            let t = (10 * (index + 1)) as f64 * h;
            let force = kit::table::load_at(&table, t);
            let exact = impulse(&table, t) + (b - 0.5) * h * (force - 2.0);
            for (found, share) in momentum(&body).into_iter().zip([0.6, -0.8]) {
                let error = (found - share * exact).abs() / (30.0 * t);
                assert!(error < 1e-13, "b {b}, t = {t:e}: {error:e}");
            }
        }
    }
}

/// Sizes, thickness and force of the body without rounding.
const WIDTH: f64 = 1.0 / 64.0;
const THICKNESS: f64 = 1.0 / 1024.0;
const FORCE: f64 = 256.0;
const RISE: f64 = 3e-6;

/// All reports and the final displacements of a body of squares under a load on its upper edge.
fn life(top: Value) -> (Vec<Vec<f64>>, Vec<f64>) {
    let config = with(
        json!({
            "mesh": {"width_m": WIDTH, "height_m": WIDTH / 2.0, "size_m": WIDTH / 16.0},
            "material": {"young_pa": 102.5e9, "poisson": 0.3, "density_kg_per_m3": 7800.0},
            "time": {"step_s": "auto", "damping": 0.75, "mass_damping_per_s": 1e4},
        }),
        loaded("top", top),
    );
    let config: FemConfig = read_config(&config).expect("the keys are valid");
    let setting = Setting {
        thickness_m: THICKNESS,
        ..setting(1)
    };
    let mut body = FemNode::new(&config, &setting).expect("the body is valid");
    let march = |index| body.advance_alone(&window(index, 7)).expect("stable");
    let reports = (0..10).map(march).collect();
    (reports, body.state().u.to_vec())
}

#[test]
fn a_table_that_rises_has_the_bits_of_a_ramped_traction() {
    let pressure = FORCE / (WIDTH * THICKNESS);
    let table = json!([[0.0, 0.0], [RISE, FORCE]]);
    let down = life(json!({"traction_pa": [0.0, -pressure], "ramp_s": RISE}));
    let pushed = life(json!({"load_table": table, "load_direction": [0.0, -0.3]}));
    assert_eq!(down, pushed);
    assert!(down.1.iter().any(|u| *u < -1e-9), "it moves");

    // With a motion the ramp belongs to the motion, and the force acts in the free direction.
    for (motion, traction) in [
        (json!([0.1, "free"]), json!(["free", pressure])),
        (json!(["free", -0.1]), json!([pressure, "free"])),
    ] {
        let motion = json!({"velocity_m_per_s": motion, "ramp_s": RISE});
        let ramped = life(with(motion.clone(), json!({"traction_pa": traction})));
        let tabled = life(with(motion.clone(), json!({"load_table": table})));
        assert_eq!(ramped, tabled, "{motion}");
    }
}

/// Components and forces of the only load.
fn forces(body: &FemNode) -> &[(usize, f64)] {
    let [load] = body.model.tractions.as_slice() else {
        panic!("there is one load");
    };
    &load.forces
}

/// A square of 2 x 2 m, with a line across its middle and a set of two lines of 1 m and 2 m.
fn square() -> MshFile {
    let points = (0..9).map(|k| [f64::from(k % 3), -f64::from(k / 3)]);
    let corner = |k: usize| [k + 3, k + 4, k + 1, k];
    let drawing = Drawing {
        points: points.collect(),
        quads: [0, 1, 3, 4].map(corner).to_vec(),
        lines: vec![
            ("middle", vec![[3, 4], [4, 5]]),
            ("both", vec![[0, 1], [6, 7], [7, 8]]),
        ],
    };
    MshFile::new(&drawing.msh2())
}

#[test]
fn a_force_is_distributed_over_its_set_like_a_traction() {
    let file = square();
    let drawn = json!({"mesh": {"gmsh": file.0}, "base": "free",
                       "material": {"young_pa": 1e9, "poisson": 0.3, "density_kg_per_m3": 1e3},
                       "time": {"step_s": "auto", "damping": 0.75}});
    let flat = with(block(), json!({"mesh": {"crown_radius_m": 0.0}}));
    let periodic = with(flat.clone(), json!({"mesh": {"periodic_x": true}}));
    for (config, set, length) in [
        (&flat, "left", 7e-3),
        (&flat, "top", 12e-3),
        (&periodic, "top", 12e-3),
        (&drawn, "middle", 2.0),
        (&drawn, "both", 3.0),
    ] {
        let of = |load: Value| node(&with(config.clone(), loaded(set, load)));
        // 1 N over the length and 1 mm of thickness.
        let mean = 1.0 / (length * 1e-3);
        let drawn = of(json!({"traction_pa": [0.6 * mean, 0.8 * mean]}));
        let tabled = of(json!({"load_table": [[0.0, 7.0]], "load_direction": [6, 8]}));
        assert_eq!(forces(&drawn).len(), forces(&tabled).len(), "{set}");
        let mut total = [0.0; 2];
        let layout = tabled.model.body.layout;
        for ((at, force), (index, own)) in forces(&drawn).iter().zip(forces(&tabled)) {
            assert_eq!(at, index, "{set}");
            assert!((own / force - 1.0).abs() < 1e-12, "{set}: {own} {force}");
            total[index % layout.row_len() / layout.stride] += own;
        }
        let error = (total[0] - 0.6).abs().max((total[1] - 0.8).abs());
        assert!(error < 1e-12, "{set}: {total:?}");
    }
}

#[test]
fn threads_do_not_change_a_bit_under_a_table() {
    let load = json!({"load_table": PULSE, "load_direction": [1.0, -1.0]});
    let fine = json!({"mesh": {"size_m": 5e-5, "side_columns": 45, "depth_rows": 50}});
    let config = with(with(block(), fine), loaded("right", load));
    let run = |threads: usize| {
        let mut body = node_on(&config, threads);
        let report = body.advance_alone(&window(0, 60)).expect("stable");
        (report, body.state().clone(), *body.ledger())
    };
    let one = run(1);
    for threads in [2, 3] {
        assert_eq!(run(threads), one, "{threads} threads");
    }
}

/// The ramp lasts until the load's last change. The hold follows.
#[test]
fn the_ramp_of_a_run_lasts_until_the_table_is_constant() {
    let phases = |table: Value, end: f64| -> Vec<(String, f64, f64)> {
        let load = json!({"load_table": table, "load_direction": [0.0, -1.0]});
        let config = with(block(), json!({"time": {"end_s": end}}));
        let phases = node(&with(config, loaded("top", load))).describe().phases;
        let limits = phases.into_iter().map(|p| (p.name, p.t0_s, p.t1_s));
        limits.collect()
    };
    let (ramp, hold) = (
        |t0, t1| ("ramp".into(), t0, t1),
        |t0, t1| ("hold".into(), t0, t1),
    );
    let table = json!([[0.0, 0.0], [1e-6, 5.0], [2e-6, 3.0], [9e-6, 3.0]]);
    assert_eq!(
        phases(table.clone(), 5e-6),
        [ramp(0.0, 2e-6), hold(2e-6, 5e-6)]
    );
    assert_eq!(phases(table, 1e-6), [ramp(0.0, 1e-6)]);
    assert_eq!(phases(json!([[4e-6, 2.0]]), 5e-6), [hold(0.0, 5e-6)]);
}

#[test]
fn impossible_loads_over_time_are_refused_by_their_key() {
    let table = json!([[0.0, 0.0], [1e-6, 5.0]]);
    let down = json!({"load_table": table, "load_direction": [0.0, -1.0]});
    let still = json!({"analysis": "static"});
    let wheel = json!({"start": "static", "contact": {"friction": 0.3},
                       "wheel": {"load_n": 1.0, "mass_kg": 0.01, "ramp_s": 1e-4, "hold_s": 1e-4}});
    let changed = |change: Value| loaded("right", with(down.clone(), change));
    let cases: [(Value, &str, &str); 16] = [
        (
            changed(json!({"load_table": []})),
            ".load_table",
            "has no entries",
        ),
        (
            changed(json!({"load_table": [[0.0, 1.0], [0.0, 2.0]]})),
            ".load_table",
            "entry 1 is at 0e0, not after",
        ),
        (
            changed(json!({"traction_pa": [0.0, 1.0]})),
            "",
            "exactly one load or motion",
        ),
        (
            changed(json!({"pressure_pa": 1.0})),
            "",
            "exactly one load or motion",
        ),
        (
            changed(json!({"ramp_s": 1e-6})),
            ".ramp_s",
            "begin with [0.0, 0.0]",
        ),
        (
            changed(json!({"load_direction": [0.0, 0.0]})),
            ".load_direction",
            "not both 0",
        ),
        (
            loaded("right", json!({"load_table": table})),
            ".load_table",
            "load_direction is missing",
        ),
        (
            loaded(
                "right",
                json!({"load_table": table, "velocity_m_per_s": ["free", "free"]}),
            ),
            ".velocity_m_per_s",
            "free in both directions",
        ),
        (
            loaded(
                "right",
                json!({"load_table": table, "velocity_m_per_s": [0.0, 0.0]}),
            ),
            ".load_table",
            "exactly one free",
        ),
        (
            loaded(
                "right",
                json!({"traction_pa": [0.0, 1.0], "load_direction": [1.0, 0.0]}),
            ),
            ".load_direction",
            "which is absent",
        ),
        (
            changed(json!({"velocity_m_per_s": ["free", 0.0]})),
            "",
            "a load and a motion in y",
        ),
        (
            changed(json!({"load_direction": [1.0, 1e-9], "velocity_m_per_s": ["free", 0.0]})),
            "",
            "a load and a motion in y",
        ),
        (
            changed(json!({"displacement_m": [1e-6, "free"]})),
            ".ramp_s",
            "is missing",
        ),
        (
            with(changed(json!({})), still),
            ".load_table",
            "traction_pa",
        ),
        (
            with(changed(json!({})), wheel),
            ".load_table",
            "without time",
        ),
        (
            with(changed(json!({})), json!({"mesh": {"periodic_x": true}})),
            "",
            "left and right edge are one",
        ),
    ];
    for (change, key, word) in cases {
        let error = fem_node::check(&with(block(), change), &setting(1)).expect_err(word);
        assert_eq!(error.key, format!("boundary.right{key}"), "{error}");
        let text = format!("{} {}", error.problem, error.help.unwrap_or_default());
        assert!(text.contains(word), "{text}");
    }
}

#[test]
fn a_force_on_a_surface_is_refused() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../scenarios/verification/pressurised-cylinder/cylinder.msh"
    );
    let config = json!({
        "mesh": {"gmsh": path, "length_unit_m": 1e-3},
        "material": {"young_pa": 1e9, "poisson": 0.3, "density_kg_per_m3": 1e3},
        "time": {"step_s": "auto", "damping": 0.75},
        "boundary": {"cylinder": {"load_table": [[0.0, 1.0]], "load_direction": [1.0, 0.0]}},
    });
    let error = fem_node::check(&config, &setting(1)).expect_err("it has no length");
    assert_eq!(error.key, "boundary.cylinder.load_table");
    assert!(error.problem.contains("the set is a surface"), "{error}");
}
