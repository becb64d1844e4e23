//! Requests and answers between the coordinator and its participants.

use protocol::{Frame, Header, Kind, PROTOCOL_VERSION, Window};

use super::peer::{Peer, Wait};
use super::watch::Watch;
use crate::error::Error;
use crate::scenario::{Deadlines, Label};

/// A way to speak to all participants of a run, frame by frame. [`Peers`] is the plain one; recording and rehearsing are wrapped
/// around it.
pub trait Communicator {
    /// The participants themselves.
    fn peers(&self) -> &Peers;

    /// Sends a request whose turn has come.
    fn send(&mut self, peer: usize, header: Header, payload: Vec<f64>) -> Result<(), Error>;

    /// Sends a request that will be told next, while the peer still answers the one before: it then need not sleep in
    /// between, and what the coordinator does with that answer costs no time.
    fn send_early(&mut self, peer: usize, header: Header, payload: Vec<f64>) -> Result<(), Error>;

    /// Waits for the answer of this kind.
    fn receive(&mut self, peer: usize, kind: Kind) -> Result<Frame, Error>;

    /// Closes a window.
    fn end_window(&mut self, window: u64) -> Result<(), Error> {
        let _ = window;
        Ok(())
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

    /// A request of numbers and its answer's numbers, which are about the same window.
    pub fn ask(
        &mut self,
        peer: usize,
        (kind, answer): (Kind, Kind),
        window: &Window,
        payload: Vec<f64>,
    ) -> Result<Vec<f64>, Error> {
        self.tell(peer, kind, window, payload)?;
        self.hear(peer, answer, window)
    }

    /// Waits for the answer of this kind about this window.
    pub fn hear(&mut self, peer: usize, kind: Kind, window: &Window) -> Result<Vec<f64>, Error> {
        let frame = self.receive(peer, kind)?;
        if (frame.header.window, frame.header.iteration) != (window.index, window.iteration) {
            return Err(self.peers().protocol_error(
                peer,
                format!(
                    "answered for window {}, iteration {}",
                    frame.header.window, frame.header.iteration
                ),
            ));
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
        let numbers = self.hear(peer, kind, window)?;
        if numbers.len() != length {
            return Err(self.peers().protocol_error(
                peer,
                format!("answered {} numbers where {length} were due", numbers.len()),
            ));
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
    run_id: u64,
    labels: Vec<Label>,
    deadlines: Deadlines,
    /// Signals that end the run.
    pub watch: Watch,
    /// Whether requests may be sent before their turn.
    pub pipelined: bool,
}

impl Peers {
    /// The participants of the run `run_id`, whose frames go under their labels, one a peer.
    pub fn new(
        peers: Vec<Peer>,
        run_id: u64,
        labels: Vec<Label>,
        deadlines: &Deadlines,
        watch: Watch,
    ) -> Peers {
        Peers {
            peers,
            run_id,
            labels,
            deadlines: deadlines.clone(),
            watch,
            pipelined: false,
        }
    }

    /// Number of participants.
    pub fn count(&self) -> usize {
        self.peers.len()
    }

    /// Identity of the run.
    pub fn run_id(&self) -> u64 {
        self.run_id
    }

    /// Name of a participant in the scenario.
    pub fn name(&self, peer: usize) -> &str {
        self.peers[peer].name()
    }

    /// Label that the exchange with a participant is recorded under.
    pub fn label(&self, peer: usize) -> &Label {
        &self.labels[peer]
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
    pub fn transmit(
        &mut self,
        peer: usize,
        header: Header,
        payload: Vec<f64>,
    ) -> Result<Frame, Error> {
        let wait = wait(
            &self.deadlines,
            &self.watch,
            header.kind == Kind::Hello as u32,
        );
        self.peers[peer].send(header, payload, &wait)
    }
}

impl Communicator for Peers {
    fn peers(&self) -> &Peers {
        self
    }

    fn send(&mut self, peer: usize, header: Header, payload: Vec<f64>) -> Result<(), Error> {
        self.transmit(peer, header, payload).map(|_| ())
    }

    fn send_early(&mut self, peer: usize, header: Header, payload: Vec<f64>) -> Result<(), Error> {
        if !self.pipelined {
            return Ok(());
        }
        let wait = wait(&self.deadlines, &self.watch, false);
        self.peers[peer].send_early(header, payload, &wait)
    }

    fn receive(&mut self, peer: usize, kind: Kind) -> Result<Frame, Error> {
        let wait = wait(&self.deadlines, &self.watch, kind == Kind::Welcome);
        let frame = self.peers[peer].receive(kind, &wait)?;
        if frame.header.run_id == self.run_id {
            return Ok(frame);
        }
        Err(self.protocol_error(
            peer,
            format!(
                "answered for run {:016x}, this is run {:016x}",
                frame.header.run_id, self.run_id
            ),
        ))
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
