//! Processes that are stopped (SIGSTOP), for a while or forever.

use std::fs;
use std::time::{Duration, Instant};

use nix::sys::signal::Signal;
use serde_json::Value;

use super::kills::outlived;
use super::resumes::resumes;
use super::row::{FaultOutcome, FaultResult, Wrong};
use super::trial::{ANSWER_S, FaultTrial, HANGS, RunPhase, send};
use scenario::error::Error;

/// A run that must complete in spite of its fault.
fn completed(trial: &mut FaultTrial) -> FaultResult {
    let status = trial.end()?;
    let completed = trial.completed()?;
    if !status.success() {
        return Err(format!("{status}: {}", trial.said()).into());
    }
    Ok(completed)
}

/// Lets time pass, unless the run ends.
fn pause(trial: &mut FaultTrial, time_s: f64) -> Result<(), Wrong> {
    let start = Instant::now();
    trial.until(|_| start.elapsed().as_secs_f64() >= time_s)
}

/// Stops a participant for a while. Right: the run completes bit-equal.
pub fn participant_for_1_s(trial: &mut FaultTrial) -> FaultResult {
    trial.begin(&[])?;
    if let Some(pid) = trial.participant(trial.participant_name())? {
        send(pid, Signal::SIGSTOP);
        pause(trial, 1.0)?;
        send(pid, Signal::SIGCONT);
    }
    completed(trial)
}

/// Stops a participant forever. Right: the coordinator ends with code 5 and says that the participant is stopped, no
/// participant is left, and the run resumes bit-equal; or the run needed no more answers and completes bit-equal.
pub fn participant_for_ever(trial: &mut FaultTrial) -> FaultResult {
    // A set-up has its own deadline, which also ends a stop in the set-up.
    let deadlines = format!("run.deadlines.setup_s={ANSWER_S:?}");
    let in_setup = trial.phase() == RunPhase::Handshake;
    let sets = [deadlines.as_str()];
    trial.begin(&sets[..usize::from(in_setup)])?;
    let name = trial.participant_name();
    let pid = trial.participant(name)?;
    let start = Instant::now();
    if let Some(pid) = pid {
        send(pid, Signal::SIGSTOP);
    }
    let status = trial.end()?;
    let detection_s = start.elapsed().as_secs_f64();
    trial.deserted(Duration::from_secs(1))?;
    if status.success() {
        return trial.completed();
    }
    let said = trial.said();
    let named = said.contains(&format!("participant `{name}` did not answer"));
    if status.code() != Some(5) || !named || !said.contains("alive but stopped") {
        return Err(format!("`{name}` stopped: {status}: {said}").into());
    }
    Ok(FaultOutcome::after(detection_s, "named", resumes(trial)?))
}

/// Stops the coordinator for longer than it would wait for an answer. Right: the run completes bit-equal, since no participant
/// kept it waiting.
pub fn coordinator_for_3_s(trial: &mut FaultTrial) -> FaultResult {
    trial.begin(&[])?;
    trial.signal(Signal::SIGSTOP);
    pause(trial, 3.0)?;
    trial.signal(Signal::SIGCONT);
    completed(trial)
}

/// Stops the coordinator forever. Right: the participants end by themselves once `idle_s` has passed, and after the coordinator is
/// killed the run resumes bit-equal.
pub fn coordinator_for_ever(trial: &mut FaultTrial) -> FaultResult {
    trial.begin(&[&format!("run.deadlines.idle_s={ANSWER_S:?}")])?;
    trial.signal(Signal::SIGSTOP);
    outlived(trial)
}

/// Stops one process after the other for 1 to 50 ms during the whole run. Right: it completes bit-equal.
pub fn jitter(trial: &mut FaultTrial) -> FaultResult {
    trial.start(&[])?;
    stop_and_go(trial, None, [[1e-3, 0.05]; 2])?;
    completed(trial)
}

/// Keys of a scene of 211 grains whose rail yields and sends a new compliance in most windows: 178 000 numbers for the layer each time,
/// in 11 pieces, of which at most 4 wait.
pub const LONG_FRAMES: [&str; 12] = [
    "run.end_s=2.4e-5",
    "interface.layer-base.scheme=dual-schur-secant",
    "interface.layer-base.substeps=5",
    "participant.rail.config.element=q4_bbar",
    "participant.rail.config.material={ kind = \"j2\", young_pa = 102.5e9, poisson = 0.3, density_kg_per_m3 = 7800.0, yield_pa = 1e6 }",
    "participant.rail.config.mesh.size_m=0.8e-3",
    "participant.rail.config.mesh.fine_depth_m=2.4e-3",
    "participant.rail.config.mesh.side_columns=6",
    "participant.rail.config.mesh.depth_rows=5",
    "participant.third-body.config.sample.half_width_m=8e-3",
    "participant.third-body.config.sample.radius_min_m=0.03e-3",
    "participant.third-body.config.sample.radius_max_m=0.06e-3",
];

/// Stops the layer for 120 of every 140 ms, longer than the coordinator's patience in the middle of a long frame, as a busy machine does.
/// Right: the run completes with the hashes of the undisturbed run.
pub fn long_frames(trial: &mut FaultTrial) -> FaultResult {
    trial.start(&LONG_FRAMES)?;
    trial.end()?;
    let (out, alone) = (trial.path("out"), trial.path("alone"));
    fs::rename(&out, alone).map_err(Error::output(out.display()))?;
    trial.start(&LONG_FRAMES)?;
    stop_and_go(trial, Some("third-body"), [[0.12; 2], [0.02; 2]])?;
    trial.end()?;
    let [own, alone] = ["out", "alone"].map(|out| trial.hashes(out));
    if own == alone && !own.contains(&Value::Null) {
        return Ok(FaultOutcome::of("completed"));
    }
    Err(format!("{own:?} instead of {alone:?}: {}", trial.said()).into())
}

/// Stops processes one after the other until the run has completed: this participant, or a random process of the run. Random times
/// between limits (s): stopped, and running.
fn stop_and_go(
    trial: &mut FaultTrial,
    name: Option<&str>,
    [stop_s, go_s]: [[f64; 2]; 2],
) -> Result<(), Wrong> {
    let end = Instant::now() + HANGS / 4;
    let mut ended = false;
    while !ended && Instant::now() < end {
        let participants = trial.participants();
        let any = trial.random.below(1 + participants.len() as u64) as usize;
        let stopped = match name {
            Some(name) => participants.iter().find(|(_, known)| known == name),
            None => participants.get(any),
        };
        let stopped = stopped.map(|(pid, _)| *pid);
        let signal = |trial: &FaultTrial, signal| match stopped {
            Some(pid) => send(pid, signal),
            None if name.is_none() => trial.signal(signal),
            None => {}
        };
        signal(trial, Signal::SIGSTOP);
        let time_s = trial.random.between(stop_s[0], stop_s[1]);
        pause(trial, time_s)?;
        signal(trial, Signal::SIGCONT);
        let time_s = trial.random.between(go_s[0], go_s[1]);
        pause(trial, time_s)?;
        ended = trial.log().contains("completed");
    }
    Ok(())
}
