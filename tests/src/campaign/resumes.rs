//! Resumed runs.

use super::row::Wrong;
use super::trial::FaultTrial;

/// Resumes a run that wrote its summary, to the bits of the undisturbed run; returns the number of lost windows.
pub fn resumes(trial: &mut FaultTrial) -> Result<Option<u64>, Wrong> {
    let reached = trial.json("out/summary.json")["windows"].as_u64();
    let from = resumed_from(trial)?;
    Ok(reached.map(|reached| reached.saturating_sub(from)))
}

/// The same for a run whose coordinator could not write a summary: the log shows how far it had come.
pub fn lost_windows(trial: &mut FaultTrial) -> Result<Option<u64>, Wrong> {
    let inspected = trial.verb(&["inspect", "out", "--recover", "--json"])?;
    let windows = trial.json("stdout")["windows"].as_u64();
    let reached = windows.filter(|_| inspected == Some(0)).unwrap_or(0);
    Ok(Some(reached.saturating_sub(resumed_from(trial)?)))
}

/// Resumes, and returns the window of the checkpoint.
fn resumed_from(trial: &mut FaultTrial) -> Result<u64, Wrong> {
    let code = trial.verb(&["resume", "out", "--out", "again", "--json"])?;
    if code != Some(0) {
        return Err(format!("resume ended with {code:?}: {}", trial.said()).into());
    }
    trial.is_bit_equal("again")?;
    let manifest = trial.json("again/manifest.json");
    Ok(manifest["resumed"]["window"].as_u64().unwrap_or(0))
}
