//! The trait through which schemes call the participants of a run.
//!
//! A participant is identified by its index in the scenario. The force-driven one takes forces and answers with motion.
//! The motion-driven one solves its contacts on a boundary whose motion it gets. Pairs of requests to begin and to
//! finish let several participants work at the same time: in between a scheme may begin others. Vectors hold two
//! components a point, `(x0, y0, x1, y1, ...)`.

use nalgebra::DMatrix;
use protocol::{BoundaryAnswer, Description, Reaction, Surface, Window};

use crate::error::{Result, Unfit};

/// A window as requested from a participant, by component.
#[derive(Clone, Copy, Debug)]
pub enum Request<'a> {
    /// Under a constant force (N).
    Advance(&'a [f64]),
    /// Along a velocity that is linear in time and ends at this one (m/s).
    PrescribeVelocity(&'a [f64]),
    /// A contact solve on a boundary with this free velocity a_g (m/s).
    Solve(&'a [f64]),
}

/// Heat or temperatures of a participant's exchanged points, one number a point.
#[derive(Clone, Copy, Debug)]
pub enum HeatRequest<'a> {
    /// Heat that has entered a continuum (J); it answers its temperatures (K).
    Heat(&'a [f64]),
    /// Temperatures of the boundary of a layer (K); it answers the heat that has left there (J), and then its heat per kelvin (J/K).
    Temperatures(&'a [f64]),
}

/// The participants of a run, in any process.
///
/// Between two calls of [`Participants::accept`] every request starts from the last accepted state.
pub trait Participants {
    /// Number of participants.
    fn count(&self) -> usize;

    /// Name in the scenario, for messages.
    fn name(&self, peer: usize) -> &str;

    /// Its description at the handshake.
    fn description(&self, peer: usize) -> &Description;

    /// Couples a named set and returns its points.
    fn couple(&mut self, peer: usize, set: &str) -> Result<Surface>;

    /// Restricts the exchange to these points of all coupled sets.
    fn select(&mut self, peer: usize, points: &[usize]) -> Result<()>;

    /// Condensed compliance C (m/N), n x n, of a first window like this one in the participant's own steps; n counts
    /// its exchanged components.
    fn compliance(&mut self, peer: usize, window: &Window, n: usize) -> Result<DMatrix<f64>>;

    /// Impedance D (kg/s), n x n, of such a window.
    fn impedance(&mut self, peer: usize, window: &Window, n: usize) -> Result<DMatrix<f64>>;

    /// Announces windows of length H (s), like this one, and the boundary's compliance W_g (1/kg), n x n, in them: v_g
    /// = a_g + W_g p. It is zero for a boundary with prescribed motion.
    fn set_boundary(
        &mut self,
        peer: usize,
        window: &Window,
        window_s: f64,
        compliance: &DMatrix<f64>,
    ) -> Result<()>;

    /// Begins a window.
    fn begin(&mut self, peer: usize, window: &Window, request: Request) -> Result<()>;

    /// Displacement increments (m) of the window begun under a force; `n` components.
    fn finish_advance(&mut self, peer: usize, window: &Window, n: usize) -> Result<Vec<f64>>;

    /// Reaction of the window begun along a velocity; `n` components.
    fn finish_prescribed_velocity(
        &mut self,
        peer: usize,
        window: &Window,
        n: usize,
    ) -> Result<Reaction>;

    /// Answer of the contact solve begun; `n` components.
    fn finish_solve(&mut self, peer: usize, window: &Window, n: usize) -> Result<BoundaryAnswer>;

    /// Makes the last answer for this window the state; `displacement` (m) is the boundary's, empty for a force-driven
    /// participant.
    fn accept(&mut self, peer: usize, window: &Window, displacement: &[f64]) -> Result<()>;

    /// Lets the participant begin the advance that will be requested next, as soon as it has accepted.
    fn begin_early(&mut self, peer: usize, window: &Window, force: &[f64]) -> Result<()> {
        let _ = (peer, window, force);
        Ok(())
    }

    /// Exchanges heat and temperatures between two windows; the answer has one number a point, or two of a layer. A participant without heat is not asked.
    fn exchange_heat(
        &mut self,
        peer: usize,
        window: &Window,
        request: HeatRequest,
    ) -> Result<Vec<f64>> {
        let _ = (window, request);
        let problem = "has no heat to exchange";
        Err(Unfit::participant(self.name(peer), problem).into())
    }

    /// The report of an accepted window: signals, then energies (J).
    fn report(&mut self, peer: usize) -> Result<Vec<f64>>;
}
