//! The contact problem of a step: free velocities, detection, and the contacts that may carry force.

mod detection;
mod packs;

use std::ops::Range;

use detection::{Detection, let_go};
use packs::Pack;

use super::{StepInput, Stepper};
use crate::bodies::Bodies;
use crate::bodies::geometry::{Proximity, extent};
use crate::bodies::levers::Levers;
use crate::bodies::positions::Positions;
use crate::contact::bond::{Bond, BondContact, BondCursor};
use crate::contact::detect::Slot;
use crate::contact::hand_over::hand_over;
use crate::contact::shared::share_springs;
use crate::solver::contact::{BodyRecord, Contact, NO_BOND, NO_LEVERS};
use crate::solver::partition::{Partition, in_pieces};
use crate::solver::problem::Attraction;
use crate::solver::rolling::Couple;
use crate::step::state::GrainState;

/// Consecutive slots with their contacts without a bond.
struct Loose<'a> {
    first: usize,
    slots: &'a mut [Slot],
    /// Number of bonded slots.
    bonded: usize,
    /// The contacts without a bond, by slot.
    loose: Vec<(u32, Contact)>,
}

impl Stepper {
    /// Free velocities and contacts.
    pub fn assemble(&mut self, state: &mut GrainState, input: &StepInput, parallel: bool) {
        let bodies = input.bodies;
        if bodies.softens() {
            state.heat.feel();
        }
        self.problem.friction = bodies.law.friction;
        self.problem.frictions.clear();
        let frictions = bodies.pairs.laws().iter().map(|law| law.friction);
        self.problem.frictions.extend(frictions);
        let cohesion = bodies.law.cohesion.filter(|_| bodies.has_one_law());
        self.problem.cohesion = cohesion.map(|law| (law, input.step));
        self.problem.first_glued = bodies.free;
        self.problem.surface_points = bodies.surface.points.len();
        self.problem.first_foot = bodies.count();
        self.problem.boundary.feet.clear();
        self.problem.wheel = bodies.wheel();
        self.problem.wheel_turn = input.turn.inverse_mass();
        self.problem.rounding = 4.0 * f64::EPSILON * extent(&state.centres) / input.step;
        self.problem.boundary.start(input.free_velocity);
        self.free_records(state, input);
        let travel = input.step * self.top_speed(bodies);
        let mut list = std::mem::take(&mut state.list);
        if !bodies.face.is_empty() {
            let [x, _] = state.wheel.position;
            state.place_face(bodies, x + (1.0 - input.theta) * (input.wheel_x - x));
        }
        let mut bonds = std::mem::take(&mut state.bonds);
        let positions = positions_at_detection(state, input);
        list.refresh(&positions, travel, bonds.iter().map(Bond::pair));
        self.torn.clear();
        if bodies.has_joints() {
            self.torn = hand_over(&mut list.slots, &mut bonds, (&positions, state));
            let missing = |grain| state.feed.missing(grain);
            share_springs(&mut list.slots, &bonds, &positions, missing);
        }
        let torn = self.torn.iter();
        torn.for_each(|(_, loss)| state.ledger.lose(loss));
        state.bonds = bonds;
        let positions = positions_at_detection(state, input);
        self.problem.levers.clear();
        let at = Detection {
            state,
            input,
            positions: &positions,
            compliance: bodies.law.compliance(input.step),
            reach: bodies.alert + 2.0 * travel,
        };
        let several = Partition::new(list.slots.len(), bodies.count()).several();
        if parallel && several && bodies.clusters.list.is_empty() {
            self.take_side_by_side(&at, &mut list.slots);
        } else {
            self.take_in_turn(&at, &mut list.slots);
        }
        self.place_feet(&at, &list.slots);
        self.place_couples(&at, &mut list.slots);
        self.place_attractions(&at, &mut list.slots);
        self.problem.softening.clear();
        if bodies.softens() {
            let slots = self.slots.iter().map(|index| &list.slots[*index as usize]);
            let factors = slots.map(|slot| {
                let cold = bodies.law_of(slot.a as usize, slot.b as usize).friction;
                let warm = state.law_of(bodies, [slot.a, slot.b]).friction;
                if cold > 0.0 { warm / cold } else { 1.0 }
            });
            self.problem.softening.extend(factors);
        }
        state.list = list;
    }

    /// Adds the couples of contacts without a bond whose law resists rolling.
    fn place_couples(&mut self, at: &Detection, slots: &mut [Slot]) {
        let bodies = at.input.bodies;
        self.problem.couples.clear();
        if !bodies.any_law(|law| law.rolling > 0.0) {
            return;
        }
        for (number, (contact, index)) in self.problem.contacts.iter().zip(&self.slots).enumerate()
        {
            let slot = &mut slots[*index as usize];
            let before = std::mem::take(&mut slot.couple);
            let coefficient = bodies.law_at(contact.pair_law).rolling;
            if contact.bond != NO_BOND || coefficient == 0.0 {
                continue;
            }
            let turning = [slot.a, slot.b].map(|body| {
                let body = body as usize;
                let (curvature, inverse) = match bodies.clusters.of(body) {
                    Some((_, cluster)) => (
                        1.0 / cluster.radius,
                        cluster.inverse_mass(&at.input.step_time())[2],
                    ),
                    None if body < bodies.free => {
                        (1.0 / bodies.radii[body], self.problem.inverse_mass(body)[2])
                    }
                    None => (0.0, 0.0),
                };
                (curvature, inverse * curvature)
            });
            self.problem.couples.push(Couple {
                contact: number as u32,
                curvature: turning.map(|(curvature, _)| curvature),
                inverse: turning.map(|(_, inverse)| inverse),
                radius: bodies.reduced_radius([slot.a, slot.b]),
                coefficient,
                impulse: at.input.step * before,
            });
        }
    }

    /// Adds the attractions of pairs within the range of their adhesion; among the contacts of a disk on one face only the nearest attracts.
    fn place_attractions(&mut self, at: &Detection, slots: &mut [Slot]) {
        self.problem.attractions.clear();
        if !at.input.bodies.attracts() {
            return;
        }
        let mut first = 0;
        while first < self.slots.len() {
            let on_face = self.on_one_face(at, slots, first);
            first = on_face.end;
            self.attract(at, slots, on_face);
        }
    }

    /// The contacts of a disk, from a first one on, with segments of one face whose corners are within its range; any other contact is alone.
    fn on_one_face(&self, at: &Detection, slots: &[Slot], first: usize) -> Range<usize> {
        let (bodies, a) = (at.input.bodies, slots[self.slots[first] as usize].a);
        let law = bodies.law_at(self.problem.contacts[first].pair_law);
        let range = law.adhesion.map_or(0.0, |law| law.range);
        let reaches = |from: usize, to: usize| {
            let mut last = from;
            while let Some((next, gap)) = at.positions.corner(a as usize, last)
                && gap < range
                && next != from
                && last != to
            {
                last = next;
            }
            last == to
        };
        let joined = self.slots[first..].windows(2).take_while(|pair| {
            let [one, next] = [pair[0], pair[1]].map(|index| &slots[index as usize]);
            let faces = [one.b, next.b].map(|body| body as usize);
            let same = next.a == a && faces[0] >= bodies.first_wall();
            same && (reaches(faces[0], faces[1]) || reaches(faces[1], faces[0]))
        });
        first..first + 1 + joined.count()
    }

    fn attract(&mut self, at: &Detection, slots: &mut [Slot], on_face: Range<usize>) {
        let gap = |number: &usize| self.problem.contacts[*number].gap;
        let nearest = on_face.clone().min_by(|i, j| gap(i).total_cmp(&gap(j)));
        let nearest = nearest.unwrap_or(on_face.start);
        let contact = &self.problem.contacts[nearest];
        let index = self.slots[nearest] as usize;
        let (mut before, mut last_gap) = (0.0, slots[index].last_gap);
        for number in on_face {
            let slot = &mut slots[self.slots[number] as usize];
            if slot.attraction > 0.0 {
                (before, last_gap) = (std::mem::take(&mut slot.attraction), slot.last_gap);
            }
        }
        let Some(law) = &at.input.bodies.law_at(contact.pair_law).adhesion else {
            return;
        };
        let slot = &mut slots[index];
        let radius = at.input.bodies.reduced_radius([slot.a, slot.b]);
        slot.attraction = law.attraction(radius, contact.gap);
        if before > 0.0 || slot.attraction > 0.0 {
            self.problem.attractions.push(Attraction {
                contact: nearest as u32,
                force: [before, slot.attraction],
                impulse: at.input.step * slot.attraction,
                last_gap,
            });
        }
    }

    /// Adds the feet of contacts with segments of the surface.
    fn place_feet(&mut self, at: &Detection, slots: &[Slot]) {
        let (bodies, surface) = (at.input.bodies, &at.input.bodies.surface);
        if surface.segments() == 0 {
            return;
        }
        for index in 0..self.slots.len() {
            let slot = &slots[self.slots[index] as usize];
            let Some(segment) = bodies.segment_index(slot.b as usize) else {
                continue;
            };
            let centre = at.state.centres[slot.a as usize];
            let foot = surface.foot(segment, at.positions.surface, centre);
            let mut contact = self.problem.contacts[index];
            contact.b = self.problem.records.len() as u32;
            contact.glued = true;
            let foot = surface.on_boundary(foot, bodies.glued());
            self.problem.boundary.feet.push(foot);
            self.problem.records.push(BodyRecord::default());
            let law = bodies.law_at(contact.pair_law);
            if law.restitution.is_some() && contact.bond == NO_BOND {
                let [before, _] = self.relative_before(bodies, at.state, &contact);
                let bias = law.bias(contact.gap, before, at.input.step);
                contact.bias[0] = bias.unwrap_or(contact.bias[0]);
            }
            self.problem.contacts[index] = contact;
        }
    }

    /// Makes the contacts of the slots, one after the other, or side by side where they are alike.
    fn take_in_turn(&mut self, at: &Detection, slots: &mut [Slot]) {
        self.problem.contacts.clear();
        self.problem.bonds.clear();
        self.slots.clear();
        let mut bonds = BondCursor::new(&at.state.bonds);
        let mut pack = Pack::default();
        let alike = at.input.bodies.alike().is_some() && !at.state.feed.grows();
        for index in 0..slots.len() {
            let slot = &mut slots[index];
            let bond = bonds.find((slot.a, slot.b));
            if bond.is_none() && at.stay_apart(slot) {
                let_go(slot);
            } else if !alike {
                self.take(at, (index, slot), bond);
            } else if slot.b as usize >= at.input.bodies.free {
                pack.wait(index, bond, None);
            } else if pack.add(at, &self.problem.records, (index, slot), bond) {
                self.make_contacts(at, &mut pack, slots);
            }
        }
        self.make_contacts(at, &mut pack, slots);
    }

    /// Makes the contact of a slot with this number and bond.
    fn take(
        &mut self,
        at: &Detection,
        (index, slot): (usize, &mut Slot),
        bond: Option<(usize, &Bond)>,
    ) {
        let (mut contact, near) = self.candidate(at, slot, bond.map(|(_, bond)| bond));
        if !at.input.bodies.clusters.list.is_empty() {
            self.take_levers(at, slot, &near, &mut contact);
        }
        if bond.is_none() && !self.accept(at, slot, &mut contact) {
            self.problem.levers.truncate(contact.levers as usize);
            let_go(slot);
            return;
        }
        if let Some(bond) = bond {
            contact.bond = self.problem.bonds.len() as u32;
            let bond = at.bonded(&mut contact, bond, &self.problem.records);
            self.problem.bonds.push(bond);
        }
        self.problem.contacts.push(contact);
        self.slots.push(index as u32);
    }

    /// The same by pieces, side by side: first the contacts without a bond, which may turn out open, and then all contacts, each at its position.
    fn take_side_by_side(&mut self, at: &Detection, slots: &mut [Slot]) {
        let mut contacts = std::mem::take(&mut self.problem.contacts);
        let mut bonds = std::mem::take(&mut self.problem.bonds);
        let mut indices = std::mem::take(&mut self.slots);
        let pieces = in_pieces(slots.len(), slots, true, |range, slots| {
            self.take_loose(at, range.start, slots)
        });
        let bonded: usize = pieces.iter().map(|piece| piece.bonded).sum();
        let count = bonded + pieces.iter().map(|p| p.loose.len()).sum::<usize>();
        contacts.resize(count, Contact::default());
        indices.resize(count, 0);
        bonds.resize(bonded, BondContact::default());
        let mut rest = (&mut contacts[..], (&mut indices[..], &mut bonds[..]));
        let mut first_bond = 0;
        let stepper = &*self;
        rayon::scope(|scope| {
            for piece in pieces {
                let (all, (places, bonds)) = rest;
                let count = piece.bonded + piece.loose.len();
                let (contacts, all) = all.split_at_mut(count);
                let (indices, places) = places.split_at_mut(count);
                let (bonds, others) = bonds.split_at_mut(piece.bonded);
                rest = (all, (places, others));
                let first = first_bond;
                first_bond += piece.bonded;
                scope
                    .spawn(move |_| stepper.take_all(at, piece, first, (contacts, indices, bonds)));
            }
        });
        (self.problem.contacts, self.problem.bonds, self.slots) = (contacts, bonds, indices);
    }

    /// Contacts without a bond of slots that count from `first`.
    fn take_loose<'a>(&self, at: &Detection, first: usize, slots: &'a mut [Slot]) -> Loose<'a> {
        let mut bonds = BondCursor::at(&at.state.bonds, slots.first());
        let (mut bonded, mut loose) = (0, Vec::new());
        for (index, slot) in (first..).zip(&mut *slots) {
            if bonds.find((slot.a, slot.b)).is_some() {
                bonded += 1;
                continue;
            }
            if at.stay_apart(slot) {
                let_go(slot);
                continue;
            }
            let (mut contact, _) = self.candidate(at, slot, None);
            if self.accept(at, slot, &mut contact) {
                loose.push((index as u32, contact));
            } else {
                let_go(slot);
            }
        }
        Loose {
            first,
            slots,
            bonded,
            loose,
        }
    }

    /// All contacts of a piece, with bonds that count from `first_bond`.
    fn take_all(
        &self,
        at: &Detection,
        piece: Loose,
        first_bond: usize,
        (contacts, indices, bonds): (&mut [Contact], &mut [u32], &mut [BondContact]),
    ) {
        let mut cursor = BondCursor::at(&at.state.bonds, piece.slots.first());
        let mut loose = piece.loose.into_iter().peekable();
        let mut bonds = (first_bond as u32..).zip(bonds);
        let mut places = contacts.iter_mut().zip(indices);
        for (index, slot) in (piece.first as u32..).zip(&*piece.slots) {
            let contact = match cursor.find((slot.a, slot.b)) {
                Some(bond) => {
                    let (mut contact, _) = self.candidate(at, slot, Some(bond.1));
                    if let Some((number, bonded)) = bonds.next() {
                        *bonded = at.bonded(&mut contact, bond, &self.problem.records);
                        contact.bond = number;
                    }
                    contact
                }
                None => match loose.next_if(|(accepted, _)| *accepted == index) {
                    Some((_, contact)) => contact,
                    None => continue,
                },
            };
            if let Some((place, slot)) = places.next() {
                (*place, *slot) = (contact, index);
            }
        }
    }

    /// Free velocities v_free = v + h M^-1 F (equation 7 of Renouf, Saulot and Berthier 2006), F being the weights and the load of the wheel, and
    /// prescribed velocities.
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
        let fixed = |[x, y]: [f64; 2]| BodyRecord {
            velocity: [x, y, 0.0],
            inverse_mass: 0.0,
        };
        if let (Some([x, y]), Some(grain)) = (bodies.prescribed_velocity, records.first_mut()) {
            *grain = fixed([x, y]);
        }
        records.resize(bodies.disks(), BodyRecord::default());
        if let Some(mass) = bodies.wheel_mass {
            let x_velocity = (input.wheel_x - state.wheel.position[0]) / h;
            let y_velocity = state.wheel.velocity[1] - h * input.load / mass;
            records.push(BodyRecord {
                velocity: [
                    x_velocity,
                    y_velocity,
                    input.turn.velocity(state.wheel.turn, h),
                ],
                inverse_mass: 1.0 / mass,
            });
        }
        records.extend(bodies.walls.iter().map(|wall| fixed(wall.velocity)));
        // Until its contacts have feet, a segment moves like its middle.
        let surface = &bodies.surface;
        let middle = |index| surface.on_boundary(surface.middle(index), bodies.glued());
        let segments = (0..surface.segments()).map(middle);
        records.extend(segments.map(|foot| fixed(foot.mean(input.free_velocity))));
        let feet = self.problem.boundary.feet.len();
        records.resize(records.len() + feet, BodyRecord::default());
    }

    fn top_speed(&self, bodies: &Bodies) -> f64 {
        let problem = &self.problem;
        // The list of pairs follows the way of a wheel that rolls.
        let rolling = bodies.wheel().filter(|_| bodies.rolls);
        let records = problem.records.iter().enumerate();
        let records = records.map(|(body, r)| {
            let along = if rolling == Some(body) {
                0.0
            } else {
                r.velocity[0]
            };
            [along, r.velocity[1]]
        });
        let glued = problem.boundary.velocity.chunks_exact(2);
        let glued = glued.map(|v| [v[0], v[1]]);
        let squares = records.chain(glued).map(|v| v[0] * v[0] + v[1] * v[1]);
        let speed = squares.fold(0.0, f64::max).sqrt();
        let clusters = bodies.clusters.list.iter();
        let turning = clusters.map(|c| c.top_speed(problem.records[c.leader()].velocity));
        turning.fold(speed, f64::max)
    }

    /// The contact of a slot, open or not, with friction and compliance of its law.
    #[inline(always)]
    fn candidate(&self, at: &Detection, slot: &Slot, bond: Option<&Bond>) -> (Contact, Proximity) {
        let (state, bodies, h) = (at.state, at.input.bodies, at.input.step);
        let pair = [slot.a as usize, slot.b as usize];
        let mut near = at.positions.proximity(pair[0], pair[1]);
        if state.feed.grows() {
            near.gap += state.feed.missing(slot.a) + state.feed.missing(slot.b);
        }
        let is_glued = |body: usize| bodies.glued_index(body).is_some();
        let mut contact = Contact {
            a: slot.a,
            b: slot.b,
            glued: is_glued(pair[0]) || is_glued(pair[1]),
            normal: near.normal,
            gap: near.gap,
            relative_gap: match bodies.radii.get(slot.b as usize) {
                Some(radius) => near.gap / (radius + bodies.radii[slot.a as usize]),
                // The force of a grain acts at its foot.
                None if bodies.segment_index(pair[1]).is_some() => near.gap / bodies.radii[pair[0]],
                None => 0.0,
            },
            bias: match bond {
                None => [0.0, slot.spring / h],
                Some(bond) => [(near.gap - bond.reference) / h, 0.0],
            },
            compliance: at.compliance,
            impulse: slot.pressure().map(|force| h * force),
            bond: NO_BOND,
            levers: NO_LEVERS,
            ..Contact::default()
        };
        if let Some((own, law)) = bodies.pairs.of(pair[0], pair[1]) {
            (contact.pair_law, contact.compliance) = (own, law.compliance(h));
        }
        if slot.joined > 0.0 {
            contact.compliance = contact.compliance.map(|c| c * (1.0 + slot.joined));
        }
        if let Some(bond) = bond {
            contact.gap -= bond.reference;
            contact.compliance[1] = 0.0;
        }
        if !bodies.face.is_empty() {
            contact.b = bodies.pushed(pair[1]) as u32;
        }
        (contact, near)
    }

    /// Adds levers and inertia of a contact, if one of its bodies is in a cluster: its point is `contact.lever()` radii from the centre of either
    /// disk.
    fn take_levers(
        &mut self,
        at: &Detection,
        slot: &Slot,
        near: &Proximity,
        contact: &mut Contact,
    ) {
        let (state, bodies) = (at.state, at.input.bodies);
        let pair = [slot.a as usize, slot.b as usize];
        let clusters = pair.map(|body| bodies.clusters.of(body));
        if clusters.iter().all(Option::is_none) {
            return;
        }
        let (arm, time) = (contact.lever(), at.input.step_time());
        let mut levers = Levers::default();
        for (i, side) in [-arm, arm].into_iter().enumerate() {
            let body = pair[i];
            (levers.lever[i], levers.inverse[i]) = match clusters[i] {
                None => ([0.0, side], self.problem.inverse_mass(body)),
                Some((index, cluster)) => {
                    let (pose, centre) = (&state.clusters[index], state.centres[body]);
                    let reach = side * bodies.radii[body];
                    let lever = cluster.lever(pose, near.normal, centre, reach);
                    (lever, cluster.inverse_mass(&time))
                }
            };
        }
        contact.levers = self.problem.levers.len() as u32;
        self.problem.levers.push(levers);
        [contact.a, contact.b] = pair.map(|body| bodies.clusters.leader_of(body) as u32);
    }

    /// Gives a contact without bond its bias; false if the pair stays apart in this step and carried no force in the last one.
    fn accept(&self, at: &Detection, slot: &mut Slot, contact: &mut Contact) -> bool {
        let (bodies, h) = (at.input.bodies, at.input.step);
        if slot.joined == f64::INFINITY {
            return false;
        }
        contact.gap = slot.gap(contact.gap);
        let approach = self.problem.relative_velocity(contact)[0].min(0.0);
        // The way to a segment that has passed the disk to another is infinite.
        let held = contact.impulse[0] > 0.0 && contact.gap.is_finite();
        let touches = held || slot.attraction > 0.0 || contact.gap + h * approach < bodies.alert;
        let law = bodies.law_at(contact.pair_law);
        let before = match law.restitution {
            Some(_) if touches => self.relative_before(bodies, at.state, contact)[0],
            _ => 0.0,
        };
        let bias = law.bias(contact.gap, before, h);
        let Some(bias) = bias.filter(|_| touches) else {
            return false;
        };
        contact.bias[0] = bias;
        let damped = law.springs.filter(|springs| springs.damping > 0.0);
        if let Some(springs) = damped.filter(|_| contact.gap < 0.0) {
            let (pair, records) = ([slot.a, slot.b], &self.problem.records);
            let mobility = at.mobility(pair, contact, contact.normal, records);
            let share = springs.damped_share(mobility, h);
            contact.bias[0] *= share;
            contact.compliance[0] *= share;
        }
        true
    }
}

/// Positions at which contacts are detected. Grains and height of the wheel have drifted already; the wheel's prescribed motion is uniform within the
/// step.
fn positions_at_detection<'a>(state: &'a GrainState, input: &StepInput<'a>) -> Positions<'a> {
    let bodies = input.bodies;
    let mut positions = state.positions(bodies);
    if bodies.wheel_radius > 0.0 {
        positions.wheel[0] += (1.0 - input.theta) * (input.wheel_x - state.wheel.position[0]);
    }
    positions
}
