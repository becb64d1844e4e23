//! Rigid walls: half-planes and polylines, at rest or moving with a constant velocity.
//!
//! ```text
//!        .  n  .
//!    ____|_____|.          The faces of a polyline look to the left of its direction. The corner of a convex part
//!    a         b \ .       belongs to the disks in the fan between the normals, the rest to the faces: where a disk
//!                 \        passes from one to the other it has one contact, whose normal turns without a jump.
//!                  c       In a concave corner it has two.
//! ```
//!
//! The two contacts of a disk that overlaps a concave corner share their springs, see [`crate::contact::shared`].

use crate::bodies::geometry::Proximity;

/// Sine of the angle below which two segments in a row are one straight line.
const STRAIGHT: f64 = 1e-12;
/// Relative difference up to which two faces are equally far.
const ROUNDING: f64 = 1e-9;

/// A wall that moves with its own velocity only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidWall {
    /// Its shape at the start.
    pub face: Face,
    /// Its velocity (m/s).
    pub velocity: [f64; 2],
}

/// The shape of a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Face {
    /// The half-plane behind a line.
    HalfPlane {
        /// A point of the face (m).
        point: [f64; 2],
        /// Unit normal; the grains stay on its side.
        normal: [f64; 2],
    },
    /// A piece of a polyline.
    Segment(Segment),
}

/// A piece of a polyline; the grains stay on its left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    start: [f64; 2],
    end: [f64; 2],
    /// Unit vector from start to end.
    direction: [f64; 2],
    before: Option<Joint>,
    after: Option<Joint>,
}

/// Another segment at an end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// Its index in the list of walls, or of segments of a surface.
    pub wall: usize,
    /// Unit vector along it.
    pub direction: [f64; 2],
}

impl RigidWall {
    /// A point in the frame of the wall, which has moved for this time (s).
    pub fn frame(&self, point: [f64; 2], time: f64) -> [f64; 2] {
        [0, 1].map(|k| point[k] - self.velocity[k] * time)
    }

    /// Normal and gap of a disk given in the frame of the wall. A disk that belongs to a neighbouring segment, or lies
    /// behind this one, is infinitely far away.
    pub fn proximity(&self, centre: [f64; 2], radius: f64) -> Proximity {
        match &self.face {
            Face::HalfPlane { point, normal } => Proximity {
                normal: *normal,
                gap: dot(minus(centre, *point), *normal) - radius,
            },
            Face::Segment(segment) => {
                let apart = Proximity {
                    normal: left_of(segment.direction),
                    gap: f64::INFINITY,
                };
                segment.touch(centre, radius, 0.0).unwrap_or(apart)
            }
        }
    }

    /// Distance of a point from any part of the face (m).
    pub fn distance(&self, point: [f64; 2]) -> f64 {
        match &self.face {
            Face::HalfPlane {
                point: foot,
                normal,
            } => dot(minus(point, *foot), *normal),
            Face::Segment(segment) => segment.distance(point),
        }
    }
}

/// The segments of a polyline whose first one gets the number `first` in the list of walls. A polyline that ends where
/// it began is closed.
pub fn polyline(points: &[[f64; 2]], first: usize) -> Vec<Segment> {
    let count = points.len() - 1;
    let closed = points[0] == points[count];
    let along = |ends: &[[f64; 2]]| unit(minus(ends[1], ends[0]));
    let mut directions: Vec<[f64; 2]> = points.windows(2).map(along).collect();
    for i in 1..count {
        // The directions must be equal to the last digit, or a disk over the joint would lie in front of both segments.
        let (last, this) = (directions[i - 1], directions[i]);
        if cross(last, this).abs() < STRAIGHT && dot(last, this) > 0.0 {
            directions[i] = last;
        }
    }
    let joint = |i: usize| Joint {
        wall: first + i,
        direction: directions[i],
    };
    let segment = |i: usize| Segment {
        start: points[i],
        end: points[i + 1],
        direction: directions[i],
        before: match i {
            0 => closed.then(|| joint(count - 1)),
            i => Some(joint(i - 1)),
        },
        after: match i {
            i if i + 1 == count => closed.then(|| joint(0)),
            i => Some(joint(i + 1)),
        },
    };
    (0..count).map(segment).collect()
}

/// Distance of a point behind the nearest of these walls (m), which have moved for this time (s); `None` if the nearest wall is a half-plane, or the
/// point lies in front of it or beside its ends.
pub fn depth_behind<'a>(
    walls: impl Iterator<Item = &'a RigidWall>,
    point: [f64; 2],
    time: f64,
) -> Option<f64> {
    let [mut front, mut behind] = [f64::INFINITY; 2];
    for wall in walls {
        let point = wall.frame(point, time);
        front = front.min(wall.proximity(point, 0.0).gap);
        if let Face::Segment(segment) = &wall.face {
            behind = behind.min(segment.depth(point));
        }
    }
    // A plate with two faces is as near from behind as from the front.
    (behind < front * (1.0 - ROUNDING)).then_some(behind)
}

impl Segment {
    /// The segment from a point along a vector (m), between two others.
    pub fn new(
        start: [f64; 2],
        along: [f64; 2],
        before: Option<Joint>,
        after: Option<Joint>,
    ) -> Segment {
        Segment {
            start,
            end: [start[0] + along[0], start[1] + along[1]],
            direction: unit(along),
            before,
            after,
        }
    }

    /// Distance of a point straight behind the face (m), infinite for any other point.
    fn depth(&self, point: [f64; 2]) -> f64 {
        let (from_start, from_end) = (minus(point, self.start), minus(point, self.end));
        let beside = dot(from_start, self.direction) < 0.0 || dot(from_end, self.direction) > 0.0;
        let depth = -cross(self.direction, from_start);
        if beside || depth <= 0.0 {
            f64::INFINITY
        } else {
            depth
        }
    }

    /// Contact with a disk in front of the face or less than `depth` behind it (m), or in the fan of its first corner, or around a free
    /// end.
    pub fn touch(&self, centre: [f64; 2], radius: f64, depth: f64) -> Option<Proximity> {
        let (from_start, from_end) = (minus(centre, self.start), minus(centre, self.end));
        if dot(from_start, self.direction) < 0.0 {
            let owned = self.owns_start(from_start);
            return owned.then(|| around(from_start, self.direction, radius));
        }
        if dot(from_end, self.direction) >= 0.0 {
            let last = self.after.is_none();
            return last.then(|| around(from_end, self.direction, radius));
        }
        let normal = left_of(self.direction);
        let height = dot(from_start, normal);
        // A centre behind the face is on another side of the body that the polyline surrounds.
        (height >= -depth).then_some(Proximity {
            normal,
            gap: height - radius,
        })
    }

    /// True if the start is the nearest point for a centre before it, seen from the start.
    fn owns_start(&self, from_start: [f64; 2]) -> bool {
        let Some(before) = self.before else {
            return true;
        };
        let turn = cross(before.direction, self.direction);
        let convex = turn < 0.0 || turn == 0.0 && dot(before.direction, self.direction) < 0.0;
        convex && dot(from_start, before.direction) >= 0.0
    }

    /// The wall that a disk has reached beyond an end of this segment.
    pub fn successor(&self, centre: [f64; 2]) -> Option<usize> {
        let (from_start, from_end) = (minus(centre, self.start), minus(centre, self.end));
        let is_before = dot(from_start, self.direction) < 0.0 && !self.owns_start(from_start);
        let is_beyond = dot(from_end, self.direction) >= 0.0;
        let before = self.before.filter(|_| is_before);
        let next = before.or(self.after.filter(|_| is_beyond));
        next.map(|joint| joint.wall)
    }

    /// Height of a point over the line of the face (m).
    pub fn height(&self, point: [f64; 2]) -> f64 {
        dot(minus(point, self.start), left_of(self.direction))
    }

    /// The wall after this one, and the distance of a point from the corner between them (m).
    pub fn corner(&self, point: [f64; 2]) -> Option<(usize, f64)> {
        let [x, y] = minus(point, self.end);
        self.after.map(|joint| (joint.wall, x.hypot(y)))
    }

    /// Distance of a point from any part of it (m).
    pub fn distance(&self, point: [f64; 2]) -> f64 {
        let (from_start, from_end) = (minus(point, self.start), minus(point, self.end));
        if dot(from_start, self.direction) < 0.0 {
            from_start[0].hypot(from_start[1])
        } else if dot(from_end, self.direction) > 0.0 {
            from_end[0].hypot(from_end[1])
        } else {
            cross(self.direction, from_start).abs()
        }
    }
}

/// Contact with a point; `from` leads from it to the centre of the disk.
fn around(from: [f64; 2], direction: [f64; 2], radius: f64) -> Proximity {
    let distance = from[0].hypot(from[1]);
    let normal = if distance > 0.0 {
        from.map(|x| x / distance)
    } else {
        left_of(direction)
    };
    let gap = distance - radius;
    Proximity { normal, gap }
}

/// The unit vector along a vector.
pub fn unit(v: [f64; 2]) -> [f64; 2] {
    let length = v[0].hypot(v[1]);
    v.map(|x| x / length)
}

fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// A direction turned to its left.
pub fn left_of(direction: [f64; 2]) -> [f64; 2] {
    [-direction[1], direction[0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn contacts(points: &[[f64; 2]], centre: [f64; 2]) -> Vec<Proximity> {
        let segments = polyline(points, 0);
        let touching = segments.iter().filter_map(|s| s.touch(centre, 1.0, 0.0));
        touching.filter(|at| at.gap <= 1e-12).collect()
    }

    #[test]
    fn a_convex_corner_is_touched_once_all_around() {
        let roof = [[-5.0, 0.0], [0.0, 0.0], [0.0, -5.0]];
        for degree in 0..=90 {
            let (sin, cos) = f64::from(degree).to_radians().sin_cos();
            let found = contacts(&roof, [cos, sin]);
            assert_eq!(found.len(), 1, "at {degree} degrees");
            assert!((found[0].normal[0] - cos).abs() < 1e-12);
            assert!(found[0].gap.abs() < 1e-12);
        }
    }

    #[test]
    fn a_concave_corner_is_touched_twice() {
        let found = contacts(&[[-5.0, 0.0], [0.0, 0.0], [0.0, 5.0]], [-1.0, 1.0]);
        let normals: Vec<[f64; 2]> = found.iter().map(|at| at.normal).collect();
        assert_eq!(normals, [[0.0, 1.0], [-1.0, 0.0]]);
    }

    #[test]
    fn a_joint_of_a_straight_line_is_touched_once() {
        let line = [[-5.0, -1.5], [0.1, 0.03], [0.3, 0.09], [7.0, 2.1]];
        let normal = left_of(unit([10.0, 3.0]));
        for k in -100..400 {
            let along = f64::from(k) * 1e-3;
            let on = [along + normal[0], 0.3 * along + normal[1]];
            assert_eq!(contacts(&line, on).len(), 1, "at {along}");
        }
        let corner = [0.1 + normal[0], 0.03 + normal[1]];
        assert_eq!(contacts(&line, corner).len(), 1);
    }

    #[test]
    fn a_free_end_is_round_and_a_back_is_not_there() {
        let plate = [[0.0, 0.0], [5.0, 0.0]];
        assert_eq!(contacts(&plate, [-0.6, 0.8]).len(), 1);
        assert_eq!(contacts(&plate, [5.6, -0.8]).len(), 1);
        assert!(contacts(&plate, [2.0, -0.5]).is_empty());
    }

    #[test]
    fn a_closed_line_has_no_free_end() {
        let square = [[0.0, 0.0], [0.0, 4.0], [4.0, 4.0], [4.0, 0.0], [0.0, 0.0]];
        // Clockwise: the outside is on the left.
        assert_eq!(contacts(&square, [-0.6, -0.8]).len(), 1);
        assert_eq!(contacts(&square, [2.0, -1.0]).len(), 1);
        assert!(contacts(&square, [2.0, 1.0]).is_empty(), "inside");
        let counterclockwise: Vec<[f64; 2]> = square.into_iter().rev().collect();
        assert_eq!(contacts(&counterclockwise, [1.0, 1.0]).len(), 2, "a corner");
    }

    #[test]
    fn a_disk_that_has_passed_a_joint_belongs_to_the_next_segment() {
        let line = polyline(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], 7);
        assert_eq!(line[0].successor([0.5, 1.0]), None);
        assert_eq!(line[0].successor([1.5, 1.0]), Some(8));
        assert_eq!(line[1].successor([0.5, 1.0]), Some(7));
        assert_eq!(line[1].successor([2.5, 1.0]), None);
    }
}
