//! Requests and answers between the coordinator and its participants.

use protocol::busy::BusyTimes;
use protocol::{Frame, Header, Kind, PROTOCOL_VERSION, Window};

use super::peer::{Peer, Wait};
use super::process::SharedMemory;
use super::watch::Watch;
use crate::error::Error;
use crate::scenario::{Deadlines, Label, Scenario};

/// A way to speak to all participants of a run, frame by frame. [`Peers`] is the plain one; recording and rehearsing are
/// wrapped around it and see every frame.
pub trait Communicator {
    /// The participants themselves.
    fn peers(&self) -> &Peers;

    /// The participants, to speak to.
    fn peers_mut(&mut self) -> &mut Peers;

    /// Takes note of a frame that passed: a request whose turn has come, or an answer.
    fn witness(&mut self, peer: usize, answer: bool, frame: &Frame) -> Result<(), Error> {
        let _ = (peer, answer, frame);
        Ok(())
    }

    /// Closes a window.
    fn end_window(&mut self, window: u64) -> Result<(), Error> {
        let _ = window;
        Ok(())
    }

    /// Sends a request whose turn has come.
    fn send(&mut self, peer: usize, header: Header, payload: Vec<f64>) -> Result<(), Error> {
        let frame = self.peers_mut().transmit(peer, header, payload)?;
        self.witness(peer, false, &frame)
    }

    /// Waits for the answer of this kind.
    fn receive(&mut self, peer: usize, kind: Kind) -> Result<Frame, Error> {
        let frame = self.peers_mut().await_answer(peer, kind)?;
        self.witness(peer, true, &frame)?;
        Ok(frame)
    }
}

impl dyn Communicator + '_ {
    /// Sends a request of numbers.
    pub fn tell(
        &mut self,
        peer: usize,
        kind: Kind,
        window: &Window,
        payload: Vec<f64>,
    ) -> Result<(), Error> {
        let header = self.peers().header(peer, kind, window);
        self.send(peer, header, payload)
    }

    /// Sends a request that is a text.
    pub fn tell_text(&mut self, peer: usize, kind: Kind, text: &str) -> Result<(), Error> {
        let header = self.peers().header(peer, kind, &Window::default());
        self.send(peer, header, Frame::with_text(header, text).payload)
    }

    /// Asks all for the same at once, so that they work side by side, and reads their answers.
    pub fn ask_all<T>(
        &mut self,
        (kind, answer): (Kind, Kind),
        payload: &[f64],
        read: impl Fn(&Frame) -> Result<T, String>,
    ) -> Result<Vec<T>, Error> {
        let count = self.peers().count();
        for peer in 0..count {
            self.tell(peer, kind, &Window::default(), payload.to_vec())?;
        }
        (0..count)
            .map(|peer| {
                let frame = self.receive(peer, answer)?;
                read(&frame).map_err(|why| self.peers().protocol_error(peer, why))
            })
            .collect()
    }

    /// A request of numbers and its answer's numbers.
    pub fn ask(
        &mut self,
        peer: usize,
        (kind, answer): (Kind, Kind),
        window: &Window,
        payload: Vec<f64>,
    ) -> Result<Vec<f64>, Error> {
        self.tell(peer, kind, window, payload)?;
        Ok(self.receive(peer, answer)?.payload)
    }

    /// Waits for an answer that must hold exactly `length` finite numbers.
    pub fn hear_exactly(
        &mut self,
        peer: usize,
        kind: Kind,
        window: &Window,
        length: usize,
    ) -> Result<Vec<f64>, Error> {
        let numbers = self.receive(peer, kind)?.payload;
        if numbers.len() != length {
            let why = format!("answered {} numbers where {length} were due", numbers.len());
            return Err(self.peers().protocol_error(peer, why));
        }
        match numbers.iter().position(|value| !value.is_finite()) {
            None => Ok(numbers),
            Some(index) => Err(Error::NotFinite(format!(
                "participant `{}` answered {} at entry {index} of {kind:?} in window {}, iteration {}: it diverged; lower its step or the window",
                self.peers().name(peer),
                numbers[index],
                window.index,
                window.iteration
            ))),
        }
    }
}

/// All participants of a run, in the order of the scenario.
pub struct Peers {
    peers: Vec<Peer>,
    /// Held as long as they live, and swept after them.
    _memory: Option<SharedMemory>,
    /// Identity of the run.
    pub run_id: u64,
    /// Labels that the exchange with each participant is recorded under.
    pub labels: Vec<Label>,
    deadlines: Deadlines,
    /// Signals that end the run.
    pub watch: Watch,
}

impl Peers {
    /// Some or all participants of this scenario in the run `run_id`.
    pub fn new(
        peers: Vec<Peer>,
        memory: Option<SharedMemory>,
        run_id: u64,
        scenario: &Scenario,
        watch: Watch,
    ) -> Peers {
        Peers {
            labels: peers.iter().map(|p| scenario.label(&p.name)).collect(),
            peers,
            _memory: memory,
            run_id,
            deadlines: scenario.run.deadlines.clone(),
            watch,
        }
    }

    /// Number of participants.
    pub fn count(&self) -> usize {
        self.peers.len()
    }

    /// Name of a participant in the scenario.
    pub fn name(&self, peer: usize) -> &str {
        &self.peers[peer].name
    }

    /// A participant itself.
    pub fn peer(&mut self, peer: usize) -> &mut Peer {
        &mut self.peers[peer]
    }

    /// Times in which the coordinator did nothing but wait, for each participant.
    pub fn awaited(&self) -> Vec<BusyTimes> {
        self.peers.iter().map(|peer| peer.awaited.clone()).collect()
    }

    /// Length of these times so far (ns), for each participant.
    pub fn waited_ns(&self) -> Vec<u64> {
        self.peers.iter().map(|peer| peer.waited_ns).collect()
    }

    /// The instant of the last answer (ns of the monotonic clock).
    pub fn heard_ns(&self) -> u64 {
        let instants = self.peers.iter().map(|peer| peer.heard_ns);
        instants.max().unwrap_or(0)
    }

    /// Keeps the times of the requests from now on.
    pub fn keep_times(&mut self) {
        for peer in &mut self.peers {
            peer.times = Some(Vec::new());
        }
    }

    /// Keeps them no more.
    pub fn forget_times(&mut self) {
        for peer in &mut self.peers {
            peer.times = None;
        }
    }

    /// The error of an answer that does not belong here.
    pub fn protocol_error(&self, peer: usize, why: impl Into<String>) -> Error {
        self.peers[peer].protocol_error(why.into())
    }

    /// The header of a request about a window.
    pub fn header(&self, peer: usize, kind: Kind, window: &Window) -> Header {
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

    /// Sends a request and returns its frame.
    fn transmit(&mut self, peer: usize, header: Header, payload: Vec<f64>) -> Result<Frame, Error> {
        let greeting = header.kind == Kind::Hello as u32;
        let wait = wait(&self.deadlines, &self.watch, greeting);
        self.peers[peer].send(header, payload, &wait)
    }

    /// Sends a request that will be told next, while the peer still answers the one before: it then need not sleep in
    /// between, and what the coordinator does with that answer costs no time.
    pub fn send_early(
        &mut self,
        peer: usize,
        header: Header,
        payload: Vec<f64>,
    ) -> Result<(), Error> {
        let wait = wait(&self.deadlines, &self.watch, false);
        self.peers[peer].send_early(header, payload, &wait)
    }

    fn await_answer(&mut self, peer: usize, kind: Kind) -> Result<Frame, Error> {
        let wait = wait(&self.deadlines, &self.watch, kind == Kind::Welcome);
        let frame = self.peers[peer].receive(kind, &wait)?;
        if frame.header.run_id == self.run_id {
            return Ok(frame);
        }
        let (theirs, ours) = (frame.header.run_id, self.run_id);
        let why = format!("answered for run {theirs:016x}, this is run {ours:016x}");
        Err(self.protocol_error(peer, why))
    }
}

impl Communicator for Peers {
    fn peers(&self) -> &Peers {
        self
    }

    fn peers_mut(&mut self) -> &mut Peers {
        self
    }
}

/// Set-ups take longer than answers.
fn wait<'a>(deadlines: &Deadlines, watch: &'a Watch, greeting: bool) -> Wait<'a> {
    let (seconds, key) = if greeting {
        (deadlines.setup_s, "setup_s")
    } else {
        (deadlines.answer_s, "answer_s")
    };
    Wait {
        seconds,
        key,
        watch,
    }
}
