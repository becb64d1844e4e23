//! A communicator whose exchange must be the one that a log already holds: the handshake of a resumed run.

use std::collections::VecDeque;

use protocol::{Frame, Header, Kind};

use super::communicator::{Communicator, Peers};
use super::recorded::exchange;
use crate::error::Error;
use crate::log::{Exchange, Mismatch};

/// Participants whose exchange is compared with a logged one, message by message.
pub struct Rehearsed<'a> {
    peers: &'a mut Peers,
    expected: VecDeque<Exchange>,
}

impl Rehearsed<'_> {
    /// Begins with the first of the logged messages.
    pub fn new(peers: &mut Peers, logged: Vec<Exchange>) -> Rehearsed<'_> {
        Rehearsed {
            peers,
            expected: logged.into(),
        }
    }

    /// Refuses an exchange that ended before the logged one.
    pub fn finish(self) -> Result<(), Error> {
        match self.expected.front() {
            None => Ok(()),
            Some(Exchange { sender, .. }) => Err(Error::Refused(format!(
                "the handshake ended before that of the log, which goes on with a message of `{sender}`: resume with the build that wrote it"
            ))),
        }
    }

    fn compare(&mut self, peer: usize, answer: bool, frame: Frame) -> Result<(), Error> {
        let Some(Exchange { sender, frame, .. }) = exchange(self.peers, peer, answer, frame) else {
            return Ok(());
        };
        let differs = match self.expected.pop_front() {
            Some(logged) if logged.sender == sender => {
                Mismatch::between(&sender, &logged.frame, &frame).map(|found| found.to_string())
            }
            Some(logged) => Some(format!("`{sender}` spoke where `{}` did", logged.sender)),
            None => Some(format!("`{sender}` said more")),
        };
        match differs {
            None => Ok(()),
            Some(why) => Err(Error::Refused(format!(
                "the handshake is not that of the log: {why}; resume with the build that wrote it"
            ))),
        }
    }
}

impl Communicator for Rehearsed<'_> {
    fn peers(&self) -> &Peers {
        self.peers
    }

    fn send(&mut self, peer: usize, header: Header, payload: Vec<f64>) -> Result<(), Error> {
        let frame = self.peers.transmit(peer, header, payload)?;
        self.compare(peer, false, frame)
    }

    fn send_early(&mut self, peer: usize, header: Header, payload: Vec<f64>) -> Result<(), Error> {
        self.peers.send_early(peer, header, payload)
    }

    fn receive(&mut self, peer: usize, kind: Kind) -> Result<Frame, Error> {
        let frame = self.peers.receive(peer, kind)?;
        self.compare(peer, true, frame.clone())?;
        Ok(frame)
    }
}
