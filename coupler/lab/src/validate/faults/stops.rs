//! Processes that are stopped (SIGSTOP), for a while or for ever.

use std::time::{Duration, Instant};

use nix::sys::signal::Signal;

use super::kills::outlived;
use super::resumes::resumes;
use super::row::{FaultOutcome, FaultResult, Wrong};
use super::trial::{ANSWER_S, FaultTrial, HANGS, RunPhase, send};

/// A run that went on after a fault as if nothing had been.
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
pub fn participant_for(trial: &mut FaultTrial, time_s: f64) -> FaultResult {
    trial.begin(&[])?;
    if let Some(pid) = trial.participant(trial.participant_name())? {
        send(pid, Signal::SIGSTOP);
        pause(trial, time_s)?;
        send(pid, Signal::SIGCONT);
    }
    completed(trial)
}

/// Stops a participant for ever. Right: the coordinator ends with code 5 and says that the participant is stopped, no
/// participant is left, and the run resumes bit-equal; or the run had nothing more to ask and completes bit-equal.
pub fn participant_for_ever(trial: &mut FaultTrial) -> FaultResult {
    // A set-up has a deadline of its own: the stop comes later, or that is what it meets.
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
    Ok(FaultOutcome {
        word: "named",
        detection_s: Some(detection_s),
        windows_lost: resumes(trial)?,
    })
}

/// Stops the coordinator for longer than it would wait for an answer. Right: the run completes bit-equal, it has waited for
/// nobody.
pub fn coordinator_for(trial: &mut FaultTrial, time_s: f64) -> FaultResult {
    trial.begin(&[])?;
    trial.signal(Signal::SIGSTOP);
    pause(trial, time_s)?;
    trial.signal(Signal::SIGCONT);
    completed(trial)
}

/// Stops the coordinator for ever. Right: the participants end by themselves once `idle_s` has passed, and the run resumes
/// bit-equal when the coordinator was killed.
pub fn coordinator_for_ever(trial: &mut FaultTrial) -> FaultResult {
    trial.begin(&[&format!("run.deadlines.idle_s={ANSWER_S:?}")])?;
    trial.signal(Signal::SIGSTOP);
    outlived(trial)
}

/// Stops one process after the other for 1 to 50 ms, all through the run. Right: it completes bit-equal.
pub fn jitter(trial: &mut FaultTrial) -> FaultResult {
    trial.start(&[])?;
    let end = Instant::now() + HANGS / 4;
    let mut ended = false;
    while !ended && Instant::now() < end {
        let participants = trial.participants();
        let which = trial.random.below(1 + participants.len() as u64) as usize;
        let stopped = participants.get(which).map(|(pid, _)| *pid);
        let signal = |trial: &FaultTrial, signal| match stopped {
            Some(pid) => send(pid, signal),
            None => trial.signal(signal),
        };
        signal(trial, Signal::SIGSTOP);
        let time_s = trial.random.between(1e-3, 0.05);
        pause(trial, time_s)?;
        signal(trial, Signal::SIGCONT);
        let time_s = trial.random.between(1e-3, 0.05);
        pause(trial, time_s)?;
        ended = trial.log().contains("completed");
    }
    completed(trial)
}
