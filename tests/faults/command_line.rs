//! The command itself: its verbs, and where its results go.

use std::process::{Command, Output};

fn thirdbody(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_thirdbody"))
        .args(arguments)
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
        .output()
        .expect("the program starts")
}

#[test]
fn every_verb_explains_itself() {
    for verb in [
        "run", "check", "inspect", "report", "validate", "bench", "study", "compare", "node",
    ] {
        let output = thirdbody(&[verb, "--help"]);
        assert!(output.status.success(), "{verb}");
        assert!(
            String::from_utf8_lossy(&output.stdout).contains("Usage: thirdbody"),
            "{verb}"
        );
    }
}

#[test]
fn every_shipped_scene_is_valid() {
    let scenarios = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios");
    let mut checked = 0;
    for entry in std::fs::read_dir(scenarios).expect("they ship").flatten() {
        if entry.path().join("scenario.toml").is_file() {
            let output = thirdbody(&["check", &entry.path().display().to_string()]);
            assert!(
                output.status.success(),
                "{}",
                String::from_utf8_lossy(&output.stderr)
            );
            let printed = String::from_utf8_lossy(&output.stdout);
            let waits = printed.contains("takes longer than 8 s and a check does not wait for it");
            assert!(printed.contains("cost: about") || waits, "{printed}");
            checked += 1;
        }
    }
    assert!(checked >= 2);
}

/// Every row of a suite holds, and the suite has at least `rows` rows.
fn suite_holds(arguments: &[&str], rows: usize) {
    let output = thirdbody(&[&["validate", "--json"], arguments].concat());
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success(),
        "{text}{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert!(text.matches("\"holds\":true").count() >= rows, "{text}");
}

#[test]
fn the_verification_scenes_hold() {
    suite_holds(&[], 10);
}

/// Creep of a line contact by Carter and on steel, braking and driving, and a disk below the face of a wheel; the whole suite takes 45 s.
#[test]
fn wheels_roll_as_the_exact_answers_say() {
    suite_holds(&["--suite", "rolling", "--only", "0.64"], 12);
    suite_holds(&["--suite", "rolling", "--only", "disk"], 15);
}

#[test]
fn inputs_at_their_limits_are_right_refused_or_detected() {
    suite_holds(&["--suite", "extremes"], 80);
}

#[test]
fn short_forms_of_published_benchmarks_hold() {
    suite_holds(&["--suite", "benchmarks"], 60);
}

#[test]
fn the_short_form_of_the_paper_holds() {
    suite_holds(&["--suite", "paper"], 40);
}

#[test]
fn valid_scenes_end_without_a_warning() {
    suite_holds(&["--suite", "variants", "--only", "two-rails"], 18);
}

#[test]
fn a_suite_without_a_chosen_case_is_refused() {
    let output = thirdbody(&["validate", "--suite", "scenes", "--only", "nothing"]);
    assert_eq!(output.status.code(), Some(2));
    let printed = String::from_utf8_lossy(&output.stderr);
    assert!(printed.contains("--only nothing"), "{printed}");
}

#[test]
fn a_node_outside_of_a_run_says_so() {
    let output = thirdbody(&["node", "fem"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("thirdbody run"));
    assert!(output.stdout.is_empty());
}
