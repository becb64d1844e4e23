//! Injection: grains that are fed into the scene from outside, Qe of the tribological circuit.
//!
//! Fed grains are free grains from the start, behind the grains of the sample, with radii drawn from theirs. Until its turn comes a grain is in
//! *store*: it stands at the point of the injection, and no body meets it. When the mass due covers it, it is put, at rest, into the widest gap
//! around that point, as wide as fits there, and then grows to its radius at a uniform speed. A layer under load has no gap of a grain's size, so
//! that fed grains push others aside, as if pumped into the layer.
//!
//! A growing grain is a disk of its full radius and mass, and its missing length is added to the gaps of its contacts. Each step reduces this length,
//! which compresses the springs of the contacts that press on it: the work of the injection.

use std::ops::Range;

use crate::bodies::Bodies;
use crate::bodies::feed::Source;
use crate::bodies::geometry::between_points;
use crate::bodies::positions::Positions;
use crate::contact::detect::Slot;
use crate::step::detachment::detach;
use crate::step::state::GrainState;

/// Distance from the point within which gaps are searched, and spacing of the positions tried, over the mean radius.
const REACH: f64 = 2.0;
const SPACING: f64 = 0.125;
/// Least radius at the beginning over the final radius: between three equal disks that touch there is 0.155.
const LEAST: f64 = 0.05;
/// Part of a gap that a grain fills at first: it touches nothing yet.
const FILLED: f64 = 0.999;

/// Feeds the grains due until a time (s), and lets fed grains grow; does nothing in a scene without injection.
pub fn feed(state: &mut GrainState, bodies: &Bodies, time: f64) {
    let Some(injection) = &bodies.injection else {
        return;
    };
    let grown = state.feed.advance(injection.growth, time);
    press_all(state, bodies, &grown);
    let (point, due) = match &injection.source {
        Source::Point(source) => (source.point, source.due(time)),
        Source::Surface(law) => {
            let (point, opened) = detach(state, bodies, law);
            for (slot, length) in opened {
                state.ledger.injection += press(bodies, &mut state.list.slots[slot], -length);
            }
            (point, state.worn.mass)
        }
    };
    state.feed.due = due;
    let next = |state: &GrainState| {
        let grain = state.present(bodies);
        let mass = bodies.masses.get(grain).copied();
        mass.filter(|mass| state.feed.is_due(*mass))
            .map(|mass| (grain, mass))
    };
    while let Some((grain, mass)) = next(state) {
        let radius = bodies.radii[grain];
        let widest = widest_gap(state, bodies, point);
        let Some((position, gap)) = widest.filter(|(_, gap)| *gap > LEAST * radius) else {
            return;
        };
        state.centres[grain] = position;
        let missing = radius - FILLED * gap;
        state.feed.take_out(grain as u32, mass, missing, time);
        state.list.invalidate();
    }
}

/// Presses the contacts of grains that have grown by these lengths (m), and records the work on their springs.
fn press_all(state: &mut GrainState, bodies: &Bodies, grown: &[(u32, f64)]) {
    if grown.is_empty() {
        return;
    }
    let of = |body: u32| {
        let mut grown = grown.iter();
        grown.find(|(grain, _)| *grain == body).map_or(0.0, |g| g.1)
    };
    for slot in &mut state.list.slots {
        state.ledger.injection += press(bodies, slot, of(slot.a) + of(slot.b));
    }
}

/// Presses a closed contact together by a length (m), negative where it opens. Returns the work on its spring, less the energy that its attraction
/// releases (J).
fn press(bodies: &Bodies, slot: &mut Slot, length: f64) -> f64 {
    let law = bodies.law_of(slot.a as usize, slot.b as usize);
    let springs = law.shared(slot.joined).springs;
    let pressed = slot.pressure()[0] > 0.0 && length != 0.0;
    let Some(springs) = springs.filter(|_| pressed) else {
        return 0.0;
    };
    let energy = |slot: &Slot| {
        let adhesion = law.adhesion.as_ref();
        let attracted = adhesion.map_or(0.0, |a| a.stored(slot.attraction, slot.last_gap));
        0.5 * springs.normal * slot.last_gap.min(0.0).powi(2) + attracted
    };
    let before = energy(slot);
    slot.last_gap -= length;
    energy(slot) - before
}

/// The position around a point with the most room to all bodies, and its distance from them (m). Of positions with the same room the
/// first one counts, row by row from below.
fn widest_gap(state: &GrainState, bodies: &Bodies, point: [f64; 2]) -> Option<([f64; 2], f64)> {
    let reach = REACH * bodies.mean_radius();
    let near = Surroundings::new(state, bodies, point, reach);
    let count = (REACH / SPACING) as i32;
    let steps = || (-count..=count).map(|k| f64::from(k) * reach / f64::from(count));
    let points = steps().flat_map(|y| steps().map(move |x| [x, y]));
    let points = points.filter(|[x, y]| x.hypot(*y) <= reach);
    let mut widest: Option<([f64; 2], f64)> = None;
    let points = points.map(|[x, y]| [point[0] + x, point[1] + y]);
    for position in points {
        let gap = near.gap(position);
        if widest.is_none_or(|(_, most)| gap > most) && near.is_between(position) {
            widest = Some((position, gap));
        }
    }
    widest
}

/// Bodies near a point.
struct Surroundings<'a> {
    bodies: &'a Bodies,
    positions: Positions<'a>,
    /// Centres and radii of disks (m).
    disks: Vec<([f64; 2], f64)>,
    /// Centres of the disks of the base, and of the lid or the wheel's face (m).
    rows: [Vec<[f64; 2]>; 2],
}

impl Surroundings<'_> {
    /// Disks with less than `reach` (m) of room to some position within `reach` of a point, and all faces.
    fn new<'a>(
        state: &'a GrainState,
        bodies: &'a Bodies,
        point: [f64; 2],
        reach: f64,
    ) -> Surroundings<'a> {
        let there = (0..bodies.disks()).filter(|disk| !state.waits(bodies, *disk));
        let disks = there.map(|disk| (state.centres[disk], state.radius(bodies, disk)));
        let near = |&(centre, radius): &([f64; 2], f64)| {
            let [dx, dy] = between_points(centre, point, bodies.period);
            dx.hypot(dy) < 2.0 * reach + radius
        };
        let row = |disks: Range<usize>| {
            let off = |centre: &[f64; 2]| between_points(*centre, point, bodies.period)[0];
            let centres = state.centres[disks].iter().copied();
            centres
                .filter(|centre| off(centre).abs() < 2.0 * reach)
                .collect()
        };
        let base = bodies.free..bodies.free + bodies.base;
        Surroundings {
            bodies,
            positions: state.positions(bodies),
            disks: disks.filter(near).collect(),
            rows: [row(base), row(bodies.lid().start..bodies.disks())],
        }
    }

    /// True for a position above the base and below a lid or a wheel of disks, by the disk of each that is nearest along x, and in front of
    /// the nearest segment of a surface: there is also room behind these.
    fn is_between(&self, position: [f64; 2]) -> bool {
        let y = position[1];
        let height = |row: &[[f64; 2]]| {
            let off =
                |centre: &[f64; 2]| between_points(*centre, position, self.bodies.period)[0].abs();
            let nearest = row.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
            nearest.map(|centre| centre[1])
        };
        let (surface, points) = (&self.bodies.surface, self.positions.surface);
        let distance = |segment: &usize| surface.distance(*segment, points, position);
        let nearest = (0..surface.segments()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let in_front = nearest.is_none_or(|segment| {
            let image = surface.image(segment, points, position);
            surface.segment(segment, points).height(image) > 0.0
        });
        let [base, face] = &self.rows;
        in_front
            && height(base).is_none_or(|base| base < y)
            && height(face).is_none_or(|face| y < face)
    }

    /// Room around a position (m).
    fn gap(&self, position: [f64; 2]) -> f64 {
        let to_disks = self.disks.iter().map(|(centre, radius)| {
            let [dx, dy] = between_points(*centre, position, self.bodies.period);
            dx.hypot(dy) - radius
        });
        to_disks
            .chain(self.to_faces(position))
            .fold(f64::INFINITY, f64::min)
    }

    /// Distances to the wheel, where its face is smooth, to the walls and to the surface (m).
    fn to_faces(&self, position: [f64; 2]) -> impl Iterator<Item = f64> {
        let (bodies, positions) = (self.bodies, self.positions);
        let smooth = bodies.wheel().filter(|_| bodies.face.is_empty());
        let wheel = smooth.map(move |_| positions.under_wheel(position, 0.0).gap);
        let walls = bodies.walls.iter();
        let walls =
            walls.map(move |wall| wall.distance(wall.frame(position, positions.wall_motion_time)));
        let segments = 0..bodies.surface.segments();
        let segments = segments
            .map(move |index| (bodies.surface).distance(index, positions.surface, position));
        wheel.into_iter().chain(walls).chain(segments)
    }
}

#[cfg(test)]
mod tests;
