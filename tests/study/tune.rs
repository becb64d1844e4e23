//! `thirdbody tune` and `study new`: their results, files and refusals.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use harness::runs::{Scratch, parse_json, thirdbody};
use serde_json::Value;

use crate::rows::{printed, words};

/// `thirdbody tune`, which writes its study to the folder `found`.
fn tune(work: &Scratch, scene: &str, arguments: &[&str]) -> Command {
    let mut command = thirdbody(work.path());
    command.args(["--quiet", "tune", scene, "--no-run", "--study", "found"]);
    command.args(arguments);
    command
}

fn study(work: &Scratch) -> Value {
    let text = fs::read(work.path().join("found/study.json")).expect("it is stored");
    parse_json(&text)
}

/// Measures of a wheel on grains.
const MEASURES: [&str; 3] = ["pressure", "height", "friction"];

/// The errors of a run against another one, by `compare` with the found study.
fn errors(work: &Scratch, run: &Path, reference: &Path) -> [f64; 3] {
    let mut compare = thirdbody(work.path());
    compare.arg("compare").args([run, reference]);
    compare.args(["--study", "found", "--json"]);
    let compared = parse_json(printed(&mut compare, 0).as_bytes());
    let error = |name: &str| {
        compared["measures"][name]["error"]
            .as_f64()
            .expect("a number")
    };
    MEASURES.map(error)
}

/// Number of attempts of all runs of `tune`.
fn attempts(work: &Scratch) -> usize {
    let tasks = fs::read_dir(work.path().join("found/tasks")).expect("it is there");
    let attempts = tasks
        .flatten()
        .map(|task| fs::read_to_string(task.path().join("attempts")));
    attempts
        .map(|text| text.expect("lines").lines().count())
        .sum::<usize>()
}

/// Grains on a rigid base, with a bound that the first setting keeps. The setting is stored with its noise and the error of its reference.
/// `run --budget` uses it for a new seed, whose error against its own reference is below the bound; another load is refused.
#[test]
fn a_setting_is_found_stored_and_used_for_other_seeds() {
    let work = Scratch::new("tune-layer");
    let arguments = ["--error", "40%", "--within", "10min"];
    // A folder with the name of the scene, but without a scene.
    fs::create_dir(work.path().join("layer-alone")).expect("it is writable");
    let first = printed(&mut tune(&work, "layer-alone", &arguments), 0);
    assert!(
        first.contains("choice") && first.contains("mass scale"),
        "{first}"
    );
    assert!(
        first.contains("by extrapolation, the reference itself errs by"),
        "{first}"
    );
    let found = study(&work);
    let scenes = found["scene_keys"][0]["values"].as_array().expect("seeds");
    assert!(scenes.len() >= 4 && found["seedless"] == false, "{found:#}");
    // The file beside it describes the study.
    let file = fs::read_to_string(work.path().join("found/study.toml")).expect("it is kept");
    let file: toml::Table = file.parse().expect("it is a study");
    let seeds = file["vary"][0]["values"].as_array().expect("seeds");
    assert_eq!(seeds.len(), scenes.len());
    let missed = found["reference_misses"].as_array().expect("a list");
    assert!(
        missed.iter().all(|missed| missed.as_f64() > Some(0.0)),
        "{missed:?}"
    );
    let floors = found["floors"][0].as_array().expect("a list");
    assert!(
        floors.iter().all(|floor| floor.as_f64() > Some(0.0)),
        "{floors:?}"
    );

    let run = |out: &str, sets: &[String], more: &[&str]| {
        let mut run = thirdbody(work.path());
        run.args([
            "--quiet",
            "run",
            "layer-alone",
            "--out",
            out,
            "--set",
            "run.seed=77",
        ]);
        for set in sets {
            run.args(["--set", set]);
        }
        run.args(more).output().expect("the program starts")
    };
    let budget = ["--budget", "error=40%", "--study", "found"];
    let chosen = run("chosen", &[], &budget);
    assert!(chosen.status.success(), "{}", words(&chosen));
    let summary = fs::read(work.path().join("chosen/summary.json")).expect("it was written");
    let promised = parse_json(&summary)["budget"].clone();
    let reference = promised["reference"].as_array().expect("overrides");
    let reference: Vec<String> = reference
        .iter()
        .filter_map(|set| set.as_str().map(String::from))
        .collect();
    assert!(run("reference", &reference, &[]).status.success());
    let [chosen, reference] = ["chosen", "reference"].map(|name| work.path().join(name));
    let errors = errors(&work, &chosen, &reference);
    let bounds = MEASURES.map(|name| promised["errors"][name]["bound"].as_f64());
    for (error, bound) in errors.iter().zip(bounds) {
        let bound = bound.expect("a bound");
        assert!((1e-9..bound).contains(error), "{error} {bound}");
    }
    let load = ["participant.third-body.config.wheel.load_n=4000.0".to_string()];
    let other = run("other", &load, &budget);
    let said = words(&other);
    assert!(
        other.status.code() == Some(2) && said.contains("load_n = 8000"),
        "{said}"
    );

    // Nothing is done twice: all runs are there, and a lost one is repeated.
    let before = attempts(&work);
    let second = printed(&mut tune(&work, "layer-alone", &arguments), 0);
    assert_eq!((attempts(&work), second), (before, first));
    let mut tasks = fs::read_dir(work.path().join("found/tasks")).expect("it is there");
    let lost = tasks.next().expect("a task").expect("it is readable");
    fs::remove_file(lost.path().join("task.json")).expect("it is done");
    printed(&mut tune(&work, "layer-alone", &arguments), 0);
    // Another cost of the lost run may make `tune` try another setting.
    assert!((before + 1..2 * before).contains(&attempts(&work)));
}

/// Without grains no seed changes anything: one scene gives the error for all seeds.
#[test]
fn a_scene_without_randomness_is_measured_once() {
    let work = Scratch::new("tune-seedless");
    let arguments = ["--error", "5%", "--within", "10min"];
    let printed_text = printed(
        &mut tune(&work, "verification/block-under-wheel", &arguments),
        0,
    );
    assert!(printed_text.contains("with any seed"), "{printed_text}");
    let found = study(&work);
    assert_eq!(found["seedless"], true);
    let setting = found["settings"]
        .as_array()
        .expect("a list")
        .last()
        .expect("one");
    let error = setting["errors"][0][0].as_f64().expect("a number");
    assert!(error > 1e-3 && error <= 0.05, "{error}");
}

#[test]
fn arguments_without_sense_are_refused() {
    let work = Scratch::new("tune-refused");
    let refused = |scene: &str, arguments: &[&str], why: &str| {
        let output: Output = tune(&work, scene, arguments).output().expect("it starts");
        let said = words(&output);
        assert!(
            output.status.code() == Some(2) && said.contains(why),
            "{said}"
        );
    };
    refused("quick", &["--error", "5"], "such as 2% or 0.02");
    refused(
        "quick",
        &["--error", "5%", "--within", "soon"],
        "such as 90s, 10min",
    );
    refused(
        "quick",
        &["--error", "5%", "--for", "tractoin"],
        "pressure, height, friction, shear, traction",
    );
    refused(
        "verification/column",
        &["--error", "5%"],
        "neither a wheel nor an interface",
    );
    refused("quick", &["--error", "5%", "--within", "1ms"], "--within");
    assert!(!work.path().join("found/study.json").exists());
}

/// A study of all choices of a scene, in its own folder.
#[test]
fn a_study_of_a_scene_is_written() {
    let work = Scratch::new("study-new");
    for (scene, choices) in [
        (
            "two-rails",
            &["mesh", "window", "mass scale", "tolerance", "modes"][..],
        ),
        ("layer-alone", &["step", "mass scale", "tolerance"][..]),
        ("verification/rail-under-wheel", &["mesh", "step"][..]),
    ] {
        let mut new = thirdbody(work.path());
        let folder = scene.replace('/', "-");
        new.args(["--quiet", "study", "new", scene, &folder]);
        let printed_text = printed(&mut new, 0);
        let head = printed_text.lines().nth(1).expect("a list");
        for choice in choices {
            assert!(head.split(',').any(|column| column == *choice), "{head}");
        }
        let again = new.output().expect("the program starts");
        assert!(again.status.code() == Some(2) && words(&again).contains("exists already"));
    }
}
