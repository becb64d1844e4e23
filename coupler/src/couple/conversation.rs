//! Requests and answers between the coordinator and its participants, all of them written down.

use std::collections::VecDeque;
use std::path::Path;

use protocol::{Frame, Header, Kind, PROTOCOL_VERSION, Window};

use super::minutes::{Closed, Minutes};
use crate::error::Error;
use crate::launch::peer::Patience;
use crate::launch::{Peer, Watch};
use crate::log::{Entry, Exchange, Recorder, recover};
use crate::replay::Departure;
use crate::scenario::{Deadlines, Label};

/// Name under which the coupler's own frames are logged.
pub const COUPLER: &str = "coupler";

/// All participants of a run, and everything that was said.
pub struct Conversation {
    /// The participants, in the order of the scenario.
    pub peers: Vec<Peer>,
    run_id: u64,
    labels: Vec<Label>,
    /// Signals that end the run.
    pub watch: Watch,
    deadlines: Deadlines,
    minutes: Minutes,
    /// Requests that were sent before their turn, one a peer at most.
    ahead: Vec<Option<Frame>>,
    /// Whether requests may be sent before their turn.
    pipelined: bool,
    keeping: Keeping,
}

/// What becomes of what passes.
enum Keeping {
    /// It is recorded and hashed.
    Record,
    /// It must be what the log already holds, until the block ends.
    Rehearse(VecDeque<Exchange>),
    /// Nothing: it repeats what the log already holds, in another order.
    Nothing,
}

impl Conversation {
    /// A conversation with `peers`; what passes is recorded under their labels, one a peer.
    pub fn new(
        peers: Vec<Peer>,
        run_id: u64,
        labels: Vec<Label>,
        deadlines: &Deadlines,
        watch: Watch,
        recorder: Option<Recorder>,
    ) -> Conversation {
        Conversation {
            ahead: vec![None; peers.len()],
            pipelined: false,
            peers,
            run_id,
            labels,
            watch,
            deadlines: deadlines.clone(),
            minutes: Minutes::new(recorder),
            keeping: Keeping::Record,
        }
    }

    /// Begins with the first `blocks` of the log of another run, which is gone on with. Returns the messages of the
    /// first of them, the handshake of a coupled run.
    pub fn carry_over(&mut self, log: &Path, blocks: u64) -> Result<Vec<Exchange>, Error> {
        let mut first = Vec::new();
        for entry in recover(log)? {
            match entry? {
                Entry::Exchange(message) => {
                    if self.minutes.blocks() == 0 {
                        first.push(message.clone());
                    }
                    self.minutes.add(message)?;
                }
                Entry::WindowEnd(window) => self.end_window(window)?,
            }
            if self.minutes.blocks() == blocks {
                return Ok(first);
            }
        }
        Err(Error::Refused(format!(
            "{}: {} of {blocks} blocks can be read",
            log.display(),
            self.minutes.blocks()
        )))
    }

    /// Until the block ends, what passes is compared with these messages instead of being kept.
    pub fn rehearse(&mut self, messages: Vec<Exchange>) {
        self.keeping = Keeping::Rehearse(messages.into());
    }

    /// Lets something pass that is not kept.
    pub fn aside<T>(&mut self, say: impl FnOnce(&mut Conversation) -> T) -> T {
        let before = std::mem::replace(&mut self.keeping, Keeping::Nothing);
        let said = say(self);
        self.keeping = before;
        said
    }

    /// Sees that the log is on the disk up to the last block; returns how many there are.
    pub fn sync_log(&mut self) -> Result<u64, Error> {
        self.minutes.sync()
    }

    /// From now on [`Conversation::foretell`] sends at once.
    pub fn pipeline(&mut self) {
        self.pipelined = true;
    }

    /// Sends a request that will be told next, while the peer still answers the one before: it then need not sleep in
    /// between, and what the coordinator does with that answer costs no time. Log and hash see the request when it is told.
    pub fn foretell(
        &mut self,
        peer: usize,
        kind: Kind,
        window: &Window,
        payload: Vec<f64>,
    ) -> Result<(), Error> {
        if !self.pipelined || self.ahead[peer].is_some() {
            return Ok(());
        }
        self.send_ahead(peer, Frame::new(self.header(peer, kind, window), payload))
    }

    fn send_ahead(&mut self, peer: usize, frame: Frame) -> Result<(), Error> {
        let patience = self.patience(false);
        self.peers[peer].send_ahead(&frame, patience, &self.watch)?;
        self.ahead[peer] = Some(frame);
        Ok(())
    }

    /// Sends a request of numbers.
    pub fn tell(
        &mut self,
        peer: usize,
        kind: Kind,
        window: &Window,
        payload: Vec<f64>,
    ) -> Result<(), Error> {
        self.say(peer, self.header(peer, kind, window), payload)
    }

    /// Sends a request that is a text.
    pub fn tell_text(&mut self, peer: usize, kind: Kind, text: &str) -> Result<(), Error> {
        let frame = Frame::with_text(self.header(peer, kind, &Window::default()), text);
        self.send(peer, &frame)
    }

    /// Sends a request of another run again, as it stood but for the run.
    pub fn repeat(&mut self, peer: usize, header: Header, payload: Vec<f64>) -> Result<(), Error> {
        self.say(peer, self.ours(header), payload)
    }

    /// Sends one that will be repeated next while the peer still answers the one before, which spares it the sleep.
    pub fn repeat_ahead(
        &mut self,
        peer: usize,
        header: Header,
        payload: Vec<f64>,
    ) -> Result<(), Error> {
        match self.ahead[peer] {
            Some(_) => Ok(()),
            None => self.send_ahead(peer, Frame::new(self.ours(header), payload)),
        }
    }

    /// The header of another run's frame as one of this run.
    fn ours(&self, header: Header) -> Header {
        Header {
            run_id: self.run_id,
            ..header
        }
    }

    /// Waits for the answer of this kind.
    pub fn hear(&mut self, peer: usize, kind: Kind) -> Result<Frame, Error> {
        let patience = self.patience(kind == Kind::Welcome);
        let frame = self.peers[peer].receive(kind, patience, &self.watch)?;
        if frame.header.run_id != self.run_id {
            return Err(self.peers[peer].protocol(format!(
                "answered for run {:016x}, this is run {:016x}",
                frame.header.run_id, self.run_id
            )));
        }
        self.keep(peer, true, &frame)?;
        Ok(frame)
    }

    /// A request of numbers and its answer's numbers.
    pub fn ask(
        &mut self,
        peer: usize,
        kind: Kind,
        answer: Kind,
        window: &Window,
        payload: Vec<f64>,
    ) -> Result<Vec<f64>, Error> {
        self.tell(peer, kind, window, payload)?;
        self.hear_of(peer, answer, window)
    }

    /// The same, for an answer that must hold exactly `length` finite numbers.
    pub fn ask_exactly(
        &mut self,
        peer: usize,
        (kind, answer): (Kind, Kind),
        window: &Window,
        payload: Vec<f64>,
        length: usize,
    ) -> Result<Vec<f64>, Error> {
        self.tell(peer, kind, window, payload)?;
        self.hear_exactly(peer, answer, window, length)
    }

    /// Waits for the answer of this kind about this window.
    fn hear_of(&mut self, peer: usize, kind: Kind, window: &Window) -> Result<Vec<f64>, Error> {
        let frame = self.hear(peer, kind)?;
        if (frame.header.window, frame.header.iteration) != (window.index, window.iteration) {
            return Err(self.peers[peer].protocol(format!(
                "answered for window {}, iteration {}",
                frame.header.window, frame.header.iteration
            )));
        }
        Ok(frame.payload)
    }

    /// The same, for an answer that must hold exactly `length` finite numbers.
    pub fn hear_exactly(
        &mut self,
        peer: usize,
        kind: Kind,
        window: &Window,
        length: usize,
    ) -> Result<Vec<f64>, Error> {
        let numbers = self.hear_of(peer, kind, window)?;
        if numbers.len() != length {
            return Err(self.peers[peer].protocol(format!(
                "answered {} numbers where {length} were due",
                numbers.len()
            )));
        }
        match numbers.iter().position(|value| !value.is_finite()) {
            None => Ok(numbers),
            Some(index) => Err(Error::NotFinite(format!(
                "participant `{}` answered {} at entry {index} of {kind:?} in window {}, iteration {}: it diverged; lower its step or the window",
                self.peers[peer].name(),
                numbers[index],
                window.index,
                window.iteration
            ))),
        }
    }

    /// Closes a window in the log and in the hash.
    pub fn end_window(&mut self, window: u64) -> Result<(), Error> {
        if let Keeping::Rehearse(rest) = &self.keeping {
            let missing = rest.front().map(|message| message.sender.clone());
            self.keeping = Keeping::Record;
            return match missing {
                None => Ok(()),
                Some(sender) => Err(Error::Refused(format!(
                    "the handshake ended before that of the log, which goes on with a message of `{sender}`: resume with the build that wrote it"
                ))),
            };
        }
        self.minutes.end_window(window)
    }

    /// Closes the log, also after an error.
    pub fn close(&mut self) -> Result<Closed, Error> {
        self.minutes.close()
    }

    fn header(&self, peer: usize, kind: Kind, window: &Window) -> Header {
        Header {
            interface: self.labels[peer].interface,
            kind: kind as u32,
            protocol: PROTOCOL_VERSION,
            run_id: self.run_id,
            iteration: window.iteration,
            window: window.index,
            step: window.step,
            substeps: window.substeps,
            t0_s: window.t0_s,
            t1_s: window.t1_s,
            ..Header::default()
        }
    }

    /// Makes a request's turn come: the frame that was sent ahead is taken as it is, so it is
    /// made, and its payload summed up, once.
    fn say(&mut self, peer: usize, header: Header, payload: Vec<f64>) -> Result<(), Error> {
        match self.ahead[peer].take_if(|sent| says(sent, &header, &payload)) {
            Some(sent) => {
                self.peers[peer].wait_for(&sent);
                self.keep(peer, false, &sent)
            }
            None => self.send(peer, &Frame::new(header, payload)),
        }
    }

    /// Sends a request that was not sent ahead.
    fn send(&mut self, peer: usize, frame: &Frame) -> Result<(), Error> {
        if let Some(sent) = self.ahead[peer].take() {
            self.discard(peer, &sent)?;
        }
        let patience = self.patience(frame.header.kind == Kind::Hello as u32);
        self.peers[peer].send(frame, patience, &self.watch)?;
        self.keep(peer, false, frame)
    }

    /// Waits for the answer to a request that something else came before: a checkpoint, fields, the end. Only windows
    /// are begun ahead, and a window that is not committed changes nothing.
    fn discard(&mut self, peer: usize, sent: &Frame) -> Result<(), Error> {
        self.peers[peer].wait_for(sent);
        let patience = self.patience(false);
        self.peers[peer].receive(Kind::Motion, patience, &self.watch)?;
        Ok(())
    }

    /// Writes down a frame from a peer, or to it.
    fn keep(&mut self, peer: usize, answer: bool, frame: &Frame) -> Result<(), Error> {
        let exchanged = Kind::from_number(frame.header.kind).is_some_and(Kind::is_exchange);
        if !exchanged || matches!(self.keeping, Keeping::Nothing) {
            return Ok(());
        }
        let name = self.peers[peer].name().to_string();
        let (sender, receiver) = match answer {
            true => (name, COUPLER.to_string()),
            false => (COUPLER.to_string(), name),
        };
        match &mut self.keeping {
            Keeping::Nothing => Ok(()),
            Keeping::Rehearse(expected) => rehearsed(expected.pop_front(), &sender, frame),
            Keeping::Record => self.minutes.add(Exchange {
                interface: self.labels[peer].name.clone(),
                sender,
                receiver,
                frame: frame.clone(),
            }),
        }
    }

    /// Set-ups take longer than answers.
    fn patience(&self, greeting: bool) -> Patience {
        match greeting {
            true => Patience {
                seconds: self.deadlines.setup_s,
                key: "setup_s",
            },
            false => Patience {
                seconds: self.deadlines.answer_s,
                key: "answer_s",
            },
        }
    }
}

/// Whether a frame says this to the last bit. Equal payloads have equal counts and checksums, which the header of a
/// frame still to be made lacks.
fn says(frame: &Frame, header: &Header, payload: &[f64]) -> bool {
    let header = Header {
        count: frame.header.count,
        checksum: frame.header.checksum,
        ..*header
    };
    let bits = |value: &f64| value.to_bits();
    frame.header == header && frame.payload.iter().map(bits).eq(payload.iter().map(bits))
}

/// Compares a message of a repeated handshake with the logged one.
fn rehearsed(expected: Option<Exchange>, sender: &str, frame: &Frame) -> Result<(), Error> {
    let differs = match &expected {
        Some(logged) if logged.sender == sender => {
            Departure::between(sender, &logged.frame, frame).map(|departure| departure.to_string())
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
