//! Costs of a run, a log and a replay: measured times, predictions, the share of the log.
//!
//! Reference: the file itself, and the clocks of run and replay. The predicted size is right within 25 %: lz4 compresses every scene
//! differently.

use harness::random_log::{count, frames, write};
use harness::runs::{Scratch, parse_json, thirdbody};
use scenario::load::load;
use serde_json::Value;

use super::resume::{conduct, loaded, shipped};

/// Output of the command.
fn printed(arguments: &[&str]) -> Vec<u8> {
    let scratch = Scratch::new("printed");
    let output = thirdbody(scratch.path()).args(arguments).output();
    let output = output.expect("the command runs");
    assert!(output.status.success(), "{output:?}");
    output.stdout
}

fn predicted_over_actual(sets: &[&str]) -> f64 {
    let scratch = Scratch::new("log-size");
    let out = scratch.path().join("run");
    let summary = conduct(&loaded(&shipped("quick"), sets), &out, 1, None)
        .summary
        .value();
    let log = &summary["log"];
    let number = |key: &str| log[key].as_f64().expect("a number");
    let size = std::fs::metadata(out.join("exchange.mcap")).expect("it was closed");
    assert_eq!(number("bytes"), size.len() as f64);
    assert!(number("messages") > 0.0);
    assert!(number("share") > 0.0 && number("share") < 1.0);
    assert!(number("wall_s") > 0.0 && number("writer_wall_s") > 0.0);
    let coordinator = std::fs::read_to_string(out.join("logs/coordinator.log")).expect("a log");
    assert!(coordinator.contains("log: about"), "{coordinator}");
    number("predicted_bytes") / number("bytes")
}

#[test]
fn the_predicted_size_of_the_log_is_within_25_percent() {
    let cases: [&[&str]; 4] = [
        &["run.end_s=6e-4", "interface.layer-base.scheme=velocity"],
        &["run.end_s=9e-4", "run.output.flush_every_windows=1"],
        &["run.end_s=6e-4", "interface.layer-base.substeps=3"],
        &[
            "run.end_s=6e-4",
            "participant.rail.config.mesh.size_m=0.2e-3",
            "participant.rail.config.time.step_s=3.4e-8",
        ],
    ];
    for sets in cases {
        let ratio = predicted_over_actual(sets);
        println!("{sets:?}: predicted over actual {ratio:.3}");
        assert!((0.75..=1.25).contains(&ratio), "{sets:?}: {ratio:.3}");
    }
}

#[test]
fn check_predicts_the_size_of_the_log_if_one_is_written() {
    let predicts = |set: &str| {
        let quick = shipped("quick");
        let arguments = ["check", &quick.to_string_lossy(), "--set", set];
        String::from_utf8_lossy(&printed(&arguments)).contains("log: about")
    };
    assert!(predicts("run.output.exchange=true"));
    assert!(!predicts("run.output.exchange=false"));
}

#[test]
fn check_predicts_time_and_memory_with_their_uncertainty() {
    let checked = |name: &str, sets: &[&str]| {
        let scene = shipped(name);
        let scene = scene.to_string_lossy();
        let arguments = [["check", &scene].as_slice(), sets].concat();
        String::from_utf8_lossy(&printed(&arguments)).into_owned()
    };
    let always = ["cost: about", "cost: range", "memory: about"];
    let coupled = [
        "cost: rail: ",
        " element_steps",
        "cost: third-body: ",
        "contact_iterations",
        "cost: coupler: ",
    ];
    let quick = checked("quick", &[]);
    let alone = checked("verification/bouncing-disk", &[]);
    for word in always {
        assert!(
            quick.contains(word) && alone.contains(word),
            "{word}: {quick}{alone}"
        );
    }
    assert!(coupled.iter().all(|word| quick.contains(word)), "{quick}");
    assert!(!alone.contains("cost: coupler"), "{alone}");
    assert!(!checked("quick", &["--no-start"]).contains("cost"));
    // A run that is refused has no cost.
    let scratch = Scratch::new("refused");
    let naive = [
        "check",
        "quick",
        "--set",
        "interface.layer-base.scheme=staggered-serial",
    ];
    let refused = thirdbody(scratch.path()).args(naive).output();
    let refused = refused.expect("the command runs");
    assert_eq!(refused.status.code(), Some(2), "{refused:?}");
    assert!(!String::from_utf8_lossy(&refused.stdout).contains("cost:"));
}

#[test]
fn the_parts_of_the_wall_add_up() {
    let scratch = Scratch::new("parts");
    let sets = ["run.end_s=2e-4"];
    let run = conduct(
        &loaded(&shipped("quick"), &sets),
        &scratch.path().join("run"),
        1,
        None,
    );
    let value = run.summary.value();
    let number = |value: &Value| value.as_f64().expect("a number");
    let sum =
        |value: &Value, keys: &[&str]| keys.iter().map(|key| number(&value[key])).sum::<f64>();
    let wall_s = number(&value["wall_s"]);
    let parts = sum(
        &value,
        &["setup_wall_s", "windows_wall_s", "closing_wall_s"],
    );
    assert!(
        (parts - wall_s).abs() < 0.02 * wall_s,
        "{parts} of {wall_s}"
    );
    let (windows_s, coupling) = (number(&value["windows_wall_s"]), &value["coupling"]);
    let parts = sum(coupling, &["solve_wall_s", "own_wall_s", "wait_s"]);
    assert!(
        (parts - windows_s).abs() < 0.02 * windows_s,
        "{parts} of {windows_s}"
    );
    let parts = sum(coupling, &["solve_wall_s", "wall_s"]);
    assert!(
        (parts - windows_s).abs() < 0.02 * windows_s,
        "{parts} of {windows_s}"
    );
    for key in ["solve_wall_s", "own_wall_s", "wait_s", "share"] {
        assert!(number(&coupling[key]) > 0.0, "{key}: {coupling}");
    }
    // The union of the solves is at most their sum, and each participant works or waits from its greeting to its end.
    let participants = value["participants"].as_object().expect("a table");
    let solves: f64 = participants
        .values()
        .map(|p| number(&p["solve_wall_s"]))
        .sum();
    assert!(
        number(&coupling["solve_wall_s"]) <= solves,
        "{solves}: {coupling}"
    );
    for (name, participant) in participants {
        let own = sum(participant, &["solve_wall_s", "wait_s"]);
        assert!(
            (windows_s..wall_s).contains(&own),
            "{name}: {own} of {windows_s}"
        );
    }
}

#[test]
fn a_run_reports_the_error_of_its_prediction() {
    let scratch = Scratch::new("predicted");
    let sets = ["run.end_s=1e-3"];
    let scene = loaded(&shipped("wheel-rail-fe-small"), &sets);
    let value = conduct(&scene, &scratch.path().join("run"), 1, None)
        .summary
        .value();
    let found = &value["prediction"];
    let Some(predicted_s) = found["wall_s"].as_f64() else {
        let windows_s = value["windows_wall_s"].as_f64();
        assert!(
            windows_s.is_some_and(|s| s < 1.5),
            "no prediction: {value:#}"
        );
        return;
    };
    let ratio = predicted_s / value["wall_s"].as_f64().expect("a number");
    assert_eq!(found["wall_over_actual"].as_f64(), Some(ratio));
    let ends = ["wall_low_s", "wall_high_s"].map(|key| found[key].as_f64().expect("a number"));
    assert!((ends[0]..=ends[1]).contains(&predicted_s), "{found}");
    let memory = found["memory_over_actual"].as_f64().expect("a number");
    // Other tests use and free memory in the same process: the prediction was 1.0003 of the peak with six of them.
    assert!(memory > 0.0 && memory <= 1.1, "{found}");
    println!("predicted over actual: time {ratio:.3}, memory {memory:.3}");
}

#[test]
fn a_replay_reports_its_time_and_the_time_of_the_run() {
    let scratch = Scratch::new("replay-cost");
    let out = scratch.path().join("run");
    let sets = ["run.end_s=1e-4".to_string()];
    let scene = load(&shipped("quick").to_string_lossy(), &sets).expect("it is valid");
    let ended = conduct(&scene, &out, 1, None);
    let value = parse_json(&printed(&["replay", &out.to_string_lossy(), "--json"]));
    for row in value["results"].as_array().expect("rows") {
        let wall_s = row["wall_s"].as_f64().expect("a number");
        if row["who"] == "coupler" {
            assert!(row["solve_wall_s"].is_null());
            continue;
        }
        let solve_s = row["solve_wall_s"].as_f64().expect("a number");
        assert!(0.0 < solve_s && solve_s <= wall_s, "{row}");
        let name = row["who"].as_str().expect("a name");
        let run = &ended.summary.value()["participants"][name]["solve_wall_s"];
        assert_eq!(&row["run_solve_wall_s"], run);
    }
}

#[test]
fn the_overhead_of_a_message_is_small() {
    let scratch = Scratch::new("random-log");
    let path = scratch.path().join("exchange.mcap");
    for doubles in [100, 1_000, 10_000] {
        let messages = 8_000_000 / doubles;
        let stats = write(&path, &frames(doubles), messages).expect("the folder is writable");
        assert_eq!(stats.messages, messages as u64);
        assert_eq!(count(&path).expect("it was closed"), stats.messages);
        // Random mantissas do not compress.
        let size = stats.bytes as f64 / (8 * messages * doubles) as f64;
        assert!((0.9..1.2).contains(&size), "{doubles} doubles: {size}");
    }
}
