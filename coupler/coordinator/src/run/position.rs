//! Positions of a run in time, as checkpoints hold them.

use serde::{Deserialize, Serialize};

/// Progress of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunPosition {
    /// Accepted windows, of all groups of interfaces together.
    pub windows: u64,
    /// Simulated time that is accepted (s).
    pub t_s: f64,
    /// Position of each group of interfaces; none for a solver that runs alone.
    pub groups: Vec<GroupPosition>,
    /// True if no window is left to do.
    pub over: bool,
}

/// Position of a group.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GroupPosition {
    /// Index of the next window.
    pub window: u64,
    /// Explicit steps done.
    pub step: u64,
    /// Steps left of a window that was halved, to be done first.
    pub rest: Option<u32>,
}
