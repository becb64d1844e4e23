//! The input of a window, and the extent of its run.

use std::sync::Arc;

use fem_kernel::integrate::region::Region;

use super::committed::Committed;
use crate::model::Model;

/// Boundary data of a window.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct WindowInput {
    /// Own steps to do.
    pub(crate) substeps: u32,
    /// Interface force by component (N), held constant.
    pub(crate) interface: Vec<(usize, f64)>,
    /// Velocity by component (m/s) at the end of the window, reached linearly.
    pub(crate) velocity: Vec<(usize, f64)>,
}

/// A window of a body from its committed state.
#[derive(Clone, Copy)]
pub(crate) struct BodyWindow<'a> {
    pub(crate) model: &'a Model,
    pub(crate) committed: &'a Committed,
    pub(crate) input: &'a WindowInput,
}

/// Extent of a run of a window.
#[derive(Clone, Debug)]
pub(crate) enum Extent {
    /// The whole body.
    Whole,
    /// The whole body; the states of the rings of a region are recorded.
    Recorded(Arc<Region>),
    /// The part that the changed force can have reached since the recorded run.
    Part(Arc<Region>),
}

impl Extent {
    pub(crate) fn is_part(&self) -> bool {
        matches!(self, Extent::Part(_))
    }

    /// The region that is recorded or run.
    pub(crate) fn region(&self) -> Option<&Arc<Region>> {
        match self {
            Extent::Whole => None,
            Extent::Recorded(region) | Extent::Part(region) => Some(region),
        }
    }
}
