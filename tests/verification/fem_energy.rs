//! Problem: a crowned block under an interface force that jumps at every window, a traction with a ramp, and a force from
//! a table.
//! Exact: work - stored - dissipated = 0 at every window, with each term from its own formula.
//! Source: the derivation in `fem_kernel::integrate`, for the update as implemented.
//! Tolerance: 1e-10 of the works' summed magnitudes, rounding over 2 000 steps.

use protocol::{Node, Role};
use serde_json::{Value, json};

use crate::fem_bodies::{block, node, window, with};

/// Largest |W - E - D| / sum |W| over the windows.
fn closure(config: &Value) -> f64 {
    let mut node = node(config);
    let points = node.couple("top").expect("a set").len();
    let description = node.describe();
    let mut worst: f64 = 0.0;
    for index in 0..200u64 {
        let force: Vec<f64> = (0..2 * points as u64)
            .map(|k| 50.0 * (((index * 37 + k * 11) % 101) as f64 / 101.0 - 0.5))
            .collect();
        node.advance(&window(index, 10), &force).expect("stable");
        let report = node.commit(&window(index, 10), &[]).expect("advanced");
        let values = &report[description.signals.len()..];
        let sum = |roles: &[Role], part: fn(f64) -> f64| -> f64 {
            let terms = description.ledger.iter().zip(values);
            terms
                .filter(|(t, _)| roles.contains(&t.role))
                .map(|(_, v)| part(*v))
                .sum()
        };
        let work = [Role::Work, Role::InterfaceWork];
        let defect =
            sum(&work, |w| w) - sum(&[Role::Stored], |e| e) - sum(&[Role::Dissipated], |d| d);
        worst = worst.max(defect.abs() / sum(&work, f64::abs));
    }
    worst
}

#[test]
fn every_joule_is_accounted_for() {
    for damping in [0.5, 0.75, 1.0] {
        for mass_damping in [0.0, 3e5] {
            let config = with(
                block(),
                json!({
                    "time": {"damping": damping, "mass_damping_per_s": mass_damping},
                    "boundary": {"top": {"traction_pa": [1e6, -2e6], "ramp_s": 5e-6},
                                 "right": {"traction_pa": [5e5, 0.0]},
                                 "left": {"load_table": [[1e-6, 5.0], [9e-6, 40.0], [2e-5, -10.0]],
                                          "load_direction": [1.0, -2.0]}},
                }),
            );
            let worst = closure(&config);
            assert!(worst <= 1e-10, "b {damping} c {mass_damping}: {worst:e}");
        }
    }
}

#[test]
fn only_the_terms_of_the_scene_are_reported() {
    let names = |config: &Value| -> Vec<String> {
        node(config)
            .describe()
            .ledger
            .into_iter()
            .map(|term| term.name)
            .collect()
    };
    assert_eq!(
        names(&block()),
        ["interface_work", "strain", "kinetic", "numerical_loss"]
    );
    let damped = with(block(), json!({"time": {"mass_damping_per_s": 1.0}}));
    assert!(names(&damped).contains(&"mass_damping".into()));
}
