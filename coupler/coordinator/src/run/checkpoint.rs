//! Checkpoints: everything that can change a later bit of a run, of all participants after the same window.
//!
//! - [`content`]: the parts of one;
//! - [`mod@file`]: its form on the disk, and the choice among several;
//! - [`keeper`]: writing them while a run goes on;
//! - [`restart`]: a run that is resumed from one.
//!
//! A checkpoint is complete only together with the log and the signals up to its window: both are on the disk before
//! it gets its name, and it holds what signals, fields and profiles can be checked by.

pub mod content;
pub mod file;
pub mod keeper;
pub mod restart;

pub use content::{About, Checkpoint, FOLDER};
pub use file::{CheckpointFile, Unusable};
pub use keeper::Keeper;
pub use restart::{RestartPoint, find};
