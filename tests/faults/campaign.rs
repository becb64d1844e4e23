//! The fault campaign in its short form, and the leftovers of an interrupted one.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use harness::runs::{parse_json, program};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

fn campaign(trials: &str) -> Command {
    let mut command = Command::new(program("faults"));
    command.current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
    // The campaign leaves the user's cache alone.
    command.env("XDG_CACHE_HOME", "").env("HOME", "");
    command.args(["--json", "--trials", trials]);
    command
}

#[test]
fn a_trial_of_every_fault_ends_right() {
    let output = campaign("1").output().expect("it starts");
    let said = String::from_utf8_lossy(&output.stderr);
    let rows = parse_json(&output.stdout);
    println!("{rows:#}");
    assert_eq!(output.status.code(), Some(0), "{rows:#} {said}");
    let rows = rows["results"].as_array().expect("a list").clone();
    assert_eq!(rows.len(), 19);
    for row in rows {
        let trials = if row["name"] == "simulated network" {
            500
        } else {
            1
        };
        assert_eq!(row["trials"], trials, "{row}");
        assert_eq!(row["right"], trials, "{row}");
        assert_eq!(row["leftovers"], 0, "{row}");
        assert_eq!(row["holds"], true, "{row}");
    }
}

/// A campaign; dropping it ends the process.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Processes that name this folder among their variables or arguments.
fn processes_of(folder: &str) -> Vec<String> {
    let entries = std::fs::read_dir("/proc").expect("Linux has it").flatten();
    let numbers = entries.filter_map(|entry| entry.file_name().into_string().ok());
    let names = |number: &String| {
        ["environ", "cmdline"].iter().any(|file| {
            let bytes = std::fs::read(Path::new("/proc").join(number).join(file));
            String::from_utf8_lossy(&bytes.unwrap_or_default()).contains(folder)
        })
    };
    numbers.filter(names).collect()
}

#[test]
fn an_interrupted_campaign_leaves_nothing() {
    let silent = Stdio::null;
    let child = campaign("50").stdout(silent()).stderr(silent()).spawn();
    let mut running = Running(child.expect("it starts"));
    let pid = running.0.id();
    let folder = format!("thirdbody-fault-{pid}-");
    let start = Instant::now();
    while processes_of(&folder).len() < 3 {
        assert!(start.elapsed() < Duration::from_secs(60), "nothing runs");
        std::thread::sleep(Duration::from_millis(5));
    }
    kill(Pid::from_raw(pid as i32), Signal::SIGINT).expect("it runs");
    let start = Instant::now();
    let status = running.0.wait().expect("it is our child");
    println!("ended {:?} after the interrupt", start.elapsed());
    assert_eq!(status.code(), Some(130));
    // The participants of its runs are not its children. They were killed, which takes some milliseconds on a busy machine.
    let start = Instant::now();
    while !processes_of(&folder).is_empty() && start.elapsed() < Duration::from_secs(1) {
        std::thread::sleep(Duration::from_millis(5));
    }
    assert_eq!(processes_of(&folder), Vec::<String>::new());
    let left = std::fs::read_dir(std::env::temp_dir())
        .expect("it is there")
        .flatten();
    let mut names = left.filter_map(|entry| entry.file_name().into_string().ok());
    assert_eq!(names.find(|name| name.contains(&folder)), None);
}
