//! Participants behind a communicator: every request is a frame, and every answer is checked.

use nalgebra::DMatrix;
use protocol::frame::packed;
use protocol::serve::unpack_boundary_answer;
use protocol::{BoundaryAnswer, Description, Kind, Reaction, Surface, Window};

use super::admission::{fault_of_columns, fault_of_surface};
use super::communicator::Communicator;
use super::handshake::Greeted;
use scheme::error::Result;
use scheme::participants::{HeatRequest, Participants, Request};

/// The participants of a run as schemes see them.
pub struct Remote<'a> {
    communicator: &'a mut dyn Communicator,
    greeted: &'a [Greeted],
}

impl<'a> Remote<'a> {
    /// Participants that answered the greeting, in the order of the scenario.
    pub fn new(communicator: &'a mut dyn Communicator, greeted: &'a [Greeted]) -> Remote<'a> {
        Remote {
            communicator,
            greeted,
        }
    }

    /// A matrix (n x n, column-major) of a window.
    fn columns(
        &mut self,
        peer: usize,
        (kind, answer): (Kind, Kind),
        window: &Window,
        n: usize,
    ) -> Result<DMatrix<f64>> {
        self.communicator.send(peer, kind, window, &[])?;
        let numbers = self.numbers(peer, answer, window, n * n)?;
        let matrix = DMatrix::from_vec(n, n, numbers);
        match fault_of_columns(&matrix) {
            None => Ok(matrix),
            Some(why) => Err(self.communicator.peers().protocol_error(peer, why).into()),
        }
    }

    /// The answer of this kind, with `n` numbers.
    fn numbers(&mut self, peer: usize, kind: Kind, window: &Window, n: usize) -> Result<Vec<f64>> {
        let numbers = self.communicator.receive_numbers(peer, kind, window, n);
        Ok(numbers?)
    }
}

impl Participants for Remote<'_> {
    fn count(&self) -> usize {
        self.greeted.len()
    }

    fn name(&self, peer: usize) -> &str {
        self.communicator.peers().name(peer)
    }

    fn description(&self, peer: usize) -> &Description {
        &self.greeted[peer].description
    }

    fn couple(&mut self, peer: usize, set: &str) -> Result<Surface> {
        let kinds = (Kind::Couple, Kind::Surface);
        let window = Window::default();
        let answer = self.communicator.ask(peer, kinds, &window, packed(set))?;
        let surface = Surface::from_rows(&answer.payload);
        let why = match surface.as_ref().map(fault_of_surface) {
            None => "sent an incomplete surface".into(),
            Some(Some(why)) => why,
            Some(None) => return Ok(surface.expect("it was just looked at")),
        };
        Err(self.communicator.peers().protocol_error(peer, why).into())
    }

    fn select(&mut self, peer: usize, points: &[usize]) -> Result<()> {
        let indices: Vec<f64> = points.iter().map(|index| *index as f64).collect();
        let (kinds, window) = ((Kind::Select, Kind::Ready), Window::default());
        self.communicator.ask(peer, kinds, &window, indices)?;
        Ok(())
    }

    fn compliance(&mut self, peer: usize, window: &Window, n: usize) -> Result<DMatrix<f64>> {
        self.columns(peer, (Kind::Columns, Kind::Compliance), window, n)
    }

    fn impedance(&mut self, peer: usize, window: &Window, n: usize) -> Result<DMatrix<f64>> {
        self.columns(peer, (Kind::ImpedanceColumns, Kind::Impedance), window, n)
    }

    fn set_boundary(
        &mut self,
        peer: usize,
        window: &Window,
        window_s: f64,
        compliance: &DMatrix<f64>,
    ) -> Result<()> {
        let payload = [&[window_s], compliance.as_slice()].concat();
        let kinds = (Kind::CompliantBoundary, Kind::Ready);
        self.communicator.ask(peer, kinds, window, payload)?;
        Ok(())
    }

    fn begin(&mut self, peer: usize, window: &Window, request: Request) -> Result<()> {
        let (kind, numbers) = match request {
            Request::Advance(force) => (Kind::Advance, force),
            Request::PrescribeVelocity(velocity) => (Kind::PrescribeVelocity, velocity),
            Request::Solve(free_velocity) => (Kind::Solve, free_velocity),
        };
        Ok(self.communicator.send(peer, kind, window, numbers)?)
    }

    fn finish_advance(&mut self, peer: usize, window: &Window, n: usize) -> Result<Vec<f64>> {
        self.numbers(peer, Kind::Motion, window, n)
    }

    fn finish_prescribed_velocity(
        &mut self,
        peer: usize,
        window: &Window,
        n: usize,
    ) -> Result<Reaction> {
        let numbers = self.numbers(peer, Kind::Reaction, window, 3 * n)?;
        Ok(Reaction {
            force: numbers[..n].to_vec(),
            increment: numbers[n..2 * n].to_vec(),
            work: numbers[2 * n..].to_vec(),
        })
    }

    fn finish_solve(&mut self, peer: usize, window: &Window, n: usize) -> Result<BoundaryAnswer> {
        self.communicator.while_solving()?;
        let numbers = self.numbers(peer, Kind::Force, window, 2 * n + 3)?;
        Ok(unpack_boundary_answer(&numbers, n))
    }

    fn accept(&mut self, peer: usize, window: &Window, displacement: &[f64]) -> Result<()> {
        let communicator = &mut self.communicator;
        Ok(communicator.send(peer, Kind::Commit, window, displacement)?)
    }

    fn begin_early(&mut self, peer: usize, window: &Window, force: &[f64]) -> Result<()> {
        let peers = self.communicator.peers_mut();
        Ok(peers.send_early(peer, Kind::Advance, window, force)?)
    }

    fn exchange_heat(
        &mut self,
        peer: usize,
        window: &Window,
        request: HeatRequest,
    ) -> Result<Vec<f64>> {
        let (kind, answer, numbers, each) = match request {
            HeatRequest::Heat(heat) => (Kind::TakeHeat, Kind::Temperatures, heat, 1),
            HeatRequest::Temperatures(kelvins) => {
                (Kind::TakeTemperatures, Kind::HeatGiven, kelvins, 2)
            }
        };
        self.communicator.send(peer, kind, window, numbers)?;
        self.numbers(peer, answer, window, each * numbers.len())
    }

    fn report(&mut self, peer: usize) -> Result<Vec<f64>> {
        Ok(self.communicator.receive(peer, Kind::Report)?.payload)
    }
}
