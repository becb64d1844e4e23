//! A column of disks under gravity, and the rate at which Gauss-Seidel solves it.
//!
//! ```text
//!   O   f = mg
//!   O   f = 2 mg
//!   O   ...           contact k from the top carries k m g
//!  ===
//! ```
//!
//! Forces: exact; reference column.csv of the project's own tables. Tolerance 1e-6: the rounding
//! of a gap over the step (1e-13 m/s of the 1e-3 m/s of a step of gravity) times n^2 = 400.
//! Rate: the n x n matrix W of a column on a fixed floor is tridiagonal; Gauss-Seidel contracts by cos^2(pi / 2n)
//! per sweep (Young 1954: the square of Jacobi's), for any order of the contacts. Reference: gs_column_rate.csv.
//! Tolerance 1e-4: the growth of the impulses still changes the ratio by this much after 6 n^2 sweeps.

use dem_node::Dem;
use protocol::{Node, Window};
use serde_json::{Value, json};

use crate::dem_support::{build, close, march, mass, scene};

const RADIUS: f64 = 1e-3;
const G: f64 = 9.81;

/// n and contraction per sweep, from gs_column_rate.csv.
const RATES: [(usize, f64); 3] = [(5, 0.90450850), (10, 0.97552826), (20, 0.99384417)];

fn stack(n: usize) -> Vec<Value> {
    let disk =
        |i: usize| json!({"x_m": 0.0, "y_m": RADIUS * (2 * i + 1) as f64, "radius_m": RADIUS});
    (0..n).map(disk).collect()
}

#[test]
fn each_contact_of_a_column_carries_the_weight_above_it() {
    let sample = json!({
        "kind": "disks",
        "disks": stack(20),
        "walls": [{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}],
    });
    let overrides = json!({"gravity_m_per_s2": [0.0, -G]});
    let mut dem = build(&scene(
        json!({"kind": "signorini"}),
        1e-4,
        sample,
        overrides,
    ));
    let report = march(&mut dem, 0, 5);
    assert_eq!(report.signal("contacts"), 20.0);
    for slot in &dem.state().list.slots {
        // Disk 19 is on top; the floor is body 20 and carries disk 0.
        let above = if slot.b == 20 { 20 } else { 20 - slot.b };
        close(
            "force",
            slot.force[0] / (mass(RADIUS) * G),
            f64::from(above),
            1e-6,
        );
    }
    assert!(
        report.signal("overlap_max_rel") < 1e-9,
        "rigid contacts must not sink in"
    );
}

/// A column of n disks on a glued one: a window of a coupled run answers `converged = false` instead of failing.
fn glued_column(n: usize, solver: Value) -> Dem {
    let mut disks = stack(n);
    disks.push(json!({"x_m": 0.0, "y_m": -RADIUS, "radius_m": RADIUS, "glued": true}));
    let mut config = scene(
        json!({"kind": "signorini"}),
        1e-4,
        json!({"kind": "disks", "disks": disks}),
        json!({"gravity_m_per_s2": [0.0, -G], "solver": solver}),
    );
    config["time"] = json!({"pressure_pa": 1.0});
    let mut dem = build(&config);
    dem.couple("base").expect("there is a glued disk");
    dem
}

#[test]
fn forces_of_the_last_window_are_the_first_guess_at_any_length() {
    let solver =
        json!({"kind": "nsgs", "tolerance": 1e-6, "max_iterations": 20_000, "min_iterations": 1});
    let mut dem = glued_column(10, solver);
    let mut start = 0.0;
    let mut sweeps = Vec::new();
    for (index, length) in [1e-4, 1e-4, 0.5e-4].into_iter().enumerate() {
        dem.set_boundary(length, &[0.0; 4]).expect("a rigid wall");
        let window = Window {
            index: index as u64,
            t0_s: start,
            t1_s: start + length,
            ..Window::default()
        };
        let answer = dem.solve(&window, &[0.0; 2]).expect("it can be solved");
        dem.commit(&window, &[0.0; 2]).expect("it was solved");
        start += length;
        sweeps.push(answer.iterations);
    }
    // A cold start takes 409 sweeps; later windows only correct the remainder within the tolerance: 45 and 43.
    assert!(
        sweeps[0] > 300 && sweeps[1] < 80 && sweeps[2] < 80,
        "{sweeps:?}"
    );
}

/// Residual after exactly this many sweeps from a cold start.
fn residual_after(n: usize, sweeps: usize) -> f64 {
    let mut dem = glued_column(
        n,
        json!({"kind": "nsgs", "tolerance": 1e-12, "max_iterations": sweeps, "min_iterations": sweeps}),
    );
    dem.set_boundary(1e-4, &[0.0; 4]).expect("a rigid wall");
    let window = Window {
        t1_s: 1e-4,
        substeps: 1,
        ..Window::default()
    };
    let answer = dem
        .solve(&window, &[0.0; 2])
        .expect("an answer, converged or not");
    assert!(!answer.converged);
    assert_eq!(answer.iterations, sweeps as u64);
    answer.residual
}

#[test]
fn gauss_seidel_contracts_at_the_rate_of_theory() {
    for (n, expected) in RATES {
        let (early, late) = (6 * n * n, 6 * n * n + 20);
        let ratio = residual_after(n, late) / residual_after(n, early);
        close(
            &format!("contraction at n = {n}"),
            ratio.powf(0.05),
            expected,
            1e-4,
        );
    }
}
