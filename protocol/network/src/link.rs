//! One end of a connection between hosts.
//!
//! zenoh carries messages and reconnects by itself, but does not repeat messages lost meanwhile, and any program that it lets in may
//! publish. So an end numbers the pieces of frames, keeps them until the other end confirms them, and repeats the missing ones;
//! it signs every message. A waiting end sends a ping now and then, and the other end answers at once, even while its solver
//! computes. Unanswered pings mean that the host is lost, for any reason from a dead process to a broken cable.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use protocol::busy::monotonic_ns;
use protocol::link::RoundTrip;
use protocol::{Frame, Link, LinkError};
use zenoh::Wait;
use zenoh::bytes::ZBytes;
use zenoh::pubsub::{Publisher, Subscriber};
use zenoh::qos::{CongestionControl, Priority};

use crate::complaints::without_place;
use crate::message::{Key, Message, Purpose, Refused, Sender};

/// Doubles of a piece: it fits into one zenoh batch, so zenoh's timeout applies to each piece.
const PIECE: usize = 4096;

/// Largest payload (doubles), the same as in shared memory.
const MAX_DOUBLES: usize = 1 << 27;

/// Frames that the other end has not taken yet: a request, and one sent ahead.
const WAITING_FRAMES: u64 = 2;

/// Time between two pings before the first message of the other end, and between the pings of a leaving end.
const SOON: Duration = Duration::from_millis(20);

/// Time between two pings of a wait.
const PING: Duration = Duration::from_millis(250);

/// Longest round trip that is measured.
const LONGEST_TRIP: Duration = Duration::from_secs(2);

/// Longest wait until the other end knows that this one leaves.
const FAREWELL: Duration = Duration::from_secs(1);

/// Number of measured round trips; the shortest counts.
const ROUND_TRIPS: usize = 9;

/// One end of a connection between hosts.
pub struct NetworkLink {
    end: Arc<End>,
    /// Frames; zenoh keeps them until there is room.
    frames: Publisher<'static>,
    _subscriber: Subscriber<()>,
    /// zenoh closes it when the last link over it is dropped.
    session: zenoh::Session,
    sent_frames: u64,
    /// Time without a sign of life after which the other end counts as lost.
    lost_after: Duration,
    /// The last ping of a wait, or the wait's start; the next call continues the wait when the patience of this one ends.
    pinged: Option<Instant>,
}

/// State and keys that the two threads of an end share: the thread that calls the link, and zenoh's, which delivers messages.
struct End {
    key: Key,
    sender: Sender,
    /// Signs of life and repeated pieces; zenoh drops them if there is no room.
    signs: Publisher<'static>,
    state: Mutex<State>,
    changed: Condvar,
}

/// A piece that the other end has not confirmed.
struct Unconfirmed {
    number: u64,
    bytes: ZBytes,
    /// Clock at which zenoh took it: a message sent later arrives later, or not at all.
    put_ns: u64,
}

#[derive(Default)]
struct State {
    unconfirmed: VecDeque<Unconfirmed>,
    /// Pieces sent.
    sent: u64,
    /// Complete frames.
    arrived: VecDeque<Frame>,
    /// The beginning of the next frame.
    arriving: Option<Frame>,
    /// Pieces received, and frames taken.
    received: u64,
    taken: u64,
    /// Frames that the other end has taken.
    taken_there: u64,
    /// Its clock at its last message, and at its last ping; 0 before its first message.
    heard_ns: u64,
    heard_ping_ns: u64,
    /// Our clock at our last message that it received.
    heard_there_ns: u64,
    left: bool,
    /// True for a leaving end: its pings say so.
    leaving: bool,
    /// Time spent waiting with pings since its last message.
    silent: Duration,
    /// The answer to the last ping, or to an earlier one that took longer than the pause between them.
    answer: Option<RoundTrip>,
    refused: BTreeMap<Refused, u64>,
}

impl State {
    /// Takes the next piece; false for a piece that came before, or that follows a missing one.
    fn take(&mut self, number: u64, piece: Frame) -> bool {
        if number != self.received + 1 {
            return false;
        }
        self.received = number;
        let whole = piece.payload.len() < PIECE;
        match &mut self.arriving {
            None => self.arriving = Some(piece),
            Some(frame) if frame.payload.len() < MAX_DOUBLES => frame.payload.extend(piece.payload),
            // Its length will not match its header.
            Some(_) => {}
        }
        if whole {
            self.arrived.extend(self.arriving.take());
        }
        true
    }

    fn refuse(&mut self, refused: Refused) {
        *self.refused.entry(refused).or_default() += 1;
    }

    fn message(&self, purpose: Purpose) -> Message {
        Message {
            purpose,
            number: self.sent,
            received: self.received,
            taken: self.taken,
            clock_ns: monotonic_ns(),
            echo_ns: self.heard_ns,
        }
    }

    /// Pieces that were sent before a message that the other end received, and that it did not receive.
    fn lost(&mut self, heard_there_ns: u64) -> Vec<(u64, ZBytes)> {
        let pieces = self.unconfirmed.iter_mut();
        let lost = pieces.filter(|piece| piece.put_ns <= heard_there_ns);
        let again = lost.map(|piece| {
            piece.put_ns = u64::MAX;
            (piece.number, piece.bytes.clone())
        });
        again.collect()
    }

    /// Records that zenoh has taken a piece.
    fn put(&mut self, number: u64) {
        let mut pieces = self.unconfirmed.iter_mut();
        if let Some(piece) = pieces.find(|piece| piece.number == number) {
            piece.put_ns = monotonic_ns();
        }
    }
}

impl End {
    fn state(&self) -> MutexGuard<'_, State> {
        // Nothing that holds the lock can panic half-way.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sends a sign of life; another follows if it is lost.
    fn sign(&self, message: &Message) {
        let _ = self
            .signs
            .put(message.signed(&self.key, self.sender))
            .wait();
    }

    /// Takes a message, in zenoh's thread.
    fn hear(&self, bytes: &[u8]) {
        let mut state = self.state();
        let (answer, lost) = match Message::read(bytes, &self.key, self.sender.other()) {
            Ok(message) => {
                let (received, echo_ns) = (message.received, message.echo_ns);
                let answer = understand(&mut state, message);
                state.unconfirmed.retain(|piece| piece.number > received);
                (answer, state.lost(echo_ns))
            }
            Err(refused) => {
                state.refuse(refused);
                (None, Vec::new())
            }
        };
        drop(state);
        self.changed.notify_all();
        answer.iter().for_each(|answer| self.sign(answer));
        for (number, piece) in lost {
            let _ = self.signs.put(piece).wait();
            self.state().put(number);
        }
    }
}

/// Takes a message, and returns the answer that must be sent at once.
fn understand(state: &mut State, message: Message) -> Option<Message> {
    let answered = match message.purpose {
        Purpose::Piece(header, payload) => {
            let taken = state.take(message.number, Frame { header, payload });
            if !taken {
                state.refuse(Refused::Repeated);
            }
            !taken
        }
        Purpose::Ping if message.clock_ns <= state.heard_ping_ns => {
            state.refuse(Refused::Repeated);
            return None;
        }
        Purpose::Ping => {
            state.heard_ping_ns = message.clock_ns;
            true
        }
        Purpose::Pong => {
            let time_ns = monotonic_ns().saturating_sub(message.echo_ns);
            let middle_ns = message.echo_ns + time_ns / 2;
            state.answer = Some(RoundTrip {
                time: Duration::from_nanos(time_ns),
                offset_ns: middle_ns as i64 - message.clock_ns as i64,
            });
            // Pieces that were sent before it would have arrived.
            message.number > state.received
        }
        Purpose::Left => {
            state.left = true;
            true
        }
    };
    state.heard_ns = state.heard_ns.max(message.clock_ns);
    state.heard_there_ns = state.heard_there_ns.max(message.echo_ns);
    state.silent = Duration::ZERO;
    state.taken_there = state.taken_there.max(message.taken);
    answered.then(|| Message {
        echo_ns: message.clock_ns,
        ..state.message(Purpose::Pong)
    })
}

impl NetworkLink {
    /// The end that sends as `sender` below the key expression `place`, over this session of zenoh.
    pub(crate) fn new(
        session: &zenoh::Session,
        place: &str,
        sender: Sender,
        key: Key,
        lost_after: Duration,
    ) -> Result<NetworkLink, LinkError> {
        let [mut to, mut from] = ["request", "answer"].map(|way| format!("{place}/{way}"));
        if sender == Sender::Participant {
            std::mem::swap(&mut to, &mut from);
        }
        let publisher = |congestion| {
            session
                .declare_publisher(to.clone())
                .congestion_control(congestion)
                .priority(Priority::RealTime)
                .express(true)
                .wait()
                .map_err(failed)
        };
        let end = Arc::new(End {
            key,
            sender,
            signs: publisher(CongestionControl::Drop)?,
            state: Mutex::default(),
            changed: Condvar::new(),
        });
        let ear = Arc::clone(&end);
        let subscriber = session
            .declare_subscriber(from)
            .callback(move |sample| ear.hear(&sample.payload().to_bytes()))
            .wait()
            .map_err(failed)?;
        Ok(NetworkLink {
            frames: publisher(CongestionControl::Block)?,
            end,
            _subscriber: subscriber,
            session: session.clone(),
            sent_frames: 0,
            lost_after,
            pinged: None,
        })
    }

    /// Asks the other end, after a pause, for a sign of life.
    fn ping(&self, pause: Duration) {
        let mut state = self.end.state();
        let ping = state.message(if state.leaving {
            Purpose::Left
        } else {
            Purpose::Ping
        });
        state.answer = None;
        if state.heard_ns > 0 {
            state.silent += pause;
        }
        drop(state);
        self.end.sign(&ping);
    }

    /// Waits until `ready` returns a value, with pings. `None` if the patience ends before.
    fn wait<T>(
        &mut self,
        patience: Duration,
        between: Duration,
        mut ready: impl FnMut(&mut State) -> Option<Result<T, LinkError>>,
    ) -> Result<Option<T>, LinkError> {
        let start = Instant::now();
        let mut pinged = *self.pinged.get_or_insert(start);
        let end = Arc::clone(&self.end);
        let mut state = end.state();
        loop {
            if let Some(found) = ready(&mut state) {
                self.pinged = None;
                return found.map(Some);
            }
            if state.silent >= self.lost_after {
                let seconds = self.lost_after.as_secs_f64();
                return Err(LinkError::Lost { seconds });
            }
            let left = patience.saturating_sub(start.elapsed());
            if left.is_zero() {
                return Ok(None);
            }
            let pause = if state.heard_ns > 0 { between } else { SOON };
            let due = pause.saturating_sub(pinged.elapsed());
            if due.is_zero() {
                drop(state);
                pinged = Instant::now();
                self.pinged = Some(pinged);
                self.ping(pause);
                state = end.state();
                continue;
            }
            let waited = end.changed.wait_timeout(state, left.min(due));
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Number of refused messages by reason.
    pub fn refusals(&self) -> BTreeMap<Refused, u64> {
        self.end.state().refused.clone()
    }
}

impl Link for NetworkLink {
    /// On a stalled network the call lasts longer than its own patience, by zenoh's timeout of some seconds.
    fn send(&mut self, frame: &Frame, patience: Duration) -> Result<(), LinkError> {
        let doubles = frame.payload.len();
        if doubles > MAX_DOUBLES {
            let capacity = MAX_DOUBLES;
            return Err(LinkError::TooLong { doubles, capacity });
        }
        let sent = self.sent_frames;
        let end = Arc::clone(&self.end);
        let room = self.wait(patience, Duration::from_millis(1), |state| {
            if state.left {
                return Some(Err(LinkError::Closed));
            }
            let room = sent < state.taken_there + WAITING_FRAMES;
            (room && state.heard_ns > 0).then_some(Ok(()))
        })?;
        room.ok_or(LinkError::Full {
            seconds: patience.as_secs_f64(),
        })?;
        self.sent_frames += 1;
        // The last piece is shorter than the others, and may be empty.
        for start in (0..=doubles).step_by(PIECE) {
            let piece = &frame.payload[start..doubles.min(start + PIECE)];
            let purpose = Purpose::Piece(frame.header, piece.to_vec());
            let mut state = end.state();
            state.sent += 1;
            let number = state.sent;
            let bytes = ZBytes::from(state.message(purpose).signed(&end.key, end.sender));
            state.unconfirmed.push_back(Unconfirmed {
                number,
                bytes: bytes.clone(),
                put_ns: u64::MAX,
            });
            drop(state);
            self.frames.put(bytes).wait().map_err(failed)?;
            end.state().put(number);
        }
        Ok(())
    }

    fn receive(&mut self, patience: Duration) -> Result<Option<Frame>, LinkError> {
        self.wait(patience, PING, |state| {
            let frame = state.arrived.pop_front();
            state.taken += u64::from(frame.is_some());
            match frame {
                Some(frame) => Some(Ok(frame)),
                None => state.left.then_some(Err(LinkError::Closed)),
            }
        })
    }

    fn round_trip(&mut self) -> Option<RoundTrip> {
        let mut shortest: Option<RoundTrip> = None;
        for _ in 0..ROUND_TRIPS {
            self.ping(PING);
            let answered = self.wait(LONGEST_TRIP, PING, |state| state.answer.take().map(Ok));
            let all = shortest.into_iter().chain(answered.ok().flatten());
            shortest = all.min_by_key(|trip| trip.time);
        }
        shortest
    }

    fn refused(&self) -> Vec<String> {
        let mut refused = self.refusals();
        // Pieces arrive again after a lost connection.
        refused.remove(&Refused::Repeated);
        let line = |(reason, count): (Refused, u64)| format!("{count} messages {reason}");
        refused.into_iter().map(line).collect()
    }
}

impl Drop for NetworkLink {
    /// A participant waits until its last answer has arrived: no other program could send it again.
    fn drop(&mut self) {
        if self.end.sender == Sender::Participant {
            let _ = self.wait(self.lost_after, SOON, |state| {
                (state.left || state.unconfirmed.is_empty()).then_some(Ok(()))
            });
        }
        let left_ns = monotonic_ns();
        self.end.state().leaving = true;
        self.ping(SOON);
        // A closing session drops messages that zenoh has not sent yet.
        let _ = self.wait(FAREWELL, SOON, |state| {
            let heard = state.heard_there_ns >= left_ns || state.heard_ns == 0;
            (state.left || heard).then_some(Ok(()))
        });
        if self.end.sender == Sender::Participant {
            let _ = self.session.close().wait();
        }
    }
}

pub(crate) fn failed(error: impl std::fmt::Display) -> LinkError {
    LinkError::Transport(without_place(&format!("zenoh: {error}")))
}
