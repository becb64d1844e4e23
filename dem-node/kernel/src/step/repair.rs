//! Repair of overlaps between rigid grains, by position and not by velocity.
//!
//! The displacement w of the bodies has the least w.M w / 2 of all displacements that leave no overlap: w = M^-1 H s, and at each contact g + n.w >=
//! 0 is complementary to s >= 0. This is the contact problem without friction, with displacements instead of velocities. Momentum, kinetic energy and
//! the centre of mass of a free group do not change. Load and weight do work on the displacement: this work is added to theirs, and balanced as
//! `repair`, since nothing stores it. A repair that does not converge counts like a step that does not: its displacement does not have the least w.M
//! w / 2, and no other number of the run would show it.

use protocol::larger;

use crate::bodies::Bodies;
use crate::bodies::geometry::{extent, range};
use crate::contact::boundary::CompliantBoundary;
use crate::error::KernelError;
use crate::law::Penetration;
use crate::solver::Solver;
use crate::solver::contact::{BodyRecord, Contact, NO_BOND};
use crate::solver::criteria::Criteria;
use crate::solver::problem::Problem;
use crate::solver::residual::Convergence;
use crate::step::state::GrainState;

/// Remaining overlap over the smallest radius: a contact at rest must not open, or a rebound would follow.
const LEFT: f64 = 1e-6;
/// Projections of a step. Each computes the normals again; the error of turning normals is of second order in the overlap.
const PASSES: usize = 4;
/// Bound on the residual of a repair: the next step repairs the rest.
pub const TOLERANCE: f64 = 1e-3;

/// Makes repairs; owns their contact problem.
#[derive(Clone, Debug, Default)]
pub struct Repair {
    problem: Problem,
    solver: Solver,
}

impl Repair {
    /// Moves apart the bodies of a state at the end of its step, which was `solved` by these criteria: `drift` is the time (s) that they have moved
    /// since their gaps were detected, `load` the downward load on the wheel (N). Returns the convergence of the last solve, if there was one.
    pub fn make(
        &mut self,
        (state, bodies): (&mut GrainState, &Bodies),
        (solved, criteria): (&Problem, &Criteria),
        [drift, load]: [f64; 2],
    ) -> Result<Option<Convergence>, KernelError> {
        match bodies.law.penetration {
            Penetration::Gap | Penetration::Iqs => Ok(None),
            Penetration::Split => {
                self.problem.contacts.clear();
                let unbonded = solved.contacts.iter().filter(|c| c.bond == NO_BOND);
                self.problem.contacts.extend(unbonded.map(|contact| {
                    let gap = contact.gap + drift * solved.relative_velocity(contact)[0];
                    moved_apart(contact, gap, bodies)
                }));
                self.displace((state, bodies), (solved, criteria), load)
            }
            Penetration::Projection => {
                let mut last = None;
                for _ in 0..PASSES {
                    if self.detect(bodies, state) <= 2.0 * left(bodies) {
                        break;
                    }
                    last = self.displace((state, bodies), (solved, criteria), load)?;
                }
                Ok(last)
            }
        }
    }

    /// Finds the contacts of the present state. Returns the largest overlap (m).
    fn detect(&mut self, bodies: &Bodies, state: &GrainState) -> f64 {
        let mut largest = 0.0f64;
        self.problem.contacts.clear();
        let positions = state.positions(bodies);
        for slot in &state.list.slots {
            let at = positions.proximity(slot.a as usize, slot.b as usize);
            largest = larger(largest, -at.gap);
            if at.gap < bodies.alert {
                let contact = Contact {
                    a: slot.a,
                    b: bodies.pushed(slot.b as usize) as u32,
                    glued: bodies.glued_index(slot.a as usize).is_some()
                        || bodies.glued_index(slot.b as usize).is_some(),
                    normal: at.normal,
                    bond: NO_BOND,
                    ..Contact::default()
                };
                let contact = moved_apart(&contact, at.gap, bodies);
                self.problem.contacts.push(contact);
            }
        }
        largest
    }

    /// Solves for the displacements and makes them.
    fn displace(
        &mut self,
        (state, bodies): (&mut GrainState, &Bodies),
        (solved, criteria): (&Problem, &Criteria),
        load: f64,
    ) -> Result<Option<Convergence>, KernelError> {
        let problem = &mut self.problem;
        if problem.contacts.iter().all(|c| c.bias[0] >= 0.0) {
            return Ok(None);
        }
        problem.friction = 0.0;
        problem.first_glued = solved.first_glued;
        problem.wheel = solved.wheel;
        problem.rounding = 4.0 * f64::EPSILON * extent(&state.centres);
        // The repair does not move the surface.
        problem.boundary = CompliantBoundary::fixed(bodies.glued());
        problem.records.clear();
        let at_rest = |record: &BodyRecord| BodyRecord {
            velocity: [0.0; 3],
            ..*record
        };
        problem.records.extend(solved.records.iter().map(at_rest));
        let criteria = Criteria {
            tolerance: TOLERANCE,
            ..*criteria
        };
        let convergence = self.solver.solve(problem, &criteria)?;
        move_bodies((state, bodies), load, &problem.records);
        Ok(Some(convergence))
    }
}

/// Makes the displacements w (m) that replace velocities, and adds up the work of weight, m g.w, and load, -F w_y.
fn move_bodies((state, bodies): (&mut GrainState, &Bodies), load: f64, displaced: &[BodyRecord]) {
    let (mut weight, mut of_load) = (0.0, 0.0);
    let free = &mut state.centres[..bodies.free];
    for ((centre, record), mass) in free.iter_mut().zip(displaced).zip(&bodies.masses) {
        let moved = centre.iter_mut().zip(record.velocity);
        for ((x, w), g) in moved.zip(bodies.gravity) {
            *x += w;
            weight += mass * g * w;
        }
    }
    if let Some(wheel) = bodies.wheel() {
        let lifted = displaced[wheel].velocity[1];
        state.wheel.position[1] += lifted;
        state.place_face(bodies, state.wheel.position[0]);
        of_load -= load * lifted;
    }
    state.ledger.weight += weight;
    state.ledger.load += of_load;
    state.ledger.repair += weight + of_load;
}

/// A contact whose bodies are to be moved until the gap (m) is no overlap.
fn moved_apart(contact: &Contact, gap: f64, bodies: &Bodies) -> Contact {
    Contact {
        bias: [gap + left(bodies), 0.0],
        pair_law: 0,
        compliance: [0.0; 2],
        impulse: [0.0; 2],
        ..*contact
    }
}

/// Remaining overlap (m).
fn left(bodies: &Bodies) -> f64 {
    LEFT * range(bodies.radii.iter().copied())[0]
}

/// Mean and largest overlap of the contacts that carry force, at the present positions (m).
pub fn overlaps(bodies: &Bodies, state: &GrainState) -> [f64; 2] {
    let (mut sum, mut count, mut largest) = (0.0, 0, 0.0f64);
    let positions = state.positions(bodies);
    for slot in state.list.pressing() {
        let at = positions.proximity(slot.a as usize, slot.b as usize);
        let overlap = larger(0.0, -at.gap);
        sum += overlap;
        count += 1;
        largest = larger(largest, overlap);
    }
    [sum / f64::from(count.max(1)), largest]
}
