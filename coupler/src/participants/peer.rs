//! One participant, seen from the coordinator: its connection and its life.

use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use protocol::{Frame, Header, Kind, Link, LinkError, PROTOCOL_VERSION};
use serde::de::DeserializeOwned;

use super::process::{self, Process};
use super::watch::Watch;
use crate::error::{Error, Refusal};

/// Time after which a wait looks up from the connection to see whether the peer still lives.
const SLICE: Duration = Duration::from_millis(50);

/// The life at the other end of a connection.
pub enum Life {
    /// In a process of its own.
    Process(Process),
    /// In a thread of the coordinator.
    Thread(Option<JoinHandle<Result<(), String>>>),
    /// In a log.
    Tape,
}

/// A wait: its deadline with the key that sets it, and the signals that end it.
pub struct Wait<'a> {
    /// Deadline (s).
    pub seconds: f64,
    /// Key below `run.deadlines`.
    pub key: &'static str,
    /// Signals.
    pub watch: &'a Watch,
}

/// One participant.
pub struct Peer {
    /// Name in the scenario.
    pub name: String,
    link: Box<dyn Link>,
    /// Ends after its connection was closed.
    life: Life,
    /// The last request, for messages.
    asked: String,
    /// A request that was sent before its turn.
    early: Option<Frame>,
}

impl Peer {
    /// Joins a connection with the life at its other end.
    pub fn new(name: &str, link: Box<dyn Link>, life: Life) -> Peer {
        Peer {
            name: name.to_string(),
            link,
            life,
            asked: "during its launch".into(),
            early: None,
        }
    }

    /// Sends a request whose turn has come and returns its frame. One that was sent early is taken as it is, so that it is made,
    /// and its payload summed up, once.
    pub fn send(&mut self, header: Header, payload: Vec<f64>, wait: &Wait) -> Result<Frame, Error> {
        if let Some(sent) = self.early.take() {
            if says(&sent, &header, &payload) {
                self.asked = asked(&sent);
                return Ok(sent);
            }
            self.discard(&sent, wait)?;
        }
        let frame = Frame::new(header, payload);
        self.asked = asked(&frame);
        self.transmit(&frame, wait)?;
        Ok(frame)
    }

    /// Sends a request that will be the next while the answer to the one before is still to come: the peer then need not sleep in
    /// between. One at most is under way; a tape is told nothing before its turn.
    pub fn send_early(
        &mut self,
        header: Header,
        payload: Vec<f64>,
        wait: &Wait,
    ) -> Result<(), Error> {
        if self.early.is_none() && !matches!(self.life, Life::Tape) {
            let frame = Frame::new(header, payload);
            self.transmit(&frame, wait)?;
            self.early = Some(frame);
        }
        Ok(())
    }

    /// Waits for the answer to a request that something else came before: a checkpoint, fields, the end. Only windows
    /// are begun early, and a window that is not accepted changes nothing.
    fn discard(&mut self, sent: &Frame, wait: &Wait) -> Result<(), Error> {
        self.asked = asked(sent);
        self.receive(Kind::Motion, wait).map(|_| ())
    }

    fn transmit(&mut self, frame: &Frame, wait: &Wait) -> Result<(), Error> {
        let start = Instant::now();
        loop {
            wait.watch.check()?;
            match self.link.send(frame, SLICE) {
                Ok(()) => return Ok(()),
                Err(LinkError::Full { .. }) => self.still_alive(start, wait)?,
                Err(error) => return Err(self.broken(error)),
            }
        }
    }

    /// Waits for the answer to the last request.
    pub fn receive(&mut self, expected: Kind, wait: &Wait) -> Result<Frame, Error> {
        let start = Instant::now();
        loop {
            wait.watch.check()?;
            match self.link.receive(SLICE) {
                Ok(Some(frame)) => return self.accept(frame, expected),
                Ok(None) => self.still_alive(start, wait)?,
                Err(error) => return Err(self.broken(error)),
            }
        }
    }

    fn accept(&mut self, frame: Frame, expected: Kind) -> Result<Frame, Error> {
        if frame.header.protocol != PROTOCOL_VERSION {
            return Err(Error::from(Refusal::Version {
                participant: self.name.clone(),
                theirs: frame.header.protocol,
                ours: PROTOCOL_VERSION,
            }));
        }
        let kind = frame.verify().and_then(|()| frame.kind());
        match kind.map_err(|error| self.protocol_error(error.to_string()))? {
            Kind::Fault => Err(self.fault(&frame)),
            kind if kind == expected => Ok(frame),
            kind => {
                Err(self.protocol_error(format!("answered {kind:?} where {expected:?} was due")))
            }
        }
    }

    fn fault(&self, frame: &Frame) -> Error {
        match read_json(frame) {
            Ok(error) => Error::of_participant(&self.name, &self.asked, error),
            Err(_) => self.protocol_error("reported a fault that cannot be read".into()),
        }
    }

    fn lost(&self, why: String) -> Error {
        Error::PeerLost {
            peer: self.name.clone(),
            phase: self.asked.clone(),
            why,
        }
    }

    /// The error of an answer that does not belong here.
    pub fn protocol_error(&self, why: String) -> Error {
        Error::Protocol {
            peer: self.name.clone(),
            phase: self.asked.clone(),
            why,
        }
    }

    /// Tells a peer that died from one that is silent, and a silent one from one that is stopped.
    fn still_alive(&mut self, start: Instant, wait: &Wait) -> Result<(), Error> {
        let ended = match &mut self.life {
            Life::Process(child) => match child.try_wait() {
                Ok(Some(status)) => Some(format!("its process ended with {status}")),
                _ => None,
            },
            Life::Thread(Some(thread)) if thread.is_finished() => Some("its thread ended".into()),
            _ => None,
        };
        if let Some(why) = ended {
            return Err(self.lost(why));
        }
        if start.elapsed().as_secs_f64() < wait.seconds {
            return Ok(());
        }
        Err(Error::Deadline {
            peer: self.name.clone(),
            phase: self.asked.clone(),
            seconds: wait.seconds,
            state: self.life.state(),
            key: wait.key,
        })
    }

    fn broken(&self, error: LinkError) -> Error {
        match error {
            LinkError::Closed => self.lost("it closed the connection".into()),
            other => self.protocol_error(other.to_string()),
        }
    }
}

impl Life {
    /// Describes what can be seen of a peer that does not answer.
    fn state(&self) -> String {
        match self {
            Life::Process(child) if process::is_stopped(child.id()) => {
                let pid = child.id();
                format!("process {pid} is alive but stopped (SIGSTOP or a debugger)")
            }
            Life::Process(child) => format!("process {} is alive but silent", child.id()),
            Life::Thread(_) => "its thread is alive but silent".into(),
            Life::Tape => "the log holds no answer".into(),
        }
    }
}

impl Drop for Life {
    /// Sees that nothing of the participant is left running.
    fn drop(&mut self) {
        match self {
            Life::Thread(thread) => drop(thread.take().map(JoinHandle::join)),
            // A process ends itself when dropped.
            Life::Process(_) | Life::Tape => {}
        }
    }
}

/// Reads the text of a frame as JSON.
pub fn read_json<T: DeserializeOwned>(frame: &Frame) -> Result<T, String> {
    let text = frame.text().map_err(|error| error.to_string())?;
    serde_json::from_str(&text).map_err(|error| error.to_string())
}

/// Tells if a frame says this to the last bit. Equal payloads have equal counts and checksums, which the header of a
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

/// The request and its time, as messages say it.
fn asked(frame: &Frame) -> String {
    let header = &frame.header;
    match Kind::from_number(header.kind) {
        Some(
            kind @ (Kind::Advance
            | Kind::PrescribeVelocity
            | Kind::Solve
            | Kind::Commit
            | Kind::AdvanceAlone),
        ) => format!(
            "in window {}, iteration {} ({kind:?}, t = {:.6e} s)",
            header.window, header.iteration, header.t0_s
        ),
        Some(Kind::Hello) => "during its set-up".into(),
        Some(kind) => format!("at the handshake ({kind:?})"),
        None => "outside the protocol".into(),
    }
}
