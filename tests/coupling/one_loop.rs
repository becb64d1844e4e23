//! A coupled strip against the same two solvers in one loop, and the order of accuracy in the window.
//!
//! Problem: an elastic strip, 4 mm wide and 8 mm high, its base clamped and its sides held in x, carries a row of 23 masses
//! that is glued to its upper edge through the mapping and pressed by a constant traction from t = 0 on.
//!
//! ```text
//!      | | | | |  10 MPa
//!      O-O-O-O-O  masses, glued
//!     |~~~~~~~~~|
//!    >| elastic |<
//!     |_________|
//! ```
//!
//! Exact answer of the first test: a loop over both solvers without coupler, frames and repeats, which solves at once for the
//! force that closes one step; 1e-10 of the largest displacement at one step per window.
//!
//! Order: the masses take one backward Euler step per window, which is of first order. A force that is constant in a
//! window lags a smooth one by half a window, first order too. The displacement at the ends of windows H, 2H, 4H then
//! has (u_4H - u_2H) / (u_2H - u_H) -> 2 (Richardson 1911). The strip's own step is the same in all runs.

use harness::runs::{node, run_in_process};
use nalgebra::DMatrix;
use protocol::{Surface, Window};
use scheme::keys::MappingKind;
use scheme::mapping::Mapping;
use serde_json::{Value, json};

const STEP_S: f64 = 6.0e-8;
/// Steps of a run: the masses go down to twice their static deflection, half a swing.
const STEPS: u32 = 320;
const THICKNESS_M: f64 = 1e-3;

fn strip() -> Value {
    json!({
        "base": "clamped",
        "sides": "fixed_x",
        "mesh": {"width_m": 4e-3, "height_m": 8e-3, "size_m": 0.4e-3},
        "material": {"young_pa": 102.5e9, "poisson": 0.3, "density_kg_per_m3": 7800.0},
        "time": {"step_s": STEP_S, "damping": 0.5},
    })
}

fn plate() -> Value {
    json!({
        "points": 23,
        "width_m": 4e-3,
        "y_m": 0.0,
        "thickness_m": THICKNESS_M,
        "mass_kg": 2.5e-3,
        "traction_pa": [0.0, -10e6],
        "end_s": f64::from(STEPS) * STEP_S,
    })
}

fn scenario(substeps: u32) -> String {
    let participant = |name: &str, kind: &str, config: Value| json!({"name": name, "kind": kind, "config": config});
    let whole = json!({
        "run": {"name": "one-loop", "thickness_m": THICKNESS_M},
        "participant": [participant("strip", "fem", strip()), participant("plate", "plate", plate())],
        "interface": [{
            "name": "glue",
            "between": ["strip.top", "plate.row"],
            "scheme": "dual-schur",
            "substeps": substeps,
            "tolerance_rel": 1e-10,
        }],
    });
    toml::to_string(&whole).expect("it has no nulls")
}

/// Mean deflection (m) of the upper edge at the end of each window of a coupled run.
fn coupled(substeps: u32) -> Vec<f64> {
    let left = run_in_process(&scenario(substeps), &[]);
    let left = left.expect("it is valid").completed();
    left.signals["strip.surface_mean_uy_m"].clone()
}

fn places(surface: &Surface) -> Vec<[f64; 2]> {
    let both = surface.x_m.iter().zip(&surface.y_m);
    both.map(|(x, y)| [*x, *y]).collect()
}

/// The same as [`coupled`] with one step per window, in one loop over both solvers.
fn in_one_loop() -> Vec<f64> {
    let build = |kind: &str, config: Value| node(kind, (0, THICKNESS_M), config);
    let (mut strip, mut plate) = (build("fem", strip()), build("plate", plate()));
    let signals = strip.describe().signals;
    let mean = signals.iter().position(|name| name == "surface_mean_uy_m");
    let mean = mean.expect("the strip reports it");
    let (nodes, points) = (strip.couple("top"), plate.couple("row"));
    let (nodes, points) = (nodes.expect("a set"), points.expect("a set"));
    let mapping = Mapping::new(MappingKind::Mortar, &places(&nodes), &places(&points), None);
    let mapping = mapping.expect("the points lie on the line");
    let size = 2 * nodes.len();
    let step = Window {
        substeps: 1,
        ..Window::default()
    };
    let c = DMatrix::from_vec(size, size, strip.columns(&step).expect("it is stable"));
    let wall = mapping.condense(&c) / (STEP_S * STEP_S);
    plate
        .set_boundary(STEP_S, wall.as_slice())
        .expect("it fits");
    let mut displacement = vec![0.0; size];
    let step = |index: u32| {
        let window = Window {
            index: index.into(),
            step: index.into(),
            substeps: 1,
            t0_s: f64::from(index) * STEP_S,
            t1_s: f64::from(index + 1) * STEP_S,
            ..Window::default()
        };
        let free = strip.advance(&window, &vec![0.0; size]).expect("stable");
        let free: Vec<f64> = mapping.motion(&free).iter().map(|du| du / STEP_S).collect();
        let answer = plate.solve(&window, &free).expect("it is linear");
        let force = mapping.force(&answer.force);
        let increment = strip.advance(&window, &force).expect("stable");
        for (total, du) in displacement.iter_mut().zip(&increment) {
            *total += du;
        }
        let report = strip.commit(&window, &[]).expect("it was advanced");
        let position = mapping.motion(&displacement);
        plate.commit(&window, &position).expect("it was solved");
        report[mean]
    };
    (0..STEPS).map(step).collect()
}

#[test]
fn one_step_per_window_equals_the_loop_over_both_solvers() {
    let (coupled, whole) = (coupled(1), in_one_loop());
    assert_eq!(coupled.len(), whole.len());
    let largest = whole.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
    let apart = coupled.iter().zip(&whole);
    let apart = apart.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
    println!("{:.1e} apart, largest {largest:.3e} m", apart / largest);
    assert!(largest > 1e-7, "nothing moves: {largest:e}");
    assert!(apart <= 1e-10 * largest, "{:e} apart", apart / largest);
}

#[test]
fn the_error_falls_with_the_first_power_of_the_window() {
    let windows = [1, 2, 4, 8, 16];
    let runs = windows.map(|substeps| {
        let all = coupled(substeps);
        // At the ends of the longest windows.
        let every = (16 / substeps) as usize;
        all.into_iter()
            .skip(every - 1)
            .step_by(every)
            .collect::<Vec<f64>>()
    });
    let norm = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>().sqrt();
    let scale = norm(&mut runs[0].iter().copied());
    let differences: Vec<f64> = runs
        .windows(2)
        .map(|pair| norm(&mut pair[0].iter().zip(&pair[1]).map(|(a, b)| a - b)) / scale)
        .collect();
    let orders: Vec<f64> = differences
        .windows(2)
        .map(|d| (d[1] / d[0]).log2())
        .collect();
    for (index, difference) in differences.iter().enumerate() {
        let (fine, coarse) = (windows[index], windows[index + 1]);
        println!("m = {coarse} from m = {fine}: {difference:.3e}");
    }
    println!("orders {orders:.3?}");
    for order in orders {
        assert!((order - 1.0).abs() <= 0.1, "order {order}");
    }
}
