//! The parts of a checkpoint.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::output::OutputState;
use crate::run::position::RunPosition;
use scheme::coupling::CouplingState;

/// Folder of the run directory.
pub const FOLDER: &str = "checkpoints";

/// Windows between two checkpoints by default: about one checkpoint a second in the shipped scenes.
pub const EVERY_WINDOWS: u64 = 1000;
/// Longest time between two checkpoints by default: windows of a large sample last seconds.
pub const EVERY_TIME: Duration = Duration::from_secs(300);

/// The author and the subject of a checkpoint. It comes first in the file, so that a file of another version is
/// recognised.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct About {
    /// Name, version and build of the coordinator.
    pub software: String,
    /// Version of the protocol.
    pub protocol: u32,
    /// blake3 of the resolved scenario.
    pub scenario_hash: String,
    /// Name and software of each participant, in the order of the scenario.
    pub participants: Vec<(String, String)>,
}

/// A run after a window.
#[derive(Debug, Serialize, Deserialize)]
pub struct Checkpoint {
    /// Position from which to continue.
    pub position: RunPosition,
    /// Completed blocks of the log: the handshake, then each window.
    pub log_blocks: u64,
    /// State of each participant, from [`protocol::Node::checkpoint`].
    pub nodes: Vec<Vec<u8>>,
    /// States of the coupler, one for each group of interfaces.
    pub couplings: Vec<CouplingState>,
    /// Memory of the outputs.
    pub outputs: OutputState,
}
