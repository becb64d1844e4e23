//! One step of the Moreau-Jean theta scheme.
//!
//! q_m = q + h (1 - theta) v; contacts are detected there; v' = v + h F/m + M^-1 H r with the contact laws;
//! q' = q_m + h theta v' (Moreau 1988; Jean 1999).
//!
//! In reading order:
//! - [`ledger`], [`state`]: the energy balance, and the state that is committed;
//! - [`injection`], [`detachment`], [`worn`]: grains that are fed in, from outside or off bare surfaces;
//! - [`stiffness`]: bounds on the step;
//! - [`repair`]: overlaps of rigid grains, repaired without velocity;
//! - [`temperature`], `heat`: temperatures of the grains, and the heat of a step;
//! - `assembly`, `update`, `balance`, `driven`, `shared_dampers`: the contact problem of a step, the changes by its solution, and checks;
//! - [`threads`]: a step by several threads.

mod assembly;
mod balance;
pub mod detachment;
mod driven;
mod heat;
pub mod injection;
pub mod ledger;
mod links;
pub mod repair;
mod shared_dampers;
pub mod state;
pub mod stiffness;
pub mod temperature;
pub mod threads;
mod update;
pub mod worn;

use protocol::larger;
use serde::{Deserialize, Serialize};

use crate::bodies::Bodies;
use crate::bodies::drive::StepTime;
use crate::contact::loss::Loss;
use crate::error::KernelError;
use crate::law::cohesion::Cohesion;
use crate::solver::Solver;
use crate::solver::contact::NO_BOND;
use crate::solver::criteria::Criteria;
use crate::solver::partition::{Partition, in_pieces};
use crate::solver::problem::Problem;
use crate::solver::residual::Convergence;
use crate::step::links::Links;
use crate::step::repair::Repair;
use crate::step::state::GrainState;

/// Input of a step: the bodies, their loads and prescribed motions.
#[derive(Clone, Copy, Debug)]
pub struct StepInput<'a> {
    /// The bodies.
    pub bodies: &'a Bodies,
    /// Length of the step (s).
    pub step: f64,
    /// Weight of the end velocity.
    pub theta: f64,
    /// Downward load on the wheel (N).
    pub load: f64,
    /// Sideways displacement of the wheel, or the abscissa of a rolling one, at the end (m).
    pub wheel_x: f64,
    /// Turning of the wheel.
    pub turn: WheelTurn,
    /// Time at which loads are taken (s).
    pub loaded: f64,
    /// Velocities of the glued disks without contact forces, a_g (m/s).
    pub free_velocity: &'a [f64],
}

/// Turning of a wheel, by the velocity R omega of its face (m/s), anticlockwise: negative while it rolls towards +x.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum WheelTurn {
    /// It does not turn.
    #[default]
    Held,
    /// Its mean velocity over the step.
    Given(f64),
    /// It spins freely.
    Free {
        /// R^2/I, the inverse mass of the face (1/kg).
        inverse_mass: f64,
        /// Force of the brake on the face (N), anticlockwise.
        brake: f64,
    },
}

impl WheelTurn {
    /// Change of the velocity of the face by a unit impulse (1/kg).
    pub fn inverse_mass(self) -> f64 {
        match self {
            WheelTurn::Free { inverse_mass, .. } => inverse_mass,
            WheelTurn::Held | WheelTurn::Given(_) => 0.0,
        }
    }

    /// Velocity of the face over a step that begins with `now`, without contacts (m/s).
    fn velocity(self, now: f64, step: f64) -> f64 {
        match self {
            WheelTurn::Held => 0.0,
            WheelTurn::Given(velocity) => velocity,
            WheelTurn::Free {
                inverse_mass,
                brake,
            } => now + step * inverse_mass * brake,
        }
    }
}

impl StepInput<'_> {
    /// The time at which the loads of driven clusters are taken.
    pub fn step_time(&self) -> StepTime {
        StepTime {
            time: self.loaded,
            step: self.step,
            theta: self.theta,
        }
    }
}

/// Summary of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StepSummary {
    /// Convergence of the contact solver, or of the repair of overlaps if only the repair did not converge.
    pub convergence: Convergence,
    /// True if the solve of the step converged, and only the repair did not.
    pub repair_failed: bool,
    /// Contacts in the problem.
    pub listed: usize,
    /// Contacts that carry force.
    pub closed: usize,
    /// Mean and largest overlap of these contacts at the end of the step (m).
    pub overlap: [f64; 2],
    /// Largest way of a grain past or into a body that it presses on, or along its weight, over the smaller radius.
    pub travel: f64,
    /// Largest D over w of a bond, the square of its force over its strength until its adhesion falls.
    pub bond_load_squared: f64,
    /// Force of the grains on the wheel (N).
    pub on_wheel: [f64; 2],
    /// Force of the grains on the boundary, summed over the glued disks (N).
    pub on_boundary: [f64; 2],
    /// Largest component of (forces on the free grains - change of their momentum / h) (N).
    pub momentum_defect: f64,
    /// Part of this change of momentum over h that belongs to mass added by `mass_scale` (N).
    pub added_inertia: f64,
    /// Half the sum of the forces between the free grains and all other bodies (N).
    pub transmitted: f64,
    /// Loss in dampers of contacts that shared the landing of a cluster (J), and its products with three restitutions: the law's, the landing's, and
    /// the value of `law.damping` that gives the law's.
    pub shared_damping: [f64; 4],
}

impl StepSummary {
    /// Adds the summary of other contacts, with overlaps not yet divided by their number.
    fn join(&mut self, other: &StepSummary) {
        self.closed += other.closed;
        self.overlap[0] += other.overlap[0];
        self.overlap[1] = larger(self.overlap[1], other.overlap[1]);
        self.travel = larger(self.travel, other.travel);
        self.bond_load_squared = larger(self.bond_load_squared, other.bond_load_squared);
        self.on_wheel[0] += other.on_wheel[0];
        self.on_wheel[1] += other.on_wheel[1];
    }
}

/// Makes steps; owns the buffers that they share.
#[derive(Clone, Debug, Default)]
pub struct Stepper {
    /// The contact problem of the current step.
    pub problem: Problem,
    solver: Solver,
    /// Slot of each contact of the problem.
    slots: Vec<u32>,
    /// Adhesion at the end of the step of each bond of the problem.
    adhesion: Vec<f64>,
    /// Contacts whose bonds the last solution has softened.
    softened: Vec<u32>,
    repair: Repair,
    /// Losses of the bonds that the step has torn before its contacts, by pair.
    torn: Vec<([u32; 2], Loss)>,
    /// Contacts through which heat passes.
    links: Links,
    /// Force of the grains on each driven cluster, then on each named wall, in the last step (N).
    pub on_named: Vec<[f64; 2]>,
}

impl Stepper {
    /// True if the problem of the last step was large enough for several threads.
    pub fn is_partitioned(&self) -> bool {
        let problem = &self.problem;
        Partition::new(problem.contacts.len(), problem.records.len()).several()
    }

    /// Advances the state by a step (equation 7 of Renouf, Saulot and Berthier 2006):
    /// q_m = q + h (1 - theta) v, detection of the contacts at q_m, v' = v_free + M^-1 H r with the contact laws, and
    /// q' = q_m + h theta v'. The glued disks stay where they are: their boundary moves them.
    pub fn advance(
        &mut self,
        state: &mut GrainState,
        input: &StepInput,
        criteria: &Criteria,
    ) -> Result<StepSummary, KernelError> {
        let bodies = input.bodies;
        injection::feed(state, bodies, input.loaded);
        state.drift(bodies, input.step * (1.0 - input.theta));
        self.assemble(state, input, criteria.parallel);
        let convergence = match &bodies.law.cohesion {
            None => self.solver.solve(&mut self.problem, criteria)?,
            Some(law) => self.solve_bonded(state, input, criteria, law)?,
        };
        let (mut summary, outer) = self.update_contacts(state, input, criteria.parallel);
        summary.convergence = convergence;
        self.warm(state, input, &outer.warmed)?;
        summary.shared_damping = self.shared_damping(state, input);
        self.balance_momentum(state, input, &outer, &mut summary);
        self.drive_clusters(state, input);
        self.update_bodies(state, input, &outer);
        state.heat.see_peak(&state.centres, input.loaded);
        state.drift(bodies, input.step * input.theta);
        state.place_face(bodies, state.wheel.position[0]);
        if bodies.law.penetration.repairs() {
            let solved = (&self.problem, criteria);
            let numbers = [input.step * input.theta, input.load];
            let verdict = self.repair.make((state, bodies), solved, numbers)?;
            if let Some(verdict) = verdict.filter(|verdict| !verdict.converged) {
                summary.repair_failed = convergence.converged;
                summary.convergence = verdict;
            }
            summary.overlap = repair::overlaps(bodies, state);
        }
        Ok(summary)
    }

    /// Solves under the adhesion at the start of the step, lowers adhesion to the value of this solution, and solves again until no adhesion falls by
    /// more than the tolerance. Adhesion only falls on the way: in steps above [`stiffness::step_limit`] this selects the first solution on the way
    /// from the intact bond.
    fn solve_bonded(
        &mut self,
        state: &GrainState,
        input: &StepInput,
        criteria: &Criteria,
        law: &Cohesion,
    ) -> Result<Convergence, KernelError> {
        let mut convergence = self.solver.solve(&mut self.problem, criteria)?;
        if !convergence.converged {
            // If the window is accepted all the same, bonds have the adhesion of this solution.
            self.adhesion.clear();
            let solved = self.problem.bonds.iter().map(|bond| bond.adhesion[1]);
            self.adhesion.extend(solved);
        }
        while convergence.converged && self.lower_adhesion(state, input, criteria, law) {
            let again = (self.solver).go_on(&mut self.problem, criteria, &self.softened)?;
            let iterations = convergence.iterations + again.iterations;
            convergence = Convergence {
                iterations,
                converged: again.converged && iterations <= criteria.max_iterations,
                ..again
            };
        }
        Ok(convergence)
    }

    /// Lowers the adhesion of the bonds; true if it fell so far that the problem has to be solved again.
    fn lower_adhesion(
        &mut self,
        state: &GrainState,
        input: &StepInput,
        criteria: &Criteria,
        law: &Cohesion,
    ) -> bool {
        let (bodies, h) = (input.bodies, input.step);
        let (problem, softens) = (&self.problem, bodies.softens());
        let solved = problem.bonds.iter().map(|bond| bond.adhesion[1]);
        self.adhesion.clear();
        self.adhesion.extend(solved);
        let falling = self.solver.falling(problem).unwrap_or_else(|| {
            let contacts = (0..).zip(&problem.contacts);
            let bonded = contacts.filter(|(_, contact)| contact.bond != NO_BOND);
            bonded.map(|(index, _)| index).collect()
        });
        let all = &falling[..];
        let pieces = in_pieces(all.len(), all, criteria.parallel, |_, falling| {
            let (mut fallen, mut furthest) = (Vec::new(), 0.0);
            for index in falling {
                let contact = &problem.contacts[*index as usize];
                let bond = &problem.bonds[contact.bond as usize];
                let velocity = problem.relative_velocity(contact);
                let own = softens.then(|| {
                    let bond = &state.bonds[bond.index as usize];
                    state.law_of(bodies, [bond.a, bond.b]).cohesion
                });
                let own = own.flatten();
                let adhesion = bond.fall(own.as_ref().unwrap_or(law), velocity, contact.gap, h);
                if adhesion < bond.adhesion[1] {
                    fallen.push((*index, adhesion));
                }
                furthest = larger(furthest, bond.adhesion[1] - adhesion);
            }
            (fallen, furthest)
        });
        self.softened.clear();
        let mut furthest = 0.0;
        for (fallen, of_piece) in pieces {
            for (index, adhesion) in fallen {
                self.adhesion[problem.contacts[index as usize].bond as usize] = adhesion;
                self.softened.push(index);
            }
            furthest = larger(furthest, of_piece);
        }
        let problem = &mut self.problem;
        if furthest <= criteria.tolerance {
            return false;
        }
        for index in &self.softened {
            let number = problem.contacts[*index as usize].bond as usize;
            let contact = &mut problem.bonds[number];
            let bond = &state.bonds[contact.index as usize];
            let [a, b] = [bond.a, bond.b].map(|body| body as usize);
            contact.soften(bodies.law_of(a, b), bond, self.adhesion[number], h);
        }
        true
    }
}
