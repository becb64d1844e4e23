//! Problem: the longest stable step of the rail's meshes.
//! Exact: h = sqrt(2/b)/omega_max; paper mesh omega_max = 9.18e7 1/s, h = 2.179e-8 / 1.778e-8 / 1.540e-8 s at
//! b = 0.5 / 0.75 / 1.
//! Source: spectral radius of the scheme (see `fem_newmark`), omega_max from an independent code on the same mesh.
//! Mass damping does not lower the limit (derived in `fem_kernel::integrate`).
//! Tolerance: 0.2 % of independent figures with 3 to 4 digits. Runs decide on stability: 400 steps at 0.999 of the
//! limit stay bounded; at 1.01 the fastest mode grows by a factor of 1.15 to 1.3 per step.

use fem_kernel::spectrum;
use protocol::{FaultCode, Node};
use serde_json::{Value, json};

use crate::fem_bodies::{block, node, paper, rail, setting, window, with};

#[test]
fn the_paper_mesh_has_the_limits_of_the_reference() {
    let reference = [(0.5, 2.179e-8), (0.75, 1.778e-8), (1.0, 1.540e-8)];
    for (damping, limit) in reference {
        let config = with(rail(paper()), json!({"time": {"damping": damping}}));
        let node = node(&config);
        let model = &node.model;
        assert!(
            (model.omega_max / 9.18e7 - 1.0).abs() < 2e-3,
            "{:e}",
            model.omega_max
        );
        assert!(
            (model.step_limit / limit - 1.0).abs() < 2e-3,
            "{:e}",
            model.step_limit
        );
        assert_eq!(
            model.step_limit,
            spectrum::step_limit(model.omega_max, damping, 0.0)
        );
    }
}

/// Runs the block at a share of its limit after an impulse at the crown. Returns the largest displacement (m) or the fault.
fn kicked(damping: f64, mass_damping: f64, share: f64) -> Result<f64, protocol::NodeError> {
    let auto = node(&with(block(), json!({"time": {"damping": damping}})));
    let step = share * auto.model.step_limit;
    let time = json!({"time": {"damping": damping, "mass_damping_per_s": mass_damping,
                               "step_s": step, "unsafe_step": share >= 1.0}});
    let mut node = node(&with(block(), time));
    let points = node.couple("top")?.len();
    let mut force = vec![0.0; 2 * points];
    force[points] = -1.0;
    node.advance(&window(0, 1), &force)?;
    node.commit(&window(0, 1), &[])?;
    for index in 1..400 {
        node.advance_alone(&window(index, 1))?;
    }
    Ok(node
        .state()
        .u
        .iter()
        .fold(0.0, |far: f64, u| far.max(u.abs())))
}

#[test]
fn a_step_just_below_the_limit_is_stable() {
    for damping in [0.5, 0.75, 1.0] {
        for mass_damping in [0.0, 3e4, 3e6] {
            let far = kicked(damping, mass_damping, 0.999).expect("it is stable");
            assert!(far < 1e-7, "1 N for one step moves it by {far} m");
        }
    }
}

#[test]
fn a_step_above_the_limit_diverges_and_is_reported() {
    for damping in [0.5, 0.75, 1.0] {
        let fault = kicked(damping, 0.0, 1.01).expect_err("it is unstable");
        assert_eq!(fault.code, FaultCode::Diverged);
        assert!(fault.message.contains("window"), "{}", fault.message);
    }
}

/// The step at which a block, 1 % above its limit and after an impulse, reports divergence, in windows of `substeps` steps.
fn found(damping: f64, substeps: u32) -> u64 {
    let auto = node(&with(block(), json!({"time": {"damping": damping}})));
    let step = 1.01 * auto.model.step_limit;
    let time = json!({"time": {"damping": damping, "step_s": step, "unsafe_step": true}});
    let mut node = node(&with(block(), time));
    let points = node.couple("top").expect("a set").len();
    let mut force = vec![0.0; 2 * points];
    force[points] = -1.0;
    node.advance(&window(0, 1), &force).expect("one step");
    node.commit(&window(0, 1), &[]).expect("one step");
    let fault = (1..1000)
        .find_map(|index| node.advance_alone(&window(index, substeps)).err())
        .expect("it is unstable");
    assert_eq!(fault.code, FaultCode::Diverged);
    let (_, after) = fault
        .message
        .split_once("step ")
        .expect("it gives the step");
    let (number, _) = after.split_once(',').expect("a number");
    number.parse().expect("a number")
}

/// A check after every step finds the second step with ten times the supplied energy.
#[test]
fn divergence_is_found_within_a_hundred_steps_in_windows_of_any_length() {
    for damping in [0.5, 0.75, 1.0] {
        let first = found(damping, 1);
        assert!((3..=150).contains(&first), "b = {damping}: {first}");
        for substeps in [7, 100, 100_000] {
            let late = found(damping, substeps);
            assert!(late < first + 60, "b = {damping}: {late} after {first}");
        }
    }
}

#[test]
fn a_step_above_the_limit_is_refused_with_the_limit_in_seconds() {
    let limit = node(&block()).model.step_limit;
    let above = with(block(), json!({"time": {"step_s": 1.01 * limit}}));
    let error = fem_node::check(&above, &setting(1)).expect_err("it is above the limit");
    assert_eq!(error.key, "time.step_s");
    assert!(
        error.problem.contains(&format!("{limit:.4e} s")),
        "{}",
        error.problem
    );
    let remarks = |config: &Value| -> usize {
        let warnings = fem_node::check(config, &setting(1)).expect("accepted");
        warnings
            .iter()
            .filter(|warning| warning.starts_with("time.step_s"))
            .count()
    };
    let below = with(block(), json!({"time": {"step_s": 0.99 * limit}}));
    assert_eq!(remarks(&below), 0);
    let forced = with(above, json!({"time": {"unsafe_step": true}}));
    assert_eq!(remarks(&forced), 1);
}
