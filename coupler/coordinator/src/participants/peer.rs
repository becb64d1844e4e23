//! One participant, seen from the coordinator: the connection and its other end.

use std::borrow::Cow;
use std::collections::VecDeque;
use std::sync::{Arc, OnceLock};
use std::thread::JoinHandle;
use std::time::Duration;

use protocol::busy::{BusyTimes, monotonic_ns};
use protocol::link::channel;
use protocol::{Cause, Frame, Header, Kind, Link, LinkError, NodeError, PROTOCOL_VERSION};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::process::{self, Process};
use super::watch::Watch;
use crate::events::{Listener, RunEvent};
use exchange_log::timing::RequestTimes;
use scenario::error::{Code, Error, Refusal, Result};
use scheme::ledger::{largest_difference, ratio};

/// Time after which a wait checks whether the peer still lives.
const SLICE: Duration = Duration::from_millis(50);

/// The participant at the other end of a connection, by the place where it runs.
pub enum OtherEnd {
    /// In a process of its own.
    Process(Process),
    /// In a thread of the coordinator.
    Thread(Option<JoinHandle<Result<(), String>>>),
    /// In a log.
    Tape,
    /// At the far end of a simulated connection, with the reason of its end once it has ended.
    Simulated(Arc<OnceLock<String>>),
}

/// A wait: its deadline with the key that sets it, and the signals that end it.
pub struct Wait<'a> {
    /// Deadline (s).
    pub seconds: f64,
    /// Key below `run.deadlines`.
    pub key: &'static str,
    /// Signals.
    pub watch: &'a Watch,
    /// Receives events of a long wait.
    pub listener: Option<&'a Listener>,
}

/// One participant.
pub struct Peer {
    /// Name in the scenario.
    pub name: String,
    link: Box<dyn Link>,
    /// Ends after its connection was closed.
    other_end: OtherEnd,
    /// The last request, for messages.
    asked: String,
    /// A request sent before its turn.
    early: Option<Frame>,
    /// Unanswered requests.
    open: VecDeque<Asked>,
    /// Number of answered requests.
    answered: u64,
    /// The fault that it reported, after which it ends.
    pub fault: Option<NodeError>,
    /// Times in which the coordinator only waited for its answers.
    pub awaited: BusyTimes,
    /// Total length of these times (ns).
    pub waited_ns: u64,
    /// The end of the last wait (ns of the monotonic clock).
    pub last_answer_ns: u64,
    /// Times of the answered requests, if they are kept.
    pub times: Option<Vec<RequestTimes>>,
    /// True if some windows are requested twice: for a foreign program that can repeat windows.
    pub twice: bool,
    /// The request that will be sent twice.
    again: Option<Frame>,
    /// Data of a participant on another host.
    pub far: Option<Far>,
}

/// A participant on another host.
#[derive(Clone, Debug, Serialize)]
pub struct Far {
    /// Its host, by its own report.
    pub host: String,
    /// Round-trip time (s).
    pub round_trip_s: f64,
    /// Number of round trips for which the coordinator waited in windows. A trip that ran partly during another wait
    /// counts in part.
    pub round_trips: f64,
}

/// A sent request.
#[derive(Clone, Copy)]
struct Asked {
    header: Header,
    at_ns: u64,
}

impl Peer {
    /// A participant with its connection and other end.
    pub fn new(name: &str, link: Box<dyn Link>, other_end: OtherEnd) -> Peer {
        Peer {
            name: name.to_string(),
            link,
            other_end,
            asked: "during its launch".into(),
            early: None,
            open: VecDeque::new(),
            answered: 0,
            fault: None,
            awaited: BusyTimes::default(),
            waited_ns: 0,
            last_answer_ns: 0,
            times: None,
            twice: false,
            again: None,
            far: None,
        }
    }

    /// Notes a greeting from another host, and measures the round trip.
    pub fn is_at(&mut self, host: &str) {
        self.far = self.link.round_trip().map(|trip| Far {
            host: host.into(),
            round_trip_s: trip.time.as_secs_f64(),
            round_trips: 0.0,
        });
    }

    /// Its process, unless it runs in this one.
    pub fn process(&mut self) -> Option<&mut Process> {
        match &mut self.other_end {
            OtherEnd::Process(process) => Some(process),
            OtherEnd::Thread(_) | OtherEnd::Tape | OtherEnd::Simulated(_) => None,
        }
    }

    /// Messages of other programs on its connection, in words.
    pub fn strangers(&self) -> Vec<String> {
        self.link.refused()
    }

    /// Closes the connection without a message.
    pub fn hang_up(&mut self) {
        self.link = Box::new(channel::pair().0);
    }

    /// Sends a request whose turn has come and returns its frame. A request that was sent early is reused, so that its
    /// frame and checksum are made once.
    pub fn send(&mut self, header: Header, payload: Cow<[f64]>, wait: &Wait) -> Result<Frame> {
        if let Some(sent) = self.early.take() {
            self.asked = asked(&sent.header);
            if equals(&sent, &header, &payload) {
                return Ok(sent);
            }
            // Another request comes first: a checkpoint, fields, the end. Only windows begin early, and a window that
            // is not accepted changes nothing.
            self.receive(Kind::Motion, wait)?;
        }
        self.asked = asked(&header);
        self.put_on_link(Frame::new(header, payload.into_owned()), wait)
    }

    /// Sends the next request before the answer to the current one has arrived, so that the peer need not sleep in
    /// between. At most one is under way; a tape gets no request before its turn.
    pub fn send_early(&mut self, header: Header, payload: &[f64], wait: &Wait) -> Result<()> {
        if self.early.is_none() && !matches!(self.other_end, OtherEnd::Tape) {
            let frame = Frame::new(header, payload.to_vec());
            self.early = Some(self.put_on_link(frame, wait)?);
        }
        Ok(())
    }

    /// Returns the frame as in the log: without the stamp of its turn on this link.
    fn put_on_link(&mut self, mut frame: Frame, wait: &Wait) -> Result<Frame> {
        let turn = self.answered + self.open.len() as u64;
        let header = frame.header;
        self.open.push_back(Asked {
            header,
            at_ns: monotonic_ns(),
        });
        frame.stamp(turn);
        let mut waited = Duration::ZERO;
        loop {
            wait.watch.check()?;
            match self.link.send(&frame, SLICE) {
                Ok(()) => return Ok(Frame { header, ..frame }),
                Err(LinkError::Full { .. }) => self.still_alive(&mut waited, wait)?,
                Err(error) => return Err(self.broken(error)),
            }
        }
    }

    /// Waits for the answer to the last request.
    pub fn receive(&mut self, expected: Kind, wait: &Wait) -> Result<Frame> {
        let start_ns = monotonic_ns();
        let asked = self.open.front().copied();
        let answer = self.wait_for(expected, wait);
        self.last_answer_ns = monotonic_ns();
        self.waited_ns += self.last_answer_ns - start_ns;
        self.awaited.add([start_ns, self.last_answer_ns]);
        let kind = asked.and_then(|asked| Kind::from_number(asked.header.kind));
        if let (Some(far), true) = (&mut self.far, kind.is_some_and(Kind::is_about_window)) {
            let waited_s = 1e-9 * (self.last_answer_ns - start_ns) as f64;
            far.round_trips += ratio(waited_s, far.round_trip_s).min(1.0);
        }
        if let (Ok(_), Some(asked), Some(times)) = (&answer, asked, &mut self.times) {
            let answered = RequestTimes::answered_now(&asked.header, asked.at_ns, start_ns);
            times.push(answered);
        }
        answer
    }

    /// Keeps a request for a window that will be requested twice. The windows 16, 64, 256, .. are less than 0.4 % of a
    /// long run.
    pub fn keep_request(&mut self, sent: &Frame) {
        let (window, kind) = (sent.header.window, Kind::from_number(sent.header.kind));
        let repeatable = [Kind::Advance, Kind::Solve, Kind::PrescribeVelocity];
        let due = window >= 16 && window.is_power_of_two() && window.trailing_zeros() % 2 == 0;
        let first = sent.header.iteration == 0 && kind.is_some_and(|k| repeatable.contains(&k));
        self.again = (self.twice && due && first).then(|| sent.clone());
    }

    /// Sends the kept request again, and returns the distance of its answer from the first, over the size of the first.
    /// Only the participant sees this exchange: no log has it.
    pub fn ask_again(&mut self, kind: Kind, first: &[f64], wait: &Wait) -> Result<f64> {
        let Some(request) = self.again.take() else {
            return Ok(0.0);
        };
        let times = self.times.take();
        self.put_on_link(request, wait)?;
        let again = self.receive(kind, wait)?.payload;
        self.times = times;
        let size = largest_difference(first, &vec![0.0; first.len()]);
        let apart = ratio(largest_difference(&again, first), size);
        // One difference is enough.
        self.twice = apart == 0.0;
        Ok(apart)
    }

    fn wait_for(&mut self, expected: Kind, wait: &Wait) -> Result<Frame> {
        let mut waited = Duration::ZERO;
        loop {
            wait.watch.check()?;
            match self.link.receive(SLICE) {
                Ok(Some(frame)) => return self.accept(frame, expected),
                Ok(None) => {}
                Err(error) => return Err(self.broken(error)),
            }
            if let Err(error) = self.still_alive(&mut waited, wait) {
                // A peer that has ended may have answered since the last check, with its farewell or a fault.
                return match self.link.receive(Duration::ZERO) {
                    Ok(Some(frame)) => self.accept(frame, expected),
                    _ => Err(error),
                };
            }
        }
    }

    /// Accepts an answer with the turn and the header of the oldest open request.
    fn accept(&mut self, mut frame: Frame, expected: Kind) -> Result<Frame> {
        if frame.header.protocol != PROTOCOL_VERSION {
            let text = format!(
                "participant `{}` speaks protocol version {}, the coordinator speaks {PROTOCOL_VERSION}: build both from the same release",
                self.name, frame.header.protocol
            );
            return Err(Refusal::other(Code::Of(Cause::OtherRelease), text).into());
        }
        let opened = frame.open(self.answered).and_then(|()| frame.kind());
        let kind = opened.map_err(|error| self.protocol_error(error.to_string()))?;
        if kind == Kind::Fault {
            return Err(self.take_fault(&frame));
        }
        if kind != expected {
            let why = format!("answered {kind:?} instead of {expected:?}");
            return Err(self.protocol_error(why));
        }
        let request = self.open.pop_front();
        self.answered += 1;
        if kind == Kind::Finished
            && let Some(process) = self.process()
        {
            process.said_farewell();
        }
        match request.and_then(|asked| other_subject(&asked.header, &frame.header)) {
            None => Ok(frame),
            Some(why) => Err(self.protocol_error(why)),
        }
    }

    fn take_fault(&mut self, frame: &Frame) -> Error {
        let Ok(error) = read_json::<NodeError>(frame) else {
            return self.protocol_error("reported a fault that cannot be read".into());
        };
        self.fault = Some(error.clone());
        Error::Fault {
            peer: self.name.clone(),
            phase: self.asked.clone(),
            cause: error.cause(),
            message: error.message,
        }
    }

    fn lost(&self, why: String) -> Error {
        Error::PeerLost {
            peer: self.name.clone(),
            phase: self.asked.clone(),
            why,
        }
    }

    /// The error for an answer out of place.
    pub fn protocol_error(&self, why: String) -> Error {
        Error::Protocol {
            peer: self.name.clone(),
            phase: self.asked.clone(),
            why,
        }
    }

    /// Distinguishes a peer that died, a silent peer and a stopped peer. Only time inside calls of the link counts as
    /// waited: a coordinator that was stopped itself was not waiting.
    fn still_alive(&mut self, waited: &mut Duration, wait: &Wait) -> Result<()> {
        if let Some(why) = self.other_end.ended() {
            return Err(self.lost(why));
        }
        // A signal leaves a window some time, which is useless if the peer is stopped.
        let signal = wait.watch.interrupted();
        if let Some(error) = signal.filter(|_| self.other_end.is_stopped()) {
            return Err(error);
        }
        let before = waited.as_secs_f64();
        *waited += SLICE;
        let now = waited.as_secs_f64();
        if now < wait.seconds {
            if let Some(listener) = wait.listener {
                listener.report(&RunEvent::Prepares {
                    participant: &self.name,
                    waited_s: [before, now],
                    limit_s: wait.seconds,
                });
            }
            return Ok(());
        }
        let state = self.other_end.state();
        Err(self.late(wait.seconds, state, wait.key))
    }

    fn late(&self, seconds: f64, state: String, key: &'static str) -> Error {
        Error::Deadline {
            peer: self.name.clone(),
            phase: self.asked.clone(),
            seconds,
            state,
            key,
        }
    }

    fn broken(&mut self, error: LinkError) -> Error {
        match error {
            LinkError::Closed => self.lost("it closed the connection".into()),
            LinkError::Lost { seconds } => {
                if let Some(why) = self.other_end.ended() {
                    return self.lost(why);
                }
                let far = self.far.as_ref();
                let host = far.map_or(String::new(), |far| format!(" `{}`", far.host));
                let state = format!(
                    "it gave no sign of life: its host{host}, its process there or the network to it is down"
                );
                self.late(seconds, state, "link_s")
            }
            other => self.protocol_error(other.to_string()),
        }
    }
}

impl OtherEnd {
    /// The reason of its end, once it has ended.
    fn ended(&mut self) -> Option<String> {
        match self {
            OtherEnd::Process(child) => {
                let status = child.try_wait().ok()??;
                let said = match child.last_words() {
                    words if words.is_empty() => "it printed nothing".into(),
                    words => format!("its last output: {words}"),
                };
                Some(format!("its process ended with {status}; {said}"))
            }
            OtherEnd::Thread(Some(thread)) if thread.is_finished() => {
                Some("its thread ended".into())
            }
            OtherEnd::Simulated(end) => end.get().cloned(),
            _ => None,
        }
    }

    /// True for a process that another program stopped.
    fn is_stopped(&self) -> bool {
        matches!(self, OtherEnd::Process(process) if process::is_stopped(process.id()))
    }

    /// The visible state of a peer that does not answer.
    fn state(&self) -> String {
        match self {
            OtherEnd::Process(child) => {
                let words = ["silent", "stopped (SIGSTOP or a debugger)"];
                let state = words[usize::from(self.is_stopped())];
                format!("process {} is alive but {state}", child.id())
            }
            OtherEnd::Thread(_) => "its thread is alive but silent".into(),
            OtherEnd::Tape => "the log holds no answer".into(),
            OtherEnd::Simulated(_) => "it is silent".into(),
        }
    }
}

impl Drop for OtherEnd {
    /// Makes sure that no part of the participant keeps running.
    fn drop(&mut self) {
        // A process ends itself when dropped.
        if let OtherEnd::Thread(thread) = self {
            drop(thread.take().map(JoinHandle::join));
        }
    }
}

/// Reads the text of a frame as JSON.
pub fn read_json<T: DeserializeOwned>(frame: &Frame) -> Result<T, String> {
    let text = frame.text().map_err(|error| error.to_string())?;
    serde_json::from_str(&text).map_err(|error| error.to_string())
}

/// The difference between the headers of an answer and its request, which must agree.
fn other_subject(request: &Header, answer: &Header) -> Option<String> {
    let repeated = Header {
        kind: answer.kind,
        protocol: answer.protocol,
        run_id: answer.run_id,
        count: answer.count,
        checksum: answer.checksum,
        ..*request
    };
    (repeated != *answer).then(|| format!("answered for {}", answer.subject()))
}

/// True if a frame equals this header and payload to the last bit. Equal payloads have equal counts and checksums,
/// which the given header still lacks.
fn equals(frame: &Frame, header: &Header, payload: &[f64]) -> bool {
    let header = Header {
        count: frame.header.count,
        checksum: frame.header.checksum,
        ..*header
    };
    let bits = |value: &f64| value.to_bits();
    frame.header == header && frame.payload.iter().map(bits).eq(payload.iter().map(bits))
}

/// The request and its time, for messages.
fn asked(header: &Header) -> String {
    match Kind::from_number(header.kind) {
        Some(kind) if kind.is_about_window() => format!(
            "in window {}, iteration {} ({kind:?}, t = {:.6e} s)",
            header.window, header.iteration, header.t0_s
        ),
        Some(Kind::Hello) => "during its set-up".into(),
        Some(kind) => format!("at the handshake ({kind:?})"),
        None => "outside the protocol".into(),
    }
}

#[cfg(test)]
mod tests;
