//! Contacts of one law go side by side through a step: they must end as they do one by one.
//!
//! ```text
//!   |o o o o o      a heap of bonded disks that slides, breaks and falls apart in a box;
//!   |o o o o o      a law of its own with a ceiling that no disk reaches makes its contacts go one by one
//!   +---------
//! ```
//!
//! Reference: the same heap one by one. Motion, forces, bonds and energies agree to the last bit. Heat adds its terms in another order:
//! tolerance 1e-12 J or K.

use dem_node::Dem;
use serde_json::{Value, json};

use crate::dem_support::{build, march, scene};

const R: f64 = 1e-3;
const G: f64 = 9.81e3;
const STEPS: u32 = 400;

/// A heap of 90 disks of three sizes under this law; one by one with a law of its own for the ceiling.
fn heap(mut law: Value, one_by_one: bool, overrides: Value) -> Dem {
    if one_by_one {
        law["pairs"] = json!([{"between": ["ceiling", "grains"], "friction": 0.7}]);
    }
    let disk = |i: usize| {
        let (column, row) = (i % 10, i / 10);
        let x = R * (2 * column + 1 + row % 2) as f64;
        let radius = R * [0.99, 0.93, 0.85][i % 3];
        json!({"x_m": x, "y_m": R * (1.0 + 1.75 * row as f64), "radius_m": radius})
    };
    let disks: Vec<Value> = (0..90).map(disk).collect();
    let sample = json!({"kind": "disks", "disks": disks, "walls": [
        {"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0},
        {"x_m": 0.0, "y_m": 0.0, "nx": 1.0, "ny": 0.0},
        {"name": "ceiling", "x_m": 0.0, "y_m": 1.0, "nx": 0.0, "ny": -1.0},
    ]});
    let mut dem = build(&scene(law, 1e-6, sample, overrides));
    march(&mut dem, 0, STEPS);
    dem
}

fn compare(law: &Value, heat: Value, broken: impl Fn(usize) -> bool) {
    let overrides = json!({
        "gravity_m_per_s2": [0.4 * G, -G],
        "heat": heat,
        "solver": {"kind": "nsgs", "tolerance": 1e-6, "max_iterations": 20_000, "min_iterations": 1},
    });
    let [packed, alone] = [false, true].map(|alone| heap(law.clone(), alone, overrides.clone()));
    let [packed, alone] = [&packed, &alone].map(|dem| dem.state());
    assert_eq!(packed.centres, alone.centres);
    assert_eq!(packed.velocities, alone.velocities);
    assert_eq!(packed.list.slots, alone.list.slots);
    assert_eq!(packed.bonds, alone.bonds);
    let pressed = packed.list.pressing().count();
    assert!(pressed > 20, "{pressed} contacts press");
    assert!(
        broken(packed.bonds.len()),
        "{} bonds are left",
        packed.bonds.len()
    );
    assert_eq!(packed.ledger, alone.ledger);
    let [packed, alone] = [packed, alone].map(|state| state.heat.numbers().collect::<Vec<_>>());
    assert_eq!(packed.len(), alone.len());
    for (packed, alone) in packed.iter().zip(&alone) {
        assert!((packed - alone).abs() <= 1e-12, "{packed} {alone}");
    }
}

#[test]
fn bonds_that_slide_and_break_end_as_they_do_one_by_one() {
    for (h_prime, damping) in [("one", 0.3), ("adhesion", 0.0)] {
        let law = json!({
            "kind": "cohesion", "friction": 0.3, "damping": 0.4, "bond_damping_ratio": damping,
            "contact_stiffness_pa": 1e9, "tangential_stiffness_ratio": 0.5, "cn_pa_per_m": 1e12, "ct_pa_per_m": 4e11,
            "w_j_per_m2": 2.0, "b_pa_m_s": 0.0, "p": 1.0, "h_prime": h_prime, "alert_m": 0.3e-3,
        });
        let heat = json!({"conductivity_w_per_m_k": 45.0, "capacity_j_per_kg_k": 460.0,
            "young_pa": 2e11, "poisson": 0.3, "start_k": 300.0});
        compare(&law, Value::Null, |left| left > 20 && left < 200);
        compare(&law, heat, |left| left > 20 && left < 200);
    }
}

#[test]
fn springs_with_and_without_dampers_end_as_they_do_one_by_one() {
    for damping in [1.0, 0.5] {
        let law = json!({"kind": "coulomb", "friction": 0.3, "damping": damping,
            "contact_stiffness_pa": 1e9, "tangential_stiffness_ratio": 0.5});
        compare(&law, Value::Null, |left| left == 0);
    }
}
