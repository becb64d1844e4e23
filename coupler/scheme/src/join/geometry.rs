//! Geometry of two joined sets: the directions they face, and the shapes of their surfaces.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};

use super::super::group::Offset;
use super::super::mapping::Mapping;

/// The reason to refuse two sets with these outward normals: they must face each other.
pub(super) fn same_side((continuum, motion_driven): (&[f64; 2], &[f64; 2])) -> Option<String> {
    let along = continuum[0] * motion_driven[0] + continuum[1] * motion_driven[1];
    (along > 0.0).then(|| {
        format!(
            "both sets face the same way, with outward normals ({:.3}, {:.3}) and ({:.3}, {:.3}), so the bodies would overlap: join the set on the opposite side, or exchange the sets of two interfaces",
            continuum[0], continuum[1], motion_driven[0], motion_driven[1]
        )
    })
}

/// Number of standard errors of the fitted parabola that roughness may explain.
const ROUGHNESS: f64 = 4.0;

/// Largest difference between the periods of the two sides, over the larger: rounding of their ends.
const SAME_PERIOD: f64 = 1e-9;

/// The common period (m) of both sides along x, from their descriptions; `None` where both have ends. `Err` is the
/// reason to refuse sides with different periods.
pub(super) fn common_period(sides: [(String, Option<f64>); 2]) -> Result<Option<f64>, String> {
    let same = match [sides[0].1, sides[1].1] {
        [None, None] => true,
        [Some(a), Some(b)] => (a - b).abs() <= SAME_PERIOD * a.max(b),
        _ => false,
    };
    if same {
        return Ok(sides[0].1);
    }
    let says = sides.map(|(set, period)| match period {
        Some(period) => format!("`{set}` repeats along x after {period:.9e} m"),
        None => format!("`{set}` has ends"),
    });
    Err(format!(
        "{} and {}: what leaves a periodic side at one end returns at the other, so both sides need the same period; give both the same period (mesh.periodic_x = true and mesh.width_m of a body, sample.periodic_x_m with the same distance between its ends for grains), or leave both without one",
        says[0], says[1]
    ))
}

/// The difference between a row of points and the line through the nodes; zero for fewer than four points.
///
/// A periodic line has neither tilt nor curvature as a whole. There the longest possible waves, cos and sin of 2 pi x /
/// period, take their place.
pub(super) fn offset(
    linear: &Mapping,
    nodes: &[[f64; 2]],
    points: &[[f64; 2]],
    period_m: Option<f64>,
) -> Offset {
    let on_line = linear.motion(&nodes.concat());
    let [x, y] = [0, 1].map(|k| on_line[on_line.len() - 2 + k] - on_line[k]);
    let (first, span, length) = match period_m {
        None => ([on_line[0], on_line[1]], [x, y], x.hypot(y)),
        Some(period) => (nodes[0], [period, 0.0], period),
    };
    let spacing_rel = spacing(nodes, &on_line);
    let along = on_line.chunks_exact(2);
    let along =
        along.map(|at| ((at[0] - first[0]) * span[0] + (at[1] - first[1]) * span[1]) / length);
    let hole_rel = hole(along.collect(), period_m);
    let measured = Offset {
        spacing_rel,
        hole_rel,
        ..Offset::default()
    };
    if nodes.len() == 1 || points.len() < 4 || length == 0.0 {
        return measured;
    }
    // Along the line s runs from -1 to 1, with P_0 = 1, P_1 = s and P_2 = s^2 - 1/3; distances are along its normal.
    let both = points.iter().zip(on_line.chunks_exact(2));
    let (shapes, distances): (Vec<[f64; 3]>, Vec<f64>) = both
        .map(|(point, line)| {
            let along = (point[0] - first[0]) * span[0] + (point[1] - first[1]) * span[1];
            let s = 2.0 * along / (length * length) - 1.0;
            let off = [point[0] - line[0], point[1] - line[1]];
            let distance = (off[1] * span[0] - off[0] * span[1]) / length;
            let angle = PI * s;
            let shape = match period_m {
                None => [1.0, s, s * s - 1.0 / 3.0],
                Some(_) => [1.0, angle.cos(), angle.sin()],
            };
            (shape, distance)
        })
        .unzip();
    let rows = DMatrix::from_fn(points.len(), 3, |i, k| shapes[i][k]);
    let distances = DVector::from_vec(distances);
    let Some(inverse) = (rows.transpose() * &rows).try_inverse() else {
        return measured;
    };
    let fitted = &inverse * (rows.transpose() * &distances);
    let rough = &distances - &rows * &fitted;
    let variance = rough.norm_squared() / (points.len() - 3) as f64;
    let departs = |k: usize, largest: f64| {
        let error = (variance * inverse[(k, k)]).sqrt();
        largest * (fitted[k].abs() - ROUGHNESS * error).max(0.0)
    };
    let (shape, gaps) = match period_m {
        None => (departs(1, 1.0) + departs(2, 2.0 / 3.0), points.len() - 1),
        Some(_) => (departs(1, 1.0).hypot(departs(2, 1.0)), points.len()),
    };
    let spacing = length / gaps as f64;
    Offset {
        shape_rel: shape / spacing,
        distance_rel: fitted[0].abs() / length,
        ..measured
    }
}

/// Largest distance of neighbours in a row over their median; 0 for fewer than three points.
fn hole(mut along: Vec<f64>, period_m: Option<f64>) -> f64 {
    along.sort_by(f64::total_cmp);
    let round = period_m.zip(along.first());
    along.extend(round.map(|(period, first)| first + period));
    let mut gaps = Vec::from_iter(along.windows(2).map(|pair| pair[1] - pair[0]));
    gaps.sort_by(f64::total_cmp);
    let median = gaps.get(gaps.len() / 2).copied().unwrap_or(0.0);
    match gaps.last() {
        Some(largest) if gaps.len() > 1 && median > 0.0 => largest / median,
        _ => 0.0,
    }
}

/// Distance of neighbouring points on the line through the nodes, over the distance of the nodes there: the median
/// along the row, or 0 for a single point or node.
fn spacing(nodes: &[[f64; 2]], on_line: &[f64]) -> f64 {
    let apart = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    let nearest = |to: &[f64; 2], of: &[[f64; 2]]| {
        let others = of.iter().filter(|one| apart(one, to) > 0.0);
        let nearest = others.min_by(|a, b| apart(a, to).total_cmp(&apart(b, to)));
        nearest.copied()
    };
    let points = on_line.chunks_exact(2).map(|point| [point[0], point[1]]);
    let points: Vec<[f64; 2]> = points.collect();
    let ratio = |point: &[f64; 2]| {
        let node = nearest(point, nodes)?;
        Some(apart(point, &nearest(point, &points)?) / apart(&node, &nearest(&node, nodes)?))
    };
    let mut found: Vec<f64> = points.iter().filter_map(ratio).collect();
    found.sort_by(f64::total_cmp);
    found.get(found.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::keys::MappingKind;

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
            let linear = Mapping::new(MappingKind::Linear, &nodes, &points, None).expect("it fits");
            offset(&linear, &nodes, &points, None).shape_rel
        };
        assert!(off(0.0, 0.0, 0.0) < 1e-12);
        assert!((off(0.3, 0.0, 0.0) - 1.6).abs() < 1e-12);
        assert!((off(0.0, 0.1, 0.0) - 0.4).abs() < 1e-12);
        assert_eq!(off(0.0, 0.0, 0.4), 0.0, "rough, but of the same shape");
        assert!((0.5..1.6).contains(&off(0.3, 0.0, 0.1)));
    }

    /// Three nodes 0.5 apart and one 2 further: all points but the last lie on the fine part.
    #[test]
    fn the_spacing_of_points_is_compared_with_the_nodes_that_carry_them() {
        let nodes = [[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [3.0, 0.0]];
        let found = |points: &[f64]| {
            let points: Vec<[f64; 2]> = points.iter().map(|x| [*x, 0.1]).collect();
            let linear = Mapping::new(MappingKind::Linear, &nodes, &points, None).expect("it fits");
            offset(&linear, &nodes, &points, None).spacing_rel
        };
        assert!((found(&[-0.0, 0.75]) - 1.5).abs() < 1e-12);
        assert!((found(&[0.0, 0.1, 0.2, 0.3, 3.0]) - 0.2).abs() < 1e-12);
        assert_eq!(found(&[0.5]), 0.0);
    }

    #[test]
    fn a_hole_in_a_row_is_compared_with_the_other_distances() {
        assert_eq!(hole(vec![0.0, 1.0, 2.0, 10.0, 11.0], None), 8.0);
        assert_eq!(hole(vec![2.0, 0.0, 1.0, 3.0], Some(4.0)), 1.0);
        assert_eq!(hole(vec![0.0, 1.0, 2.0, 3.0], Some(9.0)), 6.0);
        for row in [vec![], vec![1.0], vec![1.0, 5.0], vec![1.0; 4]] {
            assert_eq!(hole(row, None), 0.0);
        }
    }

    /// Twelve points on y = c cos(2 pi x / 6) over nodes on y = 0, half of them a period away.
    #[test]
    fn a_wave_on_a_flat_periodic_surface_is_found() {
        let nodes: Vec<[f64; 2]> = (0..9).map(|i| [f64::from(i) * 6.0 / 9.0, 0.0]).collect();
        let off = |c: f64, shift: f64| {
            let position = |i: i32| 0.5 * f64::from(i) + shift + 6.0 * f64::from(i % 2);
            let points = (0..12).map(|i| [position(i), 2.0 + c * (PI * position(i) / 3.0).cos()]);
            let points: Vec<[f64; 2]> = points.collect();
            let linear = Mapping::new(MappingKind::Linear, &nodes, &points, Some(6.0));
            offset(&linear.expect("it fits"), &nodes, &points, Some(6.0))
        };
        assert!(off(0.0, 0.0).shape_rel < 1e-12);
        for shift in [0.0, 0.2, 1.9, -40.0] {
            let found = off(0.1, shift);
            assert!((found.shape_rel - 0.2).abs() < 1e-12, "{found:?}");
            assert!((found.distance_rel - 2.0 / 6.0).abs() < 1e-12, "{found:?}");
        }
    }

    #[test]
    fn both_sides_have_the_same_period_or_none() {
        let period = |a, b| common_period([("rail.top".into(), a), ("layer.base".into(), b)]);
        assert_eq!(period(None, None), Ok(None));
        assert_eq!(period(Some(2.0), Some(2.0 + 1e-9)), Ok(Some(2.0)));
        let cases = [
            (
                Some(2.0),
                Some(2.0 + 1e-8),
                "`layer.base` repeats along x after 2.000000010e0 m",
            ),
            (
                Some(2.0),
                None,
                "`rail.top` repeats along x after 2.000000000e0 m and `layer.base` has ends",
            ),
            (
                None,
                Some(3.0),
                "`rail.top` has ends and `layer.base` repeats along x after 3.000000000e0 m",
            ),
        ];
        for (a, b, said) in cases {
            let why = period(a, b).expect_err("the periods differ");
            for said in [said, "sample.periodic_x_m", "mesh.periodic_x"] {
                assert!(why.contains(said), "no {said} in {why}");
            }
        }
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
