//! Positions of a run in time, for checkpoints.

use serde::{Deserialize, Serialize};

/// Progress of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunPosition {
    /// Accepted windows, of all groups of interfaces together.
    pub windows: u64,
    /// Accepted simulated time (s).
    pub t_s: f64,
    /// Position of each group of interfaces; empty for a solver that runs alone.
    pub groups: Vec<GroupPosition>,
    /// True if no window is left.
    pub over: bool,
}

/// Position of a group.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GroupPosition {
    /// Index of the next window.
    pub window: u64,
    /// Completed explicit steps.
    pub step: u64,
    /// Remaining steps of a halved window, which come first.
    pub rest: Option<u32>,
}
