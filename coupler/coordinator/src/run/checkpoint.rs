//! Checkpoints: the complete state of a run, with all participants after the same window.
//!
//! - [`content`]: the parts of a checkpoint;
//! - [`mod@file`]: its file, and the list of files;
//! - [`keeper`]: writing checkpoints during a run;
//! - [`restart`]: resuming a run from a checkpoint.
//!
//! A checkpoint is complete only together with the log and the signals up to its window: both are on the disk before it
//! gets its name. It holds sizes and hashes for checks of signals, fields and profiles.

pub mod content;
pub mod file;
pub mod keeper;
pub mod restart;

pub use content::{About, Checkpoint, FOLDER};
pub use file::{CheckpointFile, Unusable};
pub use keeper::Keeper;
pub use restart::{RestartPoint, find};
