//! The contact problem of a step: free velocities, detection, and the contacts that may carry force.

use super::{StepInput, Stepper};
use crate::bodies::Bodies;
use crate::bodies::geometry::{Proximity, extent};
use crate::bodies::positions::{Positions, proximity};
use crate::contact::bond::{Bond, BondContact, BondCursor};
use crate::contact::detect::Slot;
use crate::solver::contact::{BodyRecord, Contact, NO_BOND, NO_LEVERS};
use crate::step::state::GrainState;

impl Stepper {
    /// Free velocities and contacts.
    pub(crate) fn assemble(&mut self, state: &mut GrainState, input: &StepInput) {
        let bodies = input.bodies;
        self.problem.friction = bodies.law.friction;
        self.problem.frictions.clear();
        self.problem.frictions.extend(bodies.pairs.frictions());
        self.problem.first_glued = bodies.free;
        self.problem.wheel = bodies.wheel();
        self.problem.rounding = 4.0 * f64::EPSILON * extent(&state.centres) / input.step;
        self.problem.boundary.start(input.free_velocity);
        self.free_records(state, input);
        let travel = input.step * self.top_speed(bodies);
        let mut list = std::mem::take(&mut state.list);
        if !bodies.face.is_empty() {
            let [x, _] = state.wheel.position;
            state.place_face(bodies, x + (1.0 - input.theta) * (input.wheel_x - x));
        }
        let positions = positions_at_detection(state, input);
        let bonded = state.bonds.iter().map(Bond::pair);
        list.refresh(bodies, &positions, travel, bonded);
        if bodies.has_joints() {
            list.hand_over(bodies, &positions);
        }
        self.problem.contacts.clear();
        self.problem.bonds.clear();
        self.problem.levers.clear();
        self.slots.clear();
        let mut bonds = BondCursor::new(&state.bonds);
        let compliance = bodies.law.compliance(input.step);
        for (index, slot) in list.slots.iter_mut().enumerate() {
            let mut at = proximity(bodies, &positions, slot.a as usize, slot.b as usize);
            if state.feed.grows() {
                at.gap += state.feed.missing(slot.a) + state.feed.missing(slot.b);
            }
            let bond = bonds.find((slot.a, slot.b));
            let gap = match bond {
                Some((_, bond)) => at.gap - bond.reference,
                None => slot.gap(at.gap),
            };
            let mut contact = self.candidate(state, input, slot, at, compliance);
            contact.gap = gap;
            if bond.is_none() && !self.accept(state, input, &mut contact) {
                // A contact that a rebound has opened leaves the problem: it must not keep its force.
                (slot.force, slot.last_gap) = ([0.0; 2], 0.0);
                continue;
            }
            if let Some((index, bond)) = bond {
                let law = bodies.law_of(contact.a as usize, contact.b as usize);
                contact.bond = self.problem.bonds.len() as u32;
                contact.bias = [contact.gap / input.step, 0.0];
                contact.compliance[1] = 0.0;
                let bonded = BondContact::new(law, bond, index, input.step);
                self.problem.bonds.push(bonded);
            }
            self.problem.contacts.push(contact);
            self.slots.push(index as u32);
        }
        state.list = list;
    }

    /// Free velocities v_free = v + h M^-1 F (equation 7 of Renouf, Saulot and Berthier 2006), F being the weights and the
    /// load of the wheel, with the velocities that are prescribed.
    pub fn free_records(&mut self, state: &GrainState, input: &StepInput) {
        let bodies = input.bodies;
        let records = &mut self.problem.records;
        records.clear();
        let h = input.step;
        records.extend(state.velocities.iter().zip(&bodies.masses).map(|(v, m)| {
            let kick = [h * bodies.gravity[0], h * bodies.gravity[1]];
            BodyRecord {
                velocity: [v[0] + kick[0], v[1] + kick[1], v[2]],
                inverse_mass: 1.0 / m,
            }
        }));
        for cluster in &bodies.clusters.list {
            for disk in &cluster.disks {
                records[*disk] = BodyRecord::default();
            }
            let start = state.velocities[cluster.leader()];
            records[cluster.leader()] = BodyRecord {
                velocity: cluster.free_velocity(start, bodies.gravity, &input.step_time()),
                inverse_mass: 1.0 / cluster.mass,
            };
        }
        if let (Some([x, y]), Some(grain)) = (bodies.prescribed_velocity, records.first_mut()) {
            *grain = BodyRecord {
                velocity: [x, y, 0.0],
                ..BodyRecord::default()
            };
        }
        records.resize(bodies.disks(), BodyRecord::default());
        if let Some(mass) = bodies.wheel_mass {
            let x_velocity = (input.wheel_x - state.wheel.position[0]) / h;
            let y_velocity = state.wheel.velocity[1] - h * input.load / mass;
            records.push(BodyRecord {
                velocity: [x_velocity, y_velocity, 0.0],
                inverse_mass: 1.0 / mass,
            });
        }
        records.extend(bodies.walls.iter().map(|wall| BodyRecord {
            velocity: [wall.velocity[0], wall.velocity[1], 0.0],
            inverse_mass: 0.0,
        }));
    }

    fn top_speed(&self, bodies: &Bodies) -> f64 {
        let problem = &self.problem;
        let records = problem
            .records
            .iter()
            .map(|r| [r.velocity[0], r.velocity[1]]);
        let glued = problem.boundary.velocity.chunks_exact(2);
        let glued = glued.map(|v| [v[0], v[1]]);
        let squares = records.chain(glued).map(|v| v[0] * v[0] + v[1] * v[1]);
        let speed = squares.fold(0.0, f64::max).sqrt();
        let clusters = bodies.clusters.list.iter();
        let turning = clusters.map(|c| c.top_speed(problem.records[c.leader()].velocity));
        turning.fold(speed, f64::max)
    }

    /// The contact that a slot would have, with friction and compliance of its law; its levers, if it needs any, join the problem.
    fn candidate(
        &mut self,
        state: &GrainState,
        input: &StepInput,
        slot: &Slot,
        at: Proximity,
        compliance: [f64; 2],
    ) -> Contact {
        let (bodies, h) = (input.bodies, input.step);
        let pair = [slot.a as usize, slot.b as usize];
        let glued = pair.map(|body| bodies.glued_index(body).is_some());
        let mut contact = Contact {
            a: slot.a,
            b: slot.b,
            glued: glued[0] || glued[1],
            normal: at.normal,
            gap: at.gap,
            relative_gap: match bodies.radii.get(slot.b as usize) {
                Some(radius) => at.gap / (radius + bodies.radii[slot.a as usize]),
                None => 0.0,
            },
            bias: [0.0, slot.spring / h],
            compliance,
            impulse: [h * slot.force[0], h * slot.force[1]],
            bond: NO_BOND,
            levers: NO_LEVERS,
            ..Contact::default()
        };
        if let Some((own, law)) = bodies.pairs.of(pair[0], pair[1]) {
            (contact.pair_law, contact.compliance) = (own, law.compliance(h));
        }
        if !bodies.face.is_empty() {
            contact.b = bodies.pushed(pair[1]) as u32;
        }
        if !bodies.clusters.list.is_empty() {
            let disk = |body: usize| (state.centres[body], bodies.radii[body]);
            let inverse = |body: usize| self.problem.inverse_mass(body);
            let levers = bodies.clusters.levers(
                &state.clusters,
                pair,
                &at,
                disk,
                inverse,
                &input.step_time(),
            );
            if let Some(levers) = levers {
                contact.levers = self.problem.levers.len() as u32;
                self.problem.levers.push(levers);
                [contact.a, contact.b] = pair.map(|body| bodies.clusters.leader_of(body) as u32);
            }
        }
        contact
    }

    /// Gives a contact without bond its bias; false if the pair stays apart in this step and carried no force in the last one.
    fn accept(&mut self, state: &GrainState, input: &StepInput, contact: &mut Contact) -> bool {
        let (bodies, h) = (input.bodies, input.step);
        let approach = self.problem.relative_velocity(contact)[0].min(0.0);
        let touches = contact.impulse[0] > 0.0 || contact.gap + h * approach < bodies.alert;
        let law = bodies.law_at(contact.pair_law);
        let before = match law.restitution {
            Some(_) if touches => self.relative_before(bodies, state, contact)[0],
            _ => 0.0,
        };
        let bias = law.bias(contact.gap, before, h);
        let Some(bias) = bias.filter(|_| touches) else {
            self.problem.levers.truncate(contact.levers as usize);
            return false;
        };
        contact.bias[0] = bias;
        let damped = law.springs.filter(|springs| springs.damping > 0.0);
        if let Some(springs) = damped.filter(|_| contact.gap < 0.0) {
            let inverse = |body: u32| self.problem.records[body as usize].inverse_mass;
            let share = springs.damped_share(inverse(contact.a) + inverse(contact.b), h);
            contact.bias[0] *= share;
            contact.compliance[0] *= share;
        }
        true
    }
}

/// Positions at which contacts are detected. Grains and height of the wheel have drifted already, its prescribed
/// way is uniform within the step.
fn positions_at_detection<'a>(state: &'a GrainState, input: &StepInput) -> Positions<'a> {
    let bodies = input.bodies;
    let mut positions = state.positions(bodies);
    if bodies.wheel_radius > 0.0 {
        positions.wheel[0] += (1.0 - input.theta) * (input.wheel_x - state.wheel.position[0]);
    }
    positions
}
