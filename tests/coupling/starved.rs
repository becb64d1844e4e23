//! A contact solve that ran out of iterations (case 10 of the coupling page): the gap is still zero, since the coupler gives
//! the continuum the returned force, so only the solver's own residual shows the fault.

use harness::runs::{run_in_process, run_over_shared_memory};
use harness::scene::{bar, body, glue, head};
use scenario::error::Error;

fn scenario() -> String {
    [
        head("starved", 1.0, ""),
        bar("bar", 10, 0.5, ""),
        body(10.0, 1.0, 1.0, "end_s = 50.0\nstarve_from_window = 7"),
        glue("dual-schur", 10, "tolerance_rel = 1e-9"),
    ]
    .concat()
}

#[test]
fn a_starved_contact_solve_ends_the_run_by_name() {
    let left = run_in_process(&scenario(), &[]).expect("it is valid");
    let error = left.ended.error.as_ref().expect("window 7 is starved");
    assert!(matches!(error, Error::NotConverged(_)), "{error}");
    let text = error.to_string();
    for word in ["`glue`", "window 7", "starved", "3.000e-1"] {
        assert!(text.contains(word), "no {word} in {text}");
    }
    assert_eq!(left.text("status"), "not_converged");
    assert_eq!(left.number("exit_code"), 3.0);
    assert_eq!(left.number("windows"), 7.0);
    assert!(
        left.number("coupling.gap_max_rel") < 1e-12,
        "the gap does not show it"
    );
}

#[test]
fn halving_a_solve_that_stays_starved_ends_by_name() {
    let halve = ["interface.glue.on_not_converged=halve"];
    let left = run_in_process(&scenario(), &halve).expect("it is valid");
    let text = left
        .ended
        .error
        .as_ref()
        .expect("window 7 is starved")
        .to_string();
    for word in ["starved", "one step left"] {
        assert!(text.contains(word), "no {word} in {text}");
    }
    // Ten steps of the window: 10, 5, 3, 2, 1.
    assert_eq!(left.number("coupling.halved_windows"), 4.0);
}

#[test]
fn a_starved_solve_is_refused_over_shared_memory_too() {
    let left = run_over_shared_memory(&scenario(), &[]).expect("it is valid");
    let error = left.ended.error.as_ref().expect("window 7 is starved");
    assert!(matches!(error, Error::NotConverged(_)), "{error}");
    assert_eq!(left.number("windows"), 7.0);
}

#[test]
fn accepting_counts_the_windows() {
    let accept = ["interface.glue.on_not_converged=accept"];
    let left = run_in_process(&scenario(), &accept)
        .expect("it is valid")
        .completed();
    assert_eq!(
        left.number("coupling.not_converged_windows"),
        left.number("windows") - 7.0
    );
}
