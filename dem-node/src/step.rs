//! One step of the Moreau-Jean theta scheme.
//!
//! q_m = q + h (1 - theta) v; contacts are detected there; v' = v + h F/m + M^-1 H r with the contact laws;
//! q' = q_m + h theta v' (Moreau 1988; Jean 1999).

use serde::{Deserialize, Serialize};

mod balance;

use crate::bodies::Bodies;
use crate::bond::{self, BondContact, BondStep, Finder};
use crate::cohesion::Cohesion;
use crate::detect::Slot;
use crate::error::DemError;
use crate::geometry::{Places, Proximity, proximity};
use crate::ledger::{ContactStep, contact_loss};
use crate::repair::{self, Repair};
use crate::solver::{Contact, Criteria, Mover, Problem, UNARMED, UNBONDED, Verdict};
use crate::state::State;

/// What drives a step.
#[derive(Clone, Copy, Debug)]
pub struct Drive<'a> {
    /// Length of the step (s).
    pub step: f64,
    /// Weight of the end velocity.
    pub theta: f64,
    /// Downward load on the wheel (N).
    pub load: f64,
    /// Sideways displacement of the wheel at the end (m).
    pub wheel_x: f64,
    /// Velocities of the glued disks without contact forces, a_g (m/s).
    pub free_velocity: &'a [f64],
}

/// What a step did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// How the contact solver ended.
    pub verdict: Verdict,
    /// Contacts in the problem.
    pub listed: usize,
    /// Contacts that carry force.
    pub closed: usize,
    /// Mean and largest overlap of those at the end of the step (m).
    pub overlap: [f64; 2],
    /// Force of the grains on the wheel (N).
    pub on_wheel: [f64; 2],
    /// Force of the grains on the wall, summed over the glued disks (N).
    pub on_wall: [f64; 2],
    /// Largest component of (forces on the free grains - change of their momentum / h) (N).
    pub momentum_defect: f64,
}

/// Makes steps; owns the buffers that they share.
#[derive(Clone, Debug, Default)]
pub struct Stepper {
    /// The contact problem of the current step.
    pub problem: Problem,
    /// Slot of each contact of the problem.
    slots: Vec<u32>,
    /// Adhesion at the end of the step of each bond of the problem.
    adhesion: Vec<f64>,
    repair: Repair,
}

impl Stepper {
    /// Advances the state by a step. The glued disks stay where they are: their wall moves them.
    pub fn advance(
        &mut self,
        bodies: &Bodies,
        state: &mut State,
        drive: &Drive,
        criteria: &Criteria,
    ) -> Result<Summary, DemError> {
        state.drift(bodies, drive.step * (1.0 - drive.theta));
        self.pose(bodies, state, drive);
        let verdict = match &bodies.law.cohesion {
            None => self.problem.solve(criteria)?,
            Some(law) => self.solve_bonded(bodies, state, drive, criteria, law)?,
        };
        let mut summary = self.close_contacts(bodies, state, drive);
        summary.verdict = verdict;
        summary.momentum_defect = self.momentum_defect(bodies, state, drive);
        self.close_bodies(bodies, state, drive);
        let drift = drive.step * drive.theta;
        state.drift(bodies, drift);
        if bodies.law.repairs() {
            let (repair, problem) = (&mut self.repair, &self.problem);
            repair.make(bodies, state, problem, drift, criteria)?;
            summary.overlap = repair::overlaps(bodies, state);
        }
        Ok(summary)
    }

    /// Solves under the adhesion of the step's start, lowers adhesion as far as that solution asks, and solves again until
    /// no bond falls by more than the tolerance. Adhesion only goes down on the way: above the step of
    /// [`bond::step_limit`] that picks the first solution on the way from the intact bond.
    fn solve_bonded(
        &mut self,
        bodies: &Bodies,
        state: &State,
        drive: &Drive,
        criteria: &Criteria,
        law: &Cohesion,
    ) -> Result<Verdict, DemError> {
        let mut verdict = self.problem.solve(criteria)?;
        // Where no solution came of it, and yet the window may be accepted, bonds are as strong as they were solved for.
        self.adhesion.clear();
        let solved = self.problem.bonds.iter().map(|bond| bond.adhesion[1]);
        self.adhesion.extend(solved);
        while verdict.converged && self.lower_adhesion(bodies, state, drive.step, criteria, law) {
            self.problem.wall.start(drive.free_velocity);
            self.free_movers(bodies, state, drive);
            let again = self.problem.solve(criteria)?;
            let iterations = verdict.iterations + again.iterations;
            let converged = again.converged && iterations <= criteria.max_iterations;
            verdict = Verdict {
                iterations,
                residual: again.residual,
                quad: again.quad,
                converged,
            };
        }
        Ok(verdict)
    }

    /// Whether adhesion fell so far that the problem has to be solved again.
    fn lower_adhesion(
        &mut self,
        bodies: &Bodies,
        state: &State,
        h: f64,
        criteria: &Criteria,
        law: &Cohesion,
    ) -> bool {
        let problem = &mut self.problem;
        let bonded = problem.contacts.iter().filter(|c| c.bond != UNBONDED);
        self.adhesion.clear();
        self.adhesion.extend(bonded.map(|contact| {
            let velocity = problem.relative_velocity(contact);
            problem.bonds[contact.bond as usize].fall(law, velocity, contact.bias[0], h)
        }));
        let both = problem.bonds.iter().zip(&self.adhesion);
        let furthest = both.fold(0.0f64, |f, (bond, a)| f.max(bond.adhesion[1] - a));
        if furthest <= criteria.tolerance {
            return false;
        }
        for (contact, adhesion) in problem.bonds.iter_mut().zip(&self.adhesion) {
            let bond = &state.bonds[contact.index as usize];
            contact.soften(&bodies.law, bond, *adhesion, h);
        }
        true
    }

    /// Free velocities and contacts.
    pub(crate) fn pose(&mut self, bodies: &Bodies, state: &mut State, drive: &Drive) {
        self.problem.friction = bodies.law.coefficient();
        self.problem.first_glued = bodies.free;
        self.problem.wheel = bodies.wheel();
        self.problem.rounding = 4.0 * f64::EPSILON * extent(&state.centres) / drive.step;
        self.problem.wall.start(drive.free_velocity);
        self.free_movers(bodies, state, drive);
        let travel = drive.step * self.top_speed(bodies);
        let mut list = std::mem::take(&mut state.list);
        let places = places_at_detection(bodies, state, drive);
        list.refresh(bodies, &places, travel, &state.bonds);
        if bodies.has_joints() {
            list.pass_on(bodies, &places);
        }
        self.problem.contacts.clear();
        self.problem.bonds.clear();
        self.problem.arms.clear();
        self.slots.clear();
        let mut bonds = Finder::new(&state.bonds);
        for index in 0..list.slots.len() {
            let slot = &list.slots[index];
            let place = proximity(bodies, &places, slot.a as usize, slot.b as usize);
            let bond = bonds.find((slot.a, slot.b));
            let candidate = self.candidate(bodies, state, drive.step, slot, place);
            let Some(mut contact) =
                self.admit(bodies, state, drive.step, candidate, bond.is_some())
            else {
                // A contact that a rebound has opened leaves the problem: it must not keep its force.
                (list.slots[index].force, list.slots[index].left) = ([0.0; 2], 0.0);
                continue;
            };
            if let Some((place, bond)) = bond {
                contact.bond = self.problem.bonds.len() as u32;
                contact.gap -= bond.reference;
                contact.bias = [contact.gap / drive.step, 0.0];
                contact.compliance[1] = 0.0;
                let bonded = BondContact::new(&bodies.law, bond, place, drive.step);
                self.problem.bonds.push(bonded);
            }
            self.problem.contacts.push(contact);
            self.slots.push(index as u32);
        }
        state.list = list;
    }

    fn free_movers(&mut self, bodies: &Bodies, state: &State, drive: &Drive) {
        let movers = &mut self.problem.movers;
        movers.clear();
        let h = drive.step;
        movers.extend(state.velocities.iter().zip(&bodies.masses).map(|(v, m)| {
            let kick = [h * bodies.gravity[0], h * bodies.gravity[1]];
            Mover {
                velocity: [v[0] + kick[0], v[1] + kick[1], v[2]],
                inverse_mass: 1.0 / m,
            }
        }));
        for cluster in bodies.clusters.iter() {
            for disk in &cluster.disks {
                movers[*disk] = Mover::default();
            }
            let start = state.velocities[cluster.leader()];
            let kick = |k: usize| start[k] + cluster.free[k] * h * bodies.gravity[k];
            movers[cluster.leader()] = Mover {
                velocity: [kick(0), kick(1), start[2]],
                inverse_mass: 1.0 / cluster.mass,
            };
        }
        if let (Some([x, y]), Some(grain)) = (bodies.pulled, movers.first_mut()) {
            *grain = Mover {
                velocity: [x, y, 0.0],
                ..Mover::default()
            };
        }
        movers.resize(bodies.disks(), Mover::default());
        if let Some(mass) = bodies.wheel_mass {
            let x_velocity = (drive.wheel_x - state.wheel.position[0]) / h;
            movers.push(Mover {
                velocity: [
                    x_velocity,
                    state.wheel.velocity[1] - h * drive.load / mass,
                    0.0,
                ],
                inverse_mass: 1.0 / mass,
            });
        }
        movers.extend(bodies.walls.iter().map(|wall| Mover {
            velocity: [wall.velocity[0], wall.velocity[1], 0.0],
            inverse_mass: 0.0,
        }));
    }

    fn top_speed(&self, bodies: &Bodies) -> f64 {
        let movers = self
            .problem
            .movers
            .iter()
            .map(|m| [m.velocity[0], m.velocity[1]]);
        let glued = self
            .problem
            .wall
            .velocity
            .chunks_exact(2)
            .map(|v| [v[0], v[1]]);
        let squares = movers.chain(glued).map(|v| v[0] * v[0] + v[1] * v[1]);
        let speed = squares.fold(0.0, f64::max).sqrt();
        let clusters = bodies.clusters.iter();
        let turning = clusters.map(|c| c.top_speed(self.problem.movers[c.leader()].velocity));
        turning.fold(speed, f64::max)
    }

    /// The contact that a slot would have; its levers, if it needs any, join the problem.
    fn candidate(
        &mut self,
        bodies: &Bodies,
        state: &State,
        h: f64,
        slot: &Slot,
        place: Proximity,
    ) -> Contact {
        let pair = [slot.a as usize, slot.b as usize];
        let glued = pair.map(|body| bodies.glued_index(body).is_some());
        let mut contact = Contact {
            a: slot.a,
            b: slot.b,
            glued: glued[0] || glued[1],
            normal: place.normal,
            gap: place.gap,
            stretch: match bodies.radii.get(slot.b as usize) {
                Some(radius) => place.gap / (radius + bodies.radii[slot.a as usize]),
                None => 0.0,
            },
            bias: [0.0, slot.spring / h],
            compliance: bodies.law.compliance(h),
            impulse: [h * slot.force[0], h * slot.force[1]],
            bond: UNBONDED,
            arms: UNARMED,
            ..Contact::default()
        };
        if !bodies.clusters.is_empty() {
            let disk = |body: usize| (state.centres[body], bodies.radii[body]);
            let inverse = |body: usize| self.problem.inverse_mass(body);
            let arms = bodies
                .clusters
                .arms(&state.clusters, pair, &place, disk, inverse);
            if let Some(arms) = arms {
                contact.arms = self.problem.arms.len() as u32;
                self.problem.arms.push(arms);
                [contact.a, contact.b] = pair.map(|body| bodies.clusters.mover_of(body) as u32);
            }
        }
        contact
    }

    /// A contact, unless the pair has no bond, stays apart in this step and carried no force in the last one.
    fn admit(
        &mut self,
        bodies: &Bodies,
        state: &State,
        h: f64,
        mut contact: Contact,
        bonded: bool,
    ) -> Option<Contact> {
        if bonded {
            return Some(contact);
        }
        let approach = self.problem.relative_velocity(&contact)[0].min(0.0);
        let touches = contact.impulse[0] > 0.0 || contact.gap + h * approach < bodies.alert;
        if !touches {
            self.problem.arms.truncate(contact.arms as usize);
            return None;
        }
        let before = match bodies.law.restitution {
            Some(_) => self.relative_before(bodies, state, &contact)[0],
            None => 0.0,
        };
        let Some(bias) = bodies.law.bias(contact.gap, before, h) else {
            self.problem.arms.truncate(contact.arms as usize);
            return None;
        };
        contact.bias[0] = bias;
        Some(contact)
    }

    /// Stores forces and springs, books the losses, sums what the contacts did.
    fn close_contacts(&self, bodies: &Bodies, state: &mut State, drive: &Drive) -> Summary {
        let h = drive.step;
        let mut summary = Summary {
            listed: self.problem.contacts.len(),
            ..Summary::default()
        };
        for (contact, slot) in self.problem.contacts.iter().zip(&self.slots) {
            let slot = *slot as usize;
            let done = self.contact_step(bodies, state, drive, contact, &state.list.slots[slot]);
            if contact.bond == UNBONDED {
                let [impact, friction] = contact_loss(&bodies.law, &done);
                state.accounts.impact += impact;
                state.accounts.friction += friction;
                state.list.slots[slot].force = [done.impulse[0] / h, done.impulse[1] / h];
                state.list.slots[slot].spring = done.spring[1];
                state.list.slots[slot].left = done.gap + h * done.velocity[0];
            } else {
                self.close_bond(bodies, state, contact.bond as usize, slot, &done);
            }
            if done.impulse[0] > 0.0 {
                let overlap = (-done.gap - h * done.velocity[0]).max(0.0);
                summary.closed += 1;
                summary.overlap[0] += overlap;
                summary.overlap[1] = summary.overlap[1].max(overlap);
            }
            if Some(contact.b as usize) == bodies.wheel() {
                let push = push_on_a(contact);
                summary.on_wheel[0] -= push[0] / h;
                summary.on_wheel[1] -= push[1] / h;
            }
        }
        state.bonds.retain(|bond| bond.adhesion > 0.0);
        summary.overlap[0] /= summary.closed.max(1) as f64;
        for impulse in self.problem.wall.impulse.chunks_exact(2) {
            summary.on_wall[0] += impulse[0] / h;
            summary.on_wall[1] += impulse[1] / h;
        }
        summary
    }

    /// Moves a bond and its slot to the end of the step and books what it lost.
    fn close_bond(
        &self,
        bodies: &Bodies,
        state: &mut State,
        place: usize,
        slot: usize,
        done: &ContactStep,
    ) {
        let contact = &self.problem.bonds[place];
        let [before, solved] = contact.adhesion;
        let step = BondStep {
            contact: *done,
            adhesion: [before, solved, self.adhesion[place]],
        };
        let bond = &mut state.bonds[contact.index as usize];
        let loss = bond::close(&bodies.law, bond, &mut state.list.slots[slot], &step);
        state.accounts.impact += loss.impact;
        state.accounts.friction += loss.friction;
        state.accounts.cohesion += loss.cohesion;
    }

    fn contact_step(
        &self,
        bodies: &Bodies,
        state: &State,
        drive: &Drive,
        contact: &Contact,
        slot: &Slot,
    ) -> ContactStep {
        let velocity = self.problem.relative_velocity(contact);
        let before = self.relative_before(bodies, state, contact);
        let stretched = bodies
            .law
            .springs
            .map_or(0.0, |s| -contact.impulse[1] / (drive.step * s.tangential));
        // A yielding wall puts its disks where its own body says, which is not for this ledger to judge.
        let left = match contact.glued && self.problem.wall.yields() {
            true => contact.gap,
            false => slot.left,
        };
        ContactStep {
            step: drive.step,
            theta: drive.theta,
            gap: contact.gap,
            left,
            spring: [slot.spring, stretched],
            impulse: contact.impulse,
            velocity,
            change: [velocity[0] - before[0], velocity[1] - before[1]],
        }
    }

    /// (u_n, u_t) at the start of the step (m/s).
    fn relative_before(&self, bodies: &Bodies, state: &State, contact: &Contact) -> [f64; 2] {
        let a = velocity_before(bodies, state, contact.a as usize);
        let b = velocity_before(bodies, state, contact.b as usize);
        self.problem.project(contact, a, b)
    }
}

/// Where everything is when contacts are detected. Grains and height of the wheel have drifted already, its prescribed
/// way is uniform within the step.
fn places_at_detection<'a>(bodies: &Bodies, state: &'a State, drive: &Drive) -> Places<'a> {
    let mut places = state.places(bodies);
    if bodies.wheel_radius > 0.0 {
        places.wheel[0] += (1.0 - drive.theta) * (drive.wheel_x - state.wheel.position[0]);
    }
    places
}

/// Largest coordinate (m): positions, and so gaps, carry its rounding.
pub(crate) fn extent(centres: &[[f64; 2]]) -> f64 {
    let coordinates = centres.iter().flatten();
    coordinates.fold(0.0, |largest, x| largest.max(x.abs()))
}

fn push_on_a(contact: &Contact) -> [f64; 2] {
    let ([nx, ny], [r_n, r_t]) = (contact.normal, contact.impulse);
    [r_n * nx - r_t * ny, r_n * ny + r_t * nx]
}

fn velocity_before(bodies: &Bodies, state: &State, body: usize) -> [f64; 3] {
    if body < bodies.free {
        return state.velocities[body];
    }
    if let Some(disk) = bodies.glued_index(body) {
        return [
            state.glued_velocity[2 * disk],
            state.glued_velocity[2 * disk + 1],
            0.0,
        ];
    }
    if Some(body) == bodies.wheel() {
        return [state.wheel.velocity[0], state.wheel.velocity[1], 0.0];
    }
    let [x, y] = bodies.wall_of(body).map_or([0.0; 2], |wall| wall.velocity);
    [x, y, 0.0]
}
