//! The bytes of a checkpoint: what [`crate::Node::checkpoint`] gives and [`crate::Node::restore`] takes.

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::cause::Cause;
use crate::node::NodeError;

/// A state as bytes (postcard); doubles keep every bit.
pub fn pack<T: Serialize>(state: &T) -> Result<Vec<u8>, NodeError> {
    postcard::to_allocvec(state)
        .map_err(|error| NodeError::protocol(format!("the state cannot be packed: {error}")))
}

/// The reverse of [`pack`]. Bytes that are left over belong to another state, and are an error.
pub fn unpack<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, NodeError> {
    let refuse = |why: String| {
        let message = format!(
            "the checkpoint is not of this build of the solver: {why}; resume with the build that wrote it"
        );
        NodeError::of(Cause::CheckpointUnusable, message)
    };
    match postcard::take_from_bytes(bytes) {
        Ok((state, [])) => Ok(state),
        Ok((_, rest)) => Err(refuse(format!("{} bytes are left over", rest.len()))),
        Err(error) => Err(refuse(error.to_string())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_comes_back_bit_for_bit_and_another_one_is_refused() {
        let state = (vec![-0.0, f64::MIN_POSITIVE / 4.0, 0.1], Some(7u64));
        let bytes = pack(&state).expect("plain numbers");
        let back: (Vec<f64>, Option<u64>) = unpack(&bytes).expect("it was just packed");
        assert_eq!(back.0[0].to_bits(), (-0.0f64).to_bits());
        assert_eq!(back, state);
        assert!(unpack::<Vec<f64>>(&bytes).is_err());
        assert!(unpack::<(Vec<f64>, Option<u64>)>(&bytes[..bytes.len() - 1]).is_err());
    }
}
