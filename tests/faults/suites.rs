//! The user's own suites: seeds, references, numbers that are only printed, allowed warnings, and runs that are kept.

use std::path::Path;

use harness::runs::{Scratch, parse_json, thirdbody};
use serde_json::Value;

use crate::scene::fails;

/// A load on three layers of grains, compared with the first of them, and a case whose expected warning does not come.
const EXPECTED: &str = r#"
text = "Three realisations of `one` layer."
[[case]]
name = "three seeds"
source = "nobody"
seeds = [1, 2, 3]
set = ["participant.third-body.config.wheel.cycles=0.0", "participant.third-body.config.wheel.ramp_s=1e-4"]
may_warn = ["layer_at_rest", "wheel_contacts", "unreached"]
reference_scene = "."
reference = ["participant.third-body.config.wheel.cycles=0.0", "participant.third-body.config.wheel.ramp_s=1e-4"]
pictures = ["scene.svg"]
[[case.number]]
path = "results.approach_m"
of = "approach"
reported = true
published = 1e-5
basis = "calibrated"
[[case.number]]
path = "results.load_n"
expected = 8000.0
tolerance_rel = 1e-12
[[case.number]]
path = "results.approach_m"
of = "approach of the first seed"
tolerance_rel = 1e-12
[[case.number]]
path = "profile.pressure_pa"
of = "distance from the first seed"
norm = "l2"
bin_m = 1e-3
reported = true
[[case]]
name = "warned"
source = "nobody"
warns = ["wheel_drift"]
set = ["participant.third-body.config.wheel.cycles=0.0", "participant.third-body.config.wheel.ramp_s=1e-5"]
[[case]]
name = "cut short"
source = "nobody"
set = ["run.end_s=6e-5"]
may_warn = ["unreached"]
"#;

fn validated(work: &Path) -> (Option<i32>, Vec<Value>) {
    let mut command = thirdbody(work);
    command.args(["validate", "--suite", "paper", "--json", "--out", "kept"]);
    let output = command.output().expect("it starts");
    let rows = parse_json(&output.stdout)["results"].as_array().cloned();
    (output.status.code(), rows.expect("rows"))
}

#[test]
fn expectations_are_judged_for_every_seed_and_runs_are_kept() {
    let work = Scratch::new("own-suite");
    let scene = work.path().join("scenarios/paper/layer");
    let mut new = thirdbody(work.path());
    let copied = new
        .args(["new", "layer-alone", "scenarios/paper/layer"])
        .output();
    assert!(copied.is_ok_and(|copied| copied.status.success()));
    std::fs::write(scene.join("expected.toml"), EXPECTED).expect("writable");
    let (code, rows) = validated(work.path());
    assert_eq!(code, Some(8), "{rows:#?}");
    let row = |name: &str| -> &Value {
        let found = rows
            .iter()
            .find(|row| row["name"].as_str().is_some_and(|own| own.ends_with(name)));
        found.unwrap_or_else(|| panic!("no {name} in {rows:#?}"))
    };
    let approach = row("three seeds: approach");
    let [least, most] = [0, 1].map(|k| approach["seeds"][k].as_f64().expect("three seeds"));
    let median = approach["ours"].as_f64().expect("a number");
    assert!(least < median && median < most, "{approach}");
    assert_eq!(
        (&approach["reported"], &approach["holds"]),
        (&Value::Bool(true), &Value::Bool(true))
    );
    assert_eq!(approach["basis"], "calibrated");
    assert_eq!(row("results.load_n")["holds"], true);
    // Only one of the three seeds is the reference itself.
    assert_eq!(row("approach of the first seed")["holds"], false);
    let distance = row("distance from the first seed");
    assert_eq!(distance["seeds"][0], 0.0, "{distance}");
    assert!(distance["seeds"][1].as_f64() > Some(0.05), "{distance}");
    assert_eq!(row("three seeds: warnings")["holds"], true);
    assert_eq!(row("warned: warnings")["holds"], false);
    let short = row("cut short: warnings");
    assert_eq!(
        (&short["holds"], &short["ours"]),
        (&true.into(), &serde_json::json!(["unreached"]))
    );
    let page = std::fs::read_to_string(work.path().join("kept/validation.html")).expect("a page");
    for words in [
        "Three realisations of <code>one</code> layer.",
        "does not hold",
        "<svg",
        "calibrated",
        "run.seed=S",
    ] {
        assert!(page.contains(words), "{words}");
    }
    // Three seeds, the first of which is also the reference, and two more cases: each runs once.
    let attempts = || {
        let tasks = std::fs::read_dir(work.path().join("kept/tasks")).expect("tasks");
        let files = tasks.flatten().map(|task| task.path().join("attempts"));
        let texts = files.map(|file| std::fs::read_to_string(file).expect("attempts"));
        texts
            .map(|text| text.lines().count())
            .collect::<Vec<usize>>()
    };
    assert_eq!(attempts(), [1; 5]);
    assert_eq!(validated(work.path()), (code, rows.clone()));
    assert_eq!(attempts(), [1; 5]);
}

#[test]
fn a_case_with_half_a_reference_is_refused() {
    let work = Scratch::new("half-reference");
    let scene = work.path().join("scenarios/paper/layer");
    let copied = thirdbody(work.path())
        .args(["new", "layer-alone", "scenarios/paper/layer"])
        .output();
    assert!(copied.is_ok_and(|copied| copied.status.success()));
    let case = "[[case]]\nname = \"half\"\nsource = \"nobody\"\n";
    let block = "[[case.number]]\npath = \"results.load_n\"\nreported = true\n";
    for (keys, why) in [
        ("reference_scene = \".\"\n", "write reference = []"),
        ("reference = []\n", "goes with numbers without `expected`"),
    ] {
        let text = format!("{case}{keys}{block}");
        std::fs::write(scene.join("expected.toml"), text).expect("writable");
        let refused = thirdbody(work.path())
            .args(["validate", "--suite", "paper"])
            .output();
        fails(&refused.expect("it starts"), 2, &["case `half`", why]);
    }
}
