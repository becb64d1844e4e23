//! The trace of a run: a valid file of trace events whose times add up to the times of summary.json.
//!
//! Reference: the totals that each participant counts, in integer nanoseconds like the drawn spans. Both pass through a double of
//! seconds or microseconds, whose rounding over these times is far below the bound of 10 ns per participant.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Output;

use harness::runs::{Scratch, parse_json, thirdbody};
use serde_json::Value;

use super::resume::{conduct, loaded, shipped};

/// Largest error of a sum of the trace (s).
const ROUNDING_S: f64 = 1e-8;

/// An event: its times (ns) and itself.
type Timed = ([u64; 2], Value);

/// Events by process and thread.
type Threads = BTreeMap<(u64, u64), Vec<Timed>>;

struct Trace {
    /// Numbers of the processes by their names.
    processes: BTreeMap<String, u64>,
    threads: Threads,
}

impl Trace {
    fn spent_s(&self, process: &str, thread: u64, counted: impl Fn(&Value) -> bool) -> f64 {
        let events = &self.threads[&(self.processes[process], thread)];
        let counted = events.iter().filter(|(_, event)| counted(event));
        1e-9 * counted.map(|([from, to], _)| to - from).sum::<u64>() as f64
    }
}

/// A quick run of a few hundred windows, in the folder `run`, and its summary.
fn short(scratch: &Scratch, sets: &[&str]) -> Value {
    let sets = [&["run.end_s=2e-4"], sets].concat();
    let out = scratch.path().join("run");
    let ended = conduct(&loaded(&shipped("quick"), &sets), &out, 1, None);
    ended.summary.value()
}

fn export(folder: &Path, words: &[&str]) -> Output {
    let mut command = thirdbody(folder);
    command.args(["export", "run", "--trace"]).args(words);
    command.output().expect("the command runs")
}

/// Reads a trace as strictly as the format demands.
fn read(path: &Path) -> Trace {
    let value = parse_json(&std::fs::read(path).expect("it was written"));
    let mut trace = Trace {
        processes: BTreeMap::new(),
        threads: Threads::new(),
    };
    for event in value["traceEvents"].as_array().expect("a list of events") {
        let id = |key: &str| {
            event[key]
                .as_u64()
                .expect("processes and threads are numbers")
        };
        let name = event["name"].as_str().expect("every event has a name");
        match event["ph"].as_str() {
            Some("M") => {
                let named = event["args"]["name"].as_str().expect("a name").to_string();
                if name == "process_name" {
                    trace.processes.insert(named, id("pid"));
                } else {
                    assert_eq!(name, "thread_name");
                    assert_eq!(named, ["work", "wait"][id("tid") as usize - 1]);
                }
            }
            Some("X") => {
                let ns = |key: &str| (1e3 * event[key].as_f64().expect("a time (us)")).round();
                let (from, length) = (ns("ts"), ns("dur"));
                assert!(from >= 0.0 && length >= 0.0, "{event}");
                let times = [from as u64, (from + length) as u64];
                let thread = (id("pid"), id("tid"));
                trace
                    .threads
                    .entry(thread)
                    .or_default()
                    .push((times, event.clone()));
            }
            other => panic!("{other:?} is not a known kind of event: {event}"),
        }
    }
    for events in trace.threads.values() {
        for two in events.windows(2) {
            assert!(two[0].0[1] <= two[1].0[0], "{two:?} overlap");
        }
    }
    trace
}

#[test]
fn work_and_waits_add_up_to_the_times_of_the_summary() {
    for transport in ["shm", "channel"] {
        let scratch = Scratch::new("trace");
        let summary = short(&scratch, &[&format!("run.transport={transport}")]);
        let output = export(scratch.path(), &[]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && !said.contains("note:"), "{said}");
        let trace = read(&scratch.path().join("run/trace.json"));
        assert_eq!(trace.processes.len(), 3);
        for name in ["rail", "third-body"] {
            let expected = |key: &str| summary["participants"][name][key].as_f64().expect("a time");
            let is_setup = |event: &Value| event["name"] == "set-up";
            for (key, found) in [
                (
                    "solve_wall_s",
                    trace.spent_s(name, 1, |event| !is_setup(event)),
                ),
                ("setup_wall_s", trace.spent_s(name, 1, is_setup)),
                ("wait_s", trace.spent_s(name, 2, |_| true)),
            ] {
                let off = found - expected(key);
                assert!(
                    off.abs() < ROUNDING_S,
                    "{transport} {name} {key}: {off:e} s"
                );
            }
            // Participants and coordinator use the same clock: the set-up is over when the answer arrives.
            let welcome = trace.threads[&(0, 2)].iter();
            let mut welcome =
                welcome.filter(|(_, event)| event["name"] == format!("wait for {name}"));
            let setup = &trace.threads[&(trace.processes[name], 1)][0];
            let welcomed = welcome.next().expect("it was awaited");
            assert!(setup.0[1] <= welcomed.0[1], "{setup:?} after {welcomed:?}");
        }
    }
}

#[test]
fn events_name_windows_and_a_range_can_be_chosen() {
    let scratch = Scratch::new("trace-windows");
    let summary = short(&scratch, &[]);
    let advances = |trace: &Trace| -> Vec<u64> {
        let rail = &trace.threads[&(trace.processes["rail"], 1)];
        let advances = rail.iter().filter(|(_, event)| event["name"] == "Advance");
        advances
            .map(|(_, event)| event["args"]["window"].as_u64().expect("a window"))
            .collect()
    };
    assert!(export(scratch.path(), &[]).status.success());
    let all = advances(&read(&scratch.path().join("run/trace.json")));
    let windows = summary["windows"].as_u64().expect("a number");
    assert!((0..windows).all(|window| all.contains(&window)));
    let some = ["--windows", "100..102", "--out", "some.json"];
    assert!(export(scratch.path(), &some).status.success());
    let chosen = advances(&read(&scratch.path().join("some.json")));
    assert!((100..=102).all(|window| chosen.contains(&window)));
    // The first of the next window may have been sent early.
    assert!(
        chosen.iter().all(|window| (100..=103).contains(window)),
        "{chosen:?}"
    );
    for (words, said) in [
        (
            &["--windows", "9000..9001", "--out", "none.json"][..],
            "windows up to",
        ),
        (&["--windows", "5..3"], "the first not above the last"),
        (&["--out", "some.json"], "never overwrites"),
        (&["--node", "rail"], "cannot be used with"),
    ] {
        let output = export(scratch.path(), words);
        assert_eq!(output.status.code(), Some(2), "{words:?}");
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(text.contains(said), "{words:?}: {text}");
    }
}

#[test]
fn the_log_of_times_changes_no_bit_and_may_be_missing() {
    let scratch = Scratch::new("trace-missing");
    let summary = short(&scratch, &[]);
    let other = Scratch::new("trace-unlogged");
    let unlogged = short(&other, &["run.output.exchange=false"]);
    assert_eq!(
        summary["hashes"]["exchange"],
        unlogged["hashes"]["exchange"]
    );
    let output = export(other.path(), &[]);
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        said.contains("timing.mcap") && said.contains("run.output.exchange"),
        "{said}"
    );
}

#[test]
fn the_trace_of_a_killed_run_shows_the_times_of_the_coordinator() {
    let scratch = Scratch::new("trace-killed");
    short(&scratch, &["run.end_s=1.4e-3"]);
    let file = scratch.path().join("run/timing.mcap");
    let bytes = std::fs::read(&file).expect("it was written");
    std::fs::write(&file, &bytes[..3 * bytes.len() / 4]).expect("it can be written");
    let output = export(scratch.path(), &[]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    for words in ["ends early", "participant `rail` did not report its times"] {
        assert!(said.contains(words), "{said}");
    }
    let trace = read(&scratch.path().join("run/trace.json"));
    let rail = &trace.threads[&(trace.processes["rail"], 1)];
    assert!(
        rail.iter()
            .all(|(_, event)| event["args"]["seen_by"] == "coordinator")
    );
}
