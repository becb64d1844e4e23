//! Requests and answers between the coordinator and its participants.
//!
//! A request goes from the trait that schemes use ([`Remote`](super::remote::Remote)) to `send` of a [`Communicator`],
//! from there to [`Peer::send`], and onto the link.

use std::borrow::Cow;

use protocol::busy::BusyTimes;
use protocol::{Frame, Header, Kind, PROTOCOL_VERSION, Window};

use super::network::Network;
use super::peer::{Far, Peer, Wait};
use super::process::SharedMemory;
use super::watch::Watch;
use crate::events::Listener;
use runs::plausible;
use runs::warning::Warning;
use scenario::error::{Error, Result};
use scenario::keys::{Deadlines, Label, Scenario};

/// Communication with all participants of a run, frame by frame. [`Peers`] is the plain implementation; others wrap it,
/// see every frame, and record the exchange or compare it with a log.
pub trait Communicator {
    /// The participants themselves.
    fn peers(&self) -> &Peers;

    /// The participants, for sending and receiving.
    fn peers_mut(&mut self) -> &mut Peers;

    /// Notes a frame: a request whose turn has come, or an answer.
    fn passed(&mut self, peer: usize, by: SentBy, frame: Cow<Frame>) -> Result<()> {
        let _ = (peer, by, frame);
        Ok(())
    }

    /// Does background work while contacts are solved.
    fn while_solving(&mut self) -> Result<()> {
        Ok(())
    }

    /// Closes a window.
    fn end_window(&mut self, window: u64) -> Result<()> {
        let _ = window;
        Ok(())
    }
}

/// The sender of a frame between the coordinator and one of its participants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SentBy {
    /// A request.
    Coordinator,
    /// An answer.
    Participant,
}

impl dyn Communicator + '_ {
    /// Sends a request whose turn has come. A borrowed payload is copied only if the request was not sent early.
    pub fn send<'p>(
        &mut self,
        peer: usize,
        kind: Kind,
        window: &Window,
        payload: impl Into<Cow<'p, [f64]>>,
    ) -> Result<()> {
        let header = self.peers().header(peer, kind, window);
        let (to, wait) = self.peers_mut().waiting(peer, kind == Kind::Hello);
        let frame = to.send(header, payload.into(), &wait)?;
        to.keep_request(&frame);
        self.passed(peer, SentBy::Coordinator, Cow::Owned(frame))
    }

    /// Waits for the answer of this kind.
    pub fn receive(&mut self, peer: usize, kind: Kind) -> Result<Frame> {
        let (from, wait) = self.peers_mut().waiting(peer, kind == Kind::Welcome);
        let frame = from.receive(kind, &wait)?;
        let (theirs, ours) = (frame.header.run_id, self.peers().run_id);
        if theirs != ours {
            let why = format!("answered for run {theirs:016x}, but this is run {ours:016x}");
            return Err(self.peers().protocol_error(peer, why));
        }
        self.passed(peer, SentBy::Participant, Cow::Borrowed(&frame))?;
        Ok(frame)
    }

    /// Sends the same request to all at once, so that they work in parallel, and reads their answers.
    pub fn ask_all<T>(
        &mut self,
        (kind, answer): (Kind, Kind),
        payload: &[f64],
        read: impl Fn(&Frame) -> Result<T, String>,
    ) -> Result<Vec<T>> {
        let count = self.peers().count();
        for peer in 0..count {
            self.send(peer, kind, &Window::default(), payload)?;
        }
        let answer = |peer| {
            let frame = self.receive(peer, answer)?;
            read(&frame).map_err(|why| self.peers().protocol_error(peer, why))
        };
        (0..count).map(answer).collect()
    }

    /// Sends a request with numbers and waits for its answer.
    pub fn ask<'p>(
        &mut self,
        peer: usize,
        (kind, answer): (Kind, Kind),
        window: &Window,
        payload: impl Into<Cow<'p, [f64]>>,
    ) -> Result<Frame> {
        self.send(peer, kind, window, payload)?;
        self.receive(peer, answer)
    }

    /// Waits for an answer that must hold exactly `length` finite numbers.
    pub fn receive_numbers(
        &mut self,
        peer: usize,
        kind: Kind,
        window: &Window,
        length: usize,
    ) -> Result<Vec<f64>> {
        let numbers = self.receive(peer, kind)?.payload;
        let came = numbers.len();
        if came != length {
            let why = format!("answered with {came} numbers instead of {length}");
            return Err(self.peers().protocol_error(peer, why));
        }
        match numbers.iter().position(|value| !value.is_finite()) {
            None => {
                let (from, wait) = self.peers_mut().waiting(peer, false);
                let apart = from.ask_again(kind, &numbers, &wait)?;
                let finding = plausible::repeat(window.index, apart);
                let warning = finding.map(|finding| Warning::of(&from.name, finding));
                self.peers_mut().found.extend(warning);
                Ok(numbers)
            }
            Some(index) => Err(Error::NotFinite(format!(
                "participant `{}` answered with {} at entry {index} of {kind:?} in window {}, iteration {}: it diverged; shorten its step or the window",
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
    /// Kept while they live, and removed after them.
    _memory: Option<SharedMemory>,
    /// The endpoint for participants on other hosts.
    pub(crate) network: Option<Network>,
    /// Identity of the run.
    pub run_id: u64,
    /// Labels for recording the exchange with each participant.
    pub labels: Vec<Label>,
    deadlines: Deadlines,
    /// Receives events about long set-ups.
    pub listener: Listener,
    /// Signals that end the run.
    pub watch: Watch,
    /// Warnings about answers, not yet passed on.
    pub found: Vec<Warning>,
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
            network: None,
            run_id,
            deadlines: scenario.run.deadlines.clone(),
            watch,
            listener: Listener::default(),
            found: Vec::new(),
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

    /// Attempts of other programs, each with the participant or endpoint concerned.
    pub fn strangers(&self) -> Vec<(String, String)> {
        let peers = self.peers.iter();
        let peers = peers.map(|peer| (&*peer.name, peer.strangers()));
        let network = self.network.iter();
        let network = network.map(|network| (network.endpoint(), network.complaints()));
        let named = |(about, tried): (&str, Vec<String>)| {
            let about = about.to_string();
            tried.into_iter().map(move |tried| (about.clone(), tried))
        };
        peers.chain(network).flat_map(named).collect()
    }

    /// Hosts and round trips of participants on other hosts; `None` for participants on this host.
    pub fn far(&self) -> impl Iterator<Item = &Option<Far>> {
        self.peers.iter().map(|peer| &peer.far)
    }

    /// Times in which the coordinator only waited, for each participant.
    pub fn awaited(&self) -> Vec<BusyTimes> {
        self.peers.iter().map(|peer| peer.awaited.clone()).collect()
    }

    /// Length of these times so far (ns), for each participant.
    pub fn waited_ns(&self) -> Vec<u64> {
        self.peers.iter().map(|peer| peer.waited_ns).collect()
    }

    /// The instant of the last answer (ns of the monotonic clock).
    pub fn last_answer_ns(&self) -> u64 {
        let instants = self.peers.iter().map(|peer| peer.last_answer_ns);
        instants.max().unwrap_or(0)
    }

    /// Switches the recording of request times on or off.
    pub fn keep_times(&mut self, kept: bool) {
        for peer in &mut self.peers {
            peer.times = kept.then(Vec::new);
        }
    }

    /// The error for an answer out of place.
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

    /// Sends the next request while the peer still answers the one before. The peer then need not sleep in between, and
    /// the coordinator's work on that answer costs no time.
    pub fn send_early(
        &mut self,
        peer: usize,
        kind: Kind,
        window: &Window,
        payload: &[f64],
    ) -> Result<()> {
        let header = self.header(peer, kind, window);
        let (to, wait) = self.waiting(peer, false);
        to.send_early(header, payload, &wait)
    }

    /// A participant and the wait for its answer. A greeting includes the set-up, which takes longer than other
    /// answers.
    fn waiting(&mut self, peer: usize, greeting: bool) -> (&mut Peer, Wait<'_>) {
        let (seconds, key) = if greeting {
            (self.deadlines.setup_s, "setup_s")
        } else {
            (self.deadlines.answer_s, "answer_s")
        };
        let wait = Wait {
            seconds,
            key,
            watch: &self.watch,
            listener: Some(&self.listener).filter(|_| greeting),
        };
        (&mut self.peers[peer], wait)
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
