//! Capabilities: the coupler requests only what a participant offers, and a refusal names the key that helps.

use harness::broken::harmed;
use harness::runs::run_in_process;
use harness::scene::{bar, body, glue, head};
use serde_json::Value;

/// A bar with a body at its end. One of them lacks a capability, and answers a request for it with a fault.
fn ends(lacks: [&str; 2], scheme: &str, keys: &str) -> (i32, Value) {
    let text = [
        head(
            "offers",
            1.0,
            "plausible = { energy_balance_rel = [1e300, 1e300] }",
        ),
        bar("bar", 20, 0.5, ""),
        body(20.0, 3.0, -1.0, "end_s = 50.0"),
        glue(scheme, 5, &format!("tolerance_rel = 1e-9\n{keys}")),
    ]
    .concat();
    let left = run_in_process(&harmed(&text, lacks), &[]).expect("it is valid");
    let summary = left.ended.summary.value();
    (left.ended.summary.exit_code, summary)
}

#[test]
fn a_missing_capability_that_is_not_needed_is_no_obstacle() {
    for (lacks, scheme, keys) in [
        (["bar", "no-columns"], "dual-schur", "compliance = \"mass\""),
        (["bar", "no-columns"], "fixed-point-serial", ""),
        (
            ["bar", "no-rollback"],
            "staggered-serial",
            "unsafe_window = true",
        ),
        (
            ["body", "no-rollback"],
            "staggered-parallel",
            "unsafe_window = true",
        ),
        (
            ["body", "rigid-only"],
            "staggered-serial",
            "unsafe_window = true",
        ),
        (["body", "rigid-only"], "fixed-point-serial", ""),
        (["bar", "weightless"], "dual-schur", ""),
        (["bar", "no-step"], "dual-schur", "window_s = 2.5"),
        (
            ["bar", "no-step"],
            "staggered-serial",
            "window_s = 2.5\nunsafe_window = true",
        ),
    ] {
        let (code, summary) = ends(lacks, scheme, keys);
        assert!(code == 0 || code == 8, "{lacks:?} {scheme}: {summary:#}");
        let warnings = summary["warnings"].as_array().expect("a list");
        let judged = warnings
            .iter()
            .any(|warning| warning["code"] == "interface_energy");
        assert!(!judged, "it was asked to be seen failing: {summary:#}");
        let all = ["bar", "nothing"];
        let keys = keys.replace("window_s = 2.5", "");
        let (_, plain) = ends(all, scheme, &keys);
        if !keys.contains("mass") {
            assert_eq!(
                summary["coupling"]["gap_max_rel"], plain["coupling"]["gap_max_rel"],
                "{lacks:?} {scheme}"
            );
        }
        assert_eq!(summary["windows"], plain["windows"], "{lacks:?} {scheme}");
    }
}

#[test]
fn a_missing_capability_is_named_with_the_key_that_helps() {
    for (lacks, scheme, keys, words) in [
        (
            ["bar", "no-columns"],
            "dual-schur",
            "",
            "compliance = \"mass\"",
        ),
        (
            ["bar", "no-rollback"],
            "dual-schur",
            "",
            "scheme = \"staggered-serial\"",
        ),
        (
            ["body", "no-rollback"],
            "fixed-point-serial",
            "",
            "scheme = \"staggered-serial\"",
        ),
        (
            ["bar", "no-rollback"],
            "staggered-serial",
            "on_not_converged = \"halve\"",
            "interface.glue.on_not_converged",
        ),
        (
            ["body", "rigid-only"],
            "dual-schur",
            "",
            "scheme = \"fixed-point-serial\"",
        ),
        (
            ["bar", "weightless"],
            "dual-schur",
            "compliance = \"mass\"",
            "point 0",
        ),
        (
            ["bar", "no-step"],
            "dual-schur",
            "",
            "interface.glue.window_s",
        ),
        (
            ["bar", "nothing"],
            "dual-schur",
            "window_s = 2.5",
            "interface.glue.window_s",
        ),
    ] {
        let (code, summary) = ends(lacks, scheme, keys);
        let message = summary["message"].as_str().expect("a text");
        assert_eq!(code, 2, "{lacks:?} {scheme} {keys}: {message}");
        assert!(
            message.contains(words),
            "{lacks:?} {scheme} {keys}: {message}"
        );
    }
}
