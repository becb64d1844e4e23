//! Replay of logged runs: bit for bit without a change, and with the first departure named after a change.

mod cost;
mod damage;
mod fuzz;
mod resume;
mod resume_kinds;

use std::path::Path;

use coordinator::participants::{Launcher, Watch};
use exchange_log::mismatch::Difference;
use harness::runs::{Scratch, parse_json, program, run_in_process, thirdbody};
use harness::scene::{bar, body, glue, head};
use lab::replay::replayed::Replayed;
use lab::replay::{Recording, coupler as loop_replay, recording, solver};
use protocol::{Frame, Kind};
use runs::run_dir::RunDir;

mod several;
mod trace;

/// A plastic bar under a heavy body: repeats, secant updates and halved windows.
pub(crate) fn scenario() -> String {
    let keys = "left_fixed = true\nyield_elongation_m = 0.1\nhardening_ratio = 0.05";
    let policy = "tolerance_rel = 1e-9\nrepeats_max = 2\non_not_converged = \"halve\"";
    [
        head("replayed", 1.0, ""),
        bar("bar", 40, 0.9, keys),
        body(40.0, 40.0, -1.0, "end_s = 800.0"),
        glue("dual-schur-secant", 30, policy),
    ]
    .concat()
}

fn logged() -> (harness::runs::Left, Recording) {
    logged_with(&[])
}

fn logged_with(sets: &[&str]) -> (harness::runs::Left, Recording) {
    let left = run_in_process(&scenario(), sets)
        .expect("it is valid")
        .completed();
    assert!(left.number("coupling.halved_windows") > 0.0);
    let recording =
        recording(&left.scratch.path().join("exchange.mcap"), &[]).expect("it was closed");
    (left, recording)
}

fn replay(recording: &Recording, who: &str) -> Replayed {
    let scratch = Scratch::new("replay");
    let rundir = RunDir::create(Some(scratch.path()), "replay", 0).expect("it is empty");
    let registry = harness::registry();
    let launcher = Launcher {
        loaded: &recording.loaded,
        registry: &registry,
        program: program("thirdbody"),
        run_id: 7,
        threads: 1,
        rundir: &rundir,
    };
    let watch = Watch::default();
    let replayed = match who {
        "coupler" => loop_replay::replay(recording, &launcher, &watch, None),
        name => solver::replay(
            recording,
            &launcher,
            name,
            &watch,
            &solver::ReplayOptions::default(),
        ),
    };
    replayed.expect("the participants start")
}

/// Each participant and the coupler repeat their messages, and every message of the log belongs to one of them.
fn repeats_every_bit(recording: &Recording, participants: &[&str]) {
    let mut compared = 0;
    for who in participants {
        let replayed = replay(recording, who);
        assert_eq!(replayed.mismatch, None, "{who}");
        compared += replayed.equal;
    }
    let coupler = replay(recording, "coupler");
    assert_eq!(coupler.mismatch, None);
    assert_eq!(coupler.equal, compared);
    assert_eq!(2 * compared as usize, recording.messages.len());
}

#[test]
fn both_solvers_and_the_coupler_repeat_every_bit() {
    let (_left, recording) = logged();
    repeats_every_bit(&recording, &["bar", "body"]);
}

/// A strip that is pressed on a layer between crowned faces and moves to and fro.
#[test]
fn a_reciprocating_strip_its_layer_and_the_coupler_repeat_every_bit() {
    let scene = include_str!("../../scenarios/two-rails-reciprocating/scenario.toml");
    let sets = [
        "participant.upper.config.time.end_s=3e-5",
        "participant.upper.config.boundary.top={ load_table = [[0.0, 0.0], [1e-5, -1000.0]], motion = { amplitude_m = 1e-6, frequency_hz = 5e4, start_s = 1.5e-5 } }",
        "run.output.exchange=true",
    ];
    let left = run_in_process(scene, &sets)
        .expect("it is valid")
        .completed();
    let log = left.scratch.path().join("exchange.mcap");
    let recording = recording(&log, &[]).expect("it was closed");
    repeats_every_bit(&recording, &["lower", "third-body", "upper"]);
}

/// The plastic bar does not answer with its own impedance, so windows are repeated here too.
#[test]
fn both_sides_of_a_velocity_and_the_coupler_repeat_every_bit() {
    let (_left, recording) = logged_with(&[
        "interface.glue.scheme=velocity",
        "interface.glue.repeats_max=100",
        "participant.bar.config.nan_above_substeps=15",
    ]);
    repeats_every_bit(&recording, &["bar", "body"]);
}

#[test]
fn a_bar_that_follows_its_wall_and_the_coupler_repeat_every_bit() {
    for scheme in ["fixed-point-serial", "fixed-point-parallel"] {
        let scheme = format!("interface.glue.scheme={scheme}");
        let (_left, recording) = logged_with(&[
            &scheme,
            "interface.glue.dirichlet=continuum",
            "interface.glue.repeats_max=100",
            "participant.body.config.point_mass_kg=1.0",
            "participant.bar.config.nan_above_substeps=15",
        ]);
        repeats_every_bit(&recording, &["bar", "body"]);
    }
}

#[test]
fn one_flipped_bit_of_an_answer_is_named_exactly() {
    let (_left, mut recording) = logged();
    let index = recording
        .messages
        .iter()
        .rposition(|message| message.sender == "bar" && message.frame.kind() == Ok(Kind::Motion))
        .expect("the bar moved");
    let frame = &mut recording.messages[index].frame;
    let (window, iteration) = (frame.header.window, frame.header.iteration);
    let mut payload = frame.payload.clone();
    payload[0] = f64::from_bits(payload[0].to_bits() ^ 1);
    *frame = Frame::new(frame.header, payload);

    let mismatch = replay(&recording, "bar")
        .mismatch
        .expect("a bit was flipped");
    assert_eq!(
        (
            mismatch.sender.as_str(),
            mismatch.window,
            mismatch.iteration
        ),
        ("bar", window, iteration)
    );
    assert!(matches!(
        mismatch.difference,
        Difference::Number {
            entry: 0,
            ulps: 1,
            ..
        }
    ));
    assert_eq!(
        replay(&recording, "body").mismatch,
        None,
        "the other side was not touched"
    );
}

#[test]
fn a_changed_solver_departs_at_its_first_different_answer() {
    let (_left, mut recording) = logged();
    recording.loaded.scenario.participant[0]
        .config
        .insert("hardening_ratio".into(), toml::Value::Float(0.06));
    let mismatch = replay(&recording, "bar").mismatch.expect("it hardens more");
    assert_eq!(mismatch.sender, "bar");
    assert_eq!(mismatch.kind, "Motion");
}

/// The log of a run whose coordinator was killed: the flushed part is replayed.
#[test]
fn the_command_replays_a_shipped_run_and_the_rest_of_a_cut_log() {
    let work = Scratch::new("command");
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/quick");
    let out = work.path().join("out");
    let mut run = thirdbody(work.path());
    run.arg("run")
        .arg(scene)
        .arg("--out")
        .arg(&out)
        .args(["--set", "run.end_s=6e-5"]);
    run.args(["--set", "run.output.flush_every_windows=10"]);
    assert!(run.output().expect("the program starts").status.success());
    let whole = std::fs::read(out.join("exchange.mcap")).expect("it was written");
    std::fs::write(out.join("cut.mcap"), &whole[..whole.len() * 2 / 3])
        .expect("the folder is writable");
    for (name, damaged) in [("exchange.mcap", false), ("cut.mcap", true)] {
        let output = thirdbody(work.path())
            .arg("replay")
            .arg(out.join(name))
            .arg("--json")
            .output()
            .expect("it starts");
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        let found = parse_json(&output.stdout);
        assert_eq!(found["damage"].is_string(), damaged, "{found:#}");
        for row in found["results"].as_array().expect("a list") {
            assert!(row["departure"].is_null(), "{row:#}");
            assert!(row["equal_messages"].as_u64() > Some(50), "{row:#}");
        }
    }
}

/// From a checkpoint everything repeats; another friction drifts in open loop. A tolerance passes equal messages, and must be
/// finite and not negative.
#[test]
fn the_command_replays_from_a_checkpoint_and_with_another_parameter() {
    let work = Scratch::new("what-if");
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/quick");
    let mut run = thirdbody(work.path());
    run.arg("run").arg(scene).args(["--out", "out"]);
    for set in ["run.end_s=6e-5", "run.checkpoint_every_windows=20"] {
        run.args(["--set", set]);
    }
    assert!(run.output().expect("the program starts").status.success());
    let replay = |more: &[&str]| {
        let mut command = thirdbody(work.path());
        command.args(["replay", "out", "--json"]).args(more);
        let output = command.output().expect("it starts");
        (output.status.code(), parse_json(&output.stdout))
    };
    let (code, all) = replay(&[]);
    assert_eq!(code, Some(0), "{all:#}");
    let (code, found) = replay(&["--from", "75"]);
    assert_eq!(
        (code, &found["from_window"]),
        (Some(0), &60.into()),
        "{found:#}"
    );
    for (late, early) in [0, 1, 2].map(|i| (&found["results"][i], &all["results"][i])) {
        let equal = |row: &serde_json::Value| row["equal_messages"].as_u64().expect("a number");
        assert!(late["departure"].is_null() && equal(late) > 20, "{late:#}");
        assert!(equal(late) < equal(early), "{late:#}");
        assert_eq!(late["last_window"], early["last_window"]);
    }
    let friction = "participant.third-body.config.law.friction=0.299";
    let (code, found) = replay(&["--set", friction]);
    assert_eq!((code, &found["open_loop"]), (Some(0), &true.into()));
    let row = &found["results"][0];
    assert_eq!(row["who"], "third-body");
    assert!(row["departure"].is_string(), "{row:#}");
    let drift = row["drift"]["force"]["max_rel"].as_f64().expect("a number");
    assert!(drift > 1e-12 && drift.is_finite(), "{drift:e}");
    // Neither may a solver be named that no override changes, nor a picture without a drift.
    for (arguments, word) in [
        (&["--set", friction, "--node", "rail"][..], "--node rail"),
        (&["--plot", "a.svg"], "--set"),
    ] {
        let mut command = thirdbody(work.path());
        command.args(["replay", "out"]).args(arguments);
        let output = command.output().expect("it starts");
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(word), "{message}");
    }
    let svg =
        std::fs::read_to_string(work.path().join("out/replay-drift.svg")).expect("it was drawn");
    assert!(svg.contains("open loop"));
    let (code, _) = replay(&["--tolerance", "1e-12"]);
    assert_eq!(code, Some(0), "equal messages are within any tolerance");
    // No difference exceeds NaN: every log would pass.
    for refused in ["nan", "inf", "-1"] {
        let mut command = thirdbody(work.path());
        command.args(["replay", "out", "--tolerance", refused]);
        let output = command.output().expect("it starts");
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains("--tolerance"), "{message}");
    }
}
