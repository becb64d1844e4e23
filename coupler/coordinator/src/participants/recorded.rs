//! A communicator that records its exchange.

use std::borrow::Cow;

use mcap::McapError;
use protocol::serve::Farewell;
use protocol::{Frame, Kind};

use super::communicator::{Communicator, Peers, SentBy};
use super::journal::Journal;
use exchange_log::timing::{OwnTimes, TimingLog};
use exchange_log::{COUPLER, Exchange, Mismatch};
use scenario::error::{Refusal, Result};

/// Participants whose exchange is recorded and hashed. A request that was sent early is recorded when its turn comes.
/// The handshake of a resumed run is in the log already, and is compared with it message by message.
pub struct Recorded {
    /// The participants; direct requests to them are not recorded.
    pub peers: Peers,
    /// Log and hash.
    pub journal: Journal,
    /// Logged messages that the handshake of a resumed run must still repeat.
    logged: Option<std::vec::IntoIter<Exchange>>,
    /// Log of the request times, if they are recorded.
    timing: Option<TimingLog>,
    /// Reason why times are no longer recorded.
    pub untimed: Option<String>,
}

impl Recorded {
    /// Participants whose times are recorded as well if there is a log for them.
    pub fn new(mut peers: Peers, journal: Journal, timing: Option<TimingLog>) -> Recorded {
        peers.keep_times(timing.is_some());
        Recorded {
            peers,
            journal,
            logged: None,
            timing,
            untimed: None,
        }
    }

    /// From now on all messages must equal the logged ones, until the handshake ends.
    pub fn repeat_handshake(&mut self, logged: Vec<Exchange>) {
        self.logged = Some(logged.into_iter());
    }

    /// Closes the handshake; refuses a handshake shorter than the logged one.
    pub fn end_handshake(&mut self) -> Result<()> {
        let Some(mut logged) = self.logged.take() else {
            return self.end_window(0);
        };
        match logged.next() {
            None => Ok(()),
            Some(Exchange { sender, .. }) => Err(Refusal::checkpoint(format!(
                "the handshake ended before the logged one, which continues with a message of `{sender}`: resume a run with its own exchange.mcap, and with the build that wrote it"
            ))
            .into()),
        }
    }

    /// Records the participants' own times.
    pub fn record_own_times(&mut self, farewells: &[Farewell]) {
        self.note_times();
        for (participant, farewell) in farewells.iter().enumerate() {
            let own = OwnTimes::of(farewell);
            self.write_times(|timing, _| timing.tell(participant, &own));
        }
    }

    /// Completes the file of times.
    pub fn close_times(&mut self) {
        self.note_times();
        self.write_times(|timing, _| timing.finish());
    }

    fn note_times(&mut self) {
        self.write_times(|timing, peers| {
            (0..peers.count()).try_for_each(|peer| {
                let times = peers.peer(peer).times.as_mut();
                times.map_or(Ok(()), |times| timing.add(peer, times))
            })
        });
    }

    /// Times are a convenience: a run continues without them, with a warning.
    fn write_times(
        &mut self,
        write: impl FnOnce(&mut TimingLog, &mut Peers) -> Result<(), McapError>,
    ) {
        let Some(timing) = &mut self.timing else {
            return;
        };
        if let Err(error) = write(timing, &mut self.peers) {
            self.untimed = Some(error.to_string());
            self.timing = None;
            self.peers.keep_times(false);
        }
    }
}

/// Refuses a message in the handshake of a resumed run that differs from the log.
fn compare(logged: Option<Exchange>, Exchange { sender, frame, .. }: Exchange) -> Result<()> {
    let differs = match logged {
        Some(logged) if logged.sender == sender => {
            Mismatch::between(&sender, &logged.frame, &frame).map(|found| found.to_string())
        }
        Some(logged) => Some(format!(
            "`{sender}` sent a message in place of `{}`",
            logged.sender
        )),
        None => Some(format!("`{sender}` sent an additional message")),
    };
    differs.map_or(Ok(()), |why| {
        Err(Refusal::checkpoint(format!(
            "the handshake differs from the logged one: {why}; resume a run with its own exchange.mcap, and with the build that wrote it"
        ))
        .into())
    })
}

/// A message between the coupler and a participant, for the log; `None` for a frame without interface data.
fn exchange(peers: &Peers, peer: usize, by: SentBy, frame: Cow<Frame>) -> Option<Exchange> {
    if !Kind::from_number(frame.header.kind).is_some_and(Kind::is_exchange) {
        return None;
    }
    let (name, coupler) = (peers.name(peer).to_string(), COUPLER.to_string());
    let (sender, receiver) = match by {
        SentBy::Coordinator => (coupler, name),
        SentBy::Participant => (name, coupler),
    };
    Some(Exchange {
        interface: peers.labels[peer].name.clone(),
        sender,
        receiver,
        frame: frame.into_owned(),
    })
}

impl Communicator for Recorded {
    fn peers(&self) -> &Peers {
        &self.peers
    }

    fn peers_mut(&mut self) -> &mut Peers {
        &mut self.peers
    }

    fn passed(&mut self, peer: usize, by: SentBy, frame: Cow<Frame>) -> Result<()> {
        let Some(exchange) = exchange(&self.peers, peer, by, frame) else {
            return Ok(());
        };
        match &mut self.logged {
            None => self.journal.add(exchange),
            Some(logged) => compare(logged.next(), exchange),
        }
    }

    fn while_solving(&mut self) -> Result<()> {
        self.journal.write_down()
    }

    fn end_window(&mut self, window: u64) -> Result<()> {
        self.note_times();
        self.journal.end_window(window)
    }
}
