//! Soft frictionless disks brought to rest by FIRE.
//!
//! Lengths are in metres and forces are divided by the contact stiffness, so that a force is an overlap (m); with unit masses the fastest oscillation
//! of a packing is then about 3.5 per unit of time for any material.

use crate::bodies::disk::Disk;
use crate::bodies::geometry::{Period, between_points, drop_at, range, squared_displacements};
use crate::contact::cells::NearPairs;
use crate::law::lanes::widest;

/// Number of pairs whose distances are computed side by side.
const TOGETHER: usize = 16;

/// Direction in which the floor pushes.
const UPWARDS: [f64; 2] = [0.0, 1.0];

/// Disks between rigid plates.
#[derive(Clone, Debug, Default)]
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
    /// Height of the lower plate (m); minus infinity without one.
    pub floor: f64,
    /// Radius of the crown that the lower plate follows (m); 0 = flat.
    pub crown_radius: f64,
    /// Distance of the side walls, or of the ends of the strip, from x = 0 (m); infinity without them.
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
    #[inline(always)]
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

    /// True if every resultant is below this fraction of the mean contact force, and the floor's resultant below this fraction of its thrust.
    pub fn is_balanced(&self, fraction: f64) -> bool {
        self.on_floor.abs() <= fraction * self.thrust && self.unbalanced() <= fraction * self.mean()
    }
}

/// Verlet list of the packing.
struct NeighbourList {
    /// A movable disk, a near disk of a higher number, and the distance at which they touch (m), in the order of these numbers. Pairs that never
    /// touch fill the last row of [`TOGETHER`].
    near: Vec<(u32, u32, f64)>,
    /// Movable disks near a plate.
    near_plates: Vec<u32>,
    centres: Vec<[f64; 2]>,
    floor: f64,
    skin: f64,
}

impl Packing {
    /// Lets the disks relax until `at_rest` is true: FIRE (Bitzek et al., PRL 97, 170201, 2006, with their parameters) with the semi-implicit Euler
    /// step. Returns the number of iterations, which is `limit` if the disks are not at rest, and the forces at the final positions.
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
        disks.map(|(centre, radius)| Disk::at_rest(*centre, *radius))
    }

    fn neighbours(&self) -> NeighbourList {
        let skin = 0.45 * range(self.radii.iter().copied())[0];
        let mut near = NearPairs::new(&self.centres, &self.radii, self.movable, skin, self.period);
        let mut listed = Vec::new();
        for a in 0..self.movable {
            let reach = |b: &u32| self.radii[a] + self.radii[*b as usize];
            listed.extend(near.of(a).iter().map(|b| (a as u32, *b, reach(b))));
        }
        listed.resize(listed.len().next_multiple_of(TOGETHER), (0, 0, 0.0));
        let near_plate = |a: &u32| self.pushed_off_plates(*a as usize, skin).next().is_some();
        NeighbourList {
            near: listed,
            near_plates: (0..self.movable as u32).filter(near_plate).collect(),
            centres: self.centres.clone(),
            floor: self.floor,
            skin,
        }
    }

    fn refresh(&self, neighbours: &mut NeighbourList) {
        let limit = (0.5 * neighbours.skin).powi(2);
        let moved = squared_displacements(&self.centres, &neighbours.centres);
        // A count instead of a search: a loop that may end early runs disk by disk.
        let far = moved.map(|squared| u64::from(squared > limit));
        let floor_moved = (self.floor - neighbours.floor).powi(2) > limit;
        if widest!(far.sum::<u64>()) > 0 || floor_moved {
            *neighbours = self.neighbours();
        }
    }

    fn forces(&self, neighbours: &NeighbourList, load: &mut PackingForces) {
        load.on_disks.clear();
        load.on_disks.resize(self.movable, [0.0; 2]);
        load.thrust = self.thrust.unwrap_or(0.0);
        load.on_floor = load.thrust;
        let mut overlaps = widest!(self.push_pairs(neighbours, &mut load.on_disks));
        for a in &neighbours.near_plates {
            let on_a = &mut load.on_disks[*a as usize];
            for (overlap, direction) in self.pushed_off_plates(*a as usize, 0.0) {
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

    /// Pushes the disks of touching pairs apart, [`TOGETHER`] pairs at a time. This changes no bit: sums go pair by pair, and a pair that does not
    /// touch adds zeros.
    #[inline(always)]
    fn push_pairs(&self, neighbours: &NeighbourList, on_disks: &mut [[f64; 2]]) -> Overlaps {
        let (mut overlaps, centre) = (Overlaps::default(), |disk: u32| self.centres[disk as usize]);
        for row in neighbours.near.as_chunks::<TOGETHER>().0 {
            let [mut dx, mut dy, mut reach] = [[0.0; TOGETHER]; 3];
            for (k, (a, b, sum)) in row.iter().enumerate() {
                [dx[k], dy[k]] = between_points(centre(*a), centre(*b), self.period);
                reach[k] = *sum;
            }
            let (mut overlap, mut apart) = ([0.0; TOGETHER], 0);
            for k in 0..TOGETHER {
                let squared = dx[k] * dx[k] + dy[k] * dy[k];
                let touches = squared < reach[k] * reach[k] && squared != 0.0;
                let distance = if touches { squared.sqrt() } else { 1.0 };
                apart += u64::from(!touches);
                overlap[k] = if touches { reach[k] - distance } else { 0.0 };
                (dx[k], dy[k]) = (overlap[k] * dx[k] / distance, overlap[k] * dy[k] / distance);
            }
            for (k, (a, b, _)) in row.iter().enumerate() {
                let on_a = &mut on_disks[*a as usize];
                *on_a = [on_a[0] + dx[k], on_a[1] + dy[k]];
                if let Some(on_b) = on_disks.get_mut(*b as usize) {
                    *on_b = [on_b[0] - dx[k], on_b[1] - dy[k]];
                }
                overlaps.add(overlap[k]);
            }
            overlaps.count -= apart as usize;
        }
        overlaps
    }

    /// Overlaps of a disk with the plates nearer than `reach` (m), and the directions in which they push: sides, ceiling, floor.
    #[inline]
    fn pushed_off_plates(&self, a: usize, reach: f64) -> impl Iterator<Item = (f64, [f64; 2])> {
        let ([x, y], r) = (self.centres[a], self.radii[a]);
        let beside = self.period.map_or(self.half_width, |_| f64::INFINITY);
        let plates = [
            (r - (x + beside), [1.0, 0.0]),
            (r - (beside - x), [-1.0, 0.0]),
            (r - (self.ceiling - y), [0.0, -1.0]),
            (
                r - (y + drop_at(x, self.crown_radius) - self.floor),
                UPWARDS,
            ),
        ];
        let plates = plates.into_iter();
        plates.filter(move |(overlap, _)| *overlap > -reach)
    }

    /// The contacts of the movable disks; a plate has a number beyond all disks.
    pub fn contacts(&self) -> Vec<[usize; 2]> {
        let mut near = NearPairs::new(&self.centres, &self.radii, self.movable, 0.0, self.period);
        let mut contacts = Vec::new();
        for a in 0..self.movable {
            contacts.extend(near.of(a).iter().map(|b| [a, *b as usize]));
            contacts.extend(self.pushed_off_plates(a, 0.0).map(|_| [a, usize::MAX]));
        }
        contacts
    }
}

/// State of the relaxation; a disk has mass 1, the floor the mass of a row of disks.
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
        let forces = load.on_disks.as_flattened();
        let moved = self.velocities.as_flattened_mut().iter_mut().zip(forces);
        let moved = moved.zip(packing.centres.as_flattened_mut());
        widest!(moved.for_each(|((v, f), x)| {
            *v += dt * f;
            *x += dt * *v;
        }));
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
        let turned = self.velocities.as_flattened_mut().iter_mut();
        let turned = turned.zip(load.on_disks.as_flattened());
        widest!(turned.for_each(|(v, f)| *v = keep * *v + turn * f));
        self.floor_velocity = keep * self.floor_velocity + turn * floor_force / self.floor_mass;
        self.downhill += 1;
        if self.downhill > 5 {
            self.step = (1.1 * self.step).min(Fire::LONGEST_STEP);
            self.mixing *= 0.99;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::RandomNumbers;

    /// Overlap of the disks of a pair and the force on the first (m), if they touch.
    fn pushed_apart(packing: &Packing, (a, b, reach): (u32, u32, f64)) -> Option<(f64, [f64; 2])> {
        let [a, b] = [a, b].map(|disk| packing.centres[disk as usize]);
        let [dx, dy] = between_points(a, b, packing.period);
        let squared = dx * dx + dy * dy;
        if squared >= reach * reach || squared == 0.0 {
            return None;
        }
        let distance = squared.sqrt();
        let overlap = reach - distance;
        Some((overlap, [overlap * dx / distance, overlap * dy / distance]))
    }

    /// The plain double loop over all pairs, in their order, is the reference: bit by bit, also after a move within the skin of the list.
    #[test]
    fn pairs_side_by_side_push_as_one_after_the_other() {
        for period in [None, Some(Period::between([-4.0, 4.0]))] {
            let mut numbers = RandomNumbers::new(3);
            let count = 150;
            let radii: Vec<f64> = (0..count).map(|_| numbers.between(0.3, 0.6)).collect();
            let centre = |_| [numbers.between(-4.0, 4.0), numbers.between(-4.0, 4.0)];
            let mut packing = Packing {
                centres: (0..count).map(centre).collect(),
                radii,
                movable: 130,
                period,
                ceiling: 4.0,
                floor: -4.0,
                crown_radius: 0.0,
                half_width: 4.0,
                thrust: Some(0.5),
            };
            packing.centres[7] = packing.centres[6];
            let neighbours = packing.neighbours();
            packing.centres[9][0] += 0.49 * neighbours.skin;
            packing.floor += 0.49 * neighbours.skin;
            let mut load = PackingForces::default();
            packing.forces(&neighbours, &mut load);
            let (mut on_disks, mut overlaps) = ([[0.0; 2]; 130], Overlaps::default());
            for a in 0..packing.movable {
                for b in a + 1..count {
                    let reach = packing.radii[a] + packing.radii[b];
                    let pair = (a as u32, b as u32, reach);
                    let Some((overlap, [x, y])) = pushed_apart(&packing, pair) else {
                        continue;
                    };
                    on_disks[a] = [on_disks[a][0] + x, on_disks[a][1] + y];
                    if let Some(on_b) = on_disks.get_mut(b) {
                        *on_b = [on_b[0] - x, on_b[1] - y];
                    }
                    overlaps.add(overlap);
                }
            }
            let mut on_floor = 0.5;
            for (a, on_a) in on_disks.iter_mut().enumerate() {
                for (overlap, [x, y]) in packing.pushed_off_plates(a, 0.0) {
                    *on_a = [on_a[0] + overlap * x, on_a[1] + overlap * y];
                    overlaps.add(overlap);
                    on_floor -= if y > 0.0 { overlap } else { 0.0 };
                }
            }
            assert_eq!(load.on_disks, on_disks);
            assert_eq!(load.on_floor, on_floor);
            let numbers = |o: &Overlaps| ([o.sum, o.squares, o.largest], o.count);
            assert_eq!(numbers(&load.overlaps), numbers(&overlaps));
            assert!(overlaps.count > 200);
        }
    }
}
