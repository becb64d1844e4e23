//! Processes that are killed.

use std::time::{Duration, Instant};

use nix::sys::signal::Signal;

use super::resumes::{lost_windows, resumes};
use super::row::{FaultOutcome, FaultResult};
use super::trial::{FaultTrial, HANGS, RunPhase, send};
use crate::random::Random;

/// Kills a participant. Right: the coordinator ends by itself with code 4 and the name of the participant, no other participant
/// is left, and the run resumes bit-equal; or the run had nothing more to ask and completes bit-equal.
pub fn participant(
    trial: &mut FaultTrial,
    random: &mut Random,
    phase: RunPhase,
    name: &str,
) -> FaultResult {
    trial.start(&[])?;
    trial.reach(phase, random)?;
    let pid = trial.participant(name)?;
    let start = Instant::now();
    if let Some(pid) = pid {
        send(pid, Signal::SIGKILL);
    }
    let status = trial.end()?;
    trial.deserted(Duration::from_secs(1))?;
    let detection_s = start.elapsed().as_secs_f64();
    if status.code() == Some(0) {
        trial.is_bit_equal("out")?;
        return Ok(FaultOutcome {
            word: "completed",
            ..FaultOutcome::default()
        });
    }
    let said = trial.said();
    if status.code() != Some(4) || !said.contains(&format!("lost participant `{name}`")) {
        return Err(format!("`{name}` killed: {status}: {said}").into());
    }
    Ok(FaultOutcome {
        word: "lost",
        detection_s: Some(detection_s),
        windows_lost: resumes(trial)?,
    })
}

/// Kills the coordinator. Right: all participants end by themselves, and the run resumes bit-equal, or had not begun to write.
pub fn coordinator(trial: &mut FaultTrial, random: &mut Random, phase: RunPhase) -> FaultResult {
    trial.start(&[])?;
    trial.reach(phase, random)?;
    trial.signal(Signal::SIGKILL);
    let detection_s = trial.deserted(HANGS)?;
    let status = trial.end()?;
    outlived(trial, status.success(), Some(detection_s))
}

/// Kills all processes of a run at once. Right: as for the coordinator.
pub fn everything(trial: &mut FaultTrial, random: &mut Random, phase: RunPhase) -> FaultResult {
    trial.start(&[])?;
    trial.reach(phase, random)?;
    let participants = trial.participants();
    trial.signal(Signal::SIGKILL);
    for (pid, _) in participants {
        send(pid, Signal::SIGKILL);
    }
    let detection_s = trial.deserted(HANGS)?;
    let status = trial.end()?;
    outlived(trial, status.success(), Some(detection_s))
}

/// Judges what a coordinator that is gone has left.
pub fn outlived(trial: &mut FaultTrial, completed: bool, detection_s: Option<f64>) -> FaultResult {
    if completed {
        trial.is_bit_equal("out")?;
        return Ok(FaultOutcome {
            word: "completed",
            ..FaultOutcome::default()
        });
    }
    if !trial.path("out/scenario.toml").is_file() {
        let code = trial.verb(&["resume", "out", "--out", "again"])?;
        if code != Some(2) {
            return Err(format!("nothing had begun, resume: {code:?} {}", trial.said()).into());
        }
        return Ok(FaultOutcome {
            word: "not begun",
            detection_s,
            windows_lost: None,
        });
    }
    Ok(FaultOutcome {
        word: "resumed",
        detection_s,
        windows_lost: lost_windows(trial)?,
    })
}
