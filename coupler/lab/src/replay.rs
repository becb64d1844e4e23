//! Replaying a logged run: each solver alone against what the other side said, and the coupler against both.
//!
//! Requests are asked again and every answer is compared bit for bit with the logged one, repeats and halved windows
//! included; the coupler is run against tapes of both participants, and every request of its is compared.
//!
//! - [`tape`]: the logged conversation with one participant, also as a link;
//! - [`deviation`]: the size of a mismatch; [`mod@drift`]: its growth;
//! - [`solver`], [`coupler`]: the two kinds of replay.

use std::path::Path;

use protocol::{Frame, Header, Kind};

use coordinator::error::Error;
use coordinator::run::checkpoint::RestartPoint;
use coordinator::scenario::load::{Loaded, folder_of_manifest, parse};
use coordinator::scenario::source::Source;
use exchange_log::{Entry, Exchange, LogError, Mismatch, recover};
use tape::turns;

pub mod coupler;
pub mod deviation;
pub mod drift;
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
        let last = (blocks as usize).checked_sub(1);
        last.and_then(|last| self.ends.get(last))
            .map_or(0, |end| *end)
    }
}

/// The distance of an answer from its logged twin, see [`deviation::Ruler`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift {
    /// Window.
    pub window: u64,
    /// [`protocol::Kind`] as its number.
    pub kind: u32,
    /// Largest deviation, relative.
    pub rel: f64,
}

/// Outcome of replaying one participant or the coupler.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Replayed {
    /// Name of the participant, or the coupler's.
    pub who: String,
    /// Messages that were compared and equal.
    pub equal: u64,
    /// The last window with an equal message.
    pub last_window: u64,
    /// The first that was not.
    pub mismatch: Option<Mismatch>,
    /// Wall-clock time (s) from the first message to the last, without the start of solvers and the reading of the log.
    pub wall_s: f64,
    /// The part of it that the solver was at work (s), as it says itself; none for the coupler, nor after a departure.
    pub solve_wall_s: Option<f64>,
    /// Every answer, where the replay went on after the first departure.
    pub drift: Vec<Drift>,
    /// [`protocol::Outcome::state_hash`] of a solver that was asked everything.
    pub state_hash: Option<String>,
}

impl Replayed {
    /// Nothing yet.
    pub fn of(who: &str) -> Replayed {
        Replayed {
            who: who.to_string(),
            ..Replayed::default()
        }
    }

    /// Compares the state that a solver ended in with the one that the run says it ended in. An answer that had departed
    /// before comes first.
    pub fn compare_state(&mut self, logged: &str) {
        let differs = |ours: &&String| *ours != logged;
        if let Some(ours) = self.state_hash.as_ref().filter(differs) {
            let header = Header {
                window: self.last_window,
                ..Header::of(Kind::Finished)
            };
            let [logged, ours] = [logged, ours].map(|hash| format!("the final state {hash}"));
            let found = Mismatch::at(&self.who, &Frame::new(header, Vec::new()), &logged, &ours);
            self.mismatch.get_or_insert(found);
        }
    }
}

/// Reads a log; of a truncated one, the valid beginning. `overrides` change the scenario that made it.
pub fn recording(path: &Path, overrides: &[String]) -> Result<Recording, Error> {
    let mut log = recover(path)?;
    let source = Source {
        name: format!("{} (scenario)", path.display()),
        text: log.provenance().scenario_toml.clone(),
        overrides: overrides.to_vec(),
    };
    let mut loaded = parse(source)?;
    if let Some(folder) = folder_of_manifest(&log.provenance().manifest_json) {
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
        damage: log.damage().map(ToString::to_string),
        torn: log.damage().is_some_and(LogError::is_torn),
    })
}
