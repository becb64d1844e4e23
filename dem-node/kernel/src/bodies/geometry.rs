//! Normals and gaps of two bodies, crowned lines, and strips that repeat.

/// A strip that repeats along x: a body that leaves it on one side has already entered it on the other.
///
/// Positions are never folded back into the strip. Only distances are taken to the nearest image, so that the seam does not affect displacements,
/// levers and bonds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Period {
    /// Left end (m).
    pub left: f64,
    /// Length (m).
    pub length: f64,
}

impl Period {
    /// The strip between two ends (m).
    pub fn between([left, right]: [f64; 2]) -> Period {
        let length = right - left;
        Period { left, length }
    }

    /// The shortest of all images of a distance along x (m).
    pub fn nearest(self, dx: f64) -> f64 {
        dx - self.length * (dx / self.length).round()
    }

    /// The image of x inside the strip (m).
    pub fn inside(self, x: f64) -> f64 {
        self.left + (x - self.left).rem_euclid(self.length)
    }
}

/// Drop of a crowned line below its top, c(x) = R - sqrt(R^2 - x^2), written without cancellation (m); R = 0 is straight.
pub fn drop_at(x: f64, crown: f64) -> f64 {
    if crown == 0.0 {
        return 0.0;
    }
    x * x / (crown + (crown * crown - x * x).sqrt())
}

/// Geometry of a pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proximity {
    /// Unit normal from b to a.
    pub normal: [f64; 2],
    /// Gap, negative when the bodies overlap (m).
    pub gap: f64,
}

/// Two disks at a distance; `reach` is the sum of their radii.
#[inline(always)]
pub fn between_disks([dx, dy]: [f64; 2], reach: f64) -> Proximity {
    let distance = (dx * dx + dy * dy).sqrt();
    // Coincident centres have no normal; any fixed direction separates them again.
    let normal = if distance > 0.0 {
        let one_over = 1.0 / distance;
        [one_over * dx, one_over * dy]
    } else {
        [0.0, 1.0]
    };
    let gap = distance - reach;
    Proximity { normal, gap }
}

/// A disk under a wheel whose face has this radius R, 0 = flat, and its lowest point at `face`.
///
/// With d from the lowest point to the disk, the distance from the face is |d - (0, R)| - R =
/// (d.d - 2 R d_y) / (|d - (0, R)| + R), which keeps its digits when R is large.
pub fn under_wheel(face: [f64; 2], wheel_radius: f64, centre: [f64; 2], radius: f64) -> Proximity {
    if wheel_radius == 0.0 {
        return Proximity {
            normal: [0.0, -1.0],
            gap: face[1] - centre[1] - radius,
        };
    }
    let (dx, dy) = (centre[0] - face[0], centre[1] - face[1]);
    let distance = dx.hypot(dy - wheel_radius);
    let outside = (dx * dx + dy * dy - 2.0 * wheel_radius * dy) / (distance + wheel_radius);
    Proximity {
        normal: [dx / distance, (dy - wheel_radius) / distance],
        gap: outside - radius,
    }
}

/// Height of the lowest point of a wheel over x = 0 that touches this disk from above (m); `None` for a disk that it does not meet.
///
/// The centres are R + r apart, so the lowest point is y + r - (R + r - sqrt((R + r)^2 - x^2)).
pub fn height_on(wheel_radius: f64, centre: [f64; 2], radius: f64) -> Option<f64> {
    let top = centre[1] + radius;
    if wheel_radius == 0.0 {
        return Some(top);
    }
    let (x, reach) = (centre[0], wheel_radius + radius);
    let squared = reach * reach - x * x;
    (squared >= 0.0).then(|| top - x * x / (reach + squared.sqrt()))
}

/// Height of a disk over another that it touches from above, their centres `dx` apart along x and `reach` apart in all (m); `None` if they do not
/// meet.
pub fn over_disk(dx: f64, reach: f64) -> Option<f64> {
    let squared = reach * reach - dx * dx;
    (squared >= 0.0).then(|| squared.sqrt())
}

/// Vector from b to a (m), the shortest of its images where a strip repeats.
#[inline]
pub fn between_points(a: [f64; 2], b: [f64; 2], period: Option<Period>) -> [f64; 2] {
    let dx = a[0] - b[0];
    [period.map_or(dx, |period| period.nearest(dx)), a[1] - b[1]]
}

/// Squares of the distances by which points have moved (m2).
pub fn squared_displacements(now: &[[f64; 2]], then: &[[f64; 2]]) -> impl Iterator<Item = f64> {
    let both = now.iter().zip(then);
    both.map(|(now, then)| (now[0] - then[0]).powi(2) + (now[1] - then[1]).powi(2))
}

/// Smallest and largest of these values; infinity and minus infinity without values.
pub fn range(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    let none = [f64::INFINITY, f64::NEG_INFINITY];
    let values = values.into_iter();
    values.fold(none, |[low, high], x| [low.min(x), high.max(x)])
}

/// Largest coordinate (m): its rounding error is in positions, and so in gaps.
pub fn extent(centres: &[[f64; 2]]) -> f64 {
    let coordinates = centres.iter().flatten();
    coordinates.fold(0.0, |largest, x| largest.max(x.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_crown_drops_a_tenth_of_a_millimetre_at_eight() {
        let drop = drop_at(8e-3, 0.3);
        assert!((drop - 0.106_685e-3).abs() < 1e-9, "{drop}");
        assert_eq!(drop_at(8e-3, 0.0), 0.0);
    }

    #[test]
    fn a_disk_beside_the_middle_of_a_curved_wheel_is_on_a_triangle() {
        // Wheel of radius 4 around (0, 5), disk of radius 1 around (3, 1): centres 5 apart, touching.
        let at = under_wheel([0.0, 1.0], 4.0, [3.0, 1.0], 1.0);
        assert!(at.gap.abs() < 1e-15, "{at:?}");
        assert_eq!(at.normal, [0.6, -0.8]);
        assert_eq!(height_on(4.0, [3.0, 1.0], 1.0), Some(1.0));
        assert_eq!(height_on(4.0, [5.1, 1.0], 1.0), None);
    }

    #[test]
    fn distances_are_to_the_nearest_image() {
        let strip = Period::between([-2.0, 6.0]);
        assert_eq!(
            [1.0, 5.0, -5.0, 17.0].map(|dx| strip.nearest(dx)),
            [1.0, -3.0, 3.0, 1.0]
        );
        assert_eq!(
            [-3.0, 6.5, 22.0, 1.0].map(|x| strip.inside(x)),
            [5.0, -1.5, -2.0, 1.0]
        );
    }

    #[test]
    fn a_huge_wheel_is_flat() {
        let curved = under_wheel([0.0, 2.0], 1e12, [1e-3, 0.5], 1.0);
        let flat = under_wheel([0.0, 2.0], 0.0, [1e-3, 0.5], 1.0);
        assert!((curved.gap - flat.gap).abs() < 1e-11);
        assert!((curved.normal[1] - flat.normal[1]).abs() < 1e-15);
    }
}
