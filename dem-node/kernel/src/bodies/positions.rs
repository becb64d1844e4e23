//! Positions of all bodies at a moment, and the geometry of any two of them.

use std::ops::Range;

use crate::bodies::Bodies;
use crate::bodies::faces::{Face, Segment};
use crate::bodies::geometry::{Proximity, between_disks, between_points, under_wheel};

/// Positions at a moment.
#[derive(Clone, Copy, Debug)]
pub struct Positions<'a> {
    /// The bodies.
    pub bodies: &'a Bodies,
    /// Centres of all disks (m).
    pub centres: &'a [[f64; 2]],
    /// Points of the surface (m).
    pub surface: &'a [[f64; 2]],
    /// Number of free grains that are not in store.
    pub present: usize,
    /// Grains that were taken out, in order.
    pub taken: &'a [u32],
    /// Lowest point of the wheel's face (m). A flat face has no x: it is 0.
    pub wheel: [f64; 2],
    /// Time for which moving walls have moved (s).
    pub wall_motion_time: f64,
}

impl Positions<'_> {
    /// The free grains in store, which nothing meets.
    pub fn store(&self) -> Range<usize> {
        self.present..self.bodies.free
    }

    /// True for a grain that was taken out, which nothing meets either.
    pub fn is_taken(&self, grain: usize) -> bool {
        !self.taken.is_empty() && self.taken.binary_search(&(grain as u32)).is_ok()
    }

    /// Normal and gap of two bodies, a the disk of the lower number.
    #[inline(always)]
    pub fn proximity(&self, a: usize, b: usize) -> Proximity {
        let bodies = self.bodies;
        if b < bodies.disks() {
            let from_b = between_points(self.centres[a], self.centres[b], bodies.period);
            return between_disks(from_b, bodies.radii[a] + bodies.radii[b]);
        }
        self.of_face(a, b)
    }

    /// The same of a disk and the wheel, a wall or a segment.
    fn of_face(&self, a: usize, b: usize) -> Proximity {
        let bodies = self.bodies;
        let (centre, radius) = (self.centres[a], bodies.radii[a]);
        if let Some(segment) = bodies.segment_index(b) {
            let surface = &bodies.surface;
            return surface.proximity(segment, self.surface, centre, radius);
        }
        match bodies.wall_of(b) {
            None => self.under_wheel(centre, radius),
            Some(wall) => wall.proximity(wall.frame(centre, self.wall_motion_time), radius),
        }
    }

    /// A disk under the smooth wheel, the nearest of its images where a strip repeats.
    #[inline]
    pub fn under_wheel(&self, centre: [f64; 2], radius: f64) -> Proximity {
        let bodies = self.bodies;
        let [x, y] = self.wheel;
        match bodies.period.filter(|_| bodies.wheel_radius > 0.0) {
            None => under_wheel(self.wheel, bodies.wheel_radius, centre, radius),
            Some(period) => {
                let nearest = [period.nearest(centre[0] - x), centre[1]];
                under_wheel([0.0, y], bodies.wheel_radius, nearest, radius)
            }
        }
    }

    /// Gap of a disk under the wheel, the least within this way of the wheel to either side (m).
    pub fn least_under_wheel(&self, centre: [f64; 2], radius: f64, way: f64) -> f64 {
        let [x, y] = self.wheel;
        let aside = centre[0] - x;
        let aside = self
            .bodies
            .period
            .map_or(aside, |period| period.nearest(aside));
        let nearer = aside.abs() - way;
        under_wheel(
            [0.0, y],
            self.bodies.wheel_radius,
            [nearer.max(0.0), centre[1]],
            radius,
        )
        .gap
    }

    /// Distance of two bodies (m), also of a disk and a segment where the disk would touch a neighbouring segment.
    pub fn distance(&self, a: usize, b: usize) -> f64 {
        let (bodies, centre) = (self.bodies, self.centres[a]);
        if let Some(segment) = bodies.segment_index(b) {
            let distance = bodies.surface.distance(segment, self.surface, centre);
            return distance - bodies.radii[a];
        }
        match bodies.wall_of(b) {
            None if b == bodies.disks() && bodies.rolls => {
                self.least_under_wheel(centre, bodies.radii[a], bodies.rolling_skin())
            }
            None => self.proximity(a, b).gap,
            Some(wall) => {
                let centre = wall.frame(centre, self.wall_motion_time);
                wall.distance(centre) - bodies.radii[a]
            }
        }
    }

    /// The segment of a wall or surface that a disk has reached beyond an end of segment `b`.
    pub fn successor(&self, a: usize, b: usize) -> Option<usize> {
        let (segment, centre, first) = self.segment_under(a, b)?;
        segment.successor(centre).map(|next| first + next)
    }

    /// Gap of the disk `a` over the line of the segment `b` of a wall or surface, also beyond its ends (m).
    pub fn gap_over_line(&self, a: usize, b: usize) -> Option<f64> {
        let (segment, centre, _) = self.segment_under(a, b)?;
        Some(segment.height(centre) - self.bodies.radii[a])
    }

    /// The body after the segment `b` of a wall or surface, and the gap of the disk `a` at the corner between them (m).
    pub fn corner(&self, a: usize, b: usize) -> Option<(usize, f64)> {
        let (segment, centre, first) = self.segment_under(a, b)?;
        let (next, distance) = segment.corner(centre)?;
        Some((first + next, distance - self.bodies.radii[a]))
    }

    /// The segment of a wall or surface with the body number `b`, the centre of the disk `a` in its frame, and the first body number of its joints.
    fn segment_under(&self, a: usize, b: usize) -> Option<(Segment, [f64; 2], usize)> {
        let (bodies, centre) = (self.bodies, self.centres[a]);
        if let Some(index) = bodies.segment_index(b) {
            let surface = &bodies.surface;
            let centre = surface.image(index, self.surface, centre);
            let segment = surface.segment(index, self.surface);
            return Some((segment, centre, bodies.first_segment()));
        }
        let wall = bodies.wall_of(b)?;
        let Face::Segment(segment) = wall.face else {
            return None;
        };
        let centre = wall.frame(centre, self.wall_motion_time);
        Some((segment, centre, bodies.first_wall()))
    }
}
