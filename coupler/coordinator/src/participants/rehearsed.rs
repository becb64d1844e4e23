//! A communicator whose exchange must be the one that a log already holds: the handshake of a resumed run.

use std::collections::VecDeque;

use protocol::Frame;

use super::communicator::{Communicator, Peers};
use super::recorded::exchange;
use crate::error::{Error, Refusal};
use exchange_log::{Exchange, Mismatch};

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
        match self.expected.into_iter().next() {
            None => Ok(()),
            Some(Exchange { sender, .. }) => Err(Refusal::ShortHandshake { sender }.into()),
        }
    }
}

impl Communicator for Rehearsed<'_> {
    fn peers(&self) -> &Peers {
        self.peers
    }

    fn peers_mut(&mut self) -> &mut Peers {
        self.peers
    }

    fn witness(&mut self, peer: usize, answer: bool, frame: &Frame) -> Result<(), Error> {
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
            Some(why) => Err(Refusal::OtherHandshake { why }.into()),
        }
    }
}
