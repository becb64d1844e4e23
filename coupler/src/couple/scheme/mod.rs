//! One window of each coupling scheme.
//!
//! - [`compliance`]: what the coupler believes of the continua's compliance;
//! - [`source`]: where that comes from;
//! - `dual_schur`: one force a window, equal displacements at its end;
//! - `fixed_point`: motion one way, force the other, repeated or not;
//! - `velocity`: one straight line of velocities a window, equal velocities at its end;
//! - `swapped`: motion and force the other way round, for a heavy wall;
//! - `exchange`: what is said to all sides, and what they answer;
//! - `judge`: whether a window may stand;
//! - `stand`: what becomes of one that does;
//! - `outcome`: what a window comes to on this way;
//! - `state`: what a checkpoint holds of it;
//! - [`acceleration`]: what a fixed-point iteration makes of its last answers;
//! - `foresee`: what the handshake tells of its stability.

use protocol::Window;

use super::conversation::Conversation;
use super::group::Group;
use super::ledger::InterfaceLedger;
use crate::error::Error;
use crate::scenario::{CompliancePrior, Dirichlet, Interface, Policy, Scheme};
use compliance::Compliance;
use outcome::Solved;
use source::Source;

pub mod acceleration;
pub mod compliance;
mod dual_schur;
mod exchange;
mod fixed_point;
mod foresee;
mod judge;
mod outcome;
pub mod source;
mod stand;
mod state;
mod swapped;
mod velocity;

pub use outcome::{Attempt, InterfaceSignals, Standing};
pub use state::CouplingState;

/// `dual-schur-cheap` never looks back, so its compliance errs to the soft side, which is far safer than too stiff.
pub const CHEAP_FACTOR: f64 = 1.2;

/// The coupler's own state of one group: it changes only when a window stands.
#[derive(Clone, Debug)]
pub struct Coupling {
    /// The keys on which connected interfaces agree.
    rules: Interface,
    group: Group,
    compliance: Compliance,
    /// Window length that walls without compliance were told of (substeps).
    rigid_wall: Option<u32>,
    /// Motion of the glued points in the last window that stands (m), for what runs one window late.
    last_motion: Vec<f64>,
    /// Force on the exchanged nodes (N) in the last window that stands.
    pub lambda: Vec<f64>,
    /// Velocity of the exchanged nodes (m/s) at the end of the last window that stands, where the scheme prescribes it.
    velocity: Vec<f64>,
    /// Total displacement of the exchanged nodes (m), as the walls were told of it.
    pub displacement: Vec<f64>,
    /// What each interface of the group has seen.
    pub ledgers: Vec<InterfaceLedger>,
}

impl Coupling {
    /// All sides at rest and unloaded; `rules` is any of the group's interfaces.
    pub fn new(rules: &Interface, group: Group) -> Coupling {
        let factor = match rules.scheme {
            Scheme::DualSchurCheap => CHEAP_FACTOR,
            _ => 1.0,
        };
        let source = match (rules.scheme, rules.dirichlet, rules.compliance) {
            (_, Dirichlet::Continuum, _) => Source::Points,
            (Scheme::Velocity, _, _) => Source::Impedance,
            (_, _, CompliancePrior::Columns) => Source::Columns,
            (_, _, CompliancePrior::Mass) => Source::Mass,
        };
        Coupling {
            rules: rules.clone(),
            compliance: Compliance::new(source, factor),
            rigid_wall: None,
            last_motion: vec![0.0; 2 * group.points.len()],
            lambda: vec![0.0; 2 * group.nodes.len()],
            velocity: vec![0.0; 2 * group.nodes.len()],
            displacement: vec![0.0; 2 * group.nodes.len()],
            ledgers: vec![InterfaceLedger::default(); group.patches.len()],
            group,
        }
    }

    /// What the handshake agreed on.
    pub fn group(&self) -> &Group {
        &self.group
    }

    /// Tries a window until it stands, or the scenario's policy decides otherwise. `following` tells the window after
    /// one that stands.
    pub fn window(
        &mut self,
        conversation: &mut Conversation,
        window: Window,
        following: impl Fn(&Window) -> Option<Window>,
    ) -> Result<Attempt, Error> {
        let mut solved = match self.solved(conversation, window) {
            Err(Error::NotFinite(_)) if self.may_halve(&window) => return Ok(self.halve()),
            solved => solved?,
        };
        solved.faults.extend(self.leaks(&solved));
        match (solved.faults.first(), self.rules.on_not_converged) {
            (None, _) => {}
            (Some(_), Policy::Accept) => {
                for fault in &solved.faults {
                    self.ledgers[fault.patch].not_converged += 1;
                }
            }
            (Some(_), Policy::Halve) if self.may_halve(&window) => return Ok(self.halve()),
            (Some(fault), Policy::Halve) => {
                let end = self.cannot_halve();
                return Err(Error::NotConverged(format!("{}; {end}", fault.why)));
            }
            (Some(fault), Policy::Stop) => return Err(Error::NotConverged(fault.why.clone())),
        }
        let next = following(&solved.window);
        self.stand(conversation, solved, next)
            .map(Attempt::Standing)
    }

    fn solved(&mut self, conversation: &mut Conversation, window: Window) -> Result<Solved, Error> {
        let swapped = self.rules.dirichlet == Dirichlet::Continuum;
        match self.rules.scheme {
            Scheme::StaggeredSerial | Scheme::StaggeredParallel if swapped => {
                self.swapped_staggered(conversation, window)
            }
            Scheme::FixedPointSerial | Scheme::FixedPointParallel if swapped => {
                self.swapped_fixed_point(conversation, window)
            }
            Scheme::DualSchur | Scheme::DualSchurSecant | Scheme::DualSchurCheap => {
                self.dual_schur(conversation, window)
            }
            Scheme::StaggeredSerial => self.staggered_serial(conversation, window),
            Scheme::StaggeredParallel => self.staggered_parallel(conversation, window),
            Scheme::FixedPointSerial | Scheme::FixedPointParallel => {
                self.fixed_point(conversation, window)
            }
            Scheme::Velocity => self.velocity(conversation, window),
        }
    }

    /// Whether the first thing of a window is a run of the continua under the force of the window before.
    fn begins_with_continua(&self) -> bool {
        match self.rules.scheme {
            Scheme::DualSchur | Scheme::DualSchurSecant | Scheme::DualSchurCheap => true,
            Scheme::StaggeredSerial
            | Scheme::StaggeredParallel
            | Scheme::FixedPointSerial
            | Scheme::FixedPointParallel
            | Scheme::Velocity => false,
        }
    }

    fn may_halve(&self, window: &Window) -> bool {
        self.rules.on_not_converged == Policy::Halve && window.substeps > 1
    }

    fn halve(&mut self) -> Attempt {
        for ledger in &mut self.ledgers {
            ledger.halved += 1;
        }
        Attempt::Halve
    }

    fn cannot_halve(&self) -> String {
        match self.group.continua.iter().all(|side| side.steps == 1) {
            true => "the window has one step left and cannot be halved".into(),
            false => "the connected continua have no shorter window that is a whole number of steps of each: give substeps that share more factors".into(),
        }
    }
}
