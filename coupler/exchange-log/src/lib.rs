//! The exchange log of a run: every interface message, both ways, in one MCAP file.
//!
//! Each stream, that is interface, sender, receiver and kind, has its own channel of protobuf messages, so that
//! other tools can plot it; the doubles are packed and keep their bits, and a reader rebuilds the frame. Time in the
//! log is simulated time. Run id, process ids and wall-clock times stay out of the messages: equal runs have equal
//! messages. Scenario and manifest travel along.
//!
//! Modules, in reading order:
//! - [`Entry`] and [`Exchange`], the frames that passed; [`Provenance`], the run that they are of;
//! - [`proto`]: the messages, and their description for other tools;
//! - [`record`](mod@record): writing, on a thread of its own;
//! - [`read`](mod@read): reading back, with every checksum verified, also what a killed writer left; `torn`, `order` and
//!   `lengths` tell that from damage;
//! - [`summary`]: what a log holds; [`export`]: as tables of text;
//! - [`timing`]: wall-clock times of the requests, in a file of their own; [`trace`]: these for a viewer of traces;
//! - [`hash`]: the fingerprint of an exchange; [`mismatch`]: the first difference of two; [`volume`]: how long a log will be.

mod entry;
mod error;
pub mod export;
pub mod hash;
mod lengths;
pub mod mismatch;
mod order;
pub mod proto;
mod provenance;
pub mod read;
pub mod record;
pub mod summary;
pub mod timing;
mod torn;
pub mod trace;
pub mod volume;

pub use entry::{COUPLER, Entry, Exchange};
pub use error::{ExportError, LogError};
pub use hash::ExchangeHasher;
pub use mismatch::Mismatch;
pub use provenance::{FORMAT, Provenance};
pub use read::{LogFile, damage, read, recover};
pub use record::{LogStats, Recorder};
pub use summary::{LogSummary, NonFinite, Stream, WindowStats, summarize};
pub use volume::Volume;

#[cfg(test)]
mod tests;
