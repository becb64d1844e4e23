//! Problem: a body whose coupled edge has a prescribed velocity, linear in time: v = v_0 + (v_end - v_0) t/H.
//!
//! ```text
//!     o===o  a_s = (v_end - v_0)/H             One element: mass M_t, spring k. Two elements: a mass m in the
//!     |   |                                    middle swings about half of the edge's displacement.
//!     o---o
//!     |   |
//!     -----  rollers
//! ```
//!
//! Exact: the edge moves by H (v_0 + v_end)/2. From rest at a_s, the final force on one element is a_s (M_t + k H^2/2). On two
//! it is a_s (M_t + k H^2/4 + (m/4) (1 - cos(m phi))), cos(phi) = 1 - (omega h)^2/2 with omega^2 = 2 k/m, for any number of
//! steps, as H D = M_i + H^2/2 K_i + sum L L^T (1 - cos(omega H)) has one mode with L^2 = m/4. The force at the end
//! is affine in v_end with the columns of D as slope. D is symmetric and H D is not less than M_i. The energy balance
//! closes.
//! Source: the mode of the held body about its static shape, which velocity Verlet follows exactly for a constant
//! acceleration of the edge; the derivation in `fem_kernel::interface::prescribed_velocity`.
//! Tolerance: 1e-12 relative, rounding of up to 1 000 steps, 1e-10 for energies of 2 000 steps.

use nalgebra::{DMatrix, DVector};
use protocol::{FaultCode, Node, Role};
use serde_json::{Value, json};

use crate::fem_bodies::{block, confined_modulus, node, node_on, paper, rail, strip, window, with};

const POINTS: usize = 13;

fn impedance(config: &Value, substeps: u32) -> DMatrix<f64> {
    let mut node = node(config);
    let components = 2 * node.couple("top").expect("a set").len();
    let columns = node.impedance(&window(0, substeps)).expect("stable");
    DMatrix::from_column_slice(components, components, &columns)
}

/// H D (kg) of a strip of 1 mm elements, over its whole edge, and the step (s).
fn strip_resists(height: f64, damping: f64, substeps: u32) -> (f64, f64) {
    let config = with(
        strip(1e-3, height, 1e-3),
        json!({"time": {"damping": damping}}),
    );
    let step = node(&config).model.scheme.step;
    let d = impedance(&config, substeps);
    assert_eq!(d.column(0).amax(), 0.0, "its sides do not move sideways");
    (
        2.0 * step * f64::from(substeps) * (d[(1, 1)] + d[(1, 3)]),
        step,
    )
}

#[test]
fn one_element_resists_with_its_mass_and_its_spring() {
    let (stiffness, mass) = (1e-3 * confined_modulus(), 0.5 * 7800.0 * 1e-9);
    for damping in [0.5, 0.75, 1.0] {
        for substeps in [1, 2, 7, 100, 1000] {
            let (found, step) = strip_resists(1e-3, damping, substeps);
            let window = step * f64::from(substeps);
            let exact = mass + 0.5 * stiffness * window * window;
            let error = (found / exact - 1.0).abs();
            assert!(error <= 1e-12, "b {damping} m {substeps}: {error:e}");
        }
    }
}

#[test]
fn a_mass_between_two_elements_swings_about_half_of_the_displacement() {
    let (stiffness, mass) = (1e-3 * confined_modulus(), 7800.0 * 1e-9);
    for substeps in [1, 2, 3, 7, 20, 100, 1000] {
        let (found, step) = strip_resists(2e-3, 0.5, substeps);
        let window = step * f64::from(substeps);
        let phi = (1.0 - stiffness / mass * step * step).acos();
        let swing = 0.25 * mass * (1.0 - (f64::from(substeps) * phi).cos());
        let exact = 0.5 * mass + 0.25 * stiffness * window * window + swing;
        let error = (found / exact - 1.0).abs();
        assert!(error <= 1e-12, "m {substeps}: {error:e}");
    }
}

#[test]
fn the_impedance_is_symmetric_and_never_less_than_the_masses() {
    for (damping, mass_damping) in [(0.5, 0.0), (0.75, 0.0), (1.0, 0.0), (0.5, 3e5)] {
        let time = json!({"time": {"damping": damping, "mass_damping_per_s": mass_damping}});
        let config = with(block(), time);
        let mut coupled = node(&config);
        let masses = coupled.couple("top").expect("a set").mass_kg;
        for substeps in [1, 10, 100, 1000] {
            let d = impedance(&config, substeps);
            let window = coupled.model.scheme.step * f64::from(substeps);
            let asymmetry = (&d - d.transpose()).amax() / d.amax();
            let mut more = window * 0.5 * (&d + d.transpose());
            for (k, mass) in masses.iter().enumerate() {
                more[(2 * k, 2 * k)] -= mass;
                more[(2 * k + 1, 2 * k + 1)] -= mass;
            }
            let least = more.clone().symmetric_eigen().eigenvalues.min() / more.amax();
            let case = format!("b {damping}, c {mass_damping}, m {substeps}");
            assert!(asymmetry <= 1e-12, "{case}: asymmetry {asymmetry:e}");
            assert!(least > -1e-12, "{case}: {least:e}");
        }
    }
}

#[test]
fn a_window_is_affine_in_the_velocity_with_the_impedance_as_slope() {
    let mut node = node(&with(block(), json!({"time": {"mass_damping_per_s": 1e5}})));
    node.couple("top").expect("a set");
    node.select(&[2, 5, 6, 11]).expect("points of the set");
    let numbers = |seed: usize| {
        let numbers = (0..8).map(|k| ((seed + 3 * k) as f64).sin());
        numbers.collect::<Vec<f64>>()
    };
    let pushed = numbers(1).iter().map(|f| 1e3 * f).collect::<Vec<f64>>();
    node.advance(&window(0, 7), &pushed).expect("stable");
    node.commit(&window(0, 7), &[]).expect("advanced");
    node.prescribe_velocity(&window(1, 9), &numbers(4))
        .expect("stable");
    node.commit(&window(1, 9), &[]).expect("followed");
    let held = node
        .prescribe_velocity(&window(2, 25), &[0.0; 8])
        .expect("stable");
    let driven = node
        .prescribe_velocity(&window(2, 25), &numbers(9))
        .expect("stable");
    let d = DMatrix::from_column_slice(8, 8, &node.impedance(&window(0, 25)).expect("stable"));
    let expected = DVector::from_vec(held.force) + d * DVector::from_vec(numbers(9));
    let error = (DVector::from_vec(driven.force) - &expected).amax();
    assert!(error <= 1e-12 * expected.amax(), "{error:e}");
    let window_s = 25.0 * node.model.scheme.step;
    for (k, moved) in driven.increment.iter().enumerate() {
        let exact = 0.5 * window_s * (numbers(4)[k] + numbers(9)[k]);
        assert!(
            (moved - exact).abs() <= 1e-12 * window_s,
            "{moved:e} {exact:e}"
        );
    }
    node.commit(&window(2, 25), &[]).expect("followed");
    let still = node
        .prescribe_velocity(&window(3, 1), &numbers(9))
        .expect("stable");
    let exact: Vec<f64> = numbers(9).iter().map(|v| v * window_s / 25.0).collect();
    for (moved, exact) in still.increment.iter().zip(exact) {
        assert!(
            (moved - exact).abs() <= 1e-12 * window_s,
            "the window before must end at v_end"
        );
    }
}

/// Largest |W - E - D| / sum |W| over the windows, with the answers' work as W.
fn closure(config: &Value) -> f64 {
    let mut node = node(config);
    let points = node.couple("top").expect("a set").len();
    let description = node.describe();
    let (mut supplied, mut worst) = (0.0, 0.0f64);
    for index in 0..200u64 {
        let velocity: Vec<f64> = (0..2 * points as u64)
            .map(|k| ((index * 37 + k * 11) % 101) as f64 / 101.0 - 0.5)
            .collect();
        let followed = node
            .prescribe_velocity(&window(index, 10), &velocity)
            .expect("stable");
        supplied += followed.work.iter().sum::<f64>();
        let report = node.commit(&window(index, 10), &[]).expect("followed");
        let terms = || {
            description
                .ledger
                .iter()
                .zip(&report[description.signals.len()..])
        };
        let sum = |role: Role| -> f64 {
            let own = terms().filter(|(term, _)| term.role == role);
            own.map(|(_, value)| value).sum()
        };
        assert!((sum(Role::InterfaceWork) / supplied - 1.0).abs() < 1e-12);
        let defect = supplied - sum(Role::Stored) - sum(Role::Dissipated);
        worst = worst.max(defect.abs() / supplied.abs());
    }
    worst
}

#[test]
fn every_joule_of_a_prescribed_velocity_is_accounted_for() {
    for damping in [0.5, 0.75, 1.0] {
        for (mass_damping, stiffness_damping) in [(0.0, 0.0), (3e5, 0.0), (1e5, 1e-9)] {
            let time = json!({"time": {"damping": damping, "mass_damping_per_s": mass_damping,
                                       "stiffness_damping_s": stiffness_damping}});
            let worst = closure(&with(block(), time));
            let case = format!("b {damping} c {mass_damping} beta {stiffness_damping}");
            assert!(worst <= 1e-10, "{case}: {worst:e}");
        }
    }
}

#[test]
fn repeats_and_threads_do_not_change_a_bit() {
    let run = |threads: usize, repeats: bool| {
        let mut node = node_on(&rail(paper()), threads);
        node.couple("top").expect("a set");
        let points: Vec<usize> = (180..210).collect();
        node.select(&points).expect("points of the set");
        let mut answers = vec![node.impedance(&window(0, 3)).expect("stable")];
        for index in 0..4 {
            let velocity: Vec<f64> = (0..60).map(|k| ((index + 7 * k) as f64).sin()).collect();
            if repeats {
                node.prescribe_velocity(&window(index, 9), &[1.0; 60])
                    .expect("stable");
            }
            let followed = node
                .prescribe_velocity(&window(index, 9), &velocity)
                .expect("stable");
            answers.extend([followed.force, followed.increment, followed.work]);
            answers.push(node.commit(&window(index, 9), &[]).expect("followed"));
        }
        (answers, node.finish().expect("it ends").state_hash)
    };
    let one = run(1, false);
    assert_eq!(run(2, false), one);
    assert_eq!(run(3, true), one);
}

#[test]
fn impossible_prescribed_velocities_are_refused_by_name() {
    let plastic = with(block(), json!({"material": {"yield_pa": 1e8}}));
    let mut plastic = node(&plastic);
    assert!(!plastic.describe().capabilities.prescribed_velocity);
    plastic.couple("top").expect("a set");
    let refused = [
        plastic.impedance(&window(0, 3)).err(),
        plastic
            .prescribe_velocity(&window(0, 3), &[0.0; 2 * POINTS])
            .err(),
    ];
    for error in refused {
        let error = error.expect("a plastic body is refused");
        assert_eq!(error.code, FaultCode::Configuration);
        assert!(error.message.contains("dual-schur-secant"), "{error}");
    }
    let mut elastic = node(&block());
    assert!(elastic.describe().capabilities.prescribed_velocity);
    elastic.couple("top").expect("a set");
    let mut velocity = [0.0; 2 * POINTS];
    let short = elastic.prescribe_velocity(&window(0, 3), &velocity[1..]);
    assert!(short.expect_err("one is missing").message.contains("25"));
    velocity[7] = f64::NAN;
    let invalid = elastic
        .prescribe_velocity(&window(0, 3), &velocity)
        .expect_err("no number");
    for part in ["y component", "velocity", "point 3"] {
        assert!(invalid.message.contains(part), "{invalid}");
    }
    let none = elastic.prescribe_velocity(&window(0, 0), &[0.0; 2 * POINTS]);
    assert!(none.is_err(), "no steps");
}
