//! A communicator whose exchange is written down.

use protocol::{Frame, Kind};

use super::communicator::{Communicator, Peers};
use super::journal::Journal;
use crate::error::Error;
use crate::log::{COUPLER, Exchange};

/// Participants whose exchange is recorded and hashed. A request that is sent early is recorded when its turn has come.
pub struct Recorded {
    /// The participants: requests that go to them directly are not recorded.
    pub peers: Peers,
    /// Log and hash.
    pub journal: Journal,
}

/// A message between the coupler and a participant, as the log has it; `None` for a frame that carries no interface data.
pub fn exchange(peers: &Peers, peer: usize, answer: bool, frame: &Frame) -> Option<Exchange> {
    if !Kind::from_number(frame.header.kind).is_some_and(Kind::is_exchange) {
        return None;
    }
    let (name, coupler) = (peers.name(peer).to_string(), COUPLER.to_string());
    let (sender, receiver) = if answer {
        (name, coupler)
    } else {
        (coupler, name)
    };
    Some(Exchange {
        interface: peers.labels[peer].name.clone(),
        sender,
        receiver,
        frame: frame.clone(),
    })
}

impl Communicator for Recorded {
    fn peers(&self) -> &Peers {
        &self.peers
    }

    fn peers_mut(&mut self) -> &mut Peers {
        &mut self.peers
    }

    fn witness(&mut self, peer: usize, answer: bool, frame: &Frame) -> Result<(), Error> {
        match exchange(&self.peers, peer, answer, frame) {
            Some(exchange) => self.journal.add(exchange),
            None => Ok(()),
        }
    }

    fn end_window(&mut self, window: u64) -> Result<(), Error> {
        self.journal.end_window(window)
    }
}
