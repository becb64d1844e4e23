//! `run --seeds`: the runs are those of single runs, to the bit, and the means are theirs.

use harness::runs::{Scratch, parse_json, thirdbody};
use serde_json::Value;

/// Results of a single run with this seed.
fn single(work: &Scratch, seed: u64) -> Value {
    let seed = format!("run.seed={seed}");
    let out = format!("single-{}", &seed[9..]);
    let mut command = thirdbody(work.path());
    command.args([
        "run",
        "layer-alone",
        "--json",
        "--out",
        &out,
        "--set",
        &seed,
    ]);
    parse_json(&command.output().expect("it starts").stdout)
}

#[test]
fn each_run_has_the_bits_of_a_single_run_and_the_mean_is_theirs() {
    let work = Scratch::new("seeds");
    let seeds = |more: &[&str]| {
        let mut command = thirdbody(work.path());
        command.args(["run", "layer-alone", "--seeds", "3", "--set", "run.seed=4"]);
        command.args(more).output().expect("it starts")
    };
    let output = seeds(&["--json"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let all = parse_json(&output.stdout);
    let singles = [4, 5, 6].map(|seed| single(&work, seed));
    let mut values = Vec::new();
    for (run, single) in all["runs"].as_array().expect("a list").iter().zip(&singles) {
        let folder = run["path"].as_str().expect("a path");
        let text = std::fs::read_to_string(format!("{folder}/summary.json")).expect("it is there");
        let summary: Value = serde_json::from_str(&text).expect("it is JSON");
        assert_eq!(summary["hashes"], single["hashes"]);
        values.push(single["results"]["approach_m"].as_f64().expect("a number"));
    }
    let approach = &all["results"]["approach_m"];
    let number = |key: &str| approach[key].as_f64().expect("a number");
    let mean = values.iter().sum::<f64>() / 3.0;
    let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 2.0;
    // Student's t for two degrees of freedom.
    let half_width = 4.303 * (variance / 3.0).sqrt();
    assert!((number("mean") - mean).abs() < 1e-12 * mean, "{approach}");
    assert!((number("half_width_95") - half_width).abs() < 1e-3 * half_width);
    assert!(
        work.path()
            .join("runs/layer-alone-seeds/report.html")
            .is_file()
    );

    // Runs that are done are not done again, and the words are those of people.
    let words = seeds(&[]);
    let text = String::from_utf8_lossy(&words.stdout).into_owned();
    assert!(
        text.contains("3 of 3 completed") && text.contains("approach_m"),
        "{text}"
    );
    assert!(!String::from_utf8_lossy(&words.stderr).contains("1 of 3: task"));
}

#[test]
fn a_scene_without_chance_is_refused() {
    let work = Scratch::new("no-chance");
    let mut command = thirdbody(work.path());
    command.args(["run", "verification/bar-thrown", "--seeds", "2"]);
    let output = command.output().expect("it starts");
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        text.contains("--seeds") && text.contains("same bits"),
        "{text}"
    );
}
