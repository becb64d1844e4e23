//! Resuming: from every checkpoint of a run, on another number of threads, the run ends bit for bit as without the break.

use std::path::{Path, PathBuf};

use coordinator::events::Listener;
use coordinator::participants::Watch;
use coordinator::run::checkpoint::file::{list, read};
use coordinator::run::checkpoint::{FOLDER, find, keeper};
use coordinator::run::session::{Ended, RunOptions, run, run_from};
use harness::runs::{Scratch, program};
use lab::replay::recording;
use scenario::load::{Loaded, load};
use serde_json::Value;

use crate::scenario;

/// Runs in this process, from the start or from the window of a checkpoint in a folder.
pub(crate) fn conduct(
    loaded: &Loaded,
    out: &Path,
    threads: usize,
    from: Option<(&Path, u64)>,
) -> Ended {
    let registry = harness::registry();
    let options = RunOptions {
        out: Some(out),
        threads,
        registry: &registry,
        program: program("thirdbody"),
        watch: Watch::default(),
        listener: Listener::default(),
        strict: false,
        dry_run: false,
        budget: None,
    };
    let ended = match from {
        None => run(loaded, &options),
        Some((folder, window)) => {
            let (origin, passed_over) = find(folder, loaded, Some(window)).expect("it is ours");
            assert_eq!(passed_over, []);
            let origin = origin.expect("there is a checkpoint");
            assert_eq!(origin.checkpoint.position.windows, window);
            run_from(loaded, &options, Some(&origin))
        }
    };
    let ended = ended.expect("the scenario is valid");
    assert!(ended.error.is_none(), "{:?}", ended.error);
    ended
}

pub(crate) fn loaded(scenario: &Path, sets: &[&str]) -> Loaded {
    let sets: Vec<String> = ["run.transport=channel"]
        .iter()
        .chain(sets)
        .map(|set| set.to_string())
        .collect();
    load(&scenario.to_string_lossy(), &sets).expect("it is valid")
}

pub(crate) fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../scenarios")
        .join(name)
}

/// Two runs must have equal hashes, results and files, except files with wall-clock times.
fn assert_same(one: &Ended, other: &Ended) {
    let (a, b) = (one.summary.value(), other.summary.value());
    for key in [
        "hashes",
        "tables",
        "results",
        "windows",
        "sim_time_s",
        "repeats_mean",
    ] {
        assert_eq!(a[key], b[key], "{key}");
    }
    let warned = |summary: &Value| {
        let all = summary["warnings"].as_array().expect("a list").iter();
        let mut all: Vec<String> = all.map(Value::to_string).collect();
        all.sort();
        all
    };
    assert_eq!(warned(&a), warned(&b));
    for (name, participant) in a["participants"].as_object().expect("a table") {
        assert_eq!(
            participant["energy"], b["participants"][name]["energy"],
            "{name}"
        );
        assert_eq!(
            participant["steps"], b["participants"][name]["steps"],
            "{name}"
        );
    }
    let messages = |ended: &Ended| {
        let mut log = recording(&ended.path.join("exchange.mcap"), &[]).expect("it was closed");
        assert_eq!(log.damage, None);
        for message in &mut log.messages {
            message.frame.header.run_id = 0;
        }
        (log.messages, log.ends)
    };
    assert!(messages(one) == messages(other), "the logs differ");
    let mut names = ["signals.csv", "profile.csv", "fields.pvd"]
        .map(PathBuf::from)
        .to_vec();
    let fields = std::fs::read_dir(one.path.join("fields")).expect("every run has it");
    names.extend(fields.flatten().map(|entry| {
        let name = entry.file_name();
        Path::new("fields").join(name)
    }));
    for name in names {
        let bytes = |ended: &Ended| std::fs::read(ended.path.join(&name)).ok();
        assert!(bytes(one) == bytes(other), "{} differs", name.display());
    }
}

/// Resumes from every checkpoint of a whole run; returns the number of checkpoints, the number in the middle of a halved window, and
/// the whole run's summary.
pub(crate) fn resume_from_all(loaded: &Loaded, name: &str) -> (usize, usize, Value) {
    let scratch = Scratch::new(name);
    let whole = conduct(loaded, &scratch.path().join("whole"), 1, None);
    let found = list(&whole.path.join(FOLDER));
    let mut halved = 0;
    for (index, checkpoint) in found.iter().enumerate() {
        let (_, state) = read(&checkpoint.path, &keeper::about(loaded)).expect("it is whole");
        halved += usize::from(state.position.groups.iter().any(|c| c.rest.is_some()));
        let out = scratch
            .path()
            .join(format!("resumed-{}", checkpoint.window));
        let from = Some((whole.path.as_path(), checkpoint.window));
        let resumed = conduct(loaded, &out, 2 - index % 2, from);
        assert_same(&whole, &resumed);
    }
    (found.len(), halved, whole.summary.value())
}

#[test]
fn a_coupled_run_resumes_from_every_checkpoint() {
    let sets = [
        "run.end_s=6e-5",
        "run.checkpoint_every_windows=9",
        "run.checkpoints_kept=100",
    ];
    let (count, _, _) = resume_from_all(&loaded(&shipped("quick"), &sets), "resume-quick");
    assert!(count >= 10, "{count}");
}

#[test]
fn a_run_with_secant_updates_resumes_in_the_middle_of_halved_windows() {
    let scratch = Scratch::new("resume-halved-scene");
    let file = scratch.path().join("scenario.toml");
    std::fs::write(&file, scenario()).expect("writable");
    let sets = [
        "run.end_s=150.0",
        "run.checkpoint_every_windows=3",
        "run.checkpoints_kept=1000",
    ];
    let (count, halved, _) = resume_from_all(&loaded(&file, &sets), "resume-halved");
    assert!(count > 10 && halved > 0, "{count} with {halved} halved");
}

#[test]
fn bonded_grains_on_a_fine_rail_resume() {
    let sets = [
        "run.end_s=3e-5",
        "run.checkpoint_every_windows=17",
        "run.checkpoints_kept=100",
    ];
    let scene = loaded(&shipped("wheel-rail-coupled"), &sets);
    assert!(resume_from_all(&scene, "resume-bonded").0 > 0);
}

#[test]
fn solvers_that_run_alone_resume() {
    let cases = [
        ("layer-alone", "run.end_s=1.2e-4", 61),
        ("wheel-rail-fe-small", "run.end_s=4e-5", 5),
    ];
    for (name, end, every) in cases {
        let every = format!("run.checkpoint_every_windows={every}");
        let sets = [end, &every, "run.checkpoints_kept=100"];
        let scene = loaded(&shipped(name), &sets);
        assert!(resume_from_all(&scene, name).0 > 1, "{name}");
    }
}

#[test]
fn a_force_over_time_continues_where_it_was() {
    let sets = [
        "participant.bar.config.boundary.top={ load_table = [[0.0, 1.0], [1e-6, 2.0], [4e-6, -1.0]], load_direction = [0.0, -1.0] }",
        "run.output.exchange=true",
        "run.checkpoint_every_windows=7",
        "run.checkpoints_kept=100",
    ];
    let scene = loaded(&shipped("verification/bar-driven"), &sets);
    assert!(resume_from_all(&scene, "resume-table").0 > 3);
}

/// After the hold: means, traction and field files equal the whole run's.
#[test]
fn outputs_of_finished_phases_are_carried_over() {
    let sets = ["run.checkpoint_every_windows=1900"];
    assert_eq!(
        resume_from_all(&loaded(&shipped("quick"), &sets), "resume-outputs").0,
        1
    );
}
