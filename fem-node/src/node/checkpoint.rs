//! Restoring the committed state of a checkpoint.

use fem_kernel::integrate::state::NodalState;
use fem_kernel::wheel::state::WheelState;
use protocol::{Cause, NodeError};

use super::fem_node::FemNode;
use crate::interface::window::committed::Committed;

impl FemNode {
    /// Restores a committed state if it is this body's. `hash` comes from the node that wrote it: bytes read into the wrong fields give another hash.
    pub(super) fn take_up(&mut self, committed: Committed, hash: &str) -> Result<(), NodeError> {
        if lengths(&committed.state) != lengths(&self.committed.state) {
            return foreign("the lengths of its fields differ");
        }
        let contacts = |wheel: &Option<WheelState>| wheel.as_ref().map(|w| w.contacts.len());
        if contacts(&committed.wheel) != contacts(&self.committed.wheel) {
            return foreign("its wheel touches other nodes");
        }
        self.committed = committed;
        self.pending = None;
        self.run.restart();
        self.gathered.take();
        if self.state_hash() != hash {
            return foreign("the hash of its numbers differs");
        }
        Ok(())
    }
}

/// Lengths of all fields.
fn lengths(state: &NodalState) -> ([usize; 5], [usize; 2]) {
    let [u, v, a, force, damped] = state.nodal().map(<[f64]>::len);
    // Empty until something has been damped.
    let damped = if damped == 0 { u } else { damped };
    let elements = [state.history.len(), state.thermal[1].len()];
    ([u, v, a, force, damped], elements)
}

/// Refuses a checkpoint, with the reason.
pub(super) fn foreign<T>(why: &str) -> Result<T, NodeError> {
    let text = format!(
        "the checkpoint belongs to another body: {why}; resume with the build and the scenario that wrote it"
    );
    Err(NodeError::of(Cause::CheckpointUnusable, text))
}
