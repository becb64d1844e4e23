//! Problem: a body with `perturb_seed`, which displaces its nodes along y by up to 1e-12 of the mean element size.
//! Exact: x and the number of nodes stay; no y moves by more, and nearly all move. In a periodic body the two ends of a row move
//! equally. The same seed gives the same mesh, and another seed another mesh.
//! Source: requirement. Tolerance: one rounding of the coordinate.

use fem_node::FemConfig;
use fem_node::model::Model;
use serde_json::{Value, json};

use crate::fem_bodies::{block, setting, with};

fn points(config: &Value) -> Vec<[f64; 2]> {
    let config: FemConfig = kit::read_config(config).expect("it is valid");
    Model::new(&config, &setting(1))
        .expect("it is a body")
        .mesh
        .points
}

#[test]
fn nodes_are_displaced_by_a_trillionth_of_an_element() {
    let plain = points(&block());
    let of = |seed: u64| points(&with(block(), json!({"perturb_seed": seed})));
    let [first, again, other] = [7, 7, 8].map(of);
    assert_eq!(first, again);
    assert_ne!(first, other);
    let height = plain
        .iter()
        .map(|p| p[1])
        .fold(0.0, |a: f64, y| a.max(y.abs()));
    let displaced = plain.iter().zip(&first).filter(|(old, new)| {
        assert_eq!(old[0], new[0]);
        // An element is no larger than the body.
        let most = 1e-12 * height + f64::EPSILON * old[1].abs();
        assert!((new[1] - old[1]).abs() <= most, "{old:?} became {new:?}");
        old[1] != new[1]
    });
    let displaced = displaced.count();
    assert!(
        10 * displaced > 8 * plain.len(),
        "{displaced} of {}",
        plain.len()
    );
}

#[test]
fn a_periodic_body_stays_periodic() {
    let config = with(
        block(),
        json!({"mesh": {"periodic_x": true, "crown_radius_m": 0.0}, "perturb_seed": 3}),
    );
    let config: FemConfig = kit::read_config(&config).expect("it is valid");
    let mesh = Model::new(&config, &setting(1)).expect("it is a body").mesh;
    for row in 0..=mesh.rows {
        assert_eq!(
            mesh.point(0, row)[1],
            mesh.point(mesh.columns, row)[1],
            "row {row}"
        );
    }
}
