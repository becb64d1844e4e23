//! The state of the grains, which changes while they move: the checkpoint of the node.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use crate::bodies::Bodies;
use crate::bodies::cluster::Pose;
use crate::bodies::disk::Disk;
use crate::bodies::feed::Feed;
use crate::bodies::geometry::extent;
use crate::bodies::positions::Positions;
use crate::contact::bond::{Bond, BondCursor};
use crate::contact::detect::{Slot, VerletList};
use crate::contact::initial_bonds::initial_bonds;
use crate::contact::shared::share_springs;
use crate::law::Law;
use crate::step::ledger::GrainLedger;
use crate::step::temperature::Heat;
use crate::step::worn::Worn;

/// Everything that can change a later bit. A window is solved on a copy; committing it swaps the two.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct GrainState {
    /// Centres of free grains, then of glued disks, then of the wheel's face (m).
    pub centres: Vec<[f64; 2]>,
    /// Points of the surface (m).
    pub surface: Vec<[f64; 2]>,
    /// Velocities of the free grains: v_x, v_y, spin times radius (m/s); the first disk of a cluster has the cluster's.
    pub velocities: Vec<[f64; 3]>,
    /// Poses of the clusters.
    pub clusters: Vec<Pose>,
    /// Time for which moving walls have moved (s); 0 without moving walls.
    pub wall_motion_time: f64,
    /// Velocities of the glued disks and of the points of the surface, two components each (m/s).
    pub glued_velocity: Vec<f64>,
    /// The wheel.
    pub wheel: WheelState,
    /// Pairs that may touch, with their forces and springs.
    pub list: VerletList,
    /// Bonds that are not broken, sorted by (a, b).
    pub bonds: Vec<Bond>,
    /// Grains that are fed in.
    pub feed: Feed,
    /// Grains that were taken out of the plane, in order: no body meets them any more.
    pub taken: Vec<u32>,
    /// The wear of the bare surfaces.
    pub worn: Worn,
    /// Energy since the start, term by term.
    pub ledger: GrainLedger,
    /// The heat of the grains.
    pub heat: Heat,
}

/// Position and velocity of the wheel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WheelState {
    /// Sideways displacement and height of the lowest point of the face (m).
    pub position: [f64; 2],
    /// Its velocity; the sideways component is prescribed (m/s).
    pub velocity: [f64; 2],
    /// Velocity R omega of a face that turns (m/s), anticlockwise.
    pub turn: f64,
}

impl Clone for GrainState {
    fn clone(&self) -> GrainState {
        let mut copy = GrainState::default();
        copy.clone_from(self);
        copy
    }

    /// Reuses the buffers: a window is repeated thousands of times.
    fn clone_from(&mut self, other: &GrainState) {
        self.centres.clone_from(&other.centres);
        self.surface.clone_from(&other.surface);
        self.velocities.clone_from(&other.velocities);
        self.clusters.clone_from(&other.clusters);
        self.wall_motion_time = other.wall_motion_time;
        self.glued_velocity.clone_from(&other.glued_velocity);
        self.wheel = other.wheel;
        self.list.clone_from(&other.list);
        self.bonds.clone_from(&other.bonds);
        self.feed.clone_from(&other.feed);
        self.taken.clone_from(&other.taken);
        self.worn.clone_from(&other.worn);
        self.ledger = other.ledger;
        self.heat.clone_from(&other.heat);
    }
}

impl GrainState {
    /// 1/m of a disk of a cluster in a contact along this normal, 1/M as if the contact were in line with the centre of mass, and 1/M in the directions
    /// that nothing holds (1/kg); `None` for a single disk and for other bodies.
    #[inline(always)]
    pub(crate) fn mobility(
        &self,
        bodies: &Bodies,
        disk: usize,
        normal: [f64; 2],
    ) -> Option<[f64; 3]> {
        let (index, cluster) = bodies.clusters.of(disk)?;
        let pose = &self.clusters[index];
        let at = |centre| cluster.mobility(pose, normal, centre);
        let free = cluster.free.iter().copied().fold(0.0, f64::max) / cluster.mass;
        Some([at(self.centres[disk]), at(pose.centre), free])
    }

    /// The start: grains at their positions in the sample, the wheel on the first disk that it meets from above, and compliant contacts under the
    /// force of their overlap. Bonds are made here, at rest: gaps and overlaps do not stretch them.
    pub fn new(bodies: &Bodies, free: &[Disk], glued: &[Disk]) -> GrainState {
        let feed = Feed::new(bodies.injection.as_ref());
        let all = || free.iter().chain(glued);
        let present = free.len() - feed.waiting as usize;
        let there = free[..present].iter().chain(glued);
        let heights = there.filter_map(|d| bodies.wheel_height_on(d.centre, d.radius));
        let highest = heights.fold(f64::NEG_INFINITY, f64::max);
        let velocity = |d: &Disk| [d.velocity[0], d.velocity[1], d.velocity[2] * d.radius];
        let worn = match &bodies.injection {
            Some(feed) if feed.point().is_none() => Worn::new(bodies),
            _ => Worn::default(),
        };
        let mut state = GrainState {
            worn,
            centres: all().map(|disk| disk.centre).collect(),
            velocities: free.iter().map(velocity).collect(),
            surface: bodies.surface.points.clone(),
            glued_velocity: vec![0.0; 2 * bodies.boundary_points()],
            wheel: WheelState {
                position: [bodies.wheel_start, highest],
                velocity: [0.0; 2],
                turn: 0.0,
            },
            clusters: bodies.clusters.list.iter().map(|c| c.start).collect(),
            feed,
            heat: Heat::new(bodies.heat.as_ref(), bodies.free),
            ..GrainState::default()
        };
        for cluster in &bodies.clusters.list {
            state.velocities[cluster.leader()] = cluster.start_velocity;
        }
        state.place_face(bodies, 0.0);
        state.carry_surface(bodies);
        let mut list = VerletList::default();
        let positions = state.positions(bodies);
        list.refresh(&positions, 0.0, std::iter::empty());
        state.bonds = initial_bonds(&positions, &list);
        let positions = state.positions(bodies);
        // Again, with the bonded pairs beyond the reach of the list.
        list.invalidate();
        list.refresh(&positions, 0.0, state.bonds.iter().map(Bond::pair));
        share_springs(&mut list.slots, &state.bonds, &positions, |_| 0.0);
        state.list = list;
        state.load_springs(bodies, 0.0);
        state
    }

    /// The law between two bodies, at their temperatures where these change it.
    pub fn law_of<'a>(&self, bodies: &'a Bodies, [a, b]: [u32; 2]) -> Cow<'a, Law> {
        let pair = [a, b].map(|body| body as usize);
        let place = (self.centres[pair[0]], &self.surface[..]);
        let softened = self.heat.softened(bodies, pair, place);
        softened.map_or_else(
            || Cow::Borrowed(bodies.law_of(pair[0], pair[1])),
            Cow::Owned,
        )
    }

    /// Gives compliant contacts and attractions the force of the gap that the first step finds, which drifts for a time (s) before it detects contacts.
    pub fn load_springs(&mut self, bodies: &Bodies, drift: f64) {
        let mut ahead = self.clone();
        ahead.drift(bodies, drift);
        let positions = ahead.positions(bodies);
        let mut bonds = BondCursor::new(&self.bonds);
        for slot in &mut self.list.slots {
            if bonds.find((slot.a, slot.b)).is_some() {
                continue;
            }
            let gap = positions.proximity(slot.a as usize, slot.b as usize).gap;
            let law = bodies.law_of(slot.a as usize, slot.b as usize);
            (slot.force[0], slot.last_gap) = (0.0, 0.0);
            if let (Some(springs), true) = (law.springs, gap < 0.0) {
                slot.force[0] = -gap * springs.normal / (1.0 + slot.joined);
                slot.last_gap = gap;
            }
            if let Some(adhesion) = &law.adhesion {
                let radius = bodies.reduced_radius([slot.a, slot.b]);
                slot.attraction = adhesion.attraction(radius, gap);
                slot.force[0] -= slot.attraction;
                slot.last_gap = gap;
            }
        }
    }

    /// Positions of everything.
    pub fn positions<'a>(&'a self, bodies: &'a Bodies) -> Positions<'a> {
        let [x, y] = self.wheel.position;
        Positions {
            bodies,
            centres: &self.centres,
            surface: &self.surface,
            present: self.present(bodies),
            taken: &self.taken,
            wheel: [if bodies.wheel_radius > 0.0 { x } else { 0.0 }, y],
            wall_motion_time: self.wall_motion_time,
        }
    }

    /// Number of free grains that are not in store, which come first.
    pub fn present(&self, bodies: &Bodies) -> usize {
        bodies.free - self.feed.waiting as usize
    }

    /// Free grains that are neither in store nor taken out.
    pub fn grains<'a>(&'a self, bodies: &'a Bodies) -> impl Iterator<Item = usize> {
        let positions = self.positions(bodies);
        (0..positions.present).filter(move |grain| !positions.is_taken(*grain))
    }

    /// True for a grain in store or taken out.
    pub fn waits(&self, bodies: &Bodies, disk: usize) -> bool {
        let positions = self.positions(bodies);
        positions.store().contains(&disk) || positions.is_taken(disk)
    }

    /// Takes a grain out of the plane, with its motion, its contacts and its bonds: the ledger records the energy that is lost with it.
    pub fn take(&mut self, bodies: &Bodies, grain: usize) {
        let energy = |state: &GrainState| state.energies(bodies).iter().sum::<f64>();
        let before = energy(self);
        let number = grain as u32;
        let place = self.taken.partition_point(|taken| *taken < number);
        self.taken.insert(place, number);
        self.velocities[grain] = [0.0; 3];
        self.bonds
            .retain(|bond| bond.a != number && bond.b != number);
        let slots = &mut self.list.slots;
        slots.retain(|slot| slot.a != number && slot.b != number);
        self.list.invalidate();
        self.feed.forget(number);
        self.ledger.lateral += before - energy(self);
    }

    /// Present radius of a disk (m): 0 in store, less than its final radius while it grows.
    pub fn radius(&self, bodies: &Bodies, disk: usize) -> f64 {
        if self.waits(bodies, disk) {
            return 0.0;
        }
        bodies.radii[disk] - self.feed.missing(disk as u32)
    }

    /// Puts the disks of the face at the position of the wheel, with the sideways displacement `x` (m).
    pub fn place_face(&mut self, bodies: &Bodies, x: f64) {
        self.centres.truncate(bodies.first_face());
        let y = self.wheel.position[1];
        self.centres
            .extend(bodies.face.iter().map(|[dx, dy]| [dx + x, dy + y]));
    }

    /// Moves grains, wheel and walls with their velocities for a time t (s), q += t v; their boundary moves glued disks.
    pub fn drift(&mut self, bodies: &Bodies, time: f64) {
        for (centre, velocity) in self.centres.iter_mut().zip(&self.velocities) {
            centre[0] += time * velocity[0];
            centre[1] += time * velocity[1];
        }
        for (pose, cluster) in self.clusters.iter_mut().zip(&bodies.clusters.list) {
            let velocity = self.velocities[cluster.leader()];
            cluster.drift(pose, velocity, time, &mut self.centres);
        }
        self.wheel.position[1] += time * self.wheel.velocity[1];
        if bodies.wall_speed() > 0.0 {
            self.wall_motion_time += time;
        }
    }

    /// Moves the points of the surface that glued disks carry with these disks.
    pub fn carry_surface(&mut self, bodies: &Bodies) {
        let glued = &self.centres[bodies.free..bodies.first_face()];
        bodies.surface.carry(glued, &mut self.surface);
    }

    /// Velocity of the centre of a disk (m/s, m/s) and its spin (rad/s), or of the wheel, a wall or the middle of a segment.
    pub fn velocity_of(&self, bodies: &Bodies, disk: usize) -> [f64; 3] {
        if let Some(wall) = bodies.wall_of(disk) {
            return [wall.velocity[0], wall.velocity[1], 0.0];
        }
        if let Some(segment) = bodies.segment_index(disk) {
            let surface = &bodies.surface;
            let middle = surface.on_boundary(surface.middle(segment), bodies.glued());
            let [x, y] = middle.mean(&self.glued_velocity);
            return [x, y, 0.0];
        }
        if let Some(glued) = bodies.glued_index(disk) {
            let [x, y] = [0, 1].map(|k| self.glued_velocity[2 * glued + k]);
            return [x, y, 0.0];
        }
        if bodies.is_wheel(disk) {
            return [self.wheel.velocity[0], self.wheel.velocity[1], 0.0];
        }
        match bodies.clusters.of(disk) {
            None => {
                let [x, y, spin] = self.velocities[disk];
                [x, y, spin / bodies.radii[disk]]
            }
            Some((index, cluster)) => {
                let velocity = self.velocities[cluster.leader()];
                cluster.velocity_at(&self.clusters[index], velocity, self.centres[disk])
            }
        }
    }

    /// Kinetic energy of grains, spin included, of the wheel's vertical motion, and of its free spin (J). The sideways motion of the
    /// wheel is prescribed: its inertia belongs to the drive.
    pub fn kinetic(&self, bodies: &Bodies) -> f64 {
        let grains = self.velocities.iter().zip(&bodies.masses);
        let grains: f64 = grains
            .map(|(v, m)| 0.5 * m * (v[0] * v[0] + v[1] * v[1] + 0.5 * v[2] * v[2]))
            .sum();
        let wheel = 0.5 * bodies.wheel_mass.unwrap_or(0.0) * self.wheel.velocity[1].powi(2);
        let spin = bodies.wheel_spin_mass.unwrap_or(0.0);
        grains + wheel + 0.5 * spin * self.wheel.turn.powi(2)
    }

    /// Positions x (m) and normal forces (N) of the contacts that press on the wheel, with any face.
    pub fn on_wheel(&self, bodies: &Bodies) -> impl Iterator<Item = [f64; 2]> {
        let pressing = self.list.pressing();
        let on_wheel = pressing.filter(|slot| bodies.is_wheel(slot.b as usize));
        on_wheel.map(|slot| [self.centres[slot.a as usize][0], slot.force[0]])
    }

    /// A wheel that spins freely begins to roll at this velocity of its face (m/s); its drive gives the energy.
    pub fn begin_to_spin(&mut self, bodies: &Bodies, turn: f64) {
        let mass = bodies.wheel_spin_mass.unwrap_or(0.0);
        self.ledger.drive += 0.5 * mass * (turn * turn - self.wheel.turn * self.wheel.turn);
        self.wheel.turn = turn;
    }

    /// Energy in the normal and in the tangential springs, in the bonds, and of adhesion (J).
    pub fn springs(&self, bodies: &Bodies) -> [f64; 4] {
        if !bodies.is_elastic() {
            return [0.0; 4];
        }
        let mut bonds = BondCursor::new(&self.bonds);
        let mut stored = [0.0; 4];
        for slot in &self.list.slots {
            let bonded = bonds.find((slot.a, slot.b));
            // Where only the contact bears an attraction, the total force is 0 although the pair touches.
            let idle = slot.force == [0.0; 2] && slot.attraction == 0.0 && slot.last_gap >= 0.0;
            let force = match bonded {
                None if idle => continue,
                None => slot.pressure(),
                // Tension and shear are the bond's.
                Some(_) => [slot.force[0].max(0.0), 0.0],
            };
            let law = bodies.law_of(slot.a as usize, slot.b as usize);
            let [normal, tangential] = law.stored(force);
            let parts = 1.0 + slot.joined;
            // The force of a damper stores nothing.
            stored[0] += match law.springs {
                Some(s) if law.is_damped() => {
                    0.5 * s.normal / parts * slot.last_gap.min(0.0).powi(2)
                }
                _ => normal * parts,
            };
            stored[1] += tangential * parts;
            if let Some(adhesion) = &law.adhesion {
                stored[3] += adhesion.stored(slot.attraction, slot.last_gap);
            }
            if let Some((_, bond)) = bonded {
                stored[2] += bond.stored(bodies);
            }
        }
        stored
    }

    /// Energy (J) that the rounding of positions, the largest coordinate times the machine epsilon, gives to springs in one step.
    pub fn rounding(&self, bodies: &Bodies) -> f64 {
        let way = f64::EPSILON * extent(&self.centres);
        let of_slot = |slot: &Slot| {
            let springs = bodies.law_of(slot.a as usize, slot.b as usize).springs;
            let stiffness = springs.map_or(0.0, |springs| springs.normal);
            (slot.force[0].abs() + stiffness * way) * way
        };
        self.list.slots.iter().map(of_slot).sum()
    }

    /// Kinetic energy, and the energies of normal springs, tangential springs, bonds and adhesion (J).
    pub fn energies(&self, bodies: &Bodies) -> [f64; 5] {
        let [normal, tangential, bonds, adhesion] = self.springs(bodies);
        [self.kinetic(bodies), normal, tangential, bonds, adhesion]
    }

    /// Momentum of the free grains (kg m/s).
    pub fn momentum(&self, bodies: &Bodies) -> [f64; 2] {
        let grains = self.velocities.iter().zip(&bodies.masses);
        grains.fold([0.0; 2], |sum, (v, m)| {
            [sum[0] + m * v[0], sum[1] + m * v[1]]
        })
    }

    /// blake3 over every number, in hexadecimal.
    pub fn hash(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        let mut add = |x: f64| {
            hasher.update(&x.to_bits().to_le_bytes());
        };
        let points = self.centres.iter().chain(&self.surface);
        points.flatten().for_each(|x| add(*x));
        self.velocities.iter().flatten().for_each(|x| add(*x));
        for Pose { centre, angle } in &self.clusters {
            centre.iter().chain([angle]).for_each(|x| add(*x));
        }
        if self.wall_motion_time != 0.0 || self.ledger.walls != 0.0 {
            add(self.wall_motion_time);
            add(self.ledger.walls);
        }
        let taken = self.taken.iter().map(|grain| f64::from(*grain));
        let rare = [self.ledger.damping, self.ledger.healing];
        for rare in rare.into_iter().chain(taken).chain([self.ledger.lateral]) {
            if rare != 0.0 {
                add(rare);
            }
        }
        if self.feed != Feed::default() {
            self.feed.numbers().for_each(&mut add);
            add(self.ledger.injection);
        }
        if self.worn != Worn::default() {
            self.worn.numbers().for_each(&mut add);
        }
        self.glued_velocity.iter().for_each(|x| add(*x));
        self.wheel.position.iter().for_each(|x| add(*x));
        self.wheel.velocity.iter().for_each(|x| add(*x));
        if self.wheel.turn != 0.0 {
            add(self.wheel.turn);
        }
        if !self.heat.contents.is_empty() {
            self.heat.numbers().for_each(&mut add);
        }
        self.list.for_each_number(&mut add);
        self.bonds.iter().flat_map(Bond::numbers).for_each(&mut add);
        self.ledger.numbers().into_iter().for_each(add);
        hasher.finalize().to_hex().to_string()
    }
}
