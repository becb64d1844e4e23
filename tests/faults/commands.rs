//! Participants that are the user's programs: their working folder, their leftovers, and the report of one that ends.

use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use harness::runs::{Scratch, parse_json, program, thirdbody};
use harness::scene::{bar, body, glue, head};

use crate::scene::fails;

/// The steps are long, and these tests do not judge the energy error.
const COARSE: &str = "plausible = { energy_balance_rel = [1e300, 1e300] }";

/// Writes the scene of a bar with a body at its end to this folder; this command serves the bar.
pub fn scene(folder: &Path, command: &[&str], windows: u32) {
    let end = format!("end_s = {:?}", 2.5 * f64::from(windows));
    let text = [
        head("commands", 1.0, COARSE),
        bar("bar", 20, 0.5, ""),
        body(20.0, 3.0, -1.0, &end),
        glue("dual-schur", 5, "tolerance_rel = 1e-9"),
    ]
    .concat();
    let mut table: toml::Table = text.parse().expect("it is TOML");
    let node = program("verification-node").display().to_string();
    let words = [command.to_vec(), vec![&node, "chain"]];
    let participants = table["participant"].as_array_mut().expect("a list");
    for (participant, words) in participants.iter_mut().zip(words) {
        let participant = participant.as_table_mut().expect("a table");
        participant.insert("command".into(), words.into());
    }
    std::fs::write(
        folder.join("scenario.toml"),
        toml::to_string(&table).expect("it was TOML"),
    )
    .expect("the folder is writable");
}

fn run(work: &Path, scenario: &str) -> Command {
    let mut command = thirdbody(work);
    command.args(["run", scenario, "--out", "out", "--json"]);
    command
}

fn succeeds(output: Output) -> Output {
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    output
}

/// Number of processes with this word in their command line.
fn started_with(word: &str) -> usize {
    let processes = std::fs::read_dir("/proc")
        .expect("a Linux machine")
        .flatten();
    let commands = processes.filter_map(|entry| std::fs::read(entry.path().join("cmdline")).ok());
    let words = commands.map(|command| String::from_utf8_lossy(&command).into_owned());
    words
        .filter(|words| words.split('\0').any(|one| one == word))
        .count()
}

/// A script that starts the bar and another program, and an argument of that program that no other process has.
fn behind_a_shell(test: u32) -> (String, String) {
    let sleep = format!("{}.{test}", 100_000 + std::process::id());
    let node = program("verification-node");
    let script = format!("sleep {sleep} & {} bar; true", node.display());
    (script, sleep)
}

#[test]
fn a_program_behind_a_shell_takes_part_and_leaves_nothing() {
    let work = Scratch::new("shell");
    let (script, sleep) = behind_a_shell(1);
    scene(work.path(), &["bash", "-c", &script], 20);
    let output = succeeds(run(work.path(), ".").output().expect("it starts"));
    assert_eq!(parse_json(&output.stdout)["windows"], 20);
    assert_eq!(started_with(&sleep), 0, "the shell's other child is gone");
}

#[test]
fn children_of_a_program_end_when_the_coordinator_is_killed() {
    let work = Scratch::new("killed-shell");
    let (script, sleep) = behind_a_shell(2);
    scene(work.path(), &["bash", "-c", &script], 2_000_000);
    let mut child = run(work.path(), ".").spawn().expect("it starts");
    let start = Instant::now();
    while started_with(&sleep) == 0 {
        assert!(start.elapsed() < Duration::from_secs(20), "it never began");
        std::thread::sleep(Duration::from_millis(20));
    }
    child.kill().expect("it runs");
    child.wait().expect("it was killed");
    let killed = Instant::now();
    while started_with(&sleep) > 0 {
        assert!(killed.elapsed() < Duration::from_secs(3), "it lives on");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn a_program_that_ends_is_reported_with_its_last_words() {
    let work = Scratch::new("last-words");
    let script = "echo reading the mesh; echo no licence for 3 cores >&2; exit 3";
    scene(work.path(), &["bash", "-c", script], 20);
    let output = run(work.path(), ".").output().expect("it starts");
    let words = [
        "lost participant `bar`",
        "exit status: 3",
        "no licence for 3 cores",
    ];
    fails(&output, 4, &words);
}

#[test]
fn a_command_starts_in_the_folder_of_its_scenario_also_when_repeated_elsewhere() {
    let work = Scratch::new("folder");
    let scenario = work.path().join("scenario");
    std::fs::create_dir(&scenario).expect("the folder is writable");
    let script = scenario.join("node.sh");
    let text = format!(
        "#!/bin/bash\ncat data.txt >&2\nexec {} bar\n",
        program("verification-node").display()
    );
    std::fs::write(&script, text).expect("the folder is writable");
    std::fs::set_permissions(&script, std::fs::Permissions::from_mode(0o755)).expect("it is ours");
    std::fs::write(scenario.join("data.txt"), "data of the solver\n")
        .expect("the folder is writable");
    scene(&scenario, &["./node.sh"], 20);
    succeeds(run(work.path(), "scenario").output().expect("it starts"));
    let log = std::fs::read_to_string(work.path().join("out/logs/bar.log")).expect("it is kept");
    assert!(log.contains("data of the solver"), "{log}");
    let elsewhere = Scratch::new("elsewhere");
    let out = work.path().join("out").display().to_string();
    for verb in [&["replay"][..], &["resume", "--out", "again"]] {
        let mut command = thirdbody(elsewhere.path());
        command.args(verb).arg(&out).arg("--allow-commands");
        succeeds(command.output().expect("it starts"));
    }
    std::fs::rename(&scenario, work.path().join("moved")).expect("the folder is writable");
    let mut command = thirdbody(elsewhere.path());
    command.args(["replay", &out, "--allow-commands"]);
    fails(
        &command.output().expect("it starts"),
        2,
        &["`bar`", "./node.sh", "no longer exists"],
    );
}
