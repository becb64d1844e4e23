//! Frames between threads of one process.

use std::time::Duration;

use crossbeam_channel::{Receiver, RecvTimeoutError, SendTimeoutError, Sender, bounded};

use crate::frame::Frame;
use crate::link::{Link, LinkError};

/// One end of an in-process connection.
pub struct ChannelLink {
    sender: Sender<Frame>,
    receiver: Receiver<Frame>,
}

/// Both ends of an in-process connection.
pub fn pair() -> (ChannelLink, ChannelLink) {
    let (to_left, from_right) = bounded(1);
    let (to_right, from_left) = bounded(1);
    let left = ChannelLink {
        sender: to_right,
        receiver: from_right,
    };
    let right = ChannelLink {
        sender: to_left,
        receiver: from_left,
    };
    (left, right)
}

impl Link for ChannelLink {
    fn send(&mut self, frame: &Frame, patience: Duration) -> Result<(), LinkError> {
        self.sender
            .send_timeout(frame.clone(), patience)
            .map_err(|error| match error {
                SendTimeoutError::Timeout(_) => LinkError::Full {
                    seconds: patience.as_secs_f64(),
                },
                SendTimeoutError::Disconnected(_) => LinkError::Closed,
            })
    }

    fn receive(&mut self, patience: Duration) -> Result<Option<Frame>, LinkError> {
        match self.receiver.recv_timeout(patience) {
            Ok(frame) => Ok(Some(frame)),
            Err(RecvTimeoutError::Timeout) => Ok(None),
            Err(RecvTimeoutError::Disconnected) => Err(LinkError::Closed),
        }
    }
}
