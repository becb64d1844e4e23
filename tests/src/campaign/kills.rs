//! Processes that are killed.

use std::time::{Duration, Instant};

use nix::sys::signal::Signal;

use super::resumes::{lost_windows, resumes};
use super::row::{FaultOutcome, FaultResult};
use super::trial::{FaultTrial, HANGS, send};

/// Kills a participant. Right: the coordinator ends by itself with code 4 and the name of the participant, no other participant
/// is left, and the run resumes bit-equal; or the run needed no more answers and completes bit-equal.
pub fn participant(trial: &mut FaultTrial, name: &str) -> FaultResult {
    trial.begin(&[])?;
    let pid = trial.participant(name)?;
    let start = Instant::now();
    if let Some(pid) = pid {
        send(pid, Signal::SIGKILL);
    }
    let status = trial.end()?;
    trial.deserted(Duration::from_secs(1))?;
    let detection_s = start.elapsed().as_secs_f64();
    if status.code() == Some(0) {
        return trial.completed();
    }
    let said = trial.said();
    if status.code() != Some(4) || !said.contains(&format!("lost participant `{name}`")) {
        return Err(format!("`{name}` killed: {status}: {said}").into());
    }
    Ok(FaultOutcome::after(detection_s, "lost", resumes(trial)?))
}

/// Kills the coordinator. Right: all participants end by themselves, and the run resumes bit-equal, or had not written anything yet.
pub fn coordinator(trial: &mut FaultTrial) -> FaultResult {
    trial.begin(&[])?;
    trial.signal(Signal::SIGKILL);
    outlived(trial)
}

/// Kills all processes of a run at once. Right: as for the coordinator.
pub fn everything(trial: &mut FaultTrial) -> FaultResult {
    trial.begin(&[])?;
    let participants = trial.participants();
    trial.signal(Signal::SIGKILL);
    for (pid, _) in participants {
        send(pid, Signal::SIGKILL);
    }
    outlived(trial)
}

/// Waits for the participants to end, kills a stopped coordinator, and judges the rest of the run.
pub fn outlived(trial: &mut FaultTrial) -> FaultResult {
    let detection_s = trial.deserted(HANGS)?;
    trial.signal(Signal::SIGKILL);
    if trial.end()?.success() {
        return trial.completed();
    }
    if !trial.path("out/scenario.toml").is_file() {
        let code = trial.verb(&["resume", "out", "--out", "again"])?;
        if code != Some(2) {
            return Err(format!("nothing had begun, resume: {code:?} {}", trial.said()).into());
        }
        return Ok(FaultOutcome::after(detection_s, "not begun", None));
    }
    let lost = lost_windows(trial)?;
    Ok(FaultOutcome::after(detection_s, "resumed", lost))
}
