//! A step of 1.01 times the stability limit, forced with `unsafe_step = true`: the command reports the participant that diverged, the
//! step and the criterion, and exits with 3.
//!
//! The strip of `verification/strip-under-traction` without its mass damping, which would move the limit; the traction acts
//! at once. h = 1.01 sqrt(2/b)/omega_max. The traction excites the fastest mode, which grows by a factor of 1.33 per step at b = 0.5
//! and of only 1.08 at b = 1: there it takes longer to exceed ten times the work of the traction.

use harness::runs::{Scratch, thirdbody};

use crate::scene::{fails, folder};

/// sqrt(2)/omega_max of the strip (s) at b = 1: 9.5177e-8 s at b = 0.5, by power iteration.
const LIMIT_AT_ONE: f64 = 6.730e-8;

/// Steps from the start until the run reports divergence.
fn found(damping: f64) -> u64 {
    let work = Scratch::new("unstable");
    let step = 1.01 * LIMIT_AT_ONE / damping.sqrt();
    let mut command = thirdbody(work.path());
    command
        .arg("run")
        .arg(folder("verification/strip-under-traction"))
        .arg("--out")
        .arg(work.path().join("out"));
    for set in [
        format!("time.damping={damping}"),
        format!("time.step_s={step:e}"),
        "time.mass_damping_per_s=0.0".into(),
        "time.unsafe_step=true".into(),
    ] {
        command.args(["--set", &format!("participant.strip.config.{set}")]);
    }
    let output = command.output().expect("the program starts");
    let words = [
        "participant `strip`",
        "more than ten times the",
        "the solution diverged",
        "the stability limit",
        "lower time.step_s",
    ];
    fails(&output, 3, &words);
    let stderr = String::from_utf8_lossy(&output.stderr);
    let (_, after) = stderr.split_once(" step ").expect("it says when");
    let (number, _) = after.split_once(',').expect("a number");
    number.parse().expect("a number")
}

#[test]
fn an_unstable_step_is_found_by_its_energy_and_reported() {
    for (damping, most) in [(0.5, 100), (0.75, 100), (1.0, 160)] {
        let step = found(damping);
        assert!(step <= most, "b = {damping}: step {step}");
    }
}
