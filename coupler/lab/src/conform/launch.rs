//! One launch of the tested participant, from its greeting to its farewell.

use std::time::{Duration, Instant};

use nalgebra::DMatrix;
use protocol::frame::packed;
use protocol::serve::Farewell;
use protocol::{Frame, Kind, NodeError, Reaction, Surface, Window};

use super::tested::{Part, TestedParticipant};
use coordinator::participants::farewell::read_farewell;
use coordinator::participants::handshake::Greeted;
use coordinator::participants::process::Process;
use coordinator::participants::remote::Remote;
use coordinator::participants::{Communicator, Peers};
use scenario::error::Error;
use scheme::join::append;
use scheme::participants::{HeatRequest, Participants, Request};

/// The only participant.
const IT: usize = 0;

/// A launched participant, joined and ready for its first window.
pub struct Launch<'a> {
    tested: &'a TestedParticipant<'a>,
    peers: Peers,
    greeted: Vec<Greeted>,
    /// Points of the participant, set after set.
    pub surface: Surface,
    /// Number of exchanged points.
    exchanged: usize,
    /// Displacement (m) of the points of a motion-driven participant.
    pub displacement: Vec<f64>,
    launched: Instant,
}

/// The end of a launch.
pub struct LaunchEnd {
    /// The farewell.
    pub farewell: Farewell,
    /// Time from the launch to the farewell.
    pub lived: Duration,
}

impl<'a> Launch<'a> {
    /// Launches the participant and couples its sets with all their points.
    pub fn new(tested: &'a TestedParticipant<'a>, threads: usize) -> Result<Launch<'a>, Error> {
        Launch::exchanging(tested, threads, |_| true)
    }

    /// The same with only the chosen points.
    pub fn exchanging(
        tested: &'a TestedParticipant<'a>,
        threads: usize,
        chosen: impl Fn(usize) -> bool,
    ) -> Result<Launch<'a>, Error> {
        let launched = Instant::now();
        let (peers, greeted) = tested.launcher.launch(tested.participant, threads)?;
        let mut launch = Launch {
            tested,
            peers,
            greeted: vec![greeted],
            surface: Surface::default(),
            exchanged: 0,
            displacement: Vec::new(),
            launched,
        };
        for set in &tested.sets {
            let surface = launch.remote().couple(IT, set)?;
            append(&mut launch.surface, &surface);
        }
        if tested.part != Part::Alone {
            let mut points = Vec::from_iter(0..launch.surface.len());
            points.retain(|point| chosen(*point));
            launch.exchanged = points.len();
            launch.remote().select(IT, &points)?;
        }
        if tested.part == Part::MotionDriven {
            launch.displacement = vec![0.0; launch.size()];
        }
        launch.repeat_boundary()?;
        Ok(launch)
    }

    /// The participant through the port that schemes use.
    pub fn remote(&mut self) -> Remote<'_> {
        Remote::new(&mut self.peers, &self.greeted)
    }

    fn speak(&mut self) -> &mut dyn Communicator {
        &mut self.peers
    }

    /// Number of exchanged components.
    pub fn size(&self) -> usize {
        2 * self.exchanged
    }

    /// Window `index`, with the length in the scenario.
    pub fn window(&self, index: u64) -> Window {
        let clock = &self.tested.clock;
        clock.window(index, index * u64::from(clock.substeps), clock.substeps)
    }

    /// Announces windows of this length (s) and the boundary's compliance (1/kg).
    pub fn set_boundary(&mut self, window_s: f64, compliance: &DMatrix<f64>) -> Result<(), Error> {
        let window = self.window(0);
        let mut remote = self.remote();
        Ok(remote.set_boundary(IT, &window, window_s, compliance)?)
    }

    /// Requests a window under a load: forces (N), or velocities of the boundary (m/s). The answer is displacement increments (m), or forces
    /// (N), velocities (m/s), iterations, residual and convergence.
    pub fn ask(&mut self, window: &Window, load: &[f64]) -> Result<Vec<f64>, Error> {
        let size = self.size();
        let (kind, answer, length) = match self.tested.part {
            Part::Alone => return Ok(Vec::new()),
            Part::ForceDriven => (Kind::Advance, Kind::Motion, size),
            Part::MotionDriven => (Kind::Solve, Kind::Force, 2 * size + 3),
        };
        self.speak().send(IT, kind, window, load)?;
        self.speak().receive_numbers(IT, answer, window, length)
    }

    /// Requests a window and accepts it; returns answer and report.
    pub fn go(&mut self, window: &Window, load: &[f64]) -> Result<(Vec<f64>, Vec<f64>), Error> {
        let answer = self.ask(window, load)?;
        let report = self.accept(window, &answer)?;
        Ok((answer, report))
    }

    /// Accepts the window with this answer and returns the report. A participant that runs alone gets the request for its window here.
    pub fn accept(&mut self, window: &Window, answer: &[f64]) -> Result<Vec<f64>, Error> {
        if self.tested.part == Part::Alone {
            let kinds = (Kind::AdvanceAlone, Kind::Report);
            return Ok(self.speak().ask(IT, kinds, window, &[])?.payload);
        }
        self.accept_without_reading(window, answer)?;
        self.report()
    }

    /// The same without reading the report.
    pub fn accept_without_reading(&mut self, window: &Window, answer: &[f64]) -> Result<(), Error> {
        let (size, length) = (self.displacement.len(), window.t1_s - window.t0_s);
        let velocities = answer.get(size..2 * size).unwrap_or_default();
        for (displacement, velocity) in self.displacement.iter_mut().zip(velocities) {
            *displacement += length * velocity;
        }
        let displacement = self.displacement.clone();
        Ok(self.remote().accept(IT, window, &displacement)?)
    }

    /// Reads the report of the accepted window.
    pub fn report(&mut self) -> Result<Vec<f64>, Error> {
        Ok(self.remote().report(IT)?)
    }

    /// Columns of a window, not checked yet.
    pub fn matrix(
        &mut self,
        (kind, answer): (Kind, Kind),
        window: &Window,
    ) -> Result<DMatrix<f64>, Error> {
        let size = self.size();
        let speak = self.speak();
        speak.send(IT, kind, window, &[])?;
        let numbers = speak.receive_numbers(IT, answer, window, size * size)?;
        Ok(DMatrix::from_vec(size, size, numbers))
    }

    /// Requests a window along velocities (m/s).
    pub fn follow(&mut self, window: &Window, velocity: &[f64]) -> Result<Reaction, Error> {
        let size = self.size();
        let request = Request::PrescribeVelocity(velocity);
        let mut remote = self.remote();
        remote.begin(IT, window, request)?;
        Ok(remote.finish_prescribed_velocity(IT, window, size)?)
    }

    /// Exchanges heat (J) or temperatures (K) after this window.
    pub fn exchange_heat(
        &mut self,
        window: &Window,
        request: HeatRequest,
    ) -> Result<Vec<f64>, Error> {
        Ok(self.remote().exchange_heat(IT, window, request)?)
    }

    /// Sends the request for a window before its turn.
    pub fn ask_early(&mut self, window: &Window, load: &[f64]) -> Result<(), Error> {
        Ok(self.remote().begin_early(IT, window, load)?)
    }

    /// Makes it write its fields.
    pub fn snapshot(&mut self, name: &str) -> Result<(), Error> {
        let kinds = (Kind::Snapshot, Kind::Saved);
        self.request(kinds, &packed(name)).map(|_| ())
    }

    /// Its answer of this kind to a request without a window.
    fn request(&mut self, kinds: (Kind, Kind), payload: &[f64]) -> Result<Frame, Error> {
        self.speak().ask(IT, kinds, &Window::default(), payload)
    }

    /// Its committed state.
    pub fn checkpoint(&mut self) -> Result<Frame, Error> {
        self.request((Kind::Checkpoint, Kind::State), &[])
    }

    /// Restores the state of another launch as the committed one, with the displacement of its points.
    pub fn restore(&mut self, state: &Frame, displacement: &[f64]) -> Result<(), Error> {
        self.displacement = displacement.to_vec();
        let kinds = (Kind::Restore, Kind::Restored);
        self.request(kinds, &state.payload).map(|_| ())
    }

    /// Announces the boundary, as the coordinator also does after a restart.
    pub fn repeat_boundary(&mut self) -> Result<(), Error> {
        if self.tested.part != Part::MotionDriven {
            return Ok(());
        }
        let rigid = DMatrix::zeros(self.size(), self.size());
        let boundary = self.tested.boundary.get().unwrap_or(&rigid);
        self.set_boundary(self.tested.clock.window_s(), boundary)
    }

    /// Couples a set, which need not exist.
    pub fn couple(&mut self, set: &str) -> Result<Surface, Error> {
        Ok(self.remote().couple(IT, set)?)
    }

    /// Requests the farewell.
    pub fn finish(&mut self) -> Result<LaunchEnd, Error> {
        let frame = self.request((Kind::Finish, Kind::Finished), &[])?;
        let farewell = read_farewell(&frame).map_err(|why| self.peers.protocol_error(IT, why))?;
        Ok(LaunchEnd {
            farewell,
            lived: self.launched.elapsed(),
        })
    }

    /// Its process, unless it runs in this process.
    pub fn process(&mut self) -> Option<&mut Process> {
        self.peers.peer(IT).process()
    }

    /// True if its process does not end within a time.
    pub fn outlives(&mut self, time: Duration) -> bool {
        self.process().is_some_and(|it| !it.ends_within(time))
    }

    /// Goes away without a message, like a killed coordinator.
    pub fn hang_up(&mut self) {
        self.peers.peer(IT).hang_up();
    }

    /// The fault in its answer, if there was one.
    pub fn fault(&mut self) -> Option<NodeError> {
        self.peers.peer(IT).fault.clone()
    }
}
