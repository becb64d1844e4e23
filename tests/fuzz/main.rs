//! Damaged input of every kind: an error or a sound result, never a panic, and never memory beyond the limit of this process.
//!
//! Each target starts from shipped inputs and changes them at random: bits, bytes, pieces that are cut out, repeated or swapped
//! with another input, and words of the format. A seed makes every execution repeatable; `THIRDBODY_FUZZ=100` runs a
//! hundred times as many.

mod mutate;
mod targets;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

use nix::sys::resource::{Resource, setrlimit};

use mutate::Mutator;

/// Address space of this process (bytes): inputs of kilobytes must not ask for gigabytes. A request beyond it ends the process.
const MEMORY: u64 = 3 << 30;

/// Runs a target on this many changed inputs; `read` returns true if the target accepts one.
fn fuzz(name: &str, executions: u64, corpus: &[Vec<u8>], mut read: impl FnMut(&[u8]) -> bool) {
    setrlimit(Resource::RLIMIT_AS, MEMORY, MEMORY).expect("a lower limit is always allowed");
    for input in corpus {
        let text = String::from_utf8_lossy(&input[..input.len().min(2000)]);
        assert!(read(input), "{name}: a sound input is refused: {text}");
    }
    let more = std::env::var("THIRDBODY_FUZZ").map_or(1, |n| n.parse().expect("a number"));
    let mut mutator = Mutator::new(name);
    let (start, mut taken) = (Instant::now(), 0);
    for execution in 0..executions * more {
        let input = mutator.change(corpus);
        match catch_unwind(AssertUnwindSafe(|| read(&input))) {
            Ok(sound) => taken += u64::from(sound),
            Err(_) => panic!(
                "{name}: execution {execution} panics on {:?}",
                String::from_utf8_lossy(&input[..input.len().min(2000)])
            ),
        }
    }
    println!(
        "{name}: {} executions in {:.1} s, {taken} taken, 0 panics",
        executions * more,
        start.elapsed().as_secs_f64()
    );
}

#[test]
fn scenarios() {
    fuzz("scenario", 4_000, &targets::scenarios(), targets::scenario);
}

#[test]
fn overrides() {
    fuzz(
        "--set",
        6_000,
        &targets::overrides(),
        targets::with_override,
    );
}

#[test]
fn frames() {
    fuzz("frame", 60_000, &targets::frames(), targets::frame);
}

#[test]
fn meshes() {
    fuzz("mesh", 1_500, &targets::meshes(), targets::mesh);
}

#[test]
fn logs() {
    let scratch = harness::runs::Scratch::new("fuzz-log");
    let path = scratch.path().join("exchange.mcap");
    fuzz("log", 1_000, &targets::logs(), |bytes| {
        targets::log(&path, bytes)
    });
}

#[test]
fn checkpoints() {
    let run = targets::CheckpointedRun::new();
    fuzz("checkpoint", 3_000, &run.files(), |bytes| run.read(bytes));
}

#[test]
fn states_of_grains_and_rails() {
    let run = targets::CheckpointedRun::new();
    for kind in ["fem", "dem"] {
        let (state, mut node) = run.node(kind);
        fuzz(&format!("state of {kind}"), 1_500, &[state], |bytes| {
            node.restore(bytes).is_ok()
        });
    }
}
