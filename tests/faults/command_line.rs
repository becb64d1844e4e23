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
        "run", "check", "inspect", "report", "validate", "bench", "node",
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
            let told = String::from_utf8_lossy(&output.stdout);
            assert!(told.contains("cost: about"), "{told}");
            checked += 1;
        }
    }
    assert!(checked >= 2);
}

#[test]
fn the_verification_scenes_give_what_they_must() {
    let output = thirdbody(&["validate", "--json"]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success(),
        "{text}{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert!(text.matches("\"holds\":true").count() >= 10, "{text}");
}

#[test]
fn inputs_at_their_limits_are_right_refused_or_detected() {
    let output = thirdbody(&["validate", "--suite", "extremes", "--json"]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success(),
        "{text}{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert!(text.matches("\"holds\":true").count() >= 80, "{text}");
}

#[test]
fn short_forms_of_published_benchmarks_hold() {
    let output = thirdbody(&["validate", "--suite", "benchmarks", "--json"]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success(),
        "{text}{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert!(text.matches("\"holds\":true").count() >= 60, "{text}");
}

#[test]
fn a_node_outside_of_a_run_says_so() {
    let output = thirdbody(&["node", "fem"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("thirdbody run"));
    assert!(output.stdout.is_empty());
}
