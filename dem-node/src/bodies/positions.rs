//! Positions of all bodies at a moment, and the geometry of any two of them.

use std::ops::Range;

use crate::bodies::Bodies;
use crate::bodies::faces::Face;
use crate::bodies::geometry::{Proximity, between_disks, between_points, under_wheel};

/// Positions at a moment.
#[derive(Clone, Copy, Debug)]
pub struct Positions<'a> {
    /// Centres of all disks (m).
    pub centres: &'a [[f64; 2]],
    /// Points of the surface (m).
    pub surface: &'a [[f64; 2]],
    /// Number of free grains that are not in store.
    pub present: usize,
    /// Lowest point of the wheel's face (m). A flat face has no x: it is 0.
    pub wheel: [f64; 2],
    /// Time for which moving walls have moved (s).
    pub wall_motion_time: f64,
}

impl Positions<'_> {
    /// The free grains in store, which nothing meets.
    pub fn store(&self, bodies: &Bodies) -> Range<usize> {
        self.present..bodies.free
    }
}

/// Normal and gap of two bodies, a the disk of the lower number.
#[inline]
pub fn proximity(bodies: &Bodies, positions: &Positions, a: usize, b: usize) -> Proximity {
    let (centre, radius) = (positions.centres[a], bodies.radii[a]);
    if b < bodies.disks() {
        let from_b = between_points(centre, positions.centres[b], bodies.period);
        return between_disks(from_b, radius + bodies.radii[b]);
    }
    if let Some(segment) = bodies.segment_index(b) {
        let surface = &bodies.surface;
        return surface.proximity(segment, positions.surface, centre, radius);
    }
    match bodies.wall_of(b) {
        None => under_wheel(positions.wheel, bodies.wheel_radius, centre, radius),
        Some(wall) => wall.proximity(wall.frame(centre, positions.wall_motion_time), radius),
    }
}

/// Distance of two bodies, also where neither of them is the one that the other will touch (m).
pub fn distance(bodies: &Bodies, positions: &Positions, a: usize, b: usize) -> f64 {
    if let Some(segment) = bodies.segment_index(b) {
        let (surface, points) = (&bodies.surface, positions.surface);
        return surface.distance(segment, points, positions.centres[a]) - bodies.radii[a];
    }
    match bodies.wall_of(b) {
        None => proximity(bodies, positions, a, b).gap,
        Some(wall) => {
            let centre = wall.frame(positions.centres[a], positions.wall_motion_time);
            wall.distance(centre) - bodies.radii[a]
        }
    }
}

/// The segment of a wall or surface to which a disk has passed that is beyond an end of segment `b`.
pub fn successor(bodies: &Bodies, positions: &Positions, a: usize, b: usize) -> Option<usize> {
    let centre = positions.centres[a];
    if let Some(index) = bodies.segment_index(b) {
        let (surface, points) = (&bodies.surface, positions.surface);
        let centre = surface.image(index, points, centre);
        let next = surface.segment(index, points).successor(centre)?;
        return Some(bodies.first_segment() + next);
    }
    let wall = bodies.wall_of(b)?;
    let Face::Segment(segment) = &wall.face else {
        return None;
    };
    let next = segment.successor(wall.frame(centre, positions.wall_motion_time))?;
    Some(bodies.first_wall() + next)
}
