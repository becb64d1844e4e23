//! Soft frictionless disks brought to rest by FIRE.
//!
//! Lengths are in metres and forces are divided by the contact stiffness, so that a force is an overlap (m); with
//! unit masses the fastest oscillation of a packing is then about 3.5 per unit of time whatever the material.

use crate::bodies::geometry::{Period, between_points, range, squared_displacements};
use crate::contact::cells::NearPairs;
use crate::sample::types::Disk;

/// Direction in which the floor pushes.
const UPWARDS: [f64; 2] = [0.0, 1.0];

/// Disks between rigid plates.
#[derive(Clone, Debug)]
pub struct Packing {
    /// Centres (m), the movable disks first.
    pub centres: Vec<[f64; 2]>,
    /// Radii (m).
    pub radii: Vec<f64>,
    /// Number of disks that move.
    pub movable: usize,
    /// The strip that repeats along x; it has no side walls.
    pub period: Option<Period>,
    /// Height of the upper plate (m).
    pub ceiling: f64,
    /// Height of the lower plate (m); minus infinity when there is none.
    pub floor: f64,
    /// Distance of the side walls, or of the ends of the strip, from x = 0 (m); infinity when there are none.
    pub half_width: f64,
    /// Force with which the floor is pushed upwards over the stiffness (m); a fixed floor when absent.
    pub thrust: Option<f64>,
}

/// Overlaps of a packing (m).
#[derive(Clone, Copy, Debug, Default)]
struct Overlaps {
    sum: f64,
    squares: f64,
    count: usize,
    largest: f64,
}

impl Overlaps {
    fn add(&mut self, overlap: f64) {
        self.sum += overlap;
        self.squares += overlap * overlap;
        self.count += 1;
        self.largest = self.largest.max(overlap);
    }
}

/// Forces on the disks, in units of overlap (m).
#[derive(Clone, Debug, Default)]
pub struct PackingForces {
    /// On each movable disk.
    on_disks: Vec<[f64; 2]>,
    /// On the floor, thrust included.
    on_floor: f64,
    /// The thrust.
    thrust: f64,
    overlaps: Overlaps,
}

impl PackingForces {
    /// Mean overlap (m).
    pub fn mean(&self) -> f64 {
        self.overlaps.sum / self.overlaps.count.max(1) as f64
    }

    /// Root mean square of the overlaps (m).
    pub fn rms(&self) -> f64 {
        (self.overlaps.squares / self.overlaps.count.max(1) as f64).sqrt()
    }

    /// Largest overlap (m).
    pub fn largest(&self) -> f64 {
        self.overlaps.largest
    }

    /// Root mean square of the resultants on the disks (m).
    pub fn unbalanced_rms(&self) -> f64 {
        let squares = self.on_disks.iter().map(|f| f[0] * f[0] + f[1] * f[1]);
        (squares.sum::<f64>() / self.on_disks.len().max(1) as f64).sqrt()
    }

    /// Largest resultant on a disk (m).
    pub fn unbalanced(&self) -> f64 {
        let squares = self.on_disks.iter().map(|f| f[0] * f[0] + f[1] * f[1]);
        squares.fold(0.0, f64::max).sqrt()
    }

    /// True if every resultant is below this fraction of the mean contact force, and that on the floor below this
    /// fraction of its thrust.
    pub fn is_balanced(&self, fraction: f64) -> bool {
        self.unbalanced() <= fraction * self.mean() && self.on_floor.abs() <= fraction * self.thrust
    }
}

/// Verlet list of the packing.
struct NeighbourList {
    /// Disks near each movable one, of higher numbers than its own, with the distance at which they touch (m).
    near: Vec<(u32, f64)>,
    /// Ends of the movable disks' parts of `near`.
    ends: Vec<usize>,
    centres: Vec<[f64; 2]>,
    skin: f64,
}

impl NeighbourList {
    /// The disks near each movable one.
    fn of_each(&self) -> impl Iterator<Item = &[(u32, f64)]> {
        let starts = std::iter::once(&0).chain(&self.ends);
        starts
            .zip(&self.ends)
            .map(|(start, end)| &self.near[*start..*end])
    }
}

impl Packing {
    /// Lets the disks relax until `at_rest` says so: FIRE (Bitzek et al., PRL 97, 170201, 2006, with their
    /// parameters) with the semi-implicit Euler step. Returns the number of iterations, which is
    /// `limit` when they were not enough, and the forces at the final positions.
    pub fn relax(
        &mut self,
        limit: usize,
        at_rest: impl Fn(&PackingForces) -> bool,
    ) -> (usize, PackingForces) {
        let mut fire = Fire::new(self);
        let mut neighbours = self.neighbours();
        let mut load = PackingForces::default();
        let mut iteration = 0;
        loop {
            self.refresh(&mut neighbours);
            self.forces(&neighbours, &mut load);
            if iteration == limit || at_rest(&load) {
                return (iteration, load);
            }
            fire.step(self, &load);
            iteration += 1;
        }
    }

    /// The disks, at rest.
    pub fn disks(&self) -> impl Iterator<Item = Disk> {
        let disks = self.centres.iter().zip(&self.radii);
        disks.map(|(centre, radius)| Disk {
            centre: *centre,
            radius: *radius,
            ..Disk::default()
        })
    }

    fn neighbours(&self) -> NeighbourList {
        let skin = 0.3 * range(self.radii.iter().copied())[0];
        let mut near = NearPairs::new(&self.centres, &self.radii, self.movable, skin, self.period);
        let (mut listed, mut ends) = (Vec::new(), Vec::with_capacity(self.movable));
        for a in 0..self.movable {
            let reach = |b: &u32| self.radii[a] + self.radii[*b as usize];
            listed.extend(near.of(a).iter().map(|b| (*b, reach(b))));
            ends.push(listed.len());
        }
        NeighbourList {
            near: listed,
            ends,
            centres: self.centres.clone(),
            skin,
        }
    }

    fn refresh(&self, neighbours: &mut NeighbourList) {
        let limit = (0.5 * neighbours.skin).powi(2);
        if squared_displacements(&self.centres, &neighbours.centres).any(|squared| squared > limit)
        {
            *neighbours = self.neighbours();
        }
    }

    fn forces(&self, neighbours: &NeighbourList, load: &mut PackingForces) {
        load.on_disks.clear();
        load.on_disks.resize(self.movable, [0.0; 2]);
        load.thrust = self.thrust.unwrap_or(0.0);
        load.on_floor = load.thrust;
        let mut overlaps = Overlaps::default();
        let on_disks = &mut load.on_disks[..];
        for (a, near) in neighbours.of_each().enumerate() {
            let (centre, mut on_a) = (self.centres[a], on_disks[a]);
            for (b, reach) in near {
                let b = *b as usize;
                let Some((overlap, force)) = self.pushed_apart(centre, b, *reach) else {
                    continue;
                };
                on_a = [on_a[0] + force[0], on_a[1] + force[1]];
                if let Some(on_b) = on_disks.get_mut(b) {
                    *on_b = [on_b[0] - force[0], on_b[1] - force[1]];
                }
                overlaps.add(overlap);
            }
            on_disks[a] = on_a;
        }
        for (a, on_a) in on_disks.iter_mut().enumerate() {
            for (overlap, direction) in self.pushed_off_plates(a) {
                *on_a = [
                    on_a[0] + overlap * direction[0],
                    on_a[1] + overlap * direction[1],
                ];
                overlaps.add(overlap);
                if direction == UPWARDS {
                    load.on_floor -= overlap;
                }
            }
        }
        load.overlaps = overlaps;
    }

    /// Overlap of a disk around `centre` with disk b, which it touches at the distance `reach`, and the force on the first (m).
    #[inline]
    fn pushed_apart(&self, centre: [f64; 2], b: usize, reach: f64) -> Option<(f64, [f64; 2])> {
        let [dx, dy] = between_points(centre, self.centres[b], self.period);
        let squared = dx * dx + dy * dy;
        if squared >= reach * reach || squared == 0.0 {
            return None;
        }
        let distance = squared.sqrt();
        let overlap = reach - distance;
        Some((overlap, [overlap * dx / distance, overlap * dy / distance]))
    }

    /// Overlaps of a disk with the plates that it touches (m), and the directions in which they push: sides, ceiling, floor.
    #[inline]
    fn pushed_off_plates(&self, a: usize) -> impl Iterator<Item = (f64, [f64; 2])> {
        let ([x, y], r) = (self.centres[a], self.radii[a]);
        let beside = self.period.map_or(self.half_width, |_| f64::INFINITY);
        let plates = [
            (r - (x + beside), [1.0, 0.0]),
            (r - (beside - x), [-1.0, 0.0]),
            (r - (self.ceiling - y), [0.0, -1.0]),
            (r - (y - self.floor), UPWARDS),
        ];
        plates.into_iter().filter(|(overlap, _)| *overlap > 0.0)
    }

    /// The contacts of the packing: pairs of disks, and how many plates each movable disk touches.
    pub fn contacts(&self) -> (Vec<(u32, u32)>, Vec<u32>) {
        let neighbours = self.neighbours();
        let mut pairs = Vec::new();
        for (a, near) in neighbours.of_each().enumerate() {
            let touching = |(b, reach): &&(u32, f64)| {
                self.pushed_apart(self.centres[a], *b as usize, *reach)
                    .is_some()
            };
            pairs.extend(near.iter().filter(touching).map(|(b, _)| (a as u32, *b)));
        }
        let plates = (0..self.movable).map(|a| self.pushed_off_plates(a).count() as u32);
        (pairs, plates.collect())
    }
}

/// GrainState of the relaxation; a disk has mass 1, the floor that of a row of disks.
struct Fire {
    velocities: Vec<[f64; 2]>,
    floor_velocity: f64,
    floor_mass: f64,
    step: f64,
    mixing: f64,
    downhill: usize,
}

impl Fire {
    const LONGEST_STEP: f64 = 0.4;
    const MIXING: f64 = 0.1;

    fn new(packing: &Packing) -> Fire {
        let mean = packing.radii.iter().sum::<f64>() / packing.radii.len() as f64;
        let row = packing.half_width / mean;
        Fire {
            velocities: vec![[0.0; 2]; packing.movable],
            floor_velocity: 0.0,
            floor_mass: if row.is_finite() { row.max(1.0) } else { 1.0 },
            step: 0.1,
            mixing: Fire::MIXING,
            downhill: 0,
        }
    }

    fn step(&mut self, packing: &mut Packing, load: &PackingForces) {
        let floor_force = packing.thrust.map_or(0.0, |_| load.on_floor);
        self.steer(load, floor_force);
        let dt = self.step;
        let moved = self.velocities.iter_mut().zip(&load.on_disks);
        for ((v, f), x) in moved.zip(&mut packing.centres) {
            v[0] += dt * f[0];
            v[1] += dt * f[1];
            x[0] += dt * v[0];
            x[1] += dt * v[1];
        }
        self.floor_velocity += dt * floor_force / self.floor_mass;
        packing.floor += dt * self.floor_velocity;
    }

    /// Turns the velocity towards the force while the power is positive, stops when it is not.
    fn steer(&mut self, load: &PackingForces, floor_force: f64) {
        let dot = |a: &[f64; 2], b: &[f64; 2]| a[0] * b[0] + a[1] * b[1];
        let (mut power, mut speed, mut force) = (
            floor_force * self.floor_velocity,
            self.floor_mass * self.floor_velocity.powi(2),
            floor_force.powi(2) / self.floor_mass,
        );
        for (v, f) in self.velocities.iter().zip(&load.on_disks) {
            power += dot(v, f);
            speed += dot(v, v);
            force += dot(f, f);
        }
        if power <= 0.0 {
            self.velocities.fill([0.0; 2]);
            self.floor_velocity = 0.0;
            self.step = (0.5 * self.step).max(0.02);
            self.mixing = Fire::MIXING;
            self.downhill = 0;
            return;
        }
        let (keep, turn) = (1.0 - self.mixing, self.mixing * (speed / force).sqrt());
        for (v, f) in self.velocities.iter_mut().zip(&load.on_disks) {
            v[0] = keep * v[0] + turn * f[0];
            v[1] = keep * v[1] + turn * f[1];
        }
        self.floor_velocity = keep * self.floor_velocity + turn * floor_force / self.floor_mass;
        self.downhill += 1;
        if self.downhill > 5 {
            self.step = (1.1 * self.step).min(Fire::LONGEST_STEP);
            self.mixing *= 0.99;
        }
    }
}
