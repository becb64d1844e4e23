//! The refusal of a checkpoint of another body.

use protocol::{Cause, NodeError};

/// A checkpoint that cannot be taken up, and why.
pub(super) fn foreign<T>(why: &str) -> Result<T, NodeError> {
    let text = format!(
        "the checkpoint is not of this body: {why}; resume with the build and the scenario that wrote it"
    );
    Err(NodeError::of(Cause::CheckpointUnusable, text))
}
