//! The checkpoint of the grains: how it is packed, and refused where it is another one's.

use protocol::checkpoint::{pack, unpack};
use protocol::{Cause, NodeError};

use super::dem::{Dem, Progress};
use crate::measure::flow::Flow;
use crate::step::state::GrainState;

impl Dem {
    /// Packs everything that windows have changed, with the hash of the state: fields that are read into others than they
    /// came from get another one.
    pub(super) fn pack_checkpoint(&self) -> Result<Vec<u8>, NodeError> {
        pack(&(&self.progress, self.progress.hash()))
    }

    pub(super) fn restore_checkpoint(&mut self, bytes: &[u8]) -> Result<(), NodeError> {
        let (progress, hash): (Progress, String) = unpack(bytes)?;
        let counts = |state: &GrainState| {
            [
                state.centres.len(),
                state.velocities.len(),
                state.glued_velocity.len(),
                state.clusters.len(),
            ]
        };
        let refuse = |why: &str| {
            Err(NodeError::of(
                Cause::CheckpointUnusable,
                format!(
                    "the checkpoint is not of these grains: {why}; resume with the build and the scenario that wrote it"
                ),
            ))
        };
        if counts(&progress.state) != counts(&self.progress.state) {
            return refuse("their number is another");
        }
        let tracked = |progress: &Progress| progress.flow.as_ref().map(Flow::count);
        if tracked(&progress) != tracked(&self.progress) {
            return refuse("the flows of other grains, or of none, are in it");
        }
        if progress.hash() != hash {
            return refuse("their numbers have another hash");
        }
        self.progress = progress;
        self.pending = None;
        Ok(())
    }
}
