//! Replaying a logged run: each solver alone against what the other side said, and the coupler against both.
//!
//! Requests are asked again and every answer is compared bit for bit with the logged one, repeats and halved windows
//! included; the coupler is run against tapes of both participants, and every request of its is compared.
//!
//! - [`tape`]: the logged conversation with one participant, also as a link;
//! - [`departure`]: where two streams part;
//! - [`solver`], [`coupler`]: the two kinds of replay.

use std::path::Path;

use crate::error::Error;
use crate::log::{Entry, Exchange, recover};
use crate::scenario::Loaded;
use crate::scenario::load::parse;
use crate::scenario::source::Source;

pub mod coupler;
pub mod departure;
pub mod solver;
pub mod tape;

pub use departure::Departure;

/// A log in memory, with the scenario that made it.
pub struct Recording {
    /// The scenario, resolved.
    pub loaded: Loaded,
    /// All interface messages in the order in which they passed.
    pub messages: Vec<Exchange>,
    /// Windows that ended.
    pub windows: u64,
    /// Why the log ends early, if it does.
    pub damage: Option<String>,
}

/// What came of replaying one participant or the coupler.
pub struct Replayed {
    /// Who was run again.
    pub who: String,
    /// Messages that were compared and equal.
    pub equal: u64,
    /// The last window with an equal message.
    pub last_window: u64,
    /// The first that was not.
    pub departure: Option<Departure>,
}

/// Reads a log; of a truncated one, the valid beginning.
pub fn recording(path: &Path) -> Result<Recording, Error> {
    let mut log = recover(path)?;
    let source = Source {
        name: format!("{} (scenario)", path.display()),
        text: log.provenance().scenario_toml.clone(),
        overrides: Vec::new(),
    };
    let loaded = parse(source)?;
    let (mut messages, mut windows) = (Vec::new(), 0);
    for entry in &mut log {
        match entry? {
            Entry::Exchange(message) => messages.push(message),
            Entry::WindowEnd(_) => windows += 1,
        }
    }
    Ok(Recording {
        loaded,
        messages,
        windows,
        damage: log.damage().map(ToString::to_string),
    })
}
