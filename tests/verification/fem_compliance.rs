//! Problem: the condensed compliance C of the upper edge of a crowned, graded, clamped block of 12 x 6 elements, and
//! of one element between rollers, a mass on a spring k.
//! Exact: C is symmetric and positive definite for every window and damping; C(1) = h^2/2 M^-1; the motion of a
//! window is affine in the interface force, du = du_0 + C lambda.
//! For the mass on a spring at b = 1/2, C = (1 - cos(m phi))/k >= 0 with cos(phi) = 1 - (omega h)^2/2.
//! Source: C is a polynomial in M^-1 K times M^-1. From rest, the discrete oscillator swings about its static position,
//! f/k. A force that acts half a step early adds (omega h)^2 sin(m phi) / (2 k sin(phi)), which makes C negative
//! just before each full period.
//! Tolerance: 1e-12 relative, rounding of up to 1 000 steps.

use nalgebra::{DMatrix, SymmetricEigen};
use protocol::Node;
use serde_json::json;

use crate::fem_bodies::{block, confined_modulus, node, strip, window, with};

const POINTS: usize = 13;

fn compliance(damping: f64, mass_damping: f64, substeps: u32) -> DMatrix<f64> {
    let time = json!({"time": {"damping": damping, "mass_damping_per_s": mass_damping}});
    let mut node = node(&with(block(), time));
    assert_eq!(node.couple("top").expect("a set").len(), POINTS);
    let columns = node.columns(&window(0, substeps)).expect("stable");
    DMatrix::from_column_slice(2 * POINTS, 2 * POINTS, &columns)
}

#[test]
fn compliance_is_symmetric_and_positive_definite() {
    for (damping, mass_damping) in [(0.5, 0.0), (0.75, 0.0), (1.0, 0.0), (0.5, 3e5)] {
        for substeps in [1, 10, 100, 1000] {
            let c = compliance(damping, mass_damping, substeps);
            let asymmetry = (&c - c.transpose()).amax() / c.amax();
            let least = SymmetricEigen::new(c).eigenvalues.min();
            let case = format!("b {damping}, c {mass_damping}, m {substeps}");
            assert!(asymmetry <= 1e-12, "{case}: asymmetry {asymmetry:e}");
            assert!(least > 0.0, "{case}: smallest eigenvalue {least:e}");
        }
    }
}

#[test]
fn compliance_of_one_step_is_half_a_step_squared_over_the_mass() {
    let mut node = node(&block());
    let masses = node.couple("top").expect("a set").mass_kg;
    let c = compliance(0.75, 0.0, 1);
    let half = 0.5 * node.model.scheme.step.powi(2);
    for (k, mass) in masses.iter().enumerate() {
        for component in [2 * k, 2 * k + 1] {
            assert!((c[(component, component)] * mass / half - 1.0).abs() < 1e-14);
        }
    }
    let mut coupling = c;
    coupling.fill_diagonal(0.0);
    assert_eq!(coupling.amax(), 0.0, "one step couples no nodes");
}

/// Motion (m/N) of the mass on a spring after `substeps`, under a unit force on its two nodes together.
fn spring(damping: f64, substeps: u32) -> f64 {
    let mut node = node(&with(
        strip(1e-3, 1e-3, 1e-3),
        json!({"time": {"damping": damping}}),
    ));
    node.couple("top").expect("a set");
    let c = DMatrix::from_column_slice(4, 4, &node.columns(&window(0, substeps)).expect("stable"));
    0.5 * (c[(1, 1)] + c[(1, 3)])
}

#[test]
fn a_mass_on_a_spring_swings_about_its_static_position() {
    let stiffness = 1e-3 * confined_modulus();
    let speed = (confined_modulus() / 7800.0).sqrt();
    let step = node(&strip(1e-3, 1e-3, 1e-3)).model.scheme.step;
    let omega_h = 2f64.sqrt() * speed / 1e-3 * step;
    let phi = (1.0 - 0.5 * omega_h * omega_h).acos();
    for substeps in 1..=100 {
        let exact = (1.0 - (f64::from(substeps) * phi).cos()) / stiffness;
        let error = (spring(0.5, substeps) - exact).abs() * stiffness;
        assert!(error <= 1e-12, "m {substeps}: {error:e}");
    }
}

#[test]
fn a_constant_force_never_moves_a_mass_on_a_spring_backwards() {
    for damping in [0.5, 0.75, 1.0] {
        for substeps in 1..=100 {
            let motion = spring(damping, substeps);
            assert!(motion > 0.0, "b {damping} m {substeps}: {motion:e}");
        }
    }
}

#[test]
fn columns_belong_to_their_selection() {
    let mut node = node(&block());
    node.couple("top").expect("a set");
    let all = DMatrix::from_column_slice(
        2 * POINTS,
        2 * POINTS,
        &node.columns(&window(0, 5)).expect("stable"),
    );
    node.select(&[3, 8]).expect("points of the set");
    let two = DMatrix::from_column_slice(4, 4, &node.columns(&window(0, 5)).expect("stable"));
    let places = [6, 7, 16, 17];
    assert_eq!(two, all.select_rows(&places).select_columns(&places));
}

#[test]
fn a_window_is_affine_in_the_interface_force_with_the_columns_as_slope() {
    let mut node = node(&with(block(), json!({"time": {"mass_damping_per_s": 1e5}})));
    node.couple("top").expect("a set");
    let points = [2, 5, 6, 11];
    node.select(&points).expect("points of the set");
    let force = |seed: usize| {
        (0..8)
            .map(|k| ((seed + 3 * k) as f64).sin())
            .collect::<Vec<f64>>()
    };
    node.advance(&window(0, 7), &force(1)).expect("stable");
    node.commit(&window(0, 7), &[]).expect("advanced");
    let still = node.advance(&window(1, 25), &[0.0; 8]).expect("stable");
    let moved = node.advance(&window(1, 25), &force(9)).expect("stable");
    let c = DMatrix::from_column_slice(8, 8, &node.columns(&window(0, 25)).expect("stable"));
    let lambda = nalgebra::DVector::from_vec(force(9));
    let expected = nalgebra::DVector::from_vec(still) + c * lambda;
    let error = (nalgebra::DVector::from_vec(moved) - &expected).amax();
    assert!(error <= 1e-12 * expected.amax(), "{error:e}");
}
