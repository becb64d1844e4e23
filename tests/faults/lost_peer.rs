//! Processes that are killed, stopped or interrupted in the middle of a run.

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use harness::campaign::stops::LONG_FRAMES;
use harness::runs::{Scratch, program, thirdbody};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

use crate::scene::{Running, completed, fails, gone_within, shared_memory_of, short_quick};

/// The longest time from the loss of a peer to the end of the run.
const PROMPT: Duration = Duration::from_secs(2);

/// A long run of `quick`, in the middle of its windows.
fn in_the_midst(work: &Path, sets: &[&str]) -> Running {
    let mut all = vec!["run.end_s=1e-3", "run.output.flush_every_windows=10"];
    all.extend(sets);
    let mut running = Running::start(&mut short_quick(work, &all), &work.join("out"));
    running.wait_for("windows of");
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(running.participants().len(), 2, "{}", running.log());
    running
}

fn send(pid: i32, signal: Signal) {
    kill(Pid::from_raw(pid), signal).expect("it is still running");
}

#[test]
fn killing_either_node_ends_the_run_with_its_name() {
    for (index, name) in [(0, "rail"), (1, "third-body")] {
        let work = Scratch::new("killed");
        let running = in_the_midst(work.path(), &[]);
        let pids = running.participants();
        let coordinator = running.child.id();
        send(pids[index], Signal::SIGKILL);
        let (output, took) = running.end_within(PROMPT);
        println!("`{name}` killed: ended after {took:?}");
        fails(&output, 4, &["lost participant", name, "window", "SIGKILL"]);
        gone_within(&pids, PROMPT);
        assert_eq!(shared_memory_of(coordinator), Vec::<String>::new());
        let summary = harness::runs::parse_json(&output.stdout);
        assert_eq!(summary["status"], "peer_lost");
        assert!(
            summary["windows"].as_u64() > Some(0),
            "what was valid is kept"
        );
        let found = exchange_log::summarize(&work.path().join("out/exchange.mcap"), false)
            .expect("the log was closed");
        assert_eq!(found.hash, summary["hashes"]["exchange"]);
    }
}

/// A participant that is killed while it creates a file of the connection leaves the file incomplete. Nobody waits for it if the
/// coordinator has all of its own files by then: four services, the data and the wake-ups of its end.
#[test]
fn a_connection_is_whole_before_its_participant_begins() {
    let work = Scratch::new("whole");
    // Only shell built-ins: the script counts as soon as it runs.
    let find = r#"while read -r line; do case $line in *prefix*) p=${line#*: \"}; p=${p%%\"*};; esac; done < "$THIRDBODY_SESSION""#;
    let count = "for f in /dev/shm/$p*; do case $f in *.dynamic|*.data|*.ev_mgmt) n=$((n + 1));; esac; done";
    let script =
        format!("n=0; {find}; {count}; if [ $n -ge 6 ]; then echo whole; else echo $n; fi");
    let command = format!("participant.rail.command=['sh', '-c', '''{script}''']");
    let output = short_quick(work.path(), &[&command]).output();
    let said = ["lost participant `rail`", "its last output: whole"];
    fails(&output.expect("it starts"), 4, &said);
}

#[test]
fn killing_the_coordinator_ends_its_children_and_keeps_the_log() {
    let work = Scratch::new("orphans");
    let mut running = in_the_midst(work.path(), &[]);
    let pids = running.participants();
    let coordinator = running.child.id();
    send(coordinator as i32, Signal::SIGKILL);
    gone_within(&pids, PROMPT);
    running.child.wait().expect("it was killed");
    let found = exchange_log::summarize(&work.path().join("out/exchange.mcap"), true)
        .expect("readable up to its last flush");
    println!("log of a killed coordinator: {} windows", found.windows);
    assert!(found.windows > 0);

    let next = Scratch::new("next");
    let summary = completed(&mut short_quick(next.path(), &[]));
    assert_eq!(summary["status"], "completed");
    assert_eq!(shared_memory_of(coordinator), Vec::<String>::new());
}

/// Words that start a program in its own PID namespace; `None` where the system does not allow it.
fn unshare() -> Option<Vec<&'static str>> {
    let pid = ["unshare", "--pid", "--fork", "--mount-proc", "--kill-child"];
    let as_user = ["--user", "--map-current-user"];
    let ways = [pid.to_vec(), [&pid[..], &as_user].concat()];
    let works = |words: &Vec<&str>| {
        let tried = Command::new(words[0])
            .args(&words[1..])
            .arg("true")
            .status();
        tried.is_ok_and(|status| status.success())
    };
    let found = ways.into_iter().find(works);
    if found.is_none() {
        println!("skipped: this system gives no PID namespaces");
    }
    found
}

/// Number of files in shared memory of the run in this folder.
fn shared_memory_in(out: &Path) -> usize {
    let session =
        std::fs::read_to_string(out.join("logs/rail.session.json")).expect("it is written");
    let session = harness::runs::parse_json(session.as_bytes());
    let prefix = session["transport"]["prefix"].as_str().expect("a text");
    let files = std::fs::read_dir("/dev/shm")
        .expect("this is Linux")
        .flatten();
    let own = files.filter(|file| file.file_name().to_string_lossy().starts_with(prefix));
    own.count()
}

/// Two hosts may share `/dev/shm` without seeing each other's processes.
#[test]
fn a_run_in_another_pid_namespace_is_spared_while_it_lives() {
    let Some(words) = unshare() else { return };
    let elsewhere = |work: &Path| {
        let inner = short_quick(
            work,
            &["run.end_s=1e-3", "run.output.flush_every_windows=10"],
        );
        let mut command = Command::new(words[0]);
        command.args(&words[1..]).arg(inner.get_program());
        command.args(inner.get_args()).current_dir(work);
        let mut running = Running::start(&mut command, &work.join("out"));
        running.wait_for("windows of");
        running
    };
    let here = || {
        let work = Scratch::new("here");
        completed(&mut short_quick(work.path(), &["run.end_s=1e-6"]));
    };
    let work = Scratch::new("elsewhere");
    let running = elsewhere(work.path());
    let before = shared_memory_in(&work.path().join("out"));
    here();
    assert!(before > 0);
    assert_eq!(shared_memory_in(&work.path().join("out")), before);
    let (output, _) = running.end_within(Duration::from_secs(60));
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert_eq!(shared_memory_in(&work.path().join("out")), 0);

    let work = Scratch::new("elsewhere-killed");
    let mut running = elsewhere(work.path());
    send(running.child.id() as i32, Signal::SIGKILL);
    running.child.wait().expect("it was killed");
    // When the first process of a namespace is killed, the system ends the others, which takes a moment.
    let start = Instant::now();
    while shared_memory_in(&work.path().join("out")) > 0 {
        assert!(start.elapsed() < Duration::from_secs(20), "its files stay");
        here();
    }
}

#[test]
fn a_participant_in_a_pid_namespace_of_its_own_takes_part() {
    let Some(mut words) = unshare() else { return };
    let node = program("verification-node").display().to_string();
    words.extend([node.as_str(), "bar"]);
    let work = Scratch::new("namespace");
    crate::commands::scene(work.path(), &words, 20);
    let output = thirdbody(work.path()).args(["run", "."]).output();
    let output = output.expect("the program starts");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
fn a_stopped_node_is_reported_as_alive_but_stopped() {
    let work = Scratch::new("stopped");
    let running = in_the_midst(work.path(), &["run.deadlines.answer_s=1"]);
    let pids = running.participants();
    send(pids[1], Signal::SIGSTOP);
    let (output, _) = running.end_within(Duration::from_secs(8));
    fails(
        &output,
        5,
        &[
            "error[deadline-missed]",
            "third-body",
            "alive but stopped",
            "run.deadlines.answer_s",
        ],
    );
    gone_within(&pids, PROMPT);
}

/// A plastic rail under 211 grains sends a new compliance in most windows, and the layer receives 178 000 numbers each time: 11 pieces,
/// of which at most 4 wait. On a busy machine the layer may not read for longer than the coordinator's patience of 50 ms.
#[test]
fn a_node_that_stands_still_in_the_middle_of_a_long_frame_is_waited_for() {
    let [alone, stopped] = [Scratch::new("alone"), Scratch::new("still")];
    let undisturbed = completed(&mut short_quick(alone.path(), &LONG_FRAMES));
    let out = stopped.path().join("out");
    let mut running = Running::start(&mut short_quick(stopped.path(), &LONG_FRAMES), &out);
    running.wait_for("participant `third-body`");
    let layer = running.participants()[1];
    let (mut stops, start) = (0, Instant::now());
    while running.child.try_wait().expect("it is our child").is_none() {
        for (signal, millis) in [(Signal::SIGSTOP, 120), (Signal::SIGCONT, 20)] {
            // It may have ended since.
            stops += usize::from(kill(Pid::from_raw(layer), signal).is_ok());
            std::thread::sleep(Duration::from_millis(millis));
        }
        let waited = start.elapsed() < Duration::from_secs(120);
        assert!(waited, "it never ends: {}", running.log());
    }
    let (output, took) = running.end_within(PROMPT);
    println!("{stops} signals, ended {took:?} after the last");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let summary = harness::runs::parse_json(&output.stdout);
    assert_eq!(summary["hashes"], undisturbed["hashes"]);
}

#[test]
fn an_interrupt_keeps_the_valid_part() {
    for (signal, code) in [
        (Signal::SIGINT, 130),
        (Signal::SIGTERM, 143),
        (Signal::SIGHUP, 129),
    ] {
        let work = Scratch::new("interrupted");
        let running = in_the_midst(work.path(), &[]);
        let pids = running.participants();
        send(running.child.id() as i32, signal);
        let (output, _) = running.end_within(Duration::from_secs(4));
        fails(&output, code, &["error[interrupted]"]);
        gone_within(&pids, PROMPT);
        let summary = harness::runs::parse_json(&output.stdout);
        assert_eq!(summary["status"], "interrupted");
        assert_eq!(summary["code"], "interrupted");
        exchange_log::summarize(&work.path().join("out/exchange.mcap"), false)
            .expect("the log was closed");
    }
}

#[test]
fn an_interrupt_does_not_wait_for_a_stopped_node() {
    let work = Scratch::new("interrupted-stopped");
    // With checkpoints a window in progress has two seconds to end; the coordinator does not spend them on a stopped node.
    let often = [
        "run.checkpoint_every_windows=20",
        "run.deadlines.answer_s=60",
    ];
    let running = in_the_midst(work.path(), &often);
    let pids = running.participants();
    send(pids[1], Signal::SIGSTOP);
    std::thread::sleep(Duration::from_millis(100));
    send(running.child.id() as i32, Signal::SIGINT);
    let (output, took) = running.end_within(Duration::from_millis(1800));
    println!("ended after {took:?}");
    fails(&output, 130, &["interrupted"]);
    gone_within(&pids, PROMPT);
}
