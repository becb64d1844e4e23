//! The exchange log of a run: every interface message, both ways, in one MCAP file.
//!
//! Each stream, that is interface, sender, receiver and kind, has its own channel of protobuf messages, so that
//! other tools can plot it; the doubles are packed and keep their bits, and a reader rebuilds the frame. Time in the
//! log is simulated time. Run id, process ids and wall-clock times stay out of the messages: equal runs have equal
//! messages. Scenario and manifest travel along.
//!
//! Modules, in reading order:
//! - [`proto`]: the messages, and their description for other tools;
//! - [`record`](mod@record): writing, on a thread of its own;
//! - [`read`](mod@read): reading back, with every checksum verified, also what a killed writer left;
//! - [`summary`]: what a log holds; [`export`]: as tables of text;
//! - [`hash`]: the fingerprint of an exchange; [`volume`]: how long a log will be.

use std::error::Error;
use std::path::{Path, PathBuf};

use thiserror::Error as ThisError;

pub mod export;
pub mod hash;
pub mod mismatch;
pub mod proto;
pub mod read;
pub mod record;
pub mod summary;
pub mod volume;

pub use hash::ExchangeHasher;
pub use mismatch::Mismatch;
pub use read::{Entry, Exchange, LogFile, read, recover};
pub use record::{LogStats, Recorder};
pub use summary::{LogSummary, NonFinite, Stream, WindowStats, summarize};
pub use volume::Volume;

/// Name under which the coupler's own frames are logged.
pub const COUPLER: &str = "coupler";

/// The name and version of this format, in the metadata of every log.
pub const FORMAT: &str = "thirdbody.exchange/1";

/// What a log says about the run that it belongs to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Provenance {
    /// The resolved scenario, TOML.
    pub scenario_toml: String,
    /// manifest.json: versions, seeds, host.
    pub manifest_json: String,
    /// The run that all frames name.
    pub run_id: u64,
}

/// Why a log cannot be written or read.
#[derive(Debug, ThisError)]
#[allow(missing_docs)]
pub enum LogError {
    #[error("{path} cannot be written: {why}", path = .path.display())]
    Write { path: PathBuf, why: String },
    #[error("{path}: nothing was written for {seconds} s", path = .path.display())]
    Stalled { path: PathBuf, seconds: u64 },
    #[error("{path} was closed by an earlier error", path = .path.display())]
    Closed { path: PathBuf },
    #[error("a message of {doubles} doubles is longer than the {capacity} that a log takes")]
    TooLong { doubles: usize, capacity: usize },
    #[error("{path} cannot be read: {source}", path = .path.display())]
    Read {
        path: PathBuf,
        source: std::io::Error,
    },
    #[error("{path} is not an exchange log: {why}", path = .path.display())]
    NotALog { path: PathBuf, why: String },
    #[error(
        "{path} is damaged at byte {offset}, in {place}: {why}; `thirdbody inspect --recover` reads what comes before", path = .path.display()
    )]
    Damaged {
        path: PathBuf,
        offset: u64,
        place: String,
        why: String,
    },
}

impl LogError {
    fn write(path: &Path, error: &dyn Error) -> LogError {
        LogError::Write {
            path: path.into(),
            why: chain(error),
        }
    }
}

/// An error with its causes: mcap's own messages leave out what the system said.
fn chain(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        let said = error.to_string();
        if !text.contains(&said) {
            text = format!("{text}: {said}");
        }
        cause = error.source();
    }
    text
}

#[cfg(test)]
mod tests;
