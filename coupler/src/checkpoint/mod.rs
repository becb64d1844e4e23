//! Checkpoints: everything that can change a later bit of a run, of all participants after the same window.
//!
//! - [`mod@file`]: how one lies on the disk, and which of several is taken;
//! - [`keeper`]: writing them while a run goes on;
//! - [`origin`]: a run that goes on from one.
//!
//! A checkpoint is complete only together with the log and the signals up to its window: both are on the disk before
//! it gets its name.

use serde::{Deserialize, Serialize};

use crate::couple::scheme::CouplingState;
use crate::output::OutputState;

pub mod file;
pub mod keeper;
pub mod origin;

pub use file::{Found, Unusable};
pub use keeper::Keeper;
pub use origin::{Origin, find};

/// Folder of the run directory.
pub const FOLDER: &str = "checkpoints";

/// Windows between two checkpoints when the scenario says nothing: about one a second in the shipped scenes.
pub const EVERY_WINDOWS: u64 = 1000;

/// Who wrote a checkpoint, of what. It comes first in the file, so that a file of another version can say so.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct About {
    /// Name and version of the coordinator.
    pub software: String,
    /// Version of the protocol.
    pub protocol: u32,
    /// blake3 of the resolved scenario.
    pub scenario_hash: String,
    /// Name and software of each participant, in the order of the scenario.
    pub participants: Vec<(String, String)>,
}

/// How far a run has come.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Position {
    /// Windows that stand, of all groups of interfaces together.
    pub windows: u64,
    /// Simulated time that stands (s).
    pub t_s: f64,
    /// Where each group of interfaces goes on; none for a solver that runs alone.
    pub courses: Vec<Place>,
    /// Whether no window is left to do.
    pub over: bool,
}

/// Where the windows of a group go on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Place {
    /// Index of the next window.
    pub window: u64,
    /// Explicit steps done.
    pub step: u64,
    /// Steps left of a window that was halved, to be done first.
    pub rest: Option<u32>,
}

/// A run after a window.
#[derive(Debug, Serialize, Deserialize)]
pub struct Checkpoint {
    /// Where to go on.
    pub position: Position,
    /// Blocks that were ended in the log: the handshake, then each window.
    pub log_blocks: u64,
    /// State of each participant, as [`protocol::Node::checkpoint`] gave it.
    pub nodes: Vec<Vec<u8>>,
    /// State of the coupler, one for each group of interfaces.
    pub couplings: Vec<CouplingState>,
    /// What the outputs remember.
    pub outputs: OutputState,
}
