//! Same scenario, same build: same bits, whatever the threads, the transport and the company.

use std::path::Path;

use harness::runs::{Scratch, parse_json};
use serde_json::Value;

use crate::scene::{completed, short_quick};

fn hashes(summary: &Value) -> (String, String) {
    let hash = |name: &str| {
        summary["hashes"][name]
            .as_str()
            .expect("a completed run has it")
            .to_string()
    };
    (hash("exchange"), hash("state"))
}

fn run(sets: &[&str], threads: &str) -> (String, String) {
    let work = Scratch::new("bits");
    hashes(&completed(
        short_quick(work.path(), sets).args(["--threads", threads]),
    ))
}

#[test]
fn threads_and_transport_change_no_bit() {
    let first = run(&[], "1");
    assert_eq!(first, run(&[], "1"), "a second run");
    assert_eq!(first, run(&[], "2"), "two threads");
    assert_eq!(
        first,
        run(&["run.transport=channel"], "1"),
        "in one process"
    );
}

#[test]
fn nor_do_they_along_a_given_velocity() {
    let velocity = "interface.layer-base.scheme=velocity";
    let first = run(&[velocity], "1");
    assert_ne!(first, run(&[], "1"), "another scheme");
    assert_eq!(first, run(&[velocity], "2"), "two threads");
    assert_eq!(first, run(&[velocity, "run.transport=channel"], "1"));
}

#[test]
fn nor_do_they_where_the_rail_follows_the_grains() {
    let sets = [
        "interface.layer-base.scheme=fixed-point-serial",
        "interface.layer-base.dirichlet=continuum",
        "interface.layer-base.tolerance_rel=1e-4",
    ];
    let first = run(&sets, "1");
    assert_ne!(first, run(&[], "1"), "another scheme");
    assert_eq!(first, run(&sets, "2"), "two threads");
    let inside = [sets.as_slice(), &["run.transport=channel"]].concat();
    assert_eq!(first, run(&inside, "1"), "in one process");
}

#[test]
fn another_seed_and_one_ulp_of_load_change_both_hashes() {
    let first = run(&[], "1");
    let ulp = f64::from_bits(8000f64.to_bits() + 1);
    let load = format!("participant.third-body.config.wheel.load_n={ulp:?}");
    for set in ["run.seed=2", load.as_str()] {
        let other = run(&[set], "1");
        assert_ne!(first.0, other.0, "{set}");
        assert_ne!(first.1, other.1, "{set}");
    }
}

#[test]
fn two_runs_at_the_same_time_do_not_hear_each_other() {
    let works = [Scratch::new("one"), Scratch::new("other")];
    let start = |path: &Path| {
        short_quick(path, &[])
            .stdout(std::process::Stdio::piped())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .expect("the program starts")
    };
    let children = works.each_ref().map(|work| start(work.path()));
    let ended = children.map(|child| child.wait_with_output().expect("its output was piped"));
    for output in &ended {
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
    }
    let [one, other] = ended.map(|output| hashes(&parse_json(&output.stdout)));
    assert_eq!(one, other);
    assert_eq!(one, run(&[], "1"));
}
