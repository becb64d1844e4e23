//! Policies for a window that should not be accepted: an energy defect above its bound, and numbers that are not finite. The
//! other two faults, no convergence and a starved contact solve, are in `schemes` and `starved`.
//!
//! Problem: an elastic bar of 20 elements of 1 kg and 1 N/m with a held left end, glued to a body of its own mass that starts
//! with 1 m/s. Exact answer: `stop` ends the run with exit code 3 and names interface, window and key; `accept` counts the
//! windows; `halve` reaches the end if shorter windows cure the fault, and otherwise reports that a window cannot be
//! halved. A number that is not finite is never accepted.

use harness::runs::{Left, run_in_process};
use harness::scene::{bar, body, glue, head};
use scenario::error::Error;

fn scenario(scheme: &str) -> String {
    [
        head("policies", 1.0, ""),
        bar("bar", 20, 0.5, "left_fixed = true"),
        body(20.0, 20.0, 1.0, "end_s = 40.0"),
        glue(scheme, 8, "tolerance_rel = 1e-9"),
    ]
    .concat()
}

fn run(scheme: &str, sets: &[&str]) -> Left {
    run_in_process(&scenario(scheme), sets).expect("it is valid")
}

/// The scheme is predicted to be unstable here, and these tests need the instability.
const UNSAFE: &str = "interface.glue.unsafe_window=true";

fn message(left: &Left) -> String {
    let error = left.ended.error.as_ref().expect("it ends early");
    assert_eq!(left.number("exit_code"), 3.0);
    error.to_string()
}

const BOUND: &str = "interface.glue.energy_defect_max_rel=0.1";

#[test]
fn an_energy_defect_above_its_bound_stops_the_run_by_name() {
    let left = run("staggered-serial", &[BOUND, UNSAFE]);
    let text = message(&left);
    for word in ["`glue`", "window", "energy_defect_max_rel = 1.0e-1"] {
        assert!(text.contains(word), "no {word} in {text}");
    }
    assert_eq!(left.text("status"), "not_converged");
    // Accepted windows are within the bound.
    assert!(left.number("coupling.energy_defect_rel") <= 0.1);
}

#[test]
fn an_accepted_energy_defect_is_counted() {
    let accept = [BOUND, UNSAFE, "interface.glue.on_not_converged=accept"];
    let left = run("staggered-serial", &accept).completed();
    assert!(left.number("coupling.not_converged_windows") > 0.0);
    assert!(left.number("coupling.energy_defect_rel") > 0.1);
}

#[test]
fn halving_that_does_not_cure_the_defect_ends_the_run_by_name() {
    let halve = [BOUND, UNSAFE, "interface.glue.on_not_converged=halve"];
    let left = run("staggered-serial", &halve);
    let text = message(&left);
    assert!(text.contains("cannot be halved"), "{text}");
    assert!(left.number("coupling.halved_windows") >= 3.0, "8, 4, 2, 1");
}

#[test]
fn the_default_scheme_stays_within_a_bound_of_rounding() {
    let tight = ["interface.glue.energy_defect_max_rel=1e-12"];
    run("dual-schur", &tight).completed();
}

const NAN: [&str; 2] = [
    "participant.body.config.nan_above_window_s=2.5",
    "participant.bar.config.nan_above_substeps=5",
];

#[test]
fn a_number_that_is_not_finite_ends_the_run_and_names_its_participant() {
    for (set, name) in [(NAN[0], "`body`"), (NAN[1], "`bar`")] {
        for policy in ["stop", "accept"] {
            let policy = format!("interface.glue.on_not_converged={policy}");
            let left = run("dual-schur", &[set, &policy]);
            assert!(matches!(left.ended.error, Some(Error::NotFinite(_))));
            let text = message(&left);
            for word in [name, "NaN", "window 0"] {
                assert!(text.contains(word), "no {word} in {text}");
            }
            assert_eq!(left.text("status"), "diverged");
        }
    }
}

#[test]
fn a_window_that_is_not_finite_is_halved_with_that_policy() {
    for set in NAN {
        let halve = [set, "interface.glue.on_not_converged=halve"];
        let left = run("dual-schur", &halve).completed();
        // Ten windows of eight steps, each replaced by two of four.
        assert_eq!(left.number("coupling.halved_windows"), 10.0);
        assert_eq!(left.number("windows"), 20.0);
        assert!(left.number("coupling.gap_max_rel") <= 1e-12);
    }
}
