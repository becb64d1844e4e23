//! Replaying a logged run: each solver alone against what the other side said, and the coupler against both.
//!
//! Requests are asked again and every answer is compared bit for bit with the logged one, repeats and halved windows
//! included; the coupler is run against tapes of both participants, and every request of its is compared.
//!
//! - [`tape`]: the logged conversation with one participant, also as a link;
//! - [`judge`]: the size of a mismatch; [`mod@drift`]: its growth;
//! - [`solver`], [`coupler`]: the two kinds of replay.

use std::path::Path;

use crate::error::Error;
use crate::log::{Entry, Exchange, Mismatch, recover};
use crate::run::checkpoint::RestartPoint;
use crate::scenario::load::{Loaded, parse};
use crate::scenario::source::Source;

pub mod coupler;
pub mod drift;
pub mod judge;
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

    /// Messages of the first so many blocks.
    fn before(&self, blocks: u64) -> usize {
        let last = (blocks as usize).checked_sub(1);
        last.and_then(|last| self.ends.get(last))
            .map_or(0, |end| *end)
    }
}

/// The distance of an answer from its logged twin, see [`judge::Ruler`].
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
}

impl Replayed {
    /// Nothing yet.
    pub fn of(who: &str) -> Replayed {
        Replayed {
            who: who.to_string(),
            ..Replayed::default()
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
    let loaded = parse(source)?;
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
    })
}
