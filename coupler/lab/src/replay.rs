//! Replaying a logged run: each solver alone against what the other side said, and the coupler against both.
//!
//! Requests are asked again and every answer is compared bit for bit with the logged one, repeats and halved windows
//! included; the coupler is run against tapes of both participants, and every request of its is compared.
//!
//! - [`replayed`]: what came of a replay;
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
    /// All interface messages in the order in which they passed.
    pub messages: Vec<Exchange>,
    /// Messages before the end of each block: the handshake of a coupled run, then each window.
    pub ends: Vec<usize>,
    /// Reason why the log ends early, if it does.
    pub damage: Option<String>,
    /// True if it ends early and is sound up to there, as a killed writer leaves it.
    pub torn: bool,
}

impl Recording {
    /// Messages that had passed when a checkpoint was written; none for a replay from the start.
    pub fn messages_before(&self, origin: Option<&RestartPoint>) -> usize {
        self.before(origin.map_or(0, |origin| origin.checkpoint.log_blocks))
    }

    /// Messages of the handshake of a coupled run.
    pub fn handshake(&self) -> usize {
        self.before(1)
    }

    /// Turns of a participant after the last window that ended: whoever repeats them may stop among them as well.
    fn open_turns(&self, participant: &str) -> usize {
        let ended = self.before(self.ends.len() as u64);
        turns(&self.messages[ended..], participant).len()
    }

    /// Messages of the first so many blocks.
    fn before(&self, blocks: u64) -> usize {
        let end = |blocks: usize| self.ends.get(blocks.checked_sub(1)?);
        end(blocks as usize).copied().unwrap_or(0)
    }
}

/// Reads a log; of a truncated one, the valid beginning. `overrides` change the scenario that made it.
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
