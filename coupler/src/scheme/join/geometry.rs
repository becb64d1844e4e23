//! Geometry of two sets that are joined: the sides that they face, and the shape of their surfaces.

use nalgebra::{DMatrix, DVector};

use super::super::group::Offset;
use super::super::mapping::Mapping;

/// The reason to refuse two sets with these outward normals: they must face each other.
pub(super) fn same_side((continuum, wall): (&[f64; 2], &[f64; 2])) -> Option<String> {
    let along = continuum[0] * wall[0] + continuum[1] * wall[1];
    (along > 0.0).then(|| {
        format!(
            "both sets face the same way, with outward normals ({:.3}, {:.3}) and ({:.3}, {:.3}): they would lie inside each other; join the set on the other side, or exchange the sets of two interfaces",
            continuum[0], continuum[1], wall[0], wall[1]
        )
    })
}

/// Standard errors of a fitted parabola that roughness may explain.
const ROUGHNESS: f64 = 4.0;

/// The difference between a row of points and the line through the nodes; none of less than four points.
pub(super) fn offset(linear: &Mapping, nodes: &[[f64; 2]], points: &[[f64; 2]]) -> Offset {
    let on_line = linear.motion(&nodes.concat());
    let [x, y] = [0, 1].map(|k| on_line[on_line.len() - 2 + k] - on_line[k]);
    let (first, span, length) = ([on_line[0], on_line[1]], [x, y], x.hypot(y));
    if nodes.len() == 1 || points.len() < 4 || length == 0.0 {
        return Offset::default();
    }
    // Along the line s goes from -1 to 1, with P_0 = 1, P_1 = s and P_2 = s^2 - 1/3; distances are along its normal.
    let both = points.iter().zip(on_line.chunks_exact(2));
    let (shapes, distances): (Vec<[f64; 3]>, Vec<f64>) = both
        .map(|(point, line)| {
            let along = (point[0] - first[0]) * span[0] + (point[1] - first[1]) * span[1];
            let s = 2.0 * along / (length * length) - 1.0;
            let off = [point[0] - line[0], point[1] - line[1]];
            let distance = (off[1] * span[0] - off[0] * span[1]) / length;
            ([1.0, s, s * s - 1.0 / 3.0], distance)
        })
        .unzip();
    let rows = DMatrix::from_fn(points.len(), 3, |i, k| shapes[i][k]);
    let distances = DVector::from_vec(distances);
    let Some(inverse) = (rows.transpose() * &rows).try_inverse() else {
        return Offset::default();
    };
    let fitted = &inverse * (rows.transpose() * &distances);
    let rough = &distances - &rows * &fitted;
    let variance = rough.norm_squared() / (points.len() - 3) as f64;
    let departs = |k: usize, largest: f64| {
        let error = (variance * inverse[(k, k)]).sqrt();
        largest * (fitted[k].abs() - ROUGHNESS * error).max(0.0)
    };
    let spacing = length / (points.len() - 1) as f64;
    Offset {
        shape_rel: (departs(1, 1.0) + departs(2, 2.0 / 3.0)) / spacing,
        distance_rel: fitted[0].abs() / length,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::MappingKind;

    /// Points 1 apart on y = c x^2 / 2 + b x for |x| <= 4, over nodes on y = 0, 3 below: at the ends the parabola is 8 c - 8 c / 3
    /// above its mean, the tilt 4 b.
    #[test]
    fn a_crown_or_a_slope_on_a_flat_surface_is_found() {
        let nodes: Vec<[f64; 2]> = (-5..=5).map(|x| [f64::from(x), -3.0]).collect();
        let off = |c: f64, b: f64, rough: f64| {
            let points = (-4..=4).map(|x| {
                let y = if x % 2 == 0 { rough } else { -rough };
                let x = f64::from(x);
                [x, 0.5 * c * x * x + b * x + y]
            });
            let points: Vec<[f64; 2]> = points.collect();
            let linear = Mapping::new(MappingKind::Linear, &nodes, &points).expect("it fits");
            offset(&linear, &nodes, &points).shape_rel
        };
        assert!(off(0.0, 0.0, 0.0) < 1e-12);
        assert!((off(0.3, 0.0, 0.0) - 1.6).abs() < 1e-12);
        assert!((off(0.0, 0.1, 0.0) - 0.4).abs() < 1e-12);
        assert_eq!(off(0.0, 0.0, 0.4), 0.0, "rough, but of the same shape");
        assert!((0.5..1.6).contains(&off(0.3, 0.0, 0.1)));
    }

    #[test]
    fn sets_must_face_each_other() {
        let (up, down, aside) = ([0.0, 1.0], [0.0, -1.0], [1.0, 0.0]);
        assert_eq!(same_side((&up, &down)), None);
        assert_eq!(same_side((&up, &aside)), None);
        let why = same_side((&up, &up)).expect("both face up");
        assert!(why.contains("(0.000, 1.000)"), "{why}");
    }
}
