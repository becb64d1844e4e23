//! Surfaces of the bodies that another solver moves: polylines of their points, on whose segments the grains lie.
//!
//! ```text
//!        ( a )
//!  _ i____|___ j_        f on the grain: -(1 - s) f on point i, -s f on point j; the segment moves under the grain with
//!       s |                v = (1 - s) v_i + s v_j: forces, moments and power are exact
//! ```
//!
//! Corners follow the rules of rigid walls ([`super::faces`]): a convex corner has a fan of normals, in a concave corner a disk has two contacts.

use crate::bodies::faces::{Joint, Segment, left_of, unit};
use crate::bodies::geometry::{Period, Proximity, between_points};

/// Distance over the length of a strip up to which two points are one.
const SAME_PLACE: f64 = 1e-12;

/// The polylines, on the bodies below and above. The solid is on the right of their direction.
#[derive(Clone, Debug, Default)]
pub struct BareSurface {
    /// Undeformed points (m), line by line.
    pub points: Vec<[f64; 2]>,
    /// Number of points of the body below, which come first.
    pub base: usize,
    /// More points, which glued disks carry: the disk among these, and the way from its centre to the point (m).
    carried: Vec<(u32, [f64; 2])>,
    segments: Vec<Ends>,
    period: Option<Period>,
}

/// A segment by its points, and the segments before and after it.
#[derive(Clone, Copy, Debug)]
struct Ends {
    points: [u32; 2],
    before: Option<u32>,
    after: Option<u32>,
}

/// The position of a grain on a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// The points at the ends of the segment.
    pub points: [u32; 2],
    /// Weight of the second point.
    pub share: f64,
}

impl Foot {
    /// The parts of an impulse that the two points take.
    #[inline(always)]
    pub fn parts(self, impulse: [f64; 2]) -> [(usize, [f64; 2]); 2] {
        let [first, second] = self.points.map(|point| point as usize);
        [(first, 1.0 - self.share), (second, self.share)]
            .map(|(point, weight)| (point, impulse.map(|p| weight * p)))
    }

    /// The mean of the two points' (x, y) among the components x0, y0, x1, y1, ...
    #[inline(always)]
    pub fn mean(self, of: &[f64]) -> [f64; 2] {
        let [first, second] = self.points.map(|point| 2 * point as usize);
        [0, 1].map(|k| (1.0 - self.share) * of[first + k] + self.share * of[second + k])
    }
}

impl BareSurface {
    /// The surface of polylines of points (m) on the bodies below and above; in a strip that repeats, a polyline that ends at the image of its start
    /// is closed.
    pub fn new([below, above]: [&[Vec<[f64; 2]>]; 2], period: Option<Period>) -> BareSurface {
        let mut surface = BareSurface {
            base: below.iter().map(Vec::len).sum(),
            period,
            ..BareSurface::default()
        };
        for line in below.iter().chain(above) {
            surface.add(line);
        }
        surface
    }

    fn add(&mut self, line: &[[f64; 2]]) {
        let (first, count) = (self.segments.len() as u32, line.len() - 1);
        let closed = self.period.is_some_and(|period| {
            let [dx, dy] = between_points(line[0], line[count], Some(period));
            dx.hypot(dy) <= SAME_PLACE * period.length
        });
        let point = self.points.len() as u32;
        let kept = count + usize::from(!closed);
        for i in 0..count as u32 {
            let last = count as u32 - 1;
            self.segments.push(Ends {
                points: [point + i, point + (i + 1) % kept as u32],
                before: (i > 0 || closed).then(|| first + (i + last) % (last + 1)),
                after: (i < last || closed).then(|| first + (i + 1) % (last + 1)),
            });
        }
        self.points.extend(&line[..kept]);
        if point < self.base as u32 && closed {
            self.base -= 1;
        }
    }

    /// Adds a segment between two points that glued disks carry, at these offsets from their centres (m).
    pub fn bridge(&mut self, disks: [usize; 2], offsets: [[f64; 2]; 2]) {
        let first = (self.points.len() + self.carried.len()) as u32;
        let disks = disks.map(|disk| disk as u32);
        self.carried.extend(disks.into_iter().zip(offsets));
        self.segments.push(Ends {
            points: [first, first + 1],
            before: None,
            after: None,
        });
    }

    /// Appends the points that glued disks with these centres carry (m).
    pub fn carry(&self, glued: &[[f64; 2]], places: &mut Vec<[f64; 2]>) {
        places.truncate(self.points.len());
        let carried = self.carried.iter().map(|(disk, [x, y])| {
            let centre = glued[*disk as usize];
            [centre[0] + x, centre[1] + y]
        });
        places.extend(carried);
    }

    /// Number of a point in a boundary of this many glued disks, which come before the points.
    fn in_boundary(&self, point: u32, glued: usize) -> u32 {
        let carried = (point as usize).checked_sub(self.points.len());
        carried.map_or(point + glued as u32, |number| self.carried[number].0)
    }

    /// A foot by the numbers of its points in that boundary.
    pub fn on_boundary(&self, foot: Foot, glued: usize) -> Foot {
        Foot {
            points: foot.points.map(|point| self.in_boundary(point, glued)),
            ..foot
        }
    }

    /// True for a segment of the body above; the second argument has the number of glued disks in the boundary, and how many of them lie below.
    pub fn is_above(&self, segment: usize, disks: [usize; 2]) -> bool {
        let number = self.in_boundary(self.segments[segment].points[0], disks[0]);
        self.is_point_above(number as usize, disks)
    }

    /// The same of a point by its number in the boundary.
    pub fn is_point_above(&self, number: usize, [glued, below]: [usize; 2]) -> bool {
        number >= glued + self.base || (below..glued).contains(&number)
    }

    /// Number of segments between points of its own, which come first.
    pub fn bare(&self) -> usize {
        let own = |ends: &&Ends| (ends.points[1] as usize) < self.points.len();
        self.segments.iter().take_while(own).count()
    }

    /// The points at the ends of a segment.
    pub fn points_of(&self, segment: usize) -> [usize; 2] {
        self.segments[segment].points.map(|point| point as usize)
    }

    /// Length of a segment in the undeformed surface (m).
    pub fn length(&self, segment: usize) -> f64 {
        let [dx, dy] = self.vector(segment, &self.points);
        dx.hypot(dy)
    }

    /// Length of all bare segments (m).
    pub fn bare_length(&self) -> f64 {
        (0..self.bare()).map(|segment| self.length(segment)).sum()
    }

    /// Largest depth that may come off: a third of its shortest segment (m).
    pub fn deepest(&self) -> f64 {
        let lengths = (0..self.bare()).map(|segment| self.length(segment));
        lengths.fold(f64::INFINITY, f64::min) / 3.0
    }

    fn at(&self, point: usize) -> impl Iterator<Item = usize> {
        (0..self.bare()).filter(move |segment| self.points_of(*segment).contains(&point))
    }

    /// Length of the surface that belongs to a point, half of each of its segments (m).
    pub fn tributary(&self, point: usize) -> f64 {
        let halves = self.at(point).map(|segment| 0.5 * self.length(segment));
        halves.sum()
    }

    /// Unit normal of the undeformed surface at a point, out of the body.
    pub fn normal(&self, point: usize) -> [f64; 2] {
        let segments = self.at(point);
        let vectors = segments.map(|segment| self.vector(segment, &self.points));
        let sum = vectors.fold([0.0; 2], |[x, y], [dx, dy]| [x + dx, y + dy]);
        left_of(unit(sum))
    }

    /// Number of segments.
    pub fn segments(&self) -> usize {
        self.segments.len()
    }

    /// Start of a segment with these points, and the vector to its end (m).
    pub fn line(&self, segment: usize, points: &[[f64; 2]]) -> [[f64; 2]; 2] {
        let [start, end] = self.points_of(segment).map(|point| points[point]);
        [start, between_points(end, start, self.period)]
    }

    fn vector(&self, segment: usize, points: &[[f64; 2]]) -> [f64; 2] {
        self.line(segment, points)[1]
    }

    /// A segment with these points (m).
    pub fn segment(&self, index: usize, points: &[[f64; 2]]) -> Segment {
        let Ends { before, after, .. } = self.segments[index];
        let joint = |segment: u32| Joint {
            wall: segment as usize,
            direction: unit(self.vector(segment as usize, points)),
        };
        let [start, along] = self.line(index, points);
        Segment::new(start, along, before.map(joint), after.map(joint))
    }

    /// The image of a centre (m) that is nearest to a segment.
    pub fn image(&self, index: usize, points: &[[f64; 2]], centre: [f64; 2]) -> [f64; 2] {
        match self.period {
            None => centre,
            Some(period) => {
                let [start, along] = self.line(index, points);
                let middle = 0.5 * along[0];
                let dx = period.nearest(centre[0] - start[0] - middle) + middle;
                [start[0] + dx, centre[1]]
            }
        }
    }

    /// Normal and gap of a disk at a segment. A disk that belongs to another segment is infinitely far away; a disk whose centre lies behind the face
    /// by less than its radius is still held.
    pub fn proximity(
        &self,
        index: usize,
        points: &[[f64; 2]],
        centre: [f64; 2],
        radius: f64,
    ) -> Proximity {
        let segment = self.segment(index, points);
        let centre = self.image(index, points, centre);
        segment.touch(centre, radius, radius).unwrap_or(Proximity {
            normal: left_of(unit(self.vector(index, points))),
            gap: f64::INFINITY,
        })
    }

    /// Distance of a point from any part of a segment (m).
    pub fn distance(&self, index: usize, points: &[[f64; 2]], from: [f64; 2]) -> f64 {
        let from = self.image(index, points, from);
        self.segment(index, points).distance(from)
    }

    /// The foot of a disk on a segment.
    pub fn foot(&self, index: usize, points: &[[f64; 2]], centre: [f64; 2]) -> Foot {
        let [start, [dx, dy]] = self.line(index, points);
        let [x, y] = self.image(index, points, centre);
        let along = ((x - start[0]) * dx + (y - start[1]) * dy) / (dx * dx + dy * dy);
        let (points, share) = (self.segments[index].points, along.clamp(0.0, 1.0));
        Foot { points, share }
    }

    /// The middle of a segment.
    pub fn middle(&self, index: usize) -> Foot {
        let points = self.segments[index].points;
        Foot { points, share: 0.5 }
    }

    /// The segments ordered by their left ends, to find segments near a disk.
    pub fn order(&self, points: &[[f64; 2]]) -> SegmentOrder {
        let mut order = SegmentOrder {
            period: self.period,
            ..SegmentOrder::default()
        };
        for index in 0..self.segments() {
            let [[start, _], [dx, _]] = self.line(index, points);
            let left = start + dx.min(0.0);
            let left = self.period.map_or(left, |period| period.inside(left));
            order.lefts.push((left, index as u32));
            order.widest = order.widest.max(dx.abs());
        }
        order.lefts.sort_by(|a, b| a.0.total_cmp(&b.0));
        order
    }
}

/// The segments of a surface by ascending left ends.
#[derive(Clone, Debug, Default)]
pub struct SegmentOrder {
    lefts: Vec<(f64, u32)>,
    /// Width of the widest segment (m).
    widest: f64,
    period: Option<Period>,
}

impl SegmentOrder {
    /// Segments some part of which may be nearer to x than `reach` along x (m), in the order of their numbers.
    pub fn near(&self, x: f64, reach: f64) -> Vec<u32> {
        let within = |x: f64| {
            let first = self
                .lefts
                .partition_point(|l| l.0 < x - reach - self.widest);
            let last = self.lefts.partition_point(|l| l.0 <= x + reach);
            self.lefts[first..last.max(first)].iter().map(|l| l.1)
        };
        let mut near: Vec<u32> = match self.period {
            None => within(x).collect(),
            Some(period) => {
                let x = period.inside(x);
                let images = [-period.length, 0.0, period.length];
                let images = images.into_iter();
                images.flat_map(|turn| within(x + turn)).collect()
            }
        };
        near.sort_unstable();
        near.dedup();
        near
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two points beside a row of three glued disks, and a bridge between the last two, which carry its ends 0.1 and 0.2 above themselves.
    #[test]
    fn a_bridge_moves_with_the_glued_disks_that_carry_it() {
        let beside = vec![[3.0, 0.0], [5.0, 0.0]];
        let mut surface = BareSurface::new([&[beside], &[]], None);
        surface.bridge([1, 2], [[0.0, 0.1], [0.0, 0.2]]);
        let mut places = surface.points.clone();
        for lift in [0.0, 0.5] {
            let glued = [[-1.0, 0.0], [0.0, lift - 0.1], [2.0, lift - 0.2]];
            surface.carry(&glued, &mut places);
            assert_eq!(places, [[3.0, 0.0], [5.0, 0.0], [0.0, lift], [2.0, lift]]);
            let near = surface.proximity(1, &places, [0.5, lift + 0.3], 0.4);
            assert!((near.gap + 0.1).abs() < 1e-15 && near.normal == [0.0, 1.0]);
            let foot = surface.on_boundary(surface.foot(1, &places, [0.5, 1.0]), 3);
            assert_eq!((foot.points, foot.share), ([1, 2], 0.25));
        }
        let middle = surface.on_boundary(surface.middle(0), 3);
        assert_eq!(middle.points, [3, 4]);
        assert_eq!(
            [3, 2].map(|below| surface.is_above(1, [3, below])),
            [false, false]
        );
        assert!(surface.is_above(1, [3, 1]));
    }
}
