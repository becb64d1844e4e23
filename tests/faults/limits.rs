//! Limits of the machine and of sizes: the message names the limit and the cure before anything is lost.

use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use harness::runs::{Scratch, parse_json, thirdbody};
use nix::sys::stat::Mode;
use nix::unistd::mkfifo;

use crate::scene::{fails, folder, short_quick};

/// Output of a command that must not hang.
fn promptly(command: &mut Command) -> Output {
    let start = Instant::now();
    let mut child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    while child.try_wait().expect("it is ours").is_none() {
        let waited = start.elapsed();
        if waited > Duration::from_secs(20) {
            child.kill().expect("it is ours");
            panic!("{command:?} hangs");
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    child.wait_with_output().expect("it has ended")
}

fn pipe_at(path: &Path) {
    mkfifo(path, Mode::S_IRWXU).expect("the folder takes a pipe");
}

#[test]
fn deadlines_and_threads_beyond_reason_are_refused_by_name() {
    let work = Scratch::new("limits");
    for key in ["setup_s", "answer_s", "idle_s"] {
        let set = format!("run.deadlines.{key}=1e300");
        let output = promptly(&mut short_quick(work.path(), &[&set]));
        fails(&output, 2, &[&format!("run.deadlines.{key}"), "at most"]);
    }
    let mut many = short_quick(work.path(), &[]);
    let output = promptly(many.args(["--threads", "60000"]));
    fails(&output, 2, &["--threads", "60000", "1024"]);
}

#[test]
fn a_pipe_is_neither_a_scenario_nor_a_mesh() {
    let work = Scratch::new("pipes");
    pipe_at(&work.path().join("pipe"));
    let mut check = thirdbody(work.path());
    let output = promptly(check.args(["check", "pipe"]));
    fails(&output, 2, &["pipe", "a pipe or a device"]);

    let scene = work.path().join("scene");
    std::fs::create_dir(&scene).expect("the folder is ours");
    let mesh = scene.join("pipe.msh");
    pipe_at(&mesh);
    let shipped = folder("verification/pressurised-cylinder").join("scenario.toml");
    let text = std::fs::read_to_string(shipped).expect("it ships");
    let text = text.replace("cylinder.msh", &mesh.display().to_string());
    std::fs::write(scene.join("scenario.toml"), text).expect("the folder is ours");
    for verb in ["check", "run"] {
        let mut command = thirdbody(work.path());
        let output = promptly(command.args([verb, "scene"]));
        fails(&output, 2, &["mesh.gmsh", "pipe.msh", "a pipe or a device"]);
    }
}

#[test]
fn an_oversized_scenario_is_not_read() {
    let work = Scratch::new("long-scenario");
    let file = std::fs::File::create(work.path().join("long.toml")).expect("the folder is ours");
    // A sparse file takes no space on the disk.
    file.set_len(100 << 20).expect("sparse files are free");
    let mut check = thirdbody(work.path());
    let output = promptly(check.args(["check", "long.toml"]));
    fails(&output, 2, &["long.toml", "104857600", "at most"]);
}

#[test]
fn a_limit_of_too_few_open_files_is_refused_before_the_start() {
    let work = Scratch::new("open-files");
    let run = short_quick(work.path(), &[]);
    let mut shell = Command::new("sh");
    shell
        .args(["-c", "ulimit -n 30; exec \"$@\"", "sh"])
        .arg(run.get_program())
        .args(run.get_args())
        .current_dir(work.path());
    let words = ["2 participants", "open files", "ulimit -n"];
    fails(&promptly(&mut shell), 2, &words);
}

#[test]
fn a_low_limit_that_may_be_raised_is_raised() {
    let work = Scratch::new("soft-limit");
    let run = short_quick(work.path(), &["run.end_s=6e-6"]);
    let mut shell = Command::new("sh");
    shell
        .args(["-c", "ulimit -S -n 30; exec \"$@\"", "sh"])
        .arg(run.get_program())
        .args(run.get_args())
        .current_dir(work.path());
    let output = promptly(&mut shell);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
}

#[test]
fn a_participant_that_prints_without_end_does_not_fill_the_disk() {
    let work = Scratch::new("printing");
    let command = "participant.rail.command=[\"yes\", \"a line that says nothing\"]";
    let mut run = short_quick(work.path(), &[command, "run.deadlines.setup_s=1.0"]);
    let output = promptly(run.process_group(0));
    fails(&output, 5, &["rail", "run.deadlines.setup_s"]);
    let log = std::fs::read(work.path().join("out/logs/rail.log")).expect("it is kept");
    let text = String::from_utf8_lossy(&log);
    assert!(log.len() < 10 << 20, "{} bytes", log.len());
    let (_, end) = text
        .split_once("bytes are left out here")
        .expect("it says so");
    assert!(end.contains("a line that says nothing\n"));
}

#[test]
fn a_log_that_the_disk_has_no_room_for_is_refused_before_the_first_window() {
    let work = Scratch::new("no-room");
    let sets = ["run.end_s=1e4", "run.transport=channel"];
    let mut run = short_quick(work.path(), &sets);
    let output = promptly(&mut run);
    fails(
        &output,
        9,
        &["exchange.mcap", "the log needs about", "--out"],
    );
    let summary = parse_json(&output.stdout);
    assert_eq!(summary["status"], "output_failed");
    assert_eq!(summary["windows"], 0);
}

#[test]
fn a_log_that_may_fill_the_disk_through_repeats_is_a_warning() {
    let work = Scratch::new("little-room");
    let sets = [
        "interface.layer-base.scheme=fixed-point-serial",
        "interface.layer-base.tolerance_rel=1e-3",
        "interface.layer-base.repeats_max=4000000000",
        "run.transport=channel",
    ];
    let output = promptly(&mut short_quick(work.path(), &sets));
    let summary = parse_json(&output.stdout);
    let warnings = summary["warnings"].as_array().expect("a list");
    let found = warnings.iter().find(|found| found["code"] == "log_space");
    let text = found.and_then(|found| found["text"].as_str());
    let text = text.expect("it is reported").to_string();
    assert!(text.contains("the log needs about"), "{text}");
}
