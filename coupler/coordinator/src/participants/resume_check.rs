//! The handshake of a resumed run, which must be the one that the log of the first already holds.

use std::borrow::Cow;

use protocol::Frame;

use super::communicator::{Communicator, Peers, SentBy};
use super::recorded::exchange;
use crate::error::{Refusal, Result};
use exchange_log::{Exchange, Mismatch};

/// Participants whose exchange is compared with a logged one, message by message.
pub struct ResumeCheck<'a> {
    peers: &'a mut Peers,
    logged: std::vec::IntoIter<Exchange>,
}

impl ResumeCheck<'_> {
    /// Begins with the first of the logged messages.
    pub fn new(peers: &mut Peers, logged: Vec<Exchange>) -> ResumeCheck<'_> {
        let logged = logged.into_iter();
        ResumeCheck { peers, logged }
    }

    /// Refuses an exchange that ended before the logged one.
    pub fn finish(mut self) -> Result<()> {
        match self.logged.next() {
            None => Ok(()),
            Some(Exchange { sender, .. }) => Err(Refusal::checkpoint(format!(
                "the handshake ended before that of the log, which goes on with a message of `{sender}`: resume with the build that wrote it"
            ))
            .into()),
        }
    }
}

impl Communicator for ResumeCheck<'_> {
    fn peers(&self) -> &Peers {
        self.peers
    }

    fn peers_mut(&mut self) -> &mut Peers {
        self.peers
    }

    fn passed(&mut self, peer: usize, by: SentBy, frame: Cow<Frame>) -> Result<()> {
        let Some(Exchange { sender, frame, .. }) = exchange(self.peers, peer, by, frame) else {
            return Ok(());
        };
        let differs = match self.logged.next() {
            Some(logged) if logged.sender == sender => {
                Mismatch::between(&sender, &logged.frame, &frame).map(|found| found.to_string())
            }
            Some(logged) => Some(format!("`{sender}` spoke where `{}` did", logged.sender)),
            None => Some(format!("`{sender}` said more")),
        };
        differs.map_or(Ok(()), |why| {
            Err(Refusal::checkpoint(format!(
                "the handshake is not that of the log: {why}; resume with the build that wrote it"
            ))
            .into())
        })
    }
}
