//! Impacts of rigid disks without restitution.
//!
//! ```text
//!   V ->  O    O O O O      n disks in a row, the first one hits the others: all end with V / n
//! ```
//!
//! Exact: momentum V m = n m v. Reference: chain_inelastic.csv of the project's own tables (closed form), n = 2, 3,
//! 5, 10, 50. Tolerance: the solver's true residual, 1e-12, times the condition of the longest chain (n^2 = 2 500).

use protocol::Node;
use serde_json::{Value, json};

use crate::dem_support::{build, close, march, mass, scene};

/// Number of disks and final velocity over V, from chain_inelastic.csv.
const CHAINS: [(usize, f64); 5] = [
    (2, 0.5),
    (3, 0.333333333333),
    (5, 0.2),
    (10, 0.1),
    (50, 0.02),
];
const RADIUS: f64 = 1e-3;

fn chain(n: usize) -> Value {
    let disk = |i: usize| {
        let away = if i == 0 { 0.2 * RADIUS } else { 0.0 };
        json!({
            "x_m": 2.0 * RADIUS * i as f64 - away,
            "y_m": 0.0,
            "radius_m": RADIUS,
            "vx_m_per_s": if i == 0 { 1.0 } else { 0.0 },
        })
    };
    let disks: Vec<Value> = (0..n).map(disk).collect();
    json!({"kind": "disks", "disks": disks})
}

#[test]
fn a_chain_hit_at_its_end_moves_as_one_body() {
    for (n, expected) in CHAINS {
        let mut dem = build(&scene(
            json!({"kind": "signorini"}),
            1e-5,
            chain(n),
            json!({}),
        ));
        let report = march(&mut dem, 0, 60);
        for velocity in &dem.state().velocities {
            close(
                &format!("velocity in a chain of {n}"),
                velocity[0],
                expected,
                1e-8,
            );
        }
        let momentum = report.signal("momentum_x_kg_m_per_s");
        close("momentum", momentum, mass(RADIUS), 1e-15 * n as f64);
        let before = 0.5 * mass(RADIUS);
        close(
            "lost energy",
            report.energy("impact") / before,
            1.0 - expected,
            1e-8,
        );
    }
}

#[test]
fn grains_that_meet_within_a_step_do_not_pass_through_each_other() {
    // The free grain travels 3 radii in a step: detection must find the pair although it is far outside any skin.
    let mut sample = chain(2);
    sample["disks"][0]["x_m"] = json!(-2.0 * RADIUS);
    sample["disks"][0]["vx_m_per_s"] = json!(300.0);
    let mut dem = build(&scene(
        json!({"kind": "signorini"}),
        1e-5,
        sample,
        json!({}),
    ));
    march(&mut dem, 0, 2);
    let centres = &dem.state().centres;
    close(
        "distance",
        centres[1][0] - centres[0][0],
        2.0 * RADIUS,
        1e-12,
    );
    for velocity in &dem.state().velocities {
        close("velocity", velocity[0], 150.0, 1e-9);
    }
}

#[test]
fn equal_runs_leave_equal_bits() {
    let hash = || {
        let mut dem = build(&scene(
            json!({"kind": "signorini"}),
            1e-5,
            chain(10),
            json!({}),
        ));
        march(&mut dem, 0, 40);
        dem.finish().expect("it finishes").state_hash
    };
    assert_eq!(hash(), hash());
}
