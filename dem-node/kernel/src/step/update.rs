//! The contacts at the end of a step: forces, springs and bonds, and the energy that they lost.

mod packs;
mod totals;

use packs::{Pack, common_law, is_plain};
use protocol::larger;
pub(super) use totals::OuterImpulses;
use totals::{LANES, Totals, UpdatePiece};

use super::{StepInput, StepSummary, Stepper};
use crate::bodies::Bodies;
use crate::contact::bond::{self, Bond};
use crate::contact::detect::Slot;
use crate::contact::loss::{ContactStep, attraction_loss, contact_loss, rigid_loss, turned};
use crate::solver::contact::{Contact, NO_BOND};
use crate::solver::partition::in_pieces;
use crate::step::ledger::GrainLedger;
use crate::step::state::GrainState;
use crate::step::temperature::PairHeat;

impl Stepper {
    /// Stores forces and springs, and sums losses, forces and overlaps; in pieces with many contacts.
    pub(super) fn update_contacts(
        &mut self,
        state: &mut GrainState,
        input: &StepInput,
        parallel: bool,
    ) -> (StepSummary, OuterImpulses) {
        let h = input.step;
        let mut slots = std::mem::take(&mut state.list.slots);
        let mut bonds = std::mem::take(&mut state.bonds);
        let all = UpdatePiece {
            contacts: &self.problem.contacts,
            slot_indices: &self.slots,
            slots: &mut slots,
            first_slot: 0,
            bonds: &mut bonds,
            first_bond: 0,
            bonded: &self.problem.bonds,
        };
        let ledger = state.ledger;
        let mut summary = StepSummary {
            listed: self.problem.contacts.len(),
            ..StepSummary::default()
        };
        let rest = &*state;
        // The first piece adds to the ledger of the last step, so that few contacts are added one by one.
        let opened = |first: usize| (first == 0).then_some(ledger);
        let pieces = in_pieces(summary.listed, all, parallel, |range, piece| {
            let ledger = opened(range.start).unwrap_or_default();
            self.update_piece(rest, input, piece, ledger)
        });
        let mut outer = OuterImpulses::default();
        for (index, (of_piece, booked, impulses)) in pieces.into_iter().enumerate() {
            summary.join(&of_piece);
            outer.join(impulses);
            if index == 0 {
                state.ledger = booked;
            } else {
                state.ledger.join(&booked);
            }
        }
        for (segment, work) in &outer.rubbed {
            state.worn.rub(*segment, *work);
        }
        self.update_couples(state, input, &mut slots, &mut outer.warmed);
        if input.bodies.heat.is_some() {
            let torn = self.torn.iter();
            let torn = torn.map(|(pair, loss)| PairHeat::of(*pair, loss));
            outer.warmed.extend(torn);
        }
        self.update_attractions(state, input, &slots, (&mut summary, &mut outer));
        bonds.retain(|bond| bond.adhesion > 0.0);
        self.make_bonds(state, input, &mut slots, &mut bonds);
        (state.list.slots, state.bonds) = (slots, bonds);
        summary.overlap[0] /= summary.closed.max(1) as f64;
        for impulse in self.problem.boundary.impulse.chunks_exact(2) {
            summary.on_boundary[0] += impulse[0] / h;
            summary.on_boundary[1] += impulse[1] / h;
        }
        (summary, outer)
    }

    /// Stores the couples, and records their loss as slip, the impulse times the relative spin.
    fn update_couples(
        &self,
        state: &mut GrainState,
        input: &StepInput,
        slots: &mut [Slot],
        warmed: &mut Vec<PairHeat>,
    ) {
        for couple in &self.problem.couples {
            let contact = &self.problem.contacts[couple.contact as usize];
            let slot = &mut slots[self.slots[couple.contact as usize] as usize];
            slot.couple = couple.impulse / input.step;
            let pair = [contact.a, contact.b].map(|body| body as usize);
            let spin = couple.spin(pair.map(|body| self.problem.records[body].velocity[2]));
            let before = pair.map(|body| state.velocities.get(body).map_or(0.0, |v| v[2]));
            let step = ContactStep {
                velocity: [0.0, spin],
                change: [0.0, spin - couple.spin(before)],
                theta: input.theta,
                // Taken at the velocity of the law, so that it never creates energy; the scheme keeps its own loss.
                elastic: false,
                ..ContactStep::default()
            };
            let loss = rigid_loss(&step, [0.0, couple.impulse]);
            state.ledger.lose(&loss);
            if input.bodies.heat.is_some() {
                warmed.push(PairHeat::of([slot.a, slot.b], &loss));
            }
        }
    }

    /// Makes the bonds of pairs that have been pressed together for long enough.
    fn make_bonds(
        &self,
        state: &mut GrainState,
        input: &StepInput,
        slots: &mut [Slot],
        bonds: &mut Vec<Bond>,
    ) {
        let bodies = input.bodies;
        if !bodies.heals() {
            return;
        }
        let before = bonds.len();
        let loose = self.problem.contacts.iter().zip(&self.slots);
        for (_, index) in loose.filter(|(contact, _)| contact.bond == NO_BOND) {
            let slot = &mut slots[*index as usize];
            let law = state.law_of(bodies, [slot.a, slot.b]);
            let (Some(healing), Some(cohesion)) = (&law.healing, &law.cohesion) else {
                continue;
            };
            let area = Bond::area(bodies, cohesion, [slot.a, slot.b]);
            let heals = healing.presses(slot.force[0], area) && slot.joined == 0.0;
            // Warmth makes the time T shorter: what counts is the part of T.
            let cold = bodies.law_of(slot.a as usize, slot.b as usize).healing;
            let faster = cold.map_or(1.0, |cold| cold.time / healing.time);
            let pressed = slot.pressed + input.step * faster;
            slot.pressed = if heals { pressed } else { 0.0 };
            if let Some((bond, loss)) = Bond::healed(bodies, slot, cohesion) {
                (slot.pressed, slot.spring, slot.reference) = (0.0, 0.0, 0.0);
                slot.last_gap = bond.opening;
                state.ledger.lose(&loss);
                state.ledger.bonds_made += 1;
                bonds.push(bond);
            }
        }
        if bonds.len() > before {
            bonds.sort_by_key(Bond::pair);
        }
    }

    /// Adds the attractions to the impulses of their contacts, and records their losses.
    fn update_attractions(
        &mut self,
        state: &mut GrainState,
        input: &StepInput,
        slots: &[Slot],
        (summary, outer): (&mut StepSummary, &mut OuterImpulses),
    ) {
        for index in 0..self.problem.attractions.len() {
            let attraction = self.problem.attractions[index];
            let number = attraction.contact as usize;
            let attracting = self.problem.attracting(index);
            let Some(law) = &input.bodies.law_at(attracting.pair_law).adhesion else {
                continue;
            };
            let before = Slot {
                last_gap: attraction.last_gap,
                ..slots[self.slots[number] as usize]
            };
            let passing = passing(input.bodies, state, &before);
            let step = self.contact_step((state, input), &attracting, &before, passing);
            let loss = attraction_loss(law, attraction.force, &step);
            state.ledger.lose(&loss);
            add_push(input.bodies, &attracting, input.step, (summary, outer));
            self.problem.contacts[number].impulse[0] -= attraction.impulse;
        }
    }

    fn update_piece(
        &self,
        state: &GrainState,
        input: &StepInput,
        mut piece: UpdatePiece,
        ledger: GrainLedger,
    ) -> (StepSummary, GrainLedger, OuterImpulses) {
        let mut totals = Totals {
            ledger,
            ..Totals::default()
        };
        let law = common_law(input);
        let (mut packs, mut passed) = ([Pack::default(); 2], [0; 2]);
        for index in 0..piece.contacts.len() {
            let contact = &piece.contacts[index];
            let kind = usize::from(contact.bond != NO_BOND);
            let plain = is_plain(input.bodies, contact);
            if let Some(law) = law.filter(|_| plain) {
                let (at, pack) = ((state, input, law), (&mut packs[kind], index));
                self.pack(at, &mut piece, pack, &mut totals);
                continue;
            }
            let lane = plain.then_some((kind, passed[kind] % LANES));
            passed[kind] += usize::from(plain);
            self.update_contact((state, input), &mut piece, (index, lane), &mut totals);
        }
        for (kind, pack) in packs.iter().enumerate() {
            for (k, index) in pack.members().iter().enumerate() {
                let lane = Some((kind, k));
                self.update_contact((state, input), &mut piece, (*index, lane), &mut totals);
            }
        }
        for packs in totals.packs {
            packs.join(&mut totals);
        }
        (totals.summary, totals.ledger, totals.outer)
    }

    /// Stores force and spring or bond of a contact, and adds its loss, to a lane where packs have one for it.
    fn update_contact(
        &self,
        (state, input): (&GrainState, &StepInput),
        piece: &mut UpdatePiece,
        (index, lane): (usize, Option<(usize, usize)>),
        totals: &mut Totals,
    ) {
        let (bodies, h, contact) = (input.bodies, input.step, &piece.contacts[index]);
        let slot = &mut piece.slots[piece.slot_indices[index] as usize - piece.first_slot];
        let (summary, outer) = (&mut totals.summary, &mut totals.outer);
        let passing = passing(bodies, state, slot);
        let done = self.contact_step((state, input), contact, slot, passing);
        let loss = match self.problem.bonds.get(contact.bond as usize) {
            None => {
                let law = bodies.law_at(contact.pair_law);
                let loss = match slot.joined {
                    0.0 => contact_loss(law, &done),
                    joined => contact_loss(&law.shared(joined), &done),
                };
                slot.force = done.impulse.map(|impulse| 1.0 / h * impulse);
                slot.force[0] -= slot.attraction;
                slot.spring = done.spring[1];
                slot.last_gap = done.gap + h * done.velocity[0];
                loss
            }
            Some(solved) => {
                let bond = &mut piece.bonds[solved.index as usize - piece.first_bond];
                let after = self.adhesion[contact.bond as usize];
                let law = state.law_of(bodies, [slot.a, slot.b]);
                let loss = bond::end_step(&law, bond, slot, &done, solved, after);
                let load = bond.load_squared(&law);
                summary.bond_load_squared = larger(summary.bond_load_squared, load);
                loss
            }
        };
        if state.worn.detaches()
            && let Some(segment) = bodies.segment_index(slot.b as usize)
        {
            outer.rubbed.push((segment, loss.friction));
        }
        if bodies.heat.is_some() {
            outer.warmed.push(PairHeat::of([slot.a, slot.b], &loss));
        }
        let mut overlap = 0.0;
        if done.impulse[0] > 0.0 {
            overlap = larger(0.0, -done.gap - h * done.velocity[0]);
            summary.closed += 1;
            summary.overlap[1] = larger(summary.overlap[1], overlap);
            let travel = h * passing_speed(bodies, contact, slot, passing);
            summary.travel = larger(summary.travel, travel);
        }
        add_push(bodies, contact, h, (summary, outer));
        match lane {
            Some((kind, k)) => totals.packs[kind].add(k, loss, overlap),
            None => {
                summary.overlap[0] += overlap;
                totals.ledger.lose(&loss);
            }
        }
    }

    #[inline(always)]
    fn contact_step(
        &self,
        (state, input): (&GrainState, &StepInput),
        contact: &Contact,
        slot: &Slot,
        passing: [f64; 2],
    ) -> ContactStep {
        let velocity = self.problem.relative_velocity(contact);
        let springs = input.bodies.law_at(contact.pair_law).springs;
        // For a spring it counts only with the weight 1 - theta.
        let before = if input.theta == 1.0 && springs.is_some() {
            velocity
        } else {
            self.relative_before(input.bodies, state, contact)
        };
        let own = springs.filter(|_| contact.bond == NO_BOND);
        let stretched = own.map_or(0.0, |s| {
            -contact.impulse[1] * (1.0 + slot.joined) / (input.step * s.tangential)
        });
        // The body of a compliant boundary places its disks: this ledger has no account for that. Feet are found again in each step.
        let on_disk = contact.glued && (slot.b as usize) < input.bodies.first_segment();
        let [last_gap, turned] = if on_disk && self.problem.boundary.is_compliant() {
            [contact.gap, 0.0]
        } else if springs.is_some() || contact.bond != NO_BOND || slot.attraction > 0.0 {
            [slot.last_gap, turn(input, contact, slot, passing)]
        } else {
            [slot.last_gap, 0.0]
        };
        ContactStep {
            step: input.step,
            theta: input.theta,
            gap: contact.gap,
            last_gap,
            turned_gap: last_gap + turned,
            spring: [slot.spring, stretched],
            impulse: contact.impulse,
            velocity,
            change: [velocity[0] - before[0], velocity[1] - before[1]],
            elastic: input.bodies.is_elastic(),
        }
    }

    /// (u_n, u_t) at the start of the step (m/s).
    #[inline(always)]
    pub(super) fn relative_before(
        &self,
        bodies: &Bodies,
        state: &GrainState,
        contact: &Contact,
    ) -> [f64; 2] {
        let a = velocity_before(bodies, state, contact.a as usize);
        let b = match contact.b as usize {
            body if body < bodies.count() => velocity_before(bodies, state, body),
            body => {
                let foot = &self.problem.boundary.feet[body - bodies.count()];
                let [x, y] = foot.mean(&state.glued_velocity);
                [x, y, 0.0]
            }
        };
        self.problem.project(contact, a, b)
    }
}

/// Adds the impulse of a contact to the forces on the wheel, and to the forces between the free grains and all other bodies.
fn add_push(
    bodies: &Bodies,
    contact: &Contact,
    h: f64,
    (summary, outer): (&mut StepSummary, &mut OuterImpulses),
) {
    outer.add(bodies, contact);
    if Some(contact.b as usize) == bodies.wheel() {
        let force = contact.in_xy(contact.impulse);
        summary.on_wheel[0] -= force[0] / h;
        summary.on_wheel[1] -= force[1] / h;
    }
}

/// Way (m) by which two disks, or a disk and a wheel that rolls, have come apart along the line of their centres while they passed each other by s in
/// the last step: s^2/(2 d), d being the distance of the centres.
#[inline(always)]
fn turn(input: &StepInput, contact: &Contact, slot: &Slot, passed: [f64; 2]) -> f64 {
    let (bodies, b) = (input.bodies, slot.b as usize);
    let radii = &bodies.radii;
    let rolls = bodies.rolls && Some(b) == bodies.wheel();
    let wheel = rolls.then_some(&bodies.wheel_radius);
    let Some(other) = radii.get(b).or(wheel) else {
        return 0.0;
    };
    let distance = (radii[slot.a as usize] + other) * contact.lever();
    turned(input.step, contact.normal, distance, passed)
}

/// Velocity of the first body of a slot against the second at the start of the step (m/s).
#[inline(always)]
fn passing(bodies: &Bodies, state: &GrainState, slot: &Slot) -> [f64; 2] {
    let alone = bodies.clusters.list.is_empty();
    let velocity = |body: usize| {
        if alone && body < bodies.free {
            state.velocities[body]
        } else {
            state.velocity_of(bodies, body)
        }
    };
    // With an array of both this would be a call and two copies.
    let (a, b) = (velocity(slot.a as usize), velocity(slot.b as usize));
    [a[0] - b[0], a[1] - b[1]]
}

/// Speed at which a disk passes another, in any direction, or comes to a face, along its normal; over the smaller radius (1/s).
#[inline(always)]
fn passing_speed(bodies: &Bodies, contact: &Contact, slot: &Slot, [x, y]: [f64; 2]) -> f64 {
    let own = bodies.radii[slot.a as usize];
    match bodies.radii.get(slot.b as usize) {
        Some(other) => (x * x + y * y).sqrt() / own.min(*other),
        None => (x * contact.normal[0] + y * contact.normal[1]).abs() / own,
    }
}

#[inline(always)]
fn velocity_before(bodies: &Bodies, state: &GrainState, body: usize) -> [f64; 3] {
    if body < bodies.free {
        return state.velocities[body];
    }
    let [x, y, spin] = state.velocity_of(bodies, body);
    let turn = if bodies.wheel() == Some(body) {
        state.wheel.turn
    } else {
        spin
    };
    [x, y, turn]
}
