//! Each participant with one fault is rejected by the name of the rule that it breaks.

use std::path::Path;

use coordinator::participants::Watch;
use harness::broken::harmed;
use harness::runs::{Scratch, program, thirdbody};
use harness::scene::{bar, body, glue, head};
use lab::conform::conform;
use lab::conform::rule::{ConformRow, RuleVerdict};
use lab::conform::tested::ConformOptions;
use scenario::load::parse;
use scenario::source::ScenarioSource;

use crate::scene::fails;

/// A bar with a chain at its end.
fn bar_and_body() -> String {
    [
        head("conform", 1.0, ""),
        bar("bar", 20, 0.5, ""),
        body(20.0, 3.0, 0.0, "end_s = 50.0"),
        glue("dual-schur", 5, "tolerance_rel = 1e-9"),
    ]
    .concat()
}

fn rows(participant: &str, harm: &str) -> Vec<ConformRow> {
    rows_of(&bar_and_body(), [participant, harm], &[])
}

fn rows_of(text: &str, harm: [&str; 2], only: &[&str]) -> Vec<ConformRow> {
    let source = ScenarioSource {
        name: "conform/scenario.toml".into(),
        text: harmed(text, harm),
        overrides: vec!["run.transport=channel".into()],
    };
    let loaded = parse(source).expect("it is valid");
    let options = ConformOptions {
        registry: &harness::registry(),
        program: std::path::PathBuf::from("not-started"),
        watch: Watch::default(),
        only: only.iter().map(|word| word.to_string()).collect(),
    };
    conform(&loaded, harm[0], None, &options, |_| {}).expect("it can be tested")
}

fn broken(rows: &[ConformRow]) -> Vec<String> {
    let broken = rows.iter().filter(|row| row.verdict == RuleVerdict::Broken);
    broken.map(|row| row.rule.to_string()).collect()
}

#[test]
fn sound_participants_break_no_rule() {
    for participant in ["bar", "body"] {
        let rows = rows(participant, "nothing");
        let broken = broken(&rows);
        assert!(broken.is_empty(), "{participant}: {rows:#?}");
        let held = rows.iter().filter(|row| row.verdict == RuleVerdict::Holds);
        assert!(held.count() >= 15, "{participant}: {rows:#?}");
    }
}

#[test]
fn a_harm_is_rejected_by_the_name_of_its_rule() {
    for (participant, harm, rule) in [
        ("bar", "nan-length", "surface"),
        ("bar", "nan-mass", "surface"),
        ("bar", "negative-mass", "surface"),
        ("bar", "weightless", "surface"),
        ("bar", "negative-step", "greeting"),
        ("bar", "zero-step", "greeting"),
        ("bar", "zero-columns", "columns"),
        ("bar", "half-columns", "columns"),
        ("bar", "totals", "increments"),
        ("bar", "totals", "work"),
        ("bar", "short-repeats", "repeats"),
        ("bar", "large-repeats", "repeats"),
        ("bar", "forgets", "rollback"),
        ("bar", "nan-signal", "report"),
        ("bar", "nan-energy", "report"),
        ("bar", "short-report", "report"),
        ("bar", "double-ledger", "work"),
        ("bar", "no-interface-work", "work"),
        ("bar", "one-length", "substeps"),
        ("bar", "against", "passive"),
        ("bar", "half-stored", "balance"),
        ("bar", "fields-move", "snapshot"),
        ("bar", "lazy-restore", "checkpoint"),
        ("bar", "one-hash", "farewell"),
        ("bar", "no-steps", "farewell"),
        ("bar", "any-set", "faults"),
        ("bar", "odd-lives", "same-bits"),
        ("bar", "half-velocity", "velocity"),
        ("bar", "claims-alone", "alone"),
        ("body", "always-rigid", "boundary"),
        ("body", "never-converges", "convergence"),
        ("body", "against", "passive"),
        ("body", "double-ledger", "work"),
        ("body", "forgets", "rollback"),
        ("body", "lazy-restore", "checkpoint"),
        ("body", "any-set", "faults"),
    ] {
        let rows = rows(participant, harm);
        let broken = broken(&rows);
        println!("{participant} {harm}: {broken:?}");
        assert!(
            broken.contains(&rule.to_string()),
            "{participant} {harm}: {rows:#?}"
        );
    }
}

#[test]
fn points_that_are_mixed_up_are_rejected() {
    let path = crate::scene::folder("quick").join("scenario.toml");
    let text = std::fs::read_to_string(path).expect("it ships");
    for (harm, expected) in [("nothing", &[][..]), ("wrong-points", &["select"])] {
        let rows = rows_of(&text, ["rail", harm], &["select"]);
        assert_eq!(broken(&rows), expected, "{harm}: {rows:#?}");
    }
}

/// A clamped rail returns the stored energy of a load that comes and goes; its inertia and its damping carry a sudden load.
#[test]
fn dissipated_energy_that_comes_back_is_rejected() {
    let path = crate::scene::folder("quick").join("scenario.toml");
    let text = std::fs::read_to_string(path).expect("it ships");
    for (harm, expected) in [
        ("nothing", &[][..]),
        ("tenth-stored", &["balance"]),
        ("no-kinetic", &["balance"]),
        ("triple-dissipated", &["balance"]),
    ] {
        let rows = rows_of(&text, ["rail", harm], &["balance"]);
        assert_eq!(broken(&rows), expected, "{harm}: {rows:#?}");
    }
}

#[test]
fn a_rule_that_does_not_exist_is_refused_by_name() {
    let work = Scratch::new("conform-only");
    let node = program("verification-node").display().to_string();
    crate::commands::scene(work.path(), &[&node, "bar"], 20);
    let mut command = thirdbody(work.path());
    command.args(["conform", "--scenario", ".", "--participant", "bar"]);
    let output = command
        .args(["--only", "repeat"])
        .output()
        .expect("it starts");
    fails(&output, 2, &["--only repeat", "did you mean `repeats`?"]);
}

/// `thirdbody conform` of the bar as a separate process, started with these words after its kind.
fn conform_process(work: &Path, words: &[&str]) -> (Option<i32>, String) {
    let node = program("verification-node").display().to_string();
    let mut command = thirdbody(work);
    command.args(["conform", "--scenario", ".", "--participant", "bar", "--"]);
    let output = command.args([&node, "bar"]).args(words).output();
    let output = output.expect("it starts");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    (output.status.code(), said)
}

#[test]
fn a_process_is_tested_with_its_frames_and_its_shutdown() {
    let work = Scratch::new("conform");
    let node = program("verification-node").display().to_string();
    crate::commands::scene(work.path(), &[&node, "bar"], 20);
    let (code, said) = conform_process(work.path(), &[]);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("shutdown     holds"), "{said}");
    for field in [
        "t0",
        "t1",
        "step",
        "substeps",
        "window",
        "iteration",
        "turn",
    ] {
        let (code, said) = conform_process(work.path(), &[field]);
        assert_eq!(code, Some(8), "{field}: {said}");
        assert!(said.contains("`bar` breaks: frames"), "{field}: {said}");
    }
}
