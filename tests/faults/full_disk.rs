//! Outputs that cannot be written: exit code 9, a message that names the file, and valid output is kept.
//!
//! A limit on the size of files stands for a full disk. It also applies to shared memory, so the solvers run as threads.

use std::fs::File;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Output};

use harness::runs::{Scratch, parse_json, program, thirdbody};

use crate::scene::{completed, fails, folder, short_quick};

/// Runs the same command with files limited to `blocks` blocks of 512 bytes.
fn limited(command: &Command, blocks: u32) -> Output {
    let mut shell = Command::new("sh");
    // Without the trap, the signal for a too long file would end the program before it can print anything.
    let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$@\"");
    shell
        .args(["-c", &script, "sh"])
        .arg(command.get_program())
        .args(command.get_args());
    if let Some(folder) = command.get_current_dir() {
        shell.current_dir(folder);
    }
    shell.output().expect("there is a shell")
}

/// A run with files limited to `blocks` blocks ends because of this file.
fn ends_for_want_of(file: &str, work: &Path, run: &Command, blocks: u32) {
    let output = limited(run, blocks);
    fails(&output, 9, &["error[write-failed]", file, "File too large"]);
    let summary = parse_json(&output.stdout);
    assert_eq!(summary["status"], "output_failed", "{file}");
    assert_eq!(summary["code"], "write-failed", "{file}");
    assert_eq!(summary["exit_code"], 9, "{file}");
    for kept in ["scenario.toml", "manifest.json", "summary.json"] {
        assert!(work.join("out").join(kept).is_file(), "{kept} and {file}");
    }
}

#[test]
fn a_run_that_cannot_write_ends_with_code_9_and_says_which_file() {
    let without_log = "run.output.exchange=false";
    // Of 100 windows, signals.csv passes 50 kB, the log 100 kB, and the fields of the rail 200 kB.
    let cases: [(&str, u32, &[&str]); 3] = [
        ("exchange.mcap", 200, &[]),
        ("signals.csv", 100, &[without_log]),
        ("rail-end.vtu", 350, &[without_log]),
    ];
    for (file, blocks, sets) in cases {
        let work = Scratch::new("full-disk");
        let sets = [&["run.transport=channel"], sets].concat();
        let run = short_quick(work.path(), &sets);
        ends_for_want_of(file, work.path(), &run, blocks);
    }
}

#[test]
fn a_checkpoint_that_cannot_be_written_ends_the_run_with_code_9() {
    let work = Scratch::new("full-disk-checkpoint");
    let mut run = thirdbody(work.path());
    run.arg("run")
        .arg(folder("layer-alone"))
        .args(["--out", "out", "--json"])
        .args(["--set", "run.transport=channel"])
        .args(["--set", "run.checkpoint_every_windows=5"]);
    // A checkpoint takes 34 kB, the log before it much less.
    ends_for_want_of("000000000005.checkpoint", work.path(), &run, 40);
}

#[test]
fn a_run_directory_that_cannot_be_made_has_code_9() {
    let work = Scratch::new("no-run-directory");
    let mut command = thirdbody(work.path());
    command.arg("run").arg(folder("quick"));
    let output = command.args(["--out", "/proc/nowhere"]).output();
    fails(&output.expect("it starts"), 9, &["/proc/nowhere"]);
}

#[test]
fn verbs_that_cannot_write_have_code_9() {
    let work = Scratch::new("verbs-full-disk");
    completed(&mut short_quick(work.path(), &["run.end_s=6e-6"]));
    let run = work.path().join("out");
    let verb = |arguments: &[&str]| {
        let mut command = thirdbody(work.path());
        command.args(arguments).output().expect("it starts")
    };
    fails(
        &verb(&["export", "out", "--out", "/proc/nowhere.csv"]),
        9,
        &["/proc/nowhere.csv"],
    );
    let set = "participant.third-body.config.law.friction=0.2";
    let plot = ["--set", set, "--plot", "/dev/full"];
    fails(
        &verb(&[&["replay", "out"], &plot[..]].concat()),
        9,
        &["/dev/full", "No space left"],
    );
    symlink("/dev/full", run.join("scene.svg")).expect("the run directory is writable");
    fails(
        &verb(&["report", "out"]),
        9,
        &["scene.svg", "No space left"],
    );
    fails(
        &onto_full_disk(work.path(), &["inspect", "out"]),
        9,
        &["stdout"],
    );
}

/// A verb whose results go to a full disk.
fn onto_full_disk(work: &Path, arguments: &[&str]) -> Output {
    let full = File::create("/dev/full").expect("Linux has it");
    let mut command = Command::new(program("thirdbody"));
    command.current_dir(work).args(arguments).stdout(full);
    command.args(["--cache", "none"]);
    let child = command.stderr(std::process::Stdio::piped()).spawn();
    let child = child.expect("it starts");
    child.wait_with_output().expect("it ends")
}
