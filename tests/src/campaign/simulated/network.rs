//! A network of simulated time between a coordinator and its participants.
//!
//! The coordinator's end of each connection drives it: time advances from one delivery to the next while the coordinator waits,
//! and only then. A participant is the real serving loop in its own thread. It gets one frame, and the network waits until it asks
//! for the next, so a schedule is one fixed order of events on any machine.

use std::collections::{BTreeMap, VecDeque};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, OnceLock};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use protocol::{Frame, Link, LinkError, Node, NodeError, Session, serve};

use super::network_faults::{NetworkFault, NetworkFaults};

/// Time that a message takes (ns).
const LATENCY: u64 = 10_000;

/// Wall-clock time without a reaction after which a participant counts as hanging.
const HANGS: Duration = Duration::from_secs(20);

/// Deliveries after which a run counts as endless.
const DELIVERIES: u64 = 100_000;

/// Solver of a participant.
type Build = fn(&Session) -> Result<Box<dyn Node>, NodeError>;

/// A wrapper around each end of a connection, for tests that plant a bug in the program itself.
pub type Wrap = fn(Box<dyn Link>) -> Box<dyn Link>;

/// A network; clones share it.
#[derive(Clone)]
pub struct Network {
    shared: Arc<Mutex<State>>,
}

/// The end of a schedule, seen from the network.
#[derive(Debug, Default)]
pub struct Traces {
    /// Faults, each with the message that it hit.
    pub faults: Vec<(u64, NetworkFault)>,
    /// Simulated time since the coordinator received something (s).
    pub unheard_s: f64,
    /// Messages sent.
    pub messages: u64,
    /// The fault of a participant or of the run: it hangs, panicked, or does not end.
    pub broken: Option<String>,
}

#[derive(Default)]
struct State {
    now: u64,
    heard: u64,
    messages: u64,
    /// Deliveries so far, which orders deliveries of the same time.
    posted: u64,
    deliveries: u64,
    faults: NetworkFaults,
    /// Deliveries to come by time and number.
    coming: BTreeMap<(u64, u64), Delivery>,
    participants: Vec<Participant>,
    broken: Option<String>,
}

struct Delivery {
    participant: usize,
    frame: Frame,
    /// To the coordinator.
    answer: bool,
    fault: Option<NetworkFault>,
}

struct Participant {
    requests: Option<Sender<Frame>>,
    said: Receiver<Said>,
    /// Answers that have arrived at the coordinator.
    inbox: VecDeque<Frame>,
    /// It receives nothing before this time.
    stopped_until: u64,
    /// No message overtakes the last late one, each way.
    not_before: [u64; 2],
    /// It has ended, but its last message is still on its way: its end shows after that.
    leaves: bool,
    /// Set once it has ended.
    end: Arc<OnceLock<String>>,
    closed: bool,
    thread: Option<JoinHandle<()>>,
}

enum Said {
    Answer(Frame),
    /// It asks for the next request.
    Waits,
}

impl Network {
    /// A network without participants.
    pub fn new(faults: NetworkFaults) -> Network {
        let state = State {
            faults,
            ..State::default()
        };
        Network {
            shared: Arc::new(Mutex::new(state)),
        }
    }

    /// Starts a participant; returns the coordinator's end of its connection, and the place for the reason of its end.
    pub fn join(
        &self,
        session: Session,
        build: Build,
        wrap: Wrap,
    ) -> (Box<dyn Link>, Arc<OnceLock<String>>) {
        let (requests, hears) = channel();
        let (says, said) = channel();
        let thread = thread::spawn(move || {
            let mut far: Box<dyn Link> = wrap(Box::new(FarEnd { hears, says }));
            // The coordinator gets the reason as a fault, or the network is the reason.
            let _ = serve(&session, far.as_mut(), build);
        });
        let end = Arc::new(OnceLock::new());
        let mut state = self.shared.lock().expect("nothing panics with it");
        state.participants.push(Participant {
            requests: Some(requests),
            said,
            inbox: VecDeque::new(),
            stopped_until: 0,
            not_before: [0; 2],
            leaves: false,
            end: Arc::clone(&end),
            closed: false,
            thread: Some(thread),
        });
        let participant = state.participants.len() - 1;
        state.listen(participant);
        let near = NearEnd {
            network: self.clone(),
            participant,
        };
        (wrap(Box::new(near)), end)
    }

    /// Ends all participants; returns the traces of the schedule.
    pub fn end(&self) -> Traces {
        let mut state = self.shared.lock().expect("nothing panics with it");
        for participant in 0..state.participants.len() {
            state.crash(participant, "the run is over");
        }
        Traces {
            faults: std::mem::take(&mut state.faults.faults),
            unheard_s: 1e-9 * (state.now - state.heard) as f64,
            messages: state.messages,
            broken: state.broken.take(),
        }
    }
}

impl State {
    /// Puts a message on its way, with the fault that hits it.
    fn post(&mut self, participant: usize, frame: &Frame, answer: bool) {
        let fault = self.faults.fault(self.messages);
        self.messages += 1;
        let mut delivery = Delivery {
            participant,
            frame: frame.clone(),
            answer,
            fault: None,
        };
        let mut at = self.now + LATENCY;
        let last = &mut self.participants[participant].not_before[usize::from(answer)];
        match fault {
            Some(NetworkFault::Late(time_s)) => *last = (*last).max(at + nanoseconds(time_s)),
            Some(NetworkFault::Overtaken(time_s)) => at = (*last).max(at) + nanoseconds(time_s),
            Some(NetworkFault::Flipped(bit)) => flip(&mut delivery.frame, bit),
            Some(NetworkFault::Crash(_) | NetworkFault::Stall(_)) => delivery.fault = fault,
            _ => {}
        }
        at = at.max(*last);
        if let Some(NetworkFault::Repeated(time_s)) = fault {
            let again = Delivery {
                frame: frame.clone(),
                ..delivery
            };
            self.send(at + nanoseconds(time_s), again);
        }
        if fault != Some(NetworkFault::Lost) {
            self.send(at, delivery);
        }
    }

    fn send(&mut self, at: u64, delivery: Delivery) {
        self.posted += 1;
        self.coming.insert((at, self.posted), delivery);
    }

    /// Waits for an answer of a participant until some time; `None` if no answer comes.
    fn wait(&mut self, participant: usize, until: u64) -> Result<Option<Frame>, LinkError> {
        loop {
            if let Some(frame) = self.participants[participant].inbox.pop_front() {
                self.heard = self.now;
                return Ok(Some(frame));
            }
            if self.participants[participant].closed {
                return Err(LinkError::Closed);
            }
            if self.deliveries > DELIVERIES {
                self.broken = Some("the run goes round in a circle".into());
                return Err(LinkError::Closed);
            }
            let first = self.coming.first_entry();
            let Some(next) = first.filter(|next| next.key().0 <= until) else {
                self.now = until;
                return Ok(None);
            };
            let ((at, _), delivery) = next.remove_entry();
            self.now = self.now.max(at);
            self.deliver(delivery);
        }
    }

    fn deliver(&mut self, delivery: Delivery) {
        self.deliveries += 1;
        let one = delivery.participant;
        match delivery.fault {
            Some(NetworkFault::Crash(closes)) => {
                self.crash(one, "its process ended with signal: 9 (SIGKILL)");
                self.participants[one].closed = closes;
            }
            Some(NetworkFault::Stall(time_s)) => {
                self.participants[one].stopped_until = self.now + nanoseconds(time_s);
            }
            _ => {}
        }
        let participant = &mut self.participants[one];
        if delivery.answer {
            // It left the participant before a fault hit the participant.
            participant.inbox.push_back(delivery.frame);
            if participant.leaves {
                self.leave(one);
            }
        } else if participant.stopped_until > self.now {
            let at = participant.stopped_until;
            let fault = None;
            self.send(at, Delivery { fault, ..delivery });
        } else if let Some(requests) = &participant.requests
            && requests.send(delivery.frame).is_ok()
        {
            self.listen(one);
        }
    }

    /// Receives messages of a participant until it asks for more, or has ended.
    fn listen(&mut self, one: usize) {
        loop {
            let said = self.participants[one].said.recv_timeout(HANGS);
            match said {
                Ok(Said::Answer(frame)) => self.post(one, &frame, true),
                Ok(Said::Waits) => return,
                Err(RecvTimeoutError::Disconnected) => {
                    self.join(one);
                    return self.leave(one);
                }
                Err(RecvTimeoutError::Timeout) => {
                    self.broken = Some(format!("participant {one} hangs"));
                    // A thread cannot be ended from outside.
                    self.participants[one].thread = None;
                    return;
                }
            }
        }
    }

    /// Kills a participant: it receives nothing more, and its further messages are lost.
    fn crash(&mut self, one: usize, why: &str) {
        let participant = &mut self.participants[one];
        participant.requests = None;
        while participant.thread.is_some() && participant.said.recv_timeout(HANGS).is_ok() {}
        self.join(one);
        let _ = self.participants[one].end.set(why.into());
    }

    fn join(&mut self, one: usize) {
        let participant = &mut self.participants[one];
        if let Some(thread) = participant.thread.take()
            && thread.join().is_err()
        {
            self.broken = Some(format!("participant {one} panicked"));
        }
        participant.requests = None;
    }

    /// Shows the end of a participant once all its messages have arrived.
    fn leave(&mut self, one: usize) {
        let mut coming = self.coming.values();
        let participant = &mut self.participants[one];
        participant.leaves = coming.any(|delivery| delivery.answer && delivery.participant == one);
        if !participant.leaves {
            let _ = participant.end.set("its thread ended".into());
        }
    }
}

fn nanoseconds(time_s: f64) -> u64 {
    (1e9 * time_s) as u64
}

/// Flips a bit of the header or the payload.
fn flip(frame: &mut Frame, bit: u64) {
    let header = &mut frame.header;
    let (field, bit) = (bit % 24, bit / 24);
    let one = |bits: u64| 1u64 << (bit % bits);
    let flipped = |time_s: f64| f64::from_bits(time_s.to_bits() ^ one(64));
    match field {
        0 => header.kind ^= one(32) as u32,
        1 => header.protocol ^= one(32) as u32,
        2 => header.run_id ^= one(64),
        3 => header.interface ^= one(32) as u32,
        4 => header.iteration ^= one(32) as u32,
        5 => header.window ^= one(64),
        6 => header.step ^= one(64),
        // A body takes this many steps: the upper bits would only cost time.
        7 => header.substeps ^= one(12) as u32,
        8 => header.count ^= one(32) as u32,
        9 => header.t0_s = flipped(header.t0_s),
        10 => header.t1_s = flipped(header.t1_s),
        11 => header.checksum ^= one(64),
        _ if frame.payload.is_empty() => header.checksum ^= one(64),
        _ => {
            let entry = (bit / 64) as usize % frame.payload.len();
            let value = &mut frame.payload[entry];
            *value = f64::from_bits(value.to_bits() ^ one(64));
        }
    }
}

/// The coordinator's end of a connection.
struct NearEnd {
    network: Network,
    participant: usize,
}

impl Link for NearEnd {
    fn send(&mut self, frame: &Frame, _patience: Duration) -> Result<(), LinkError> {
        let mut state = self.network.shared.lock().expect("nothing panics with it");
        if state.participants[self.participant].closed {
            return Err(LinkError::Closed);
        }
        state.post(self.participant, frame, false);
        Ok(())
    }

    fn receive(&mut self, patience: Duration) -> Result<Option<Frame>, LinkError> {
        let mut state = self.network.shared.lock().expect("nothing panics with it");
        let until = state.now + patience.as_nanos() as u64;
        state.wait(self.participant, until)
    }
}

/// A participant's end.
struct FarEnd {
    hears: Receiver<Frame>,
    says: Sender<Said>,
}

impl Link for FarEnd {
    fn send(&mut self, frame: &Frame, _patience: Duration) -> Result<(), LinkError> {
        let said = self.says.send(Said::Answer(frame.clone()));
        said.map_err(|_| LinkError::Closed)
    }

    fn receive(&mut self, _patience: Duration) -> Result<Option<Frame>, LinkError> {
        let _ = self.says.send(Said::Waits);
        self.hears.recv().map(Some).map_err(|_| LinkError::Closed)
    }
}
