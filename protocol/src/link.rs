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
/// Frames arrive in order, once, and whole. The coordinator may send one request ahead, while the answer to the one before
/// is still to come, so that two requests may wait on a link. Every call ends within its `patience`.
pub trait Link: Send {
    /// Hands over one frame. After [`LinkError::Full`] the same frame can be sent again: a part of it that was handed over stays so.
    fn send(&mut self, frame: &Frame, patience: Duration) -> Result<(), LinkError>;

    /// The next frame, or `None` if none came within `patience`.
    fn receive(&mut self, patience: Duration) -> Result<Option<Frame>, LinkError>;

    /// Measures the way to the other end and back, which answers whatever its solver does. `None` on one host, where both ends read the
    /// same clock.
    fn round_trip(&mut self) -> Option<RoundTrip> {
        None
    }

    /// Messages that were not heard since they are none of the other end's, in words: their number and what is wrong with them.
    fn refused(&self) -> Vec<String> {
        Vec::new()
    }
}

/// The way to the other end of a link and back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RoundTrip {
    /// Its time.
    pub time: Duration,
    /// How far our monotonic clock is ahead of the other end's (ns), known to half of that time.
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
        "a frame of {doubles} doubles does not fit the {capacity} that this link was sized for"
    )]
    TooLong { doubles: usize, capacity: usize },
    #[error("no sign of life from the other end for {seconds:.1} s")]
    Lost { seconds: f64 },
    #[error("{0}")]
    Transport(String),
}
