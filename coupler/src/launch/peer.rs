//! One participant, seen from the coordinator: its connection and its life.

use std::process::Child;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use protocol::{FaultCode, Frame, Kind, Link, LinkError, NodeError, PROTOCOL_VERSION};

use super::process;
use crate::error::Error;

/// How often a wait looks up from the connection to see whether the peer still lives.
const SLICE: Duration = Duration::from_millis(50);

/// Signals that reached the coordinator; 0 while there was none.
#[derive(Clone, Debug, Default)]
pub struct Watch {
    signal: Arc<AtomicUsize>,
    /// When a wait first saw it.
    seen: Arc<OnceLock<Instant>>,
    /// How long a window may still take then.
    grace: Duration,
}

/// Windows take milliseconds. A participant that needs longer than this is waited for in vain.
const WINDOW_GRACE: Duration = Duration::from_secs(2);

impl Watch {
    /// The flag that a signal handler writes the signal's number to.
    pub fn flag(&self) -> Arc<AtomicUsize> {
        Arc::clone(&self.signal)
    }

    /// From now on a wait goes on for a while after a signal, so that the window can end: whoever asks
    /// [`Watch::interrupted`] between windows ends the run with a checkpoint.
    pub fn let_windows_end(&mut self) {
        self.grace = WINDOW_GRACE;
    }

    /// The error of a run that got a signal.
    pub fn interrupted(&self) -> Option<Error> {
        match self.signal.load(Ordering::Relaxed) {
            0 => None,
            signal => Some(Error::Interrupted {
                signal: signal as i32,
            }),
        }
    }

    fn check(&self) -> Result<(), Error> {
        match self.interrupted() {
            Some(error) if self.seen.get_or_init(Instant::now).elapsed() >= self.grace => {
                Err(error)
            }
            _ => Ok(()),
        }
    }
}

/// Where a participant lives.
pub enum Life {
    /// In a process of its own.
    Process(Child),
    /// In a thread of the coordinator.
    Thread(JoinHandle<Result<(), String>>),
    /// In a log.
    Tape,
}

/// A deadline with the key that sets it.
#[derive(Clone, Copy, Debug)]
pub struct Patience {
    /// How long (s).
    pub seconds: f64,
    /// Key below `run.deadlines`.
    pub key: &'static str,
}

/// One participant.
pub struct Peer {
    name: String,
    link: Option<Box<dyn Link>>,
    life: Option<Life>,
    /// What was asked last, for messages.
    asked: String,
}

impl Peer {
    /// Joins a connection with the life at its other end.
    pub fn new(name: &str, link: Box<dyn Link>, life: Life) -> Peer {
        Peer {
            name: name.to_string(),
            link: Some(link),
            life: Some(life),
            asked: "during its launch".into(),
        }
    }

    /// Name in the scenario.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its process, if it has one of its own.
    pub fn pid(&self) -> Option<u32> {
        match &self.life {
            Some(Life::Process(child)) => Some(child.id()),
            _ => None,
        }
    }

    /// Sends a request, the next whose answer is waited for.
    pub fn send(&mut self, frame: &Frame, patience: Patience, watch: &Watch) -> Result<(), Error> {
        self.wait_for(frame);
        self.send_ahead(frame, patience, watch)
    }

    /// From now on messages speak of the answer to this request.
    pub fn wait_for(&mut self, request: &Frame) {
        self.asked = asked(request);
    }

    /// Sends a request while the answer to the one before is still to come.
    pub fn send_ahead(
        &mut self,
        frame: &Frame,
        patience: Patience,
        watch: &Watch,
    ) -> Result<(), Error> {
        let start = Instant::now();
        loop {
            watch.check()?;
            match self.link_mut()?.send(frame, SLICE) {
                Ok(()) => return Ok(()),
                Err(LinkError::Full { .. }) => self.still_alive(start, patience)?,
                Err(error) => return Err(self.broken(error)),
            }
        }
    }

    /// Waits for the answer to the last request.
    pub fn receive(
        &mut self,
        expected: Kind,
        patience: Patience,
        watch: &Watch,
    ) -> Result<Frame, Error> {
        let start = Instant::now();
        loop {
            watch.check()?;
            match self.link_mut()?.receive(SLICE) {
                Ok(Some(frame)) => return self.accept(frame, expected),
                Ok(None) => self.still_alive(start, patience)?,
                Err(error) => return Err(self.broken(error)),
            }
        }
    }

    fn accept(&mut self, frame: Frame, expected: Kind) -> Result<Frame, Error> {
        if frame.header.protocol != PROTOCOL_VERSION {
            return Err(Error::Refused(format!(
                "participant `{}` speaks protocol version {}, the coordinator speaks {PROTOCOL_VERSION}: build both from the same release",
                self.name, frame.header.protocol
            )));
        }
        frame
            .verify()
            .map_err(|error| self.protocol(error.to_string()))?;
        match frame
            .kind()
            .map_err(|error| self.protocol(error.to_string()))?
        {
            Kind::Fault => Err(self.fault(&frame)),
            kind if kind == expected => Ok(frame),
            kind => Err(self.protocol(format!("answered {kind:?} where {expected:?} was due"))),
        }
    }

    fn fault(&self, frame: &Frame) -> Error {
        let said = frame
            .text()
            .ok()
            .and_then(|text| serde_json::from_str::<NodeError>(&text).ok());
        let Some(error) = said else {
            return self.protocol("reported a fault that cannot be read".into());
        };
        let message = format!(
            "participant `{}` {}: {}",
            self.name, self.asked, error.message
        );
        match error.code {
            FaultCode::Configuration => Error::Refused(message),
            FaultCode::Diverged => Error::Diverged(message),
            FaultCode::Protocol => self.protocol(error.message),
            FaultCode::Output => Error::Output {
                what: format!("participant `{}` {}", self.name, self.asked),
                source: std::io::Error::other(error.message),
            },
        }
    }

    /// An answer that the conversation has no place for.
    pub fn protocol(&self, why: String) -> Error {
        Error::Protocol {
            peer: self.name.clone(),
            phase: self.asked.clone(),
            why,
        }
    }

    fn link_mut(&mut self) -> Result<&mut Box<dyn Link>, Error> {
        let name = &self.name;
        self.link.as_mut().ok_or_else(|| Error::PeerLost {
            peer: name.clone(),
            phase: "after its end".into(),
            why: "the connection is closed".into(),
        })
    }

    /// Tells a peer that died from one that is silent, and a silent one from one that is stopped.
    fn still_alive(&mut self, start: Instant, patience: Patience) -> Result<(), Error> {
        let lost = |peer: &Peer, why: String| Error::PeerLost {
            peer: peer.name.clone(),
            phase: peer.asked.clone(),
            why,
        };
        let state = match &mut self.life {
            Some(Life::Process(child)) => match child.try_wait() {
                Ok(Some(status)) => {
                    return Err(lost(self, format!("its process ended with {status}")));
                }
                _ if process::is_stopped(child.id()) => {
                    format!(
                        "process {} is alive but stopped (SIGSTOP or a debugger)",
                        child.id()
                    )
                }
                _ => format!("process {} is alive but silent", child.id()),
            },
            Some(Life::Thread(thread)) if thread.is_finished() => {
                return Err(lost(self, "its thread ended".into()));
            }
            Some(Life::Tape) => "the log holds no answer".into(),
            _ => "its thread is alive but silent".into(),
        };
        if start.elapsed().as_secs_f64() < patience.seconds {
            return Ok(());
        }
        Err(Error::Deadline {
            peer: self.name.clone(),
            phase: self.asked.clone(),
            seconds: patience.seconds,
            state,
            key: patience.key,
        })
    }

    fn broken(&mut self, error: LinkError) -> Error {
        match error {
            LinkError::Closed => Error::PeerLost {
                peer: self.name.clone(),
                phase: self.asked.clone(),
                why: "it closed the connection".into(),
            },
            other => self.protocol(other.to_string()),
        }
    }

    /// Closes the connection and sees that nothing of the participant is left running.
    pub fn end(&mut self) {
        self.link = None;
        match self.life.take() {
            Some(Life::Process(mut child)) => process::end(&mut child),
            Some(Life::Thread(thread)) => {
                let _ = thread.join();
            }
            Some(Life::Tape) | None => {}
        }
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        self.end();
    }
}

/// What was asked and when, as messages say it.
fn asked(frame: &Frame) -> String {
    let header = &frame.header;
    match Kind::from_number(header.kind) {
        Some(
            kind @ (Kind::Advance
            | Kind::PrescribeVelocity
            | Kind::Solve
            | Kind::Commit
            | Kind::AdvanceAlone),
        ) => {
            format!(
                "in window {}, iteration {} ({kind:?}, t = {:.6e} s)",
                header.window, header.iteration, header.t0_s
            )
        }
        Some(Kind::Hello) => "during its set-up".into(),
        Some(kind) => format!("at the handshake ({kind:?})"),
        None => "outside the protocol".into(),
    }
}
