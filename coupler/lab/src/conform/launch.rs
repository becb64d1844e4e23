//! One launch of the participant that is tried, from its greeting to its farewell.

use std::time::{Duration, Instant};

use nalgebra::DMatrix;
use protocol::serve::Farewell;
use protocol::{Frame, Kind, NodeError, Reaction, Surface, Window};

use super::subject::{Part, TestedParticipant};
use coordinator::error::Error;
use coordinator::participants::farewell::read_farewell;
use coordinator::participants::handshake::Greeted;
use coordinator::participants::process::Process;
use coordinator::participants::remote::Remote;
use coordinator::participants::{Communicator, Peers};
use scheme::join::append;
use scheme::participants::{Participants, Request};

/// The only participant.
const IT: usize = 0;

/// A participant that is joined and ready for its first window.
pub struct Launch<'a> {
    subject: &'a TestedParticipant<'a>,
    peers: Peers,
    greeted: Vec<Greeted>,
    /// Its points, set after set.
    pub surface: Surface,
    /// Number of those that are exchanged.
    exchanged: usize,
    /// Displacement (m) of points whose motion it is told.
    place: Vec<f64>,
    born: Instant,
}

/// The end of a life.
pub struct LaunchEnd {
    /// Its last words.
    pub farewell: Farewell,
    /// Time from its launch to the farewell.
    pub lived: Duration,
}

impl<'a> Launch<'a> {
    /// Launches the participant and couples its sets, all points of them.
    pub fn new(subject: &'a TestedParticipant<'a>, threads: usize) -> Result<Launch<'a>, Error> {
        Launch::exchanging(subject, threads, |_| true)
    }

    /// The same with some of its points only.
    pub fn exchanging(
        subject: &'a TestedParticipant<'a>,
        threads: usize,
        chosen: impl Fn(usize) -> bool,
    ) -> Result<Launch<'a>, Error> {
        let born = Instant::now();
        let (peers, greeted) = subject.stage.launch(subject.participant, threads)?;
        let mut life = Launch {
            subject,
            peers,
            greeted: vec![greeted],
            surface: Surface::default(),
            exchanged: 0,
            place: Vec::new(),
            born,
        };
        for set in &subject.sets {
            let surface = life.remote().couple(IT, set)?;
            append(&mut life.surface, &surface);
        }
        if subject.part != Part::Alone {
            let points = (0..life.surface.len()).filter(|point| chosen(*point));
            let points: Vec<usize> = points.collect();
            life.exchanged = points.len();
            life.remote().select(IT, &points)?;
        }
        if subject.part == Part::MotionDriven {
            life.place = vec![0.0; life.size()];
        }
        life.repeat_boundary()?;
        Ok(life)
    }

    /// The participant behind the port that schemes use.
    pub fn remote(&mut self) -> Remote<'_> {
        Remote::new(&mut self.peers, &self.greeted)
    }

    fn speak(&mut self) -> &mut dyn Communicator {
        &mut self.peers
    }

    /// Exchanged components.
    pub fn size(&self) -> usize {
        2 * self.exchanged
    }

    /// Window `index` of the scenario's length.
    pub fn window(&self, index: u64) -> Window {
        let clock = &self.subject.clock;
        clock.window(index, index * u64::from(clock.substeps), clock.substeps)
    }

    /// Announces windows of this length (s) and the boundary's compliance (1/kg).
    pub fn set_boundary(&mut self, window_s: f64, compliance: &DMatrix<f64>) -> Result<(), Error> {
        let window = self.window(0);
        Ok(self
            .remote()
            .set_boundary(IT, &window, window_s, compliance)?)
    }

    /// Asks for a window under a load: forces (N), or velocities of the boundary (m/s). The answer is displacement increments
    /// (m), or forces (N), velocities (m/s), iterations, residual and convergence.
    pub fn ask(&mut self, window: &Window, load: &[f64]) -> Result<Vec<f64>, Error> {
        let size = self.size();
        let (kind, answer, length) = match self.subject.part {
            Part::Alone => return Ok(Vec::new()),
            Part::ForceDriven => (Kind::Advance, Kind::Motion, size),
            Part::MotionDriven => (Kind::Solve, Kind::Force, 2 * size + 3),
        };
        self.speak().tell(IT, kind, window, load.to_vec())?;
        self.speak().hear_exactly(IT, answer, window, length)
    }

    /// Accepts the window that this was the answer for, and returns the report. One that runs alone is asked for its window here.
    pub fn accept(&mut self, window: &Window, answer: &[f64]) -> Result<Vec<f64>, Error> {
        if self.subject.part == Part::Alone {
            let kinds = (Kind::AdvanceAlone, Kind::Report);
            return self.speak().ask(IT, kinds, window, Vec::new());
        }
        self.accept_without_reading(window, answer)?;
        self.report()
    }

    /// The same, the report being read later.
    pub fn accept_without_reading(&mut self, window: &Window, answer: &[f64]) -> Result<(), Error> {
        let (size, length) = (self.place.len(), window.t1_s - window.t0_s);
        let velocities = answer.get(size..2 * size).unwrap_or_default();
        for (place, velocity) in self.place.iter_mut().zip(velocities) {
            *place += length * velocity;
        }
        let place = self.place.clone();
        Ok(self.remote().accept(IT, window, &place)?)
    }

    /// Reads the report of the window that was accepted.
    pub fn report(&mut self) -> Result<Vec<f64>, Error> {
        Ok(self.remote().report(IT)?)
    }

    /// Columns of a window, not yet judged.
    pub fn matrix(
        &mut self,
        (kind, answer): (Kind, Kind),
        window: &Window,
    ) -> Result<DMatrix<f64>, Error> {
        let size = self.size();
        let speak = self.speak();
        speak.tell(IT, kind, window, Vec::new())?;
        let numbers = speak.hear_exactly(IT, answer, window, size * size)?;
        Ok(DMatrix::from_vec(size, size, numbers))
    }

    /// A window along velocities (m/s).
    pub fn follow(&mut self, window: &Window, velocity: &[f64]) -> Result<Reaction, Error> {
        let size = self.size();
        let request = Request::PrescribeVelocity(velocity);
        let mut remote = self.remote();
        remote.begin(IT, window, request)?;
        Ok(remote.finish_prescribed_velocity(IT, window, size)?)
    }

    /// Sends the request for a window before its turn.
    pub fn ask_early(&mut self, window: &Window, load: &[f64]) -> Result<(), Error> {
        Ok(self.remote().begin_early(IT, window, load)?)
    }

    /// Lets it write its fields.
    pub fn snapshot(&mut self, name: &str) -> Result<(), Error> {
        self.speak().tell_text(IT, Kind::Snapshot, name)?;
        self.speak().receive(IT, Kind::Saved).map(|_| ())
    }

    /// Its committed state.
    pub fn checkpoint(&mut self) -> Result<Frame, Error> {
        let window = Window::default();
        self.speak()
            .tell(IT, Kind::Checkpoint, &window, Vec::new())?;
        self.speak().receive(IT, Kind::State)
    }

    /// Makes a state of another life the committed one, its points being where those were.
    pub fn restore(&mut self, state: &Frame, place: &[f64]) -> Result<(), Error> {
        self.place = place.to_vec();
        let window = Window::default();
        let payload = state.payload.clone();
        self.speak().tell(IT, Kind::Restore, &window, payload)?;
        self.speak().receive(IT, Kind::Restored).map(|_| ())
    }

    /// Announces the boundary; once more as the coordinator does after a restart.
    pub fn repeat_boundary(&mut self) -> Result<(), Error> {
        if self.subject.part != Part::MotionDriven {
            return Ok(());
        }
        let rigid = DMatrix::zeros(self.size(), self.size());
        let boundary = self.subject.boundary.get().unwrap_or(&rigid);
        self.set_boundary(self.subject.clock.window_s(), boundary)
    }

    /// Displacement (m) of points whose motion it is told.
    pub fn place(&self) -> Vec<f64> {
        self.place.clone()
    }

    /// Couples a set, whether there is one of this name or not.
    pub fn couple(&mut self, set: &str) -> Result<Surface, Error> {
        Ok(self.remote().couple(IT, set)?)
    }

    /// Says farewell.
    pub fn finish(&mut self) -> Result<LaunchEnd, Error> {
        let window = Window::default();
        self.speak().tell(IT, Kind::Finish, &window, Vec::new())?;
        let frame = self.speak().receive(IT, Kind::Finished)?;
        let farewell = read_farewell(&frame).map_err(|why| {
            let why = format!("sent an outcome that cannot be read: {why}");
            self.peers.protocol_error(IT, why)
        })?;
        Ok(LaunchEnd {
            farewell,
            lived: self.born.elapsed(),
        })
    }

    /// Its process, unless it lives in this one.
    pub fn process(&mut self) -> Option<&mut Process> {
        self.peers.peer(IT).process()
    }

    /// Goes away without a word, as a coordinator does that is killed.
    pub fn hang_up(&mut self) {
        self.peers.peer(IT).hang_up();
    }

    /// The fault that it answered, if it did.
    pub fn fault(&mut self) -> Option<NodeError> {
        self.peers.peer(IT).fault.clone()
    }
}
