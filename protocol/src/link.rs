//! The ways a frame travels: trait [`Link`], in-process channels, shared memory.

use std::time::Duration;

use thiserror::Error;

use crate::frame::Frame;

pub mod channel;
mod core;
pub mod shm;
mod wait_estimate;
mod waiting;

pub use self::core::{Core, Yield};

/// One end of a two-way connection between the coordinator and one participant.
///
/// Frames arrive in order, once, and whole. The coordinator may send one request ahead, before the answer to the previous one
/// arrives, so two requests may wait on a link. Every call ends within its `patience`.
pub trait Link: Send {
    /// Sends one frame. After [`LinkError::Full`] the same frame can be sent again: the part that was sent already is not repeated.
    fn send(&mut self, frame: &Frame, patience: Duration) -> Result<(), LinkError>;

    /// The next frame, or `None` if none came within `patience`.
    fn receive(&mut self, patience: Duration) -> Result<Option<Frame>, LinkError>;

    /// Measures the round trip to the other end, which answers even while its solver computes. `None` on one host, where both ends
    /// read the same clock.
    fn round_trip(&mut self) -> Option<RoundTrip> {
        None
    }

    /// Messages dropped because the other end did not send them, in words: their number and what is wrong with them.
    fn refused(&self) -> Vec<String> {
        Vec::new()
    }
}

/// A round trip to the other end of a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RoundTrip {
    /// Its time.
    pub time: Duration,
    /// Lead of our monotonic clock over the other end's (ns), known to half of `time`.
    pub offset_ns: i64,
}

/// The reason why a link cannot carry frames.
#[derive(Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum LinkError {
    #[error("the other end closed the connection")]
    Closed,
    #[error("the other end took no frame for {seconds:.1} s")]
    Full { seconds: f64 },
    #[error(
        "a frame of {doubles} doubles exceeds the capacity of this link, which is {capacity} doubles"
    )]
    TooLong { doubles: usize, capacity: usize },
    #[error("no sign of life from the other end for {seconds:.1} s")]
    Lost { seconds: f64 },
    #[error("{0}")]
    Transport(String),
}
