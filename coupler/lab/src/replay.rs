//! Replay of a logged run: each solver alone against the logged other side, and the coupler against all participants.
//!
//! A solver gets all requests again, including repeats and halved windows, and every answer is compared bit for bit with the logged one.
//! The coupler runs against tapes of the participants, and every request is compared.
//!
//! - [`replayed`]: the outcome of a replay;
//! - [`tape`]: the logged conversation with one participant, also as a link;
//! - [`deviation`]: the size of a mismatch; [`mod@drift`]: its growth;
//! - [`solver`], [`coupler`]: the two kinds of replay.

use std::path::Path;

use coordinator::run::checkpoint::RestartPoint;
use exchange_log::{Entry, Exchange, LogError, recover};
use scenario::error::Error;
use scenario::load::{FOLDER_KEY, Loaded, of_manifest, parse};
use scenario::source::ScenarioSource;
use tape::turns;

pub mod coupler;
pub mod deviation;
pub mod drift;
pub mod replayed;
pub mod solver;
pub mod tape;

/// A log in memory, with the scenario that made it.
pub struct Recording {
    /// The scenario, resolved.
    pub loaded: Loaded,
    /// All interface messages in the order in which they were sent.
    pub messages: Vec<Exchange>,
    /// Number of messages before the end of each block: the handshake of a coupled run, then each window.
    pub ends: Vec<usize>,
    /// Reason why the log ends early, if it does.
    pub damage: Option<String>,
    /// True if it ends early but is valid up to that point, as after a killed writer.
    pub torn: bool,
}

impl Recording {
    /// Number of messages before a checkpoint; 0 for a replay from the start.
    pub fn messages_before(&self, origin: Option<&RestartPoint>) -> usize {
        self.before(origin.map_or(0, |origin| origin.checkpoint.log_blocks))
    }

    /// Number of messages of the handshake of a coupled run.
    pub fn handshake(&self) -> usize {
        self.before(1)
    }

    /// Number of turns of a participant after the last complete window: a replay may stop among them as well.
    fn open_turns(&self, participant: &str) -> usize {
        let ended = self.before(self.ends.len() as u64);
        turns(&self.messages[ended..], participant).len()
    }

    /// Number of messages of the first `blocks` blocks.
    fn before(&self, blocks: u64) -> usize {
        let last = (blocks as usize).checked_sub(1);
        last.and_then(|last| self.ends.get(last))
            .map_or(0, |end| *end)
    }
}

/// Reads a log, of a truncated log the valid part. `overrides` change its scenario.
pub fn recording(path: &Path, overrides: &[String]) -> Result<Recording, Error> {
    let mut log = recover(path)?;
    let name = format!("{} (scenario)", path.display());
    let text = log.provenance.scenario_toml.clone();
    let mut loaded = parse(ScenarioSource::new(name, text, overrides))?;
    if let Some(folder) = of_manifest(&log.provenance.manifest_json, FOLDER_KEY) {
        loaded.folder = folder;
    }
    let (mut messages, mut ends) = (Vec::new(), Vec::new());
    for entry in &mut log {
        match entry? {
            Entry::Exchange(message) => messages.push(message),
            Entry::WindowEnd(_) => ends.push(messages.len()),
        }
    }
    Ok(Recording {
        loaded,
        messages,
        ends,
        damage: log.damage.as_ref().map(ToString::to_string),
        torn: log.damage.as_ref().is_some_and(LogError::is_torn),
    })
}
