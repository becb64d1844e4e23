//! The committed state of a checkpoint, taken up again.

use protocol::NodeError;

use super::fem_node::FemNode;
use super::foreign::foreign;
use crate::integrate::state::NodalState;
use crate::interface::window::committed::Committed;
use crate::wheel::state::WheelState;

impl FemNode {
    /// Takes up a committed state if it is of this body; `hash` is that of the node that wrote it: bytes that are read into
    /// other fields than they came from give another one.
    pub(super) fn take_up(&mut self, committed: Committed, hash: &str) -> Result<(), NodeError> {
        if lengths(&committed.state) != lengths(&self.committed.state) {
            return foreign("its fields have other lengths");
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
            return foreign("its numbers have another hash");
        }
        Ok(())
    }
}

/// Lengths of all fields.
fn lengths(state: &NodalState) -> [usize; 6] {
    // Empty until something has been damped.
    let damped = Some(&state.damping_force).filter(|force| !force.is_empty());
    let damped = damped.unwrap_or(&state.u);
    let [u, v, a] = [&state.u, &state.v, &state.a];
    let [u, v, force, a, damped] = [u, v, &state.force, a, damped].map(|field| field.len());
    [u, v, force, a, damped, state.history.len()]
}
