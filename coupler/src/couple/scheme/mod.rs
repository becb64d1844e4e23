//! One window of each coupling scheme.
//!
//! - [`compliance`]: what the coupler believes of the continuum's compliance;
//! - `dual_schur`: one force a window, equal displacements at its end;
//! - `fixed_point`: motion one way, force the other, repeated or not;
//! - [`acceleration`]: what a fixed-point iteration makes of its last answers.

use protocol::serve::unpack_wall_answer;
use protocol::{Kind, WallAnswer, Window};

use super::conversation::Conversation;
use super::handshake::Joined;
use super::ledger::{InterfaceLedger, WindowEntry, largest_difference};
use crate::error::Error;
use crate::scenario::{Interface, Policy, Scheme};
use compliance::{Compliance, tell_wall};

pub mod acceleration;
pub mod compliance;
mod dual_schur;
mod fixed_point;

/// `dual-schur-cheap` never looks back, so its compliance errs to the soft side, which is far safer than too stiff.
const CHEAP_FACTOR: f64 = 1.2;

/// The coupler's own state: it changes only when a window stands.
#[derive(Clone, Debug)]
pub struct Coupling {
    interface: Interface,
    joined: Joined,
    compliance: Compliance,
    /// Window length that a wall without compliance was told of (substeps).
    rigid_wall: Option<u32>,
    /// Motion of the glued points in the last window that stands (m), for what runs one window late.
    last_motion: Vec<f64>,
    /// Force on the exchanged nodes (N) in the last window that stands.
    pub lambda: Vec<f64>,
    /// Total displacement of the exchanged nodes (m).
    pub displacement: Vec<f64>,
    /// What the interface has seen.
    pub ledger: InterfaceLedger,
}

/// What came of trying a window.
#[derive(Clone, Debug)]
pub enum Attempt {
    /// It stands, and is everybody's state.
    Standing(Standing),
    /// It did not converge, and the scenario wants it halved. Nothing has changed.
    Halve,
}

/// What a window that stands left behind.
#[derive(Clone, Debug, Default)]
pub struct Standing {
    /// Repeats beyond the first run.
    pub repeats: u32,
    /// Gap over the mean node spacing.
    pub gap_rel: f64,
    /// What the continuum reported.
    pub continuum_report: Vec<f64>,
    /// What the other side reported.
    pub wall_report: Vec<f64>,
}

/// A window that both sides may make their state.
struct Solved {
    window: Window,
    increment: Vec<f64>,
    lambda: Vec<f64>,
    answer: WallAnswer,
    /// Why it should not stand, if so.
    fault: Option<String>,
}

impl Coupling {
    /// Both sides at rest and unloaded.
    pub fn new(interface: &Interface, joined: Joined) -> Coupling {
        let factor = match interface.scheme {
            Scheme::DualSchurCheap => CHEAP_FACTOR,
            _ => 1.0,
        };
        Coupling {
            interface: interface.clone(),
            compliance: Compliance::new(interface.compliance, factor),
            rigid_wall: None,
            last_motion: vec![0.0; 2 * joined.points.len()],
            lambda: vec![0.0; 2 * joined.nodes.len()],
            displacement: vec![0.0; 2 * joined.nodes.len()],
            ledger: InterfaceLedger::default(),
            joined,
        }
    }

    /// What the handshake agreed on.
    pub fn joined(&self) -> &Joined {
        &self.joined
    }

    /// Tries a window until it stands, or the scenario's policy decides otherwise.
    pub fn window(
        &mut self,
        conversation: &mut Conversation,
        window: Window,
    ) -> Result<Attempt, Error> {
        let solved = match self.interface.scheme {
            Scheme::DualSchur | Scheme::DualSchurSecant | Scheme::DualSchurCheap => {
                self.dual_schur(conversation, window)?
            }
            Scheme::StaggeredSerial => self.staggered_serial(conversation, window)?,
            Scheme::StaggeredParallel => self.staggered_parallel(conversation, window)?,
            Scheme::FixedPointSerial | Scheme::FixedPointParallel => {
                self.fixed_point(conversation, window)?
            }
        };
        if let Some(fault) = &solved.fault {
            match self.interface.on_not_converged {
                Policy::Accept => self.ledger.not_converged += 1,
                Policy::Halve if window.substeps > 1 => {
                    self.ledger.halved += 1;
                    return Ok(Attempt::Halve);
                }
                Policy::Halve => {
                    return Err(Error::NotConverged(format!(
                        "{fault}; the window has one step left and cannot be halved"
                    )));
                }
                Policy::Stop => return Err(Error::NotConverged(fault.clone())),
            }
        }
        self.stand(conversation, solved).map(Attempt::Standing)
    }

    fn window_s(&self, window: &Window) -> f64 {
        self.joined.clock.step_s * f64::from(window.substeps)
    }

    fn advance(
        &self,
        conversation: &mut Conversation,
        window: &Window,
        lambda: &[f64],
    ) -> Result<Vec<f64>, Error> {
        conversation.ask_exactly(
            self.joined.continuum,
            (Kind::Advance, Kind::Motion),
            window,
            lambda.to_vec(),
            lambda.len(),
        )
    }

    fn solve(
        &mut self,
        conversation: &mut Conversation,
        window: &Window,
        free: Vec<f64>,
    ) -> Result<WallAnswer, Error> {
        let components = free.len();
        let numbers = conversation.ask_exactly(
            self.joined.wall,
            (Kind::Solve, Kind::Force),
            window,
            free,
            2 * components + 3,
        )?;
        let answer = unpack_wall_answer(&numbers, components).expect("the length was checked");
        self.ledger.contact_iterations += answer.iterations;
        Ok(answer)
    }

    /// A wall that moves exactly as it is told.
    fn rigid_wall(
        &mut self,
        conversation: &mut Conversation,
        window: &Window,
    ) -> Result<(), Error> {
        if self.rigid_wall != Some(window.substeps) {
            tell_wall(conversation, &self.joined, window, None)?;
            self.rigid_wall = Some(window.substeps);
        }
        Ok(())
    }

    /// |N du - H v_g|, the largest component (m).
    fn gap_m(&self, window: &Window, increment: &[f64], answer: &WallAnswer) -> f64 {
        let window_s = self.window_s(window);
        let motion = self.joined.mapping.motion(increment);
        let wall: Vec<f64> = answer.velocity.iter().map(|v| v * window_s).collect();
        largest_difference(&motion, &wall)
    }

    fn tolerance_m(&self) -> f64 {
        self.interface.tolerance_rel * self.joined.spacing_m
    }

    /// A contact solve that ran out of iterations gives garbage while the gap still reads zero, so it
    /// is the contact solver's own residual that decides.
    fn starved(&self, window: &Window, answer: &WallAnswer) -> Option<String> {
        (!answer.converged).then(|| {
            format!(
                "interface `{}`: the contact solve of window {}, iteration {} (t = {:.6e} s) was starved: true residual {:.3e} after {} iterations; raise solver.max_iterations of the participant on the wall, or lower the window",
                self.interface.name, window.index, window.iteration, window.t0_s, answer.residual, answer.iterations
            )
        })
    }

    fn open(&self, window: &Window, gap_m: f64, advice: &str) -> Option<String> {
        (gap_m > self.tolerance_m() || gap_m.is_nan()).then(|| {
            format!(
                "interface `{}`: window {} (t = {:.6e} s) has a gap of {gap_m:.3e} m = {:.3e} node spacings after {} repeats, tolerance_rel is {:.1e}: {advice}",
                self.interface.name,
                window.index,
                window.t0_s,
                gap_m / self.joined.spacing_m,
                window.iteration,
                self.interface.tolerance_rel
            )
        })
    }

    fn stand(
        &mut self,
        conversation: &mut Conversation,
        solved: Solved,
    ) -> Result<Standing, Error> {
        let window_s = self.window_s(&solved.window);
        let point_motion = self.joined.mapping.motion(&solved.increment);
        let wall_motion: Vec<f64> = solved
            .answer
            .velocity
            .iter()
            .map(|v| v * window_s)
            .collect();
        let gap_m = largest_difference(&point_motion, &wall_motion);
        self.ledger.add(&WindowEntry {
            point_force: &solved.answer.force,
            nodal_force: &solved.lambda,
            point_motion: &point_motion,
            wall_motion: &wall_motion,
            spacing_m: self.joined.spacing_m,
        });
        self.ledger.repeats += u64::from(solved.window.iteration);
        self.ledger.contact_residual_max =
            self.ledger.contact_residual_max.max(solved.answer.residual);
        for (total, increment) in self.displacement.iter_mut().zip(&solved.increment) {
            *total += increment;
        }
        self.lambda = solved.lambda;
        self.last_motion = point_motion;
        let place = self.joined.mapping.motion(&self.displacement);
        conversation.tell(
            self.joined.continuum,
            Kind::Commit,
            &solved.window,
            Vec::new(),
        )?;
        conversation.tell(self.joined.wall, Kind::Commit, &solved.window, place)?;
        let continuum_report = conversation
            .hear(self.joined.continuum, Kind::Report)?
            .payload;
        let wall_report = conversation.hear(self.joined.wall, Kind::Report)?.payload;
        conversation.end_window(solved.window.index)?;
        Ok(Standing {
            repeats: solved.window.iteration,
            gap_rel: gap_m / self.joined.spacing_m,
            continuum_report,
            wall_report,
        })
    }
}
