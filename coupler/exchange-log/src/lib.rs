//! The exchange log of a run: every interface message, both ways, in one MCAP file.
//!
//! Each stream (interface, sender, receiver and kind) has its own channel of protobuf messages, which other tools can plot. The doubles are
//! packed and keep their bits, and a reader rebuilds the frame. Time in the log is simulated time. Messages contain no run id, process ids
//! or wall-clock times: equal runs have equal messages. The log also contains scenario and manifest.
//!
//! Modules, in reading order:
//! - [`Entry`] and [`Exchange`], the exchanged frames; [`Provenance`], their run;
//! - [`proto`]: the messages, and their description for other tools;
//! - [`record`](mod@record): writing, on a separate thread;
//! - [`read`](mod@read): reading with every checksum verified, also after a killed writer; `torn`, `order` and `lengths` distinguish its
//!   torn end from damage;
//! - [`summary`]: the contents of a log in numbers; [`export`]: CSV tables;
//! - [`timing`]: wall-clock times of the requests, in a separate file; [`trace`]: these times for a trace viewer;
//! - [`hash`]: the fingerprint of an exchange; [`mismatch`]: the first difference of two; [`volume`]: the predicted size of a log.

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
