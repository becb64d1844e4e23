//! Positions of all bodies at a moment, and the geometry of any two of them.

use std::ops::Range;

use crate::bodies::Bodies;
use crate::bodies::faces::{Face, Segment};
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
    let (segment, centre, first) = segment_under(bodies, positions, a, b)?;
    segment.successor(centre).map(|next| first + next)
}

/// Gap of the disk `a` over the line of the segment `b` of a wall or surface, also beyond its ends (m).
pub fn gap_over_line(bodies: &Bodies, positions: &Positions, a: usize, b: usize) -> Option<f64> {
    let (segment, centre, _) = segment_under(bodies, positions, a, b)?;
    Some(segment.height(centre) - bodies.radii[a])
}

/// The body after the segment `b` of a wall or surface, and the gap of the disk `a` at the corner between them (m).
pub fn corner(bodies: &Bodies, positions: &Positions, a: usize, b: usize) -> Option<(usize, f64)> {
    let (segment, centre, first) = segment_under(bodies, positions, a, b)?;
    let (next, distance) = segment.corner(centre)?;
    Some((first + next, distance - bodies.radii[a]))
}

/// The segment of a wall or surface that the body `b` is, the centre of the disk `a` as it sees it, and the body from which its joints count.
fn segment_under(
    bodies: &Bodies,
    positions: &Positions,
    a: usize,
    b: usize,
) -> Option<(Segment, [f64; 2], usize)> {
    let centre = positions.centres[a];
    if let Some(index) = bodies.segment_index(b) {
        let (surface, points) = (&bodies.surface, positions.surface);
        let centre = surface.image(index, points, centre);
        return Some((
            surface.segment(index, points),
            centre,
            bodies.first_segment(),
        ));
    }
    let wall = bodies.wall_of(b)?;
    let Face::Segment(segment) = wall.face else {
        return None;
    };
    let centre = wall.frame(centre, positions.wall_motion_time);
    Some((segment, centre, bodies.first_wall()))
}
