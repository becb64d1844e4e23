//! Writes checkpoints during a run.

use std::fs;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use protocol::{Frame, Kind, PROTOCOL_VERSION};

use super::content::{About, Checkpoint, EVERY_TIME, EVERY_WINDOWS, FOLDER};
use super::file::{encode, list, path};
use crate::participants::Communicator;
use crate::participants::handshake::Greeted;
use crate::participants::recorded::Recorded;
use crate::run::position::RunPosition;
use runs::identity::build;
use runs::run_dir::{RunDir, write_whole};
use scenario::error::{Error, Refusal, Result};
use scenario::load::Loaded;

/// Decides when a checkpoint is due, and writes it.
pub struct Keeper {
    folder: PathBuf,
    about: About,
    cadence: Option<Cadence>,
    kept: usize,
    /// Time of the last checkpoint, or of the start.
    last: Instant,
}

/// Cadence of the checkpoints of a resumable run.
#[derive(Clone, Copy)]
struct Cadence {
    windows: u64,
    /// Longest time between two; `None` if the scenario gives a number of windows.
    time: Option<Duration>,
}

impl Cadence {
    fn due(&self, windows: u64, since: Duration) -> bool {
        windows.is_multiple_of(self.windows) || self.time.is_some_and(|time| since >= time)
    }
}

/// The author and subject of a checkpoint of this scenario by this build. The participants are added after their
/// greeting.
pub fn about(loaded: &Loaded) -> About {
    let (version, build) = (env!("CARGO_PKG_VERSION"), build().hash);
    About {
        // Another build may store its state differently.
        software: format!("thirdbody {version} build {build}"),
        protocol: PROTOCOL_VERSION,
        scenario_hash: loaded.hash.clone(),
        participants: Vec::new(),
    }
}

/// The name and the software of each participant.
pub fn participants(loaded: &Loaded, greeted: &[Greeted]) -> Vec<(String, String)> {
    let pairs = loaded.scenario.participant.iter().zip(greeted);
    let software = |greeted: &Greeted| greeted.description.software.clone();
    let pairs = pairs.map(|(participant, greeted)| (participant.name.clone(), software(greeted)));
    pairs.collect()
}

impl Keeper {
    /// A keeper for a run of these participants. If the scenario gives a cadence, all of them must be resumable;
    /// otherwise a run with others has no checkpoints.
    pub fn new(rundir: &RunDir, loaded: &Loaded, greeted: &[Greeted]) -> Result<Keeper> {
        let run = &loaded.scenario.run;
        let both = loaded.scenario.participant.iter().zip(greeted);
        let unable = both.filter(|(_, greeted)| !greeted.description.capabilities.resume);
        let unable: Vec<String> = unable.map(|(of, _)| format!("`{}`", of.name)).collect();
        let unable = unable.join(" and ");
        let (windows, time) = match run.checkpoint_every_windows {
            Some(windows) if windows > 0 && !unable.is_empty() => {
                let problem = format!(
                    "participant {unable} cannot write a checkpoint (capability `resume`): set the key to 0, or leave it out"
                );
                return Err(Refusal::argument("run.checkpoint_every_windows", problem).into());
            }
            Some(windows) => (windows, None),
            None if !unable.is_empty() => {
                let note = format!("no checkpoints: participant {unable} cannot write one");
                rundir.note(&note);
                (0, None)
            }
            None if !run.output.exchange => (0, None),
            None => (EVERY_WINDOWS, Some(EVERY_TIME)),
        };
        let cadence = Some(Cadence { windows, time }).filter(|cadence| cadence.windows > 0);
        Ok(Keeper {
            folder: rundir.path().join(FOLDER),
            about: About {
                participants: participants(loaded, greeted),
                ..about(loaded)
            },
            cadence,
            last: Instant::now(),
            kept: run.checkpoints_kept as usize,
        })
    }

    /// True if it writes checkpoints.
    pub fn writes(&self) -> bool {
        self.cadence.is_some()
    }

    /// True if a checkpoint is due here: at its cadence, and when the run is interrupted. At its end a run needs no
    /// checkpoint.
    pub fn due(&self, at: &RunPosition, interrupted: bool) -> bool {
        let due = |cadence: Cadence| interrupted || cadence.due(at.windows, self.last.elapsed());
        !at.over && self.cadence.is_some_and(due)
    }

    /// Requests the states of all participants, writes them with the data that `rest` adds, and removes the oldest
    /// checkpoints.
    pub fn write(
        &mut self,
        recorded: &mut Recorded,
        rest: impl FnOnce(Vec<Vec<u8>>, u64) -> Checkpoint,
    ) -> Result<()> {
        let communicator: &mut dyn Communicator = recorded;
        let kinds = (Kind::Checkpoint, Kind::State);
        let read = |frame: &Frame| frame.bytes().map_err(|error| error.to_string());
        let nodes = communicator.ask_all(kinds, &[], read)?;
        let log_blocks = recorded.journal.sync()?;
        let checkpoint = rest(nodes, log_blocks);
        let bytes = encode(&self.about, &checkpoint)?;
        fs::create_dir_all(&self.folder).map_err(Error::output(self.folder.display()))?;
        write_whole(&path(&self.folder, checkpoint.position.windows), &bytes)?;
        self.last = Instant::now();
        let all = list(&self.folder);
        for old in &all[..all.len().saturating_sub(self.kept)] {
            fs::remove_file(&old.path).map_err(Error::output(old.path.display()))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_windows_have_checkpoints_by_the_clock() {
        let by_itself = Cadence {
            windows: 10,
            time: Some(Duration::from_secs(60)),
        };
        let due =
            |cadence: Cadence, windows, seconds| cadence.due(windows, Duration::from_secs(seconds));
        assert!(due(by_itself, 20, 0) && due(by_itself, 3, 60));
        assert!(!due(by_itself, 3, 59));
        let asked = Cadence {
            time: None,
            ..by_itself
        };
        assert!(due(asked, 20, 0) && !due(asked, 3, 1_000_000));
    }
}
