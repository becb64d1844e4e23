//! The ways a frame travels.

use std::time::Duration;

use thiserror::Error;

use crate::frame::Frame;

pub mod channel;
pub mod shm;

/// One end of a two-way connection between the coordinator and one participant.
///
/// Frames arrive in order, once, and whole. Every call ends within its `patience`.
pub trait Link: Send {
    /// Hands over one frame.
    fn send(&mut self, frame: &Frame, patience: Duration) -> Result<(), LinkError>;

    /// The next frame, or `None` if none came within `patience`.
    fn receive(&mut self, patience: Duration) -> Result<Option<Frame>, LinkError>;
}

/// Why a link cannot carry frames.
#[derive(Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum LinkError {
    #[error("the other end closed the connection")]
    Closed,
    #[error("the other end took no frame for {seconds:.1} s")]
    Full { seconds: f64 },
    #[error(
        "a frame of {doubles} doubles does not fit the {capacity} that this link was sized for"
    )]
    TooLong { doubles: usize, capacity: usize },
    #[error("shared memory: {0}")]
    Transport(String),
}
