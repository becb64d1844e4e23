//! Glued points as weighted means of surface nodes: motion goes by N, force by its transpose.

use std::ops::Range;

use nalgebra::DMatrix;
use thiserror::Error;

use crate::scenario::MappingKind;

/// Why two sets of points cannot be related.
#[derive(Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum MappingError {
    #[error("one side of the interface has no points")]
    Empty,
    #[error(
        "surface nodes {first} and {second} share the place ({x_m:.6e}, {y_m:.6e}) m along the surface"
    )]
    RepeatedNode {
        first: usize,
        second: usize,
        x_m: f64,
        y_m: f64,
    },
    #[error(
        "glued points {first} and {second} share the place ({x_m:.6e}, {y_m:.6e}) m along the surface"
    )]
    RepeatedPoint {
        first: usize,
        second: usize,
        x_m: f64,
        y_m: f64,
    },
    #[error(
        "glued point {point} at ({x_m:.6e}, {y_m:.6e}) m lies beyond the ends of the surface line"
    )]
    Beyond { point: usize, x_m: f64, y_m: f64 },
}

/// N (points x nodes), row by row; every row sums to one.
#[derive(Clone, Debug, PartialEq)]
pub struct Mapping {
    rows: Vec<Vec<(usize, f64)>>,
    nodes: usize,
}

impl Mapping {
    /// The relation that a scenario asks for.
    pub fn new(
        kind: MappingKind,
        nodes: &[[f64; 2]],
        points: &[[f64; 2]],
    ) -> Result<Mapping, MappingError> {
        match kind {
            MappingKind::Mortar => Mapping::mortar(nodes, points),
            MappingKind::Linear => {
                Mapping::along(nodes, points, |line, s, _| line.interpolation(s))
            }
            MappingKind::Nearest => Mapping::along(nodes, points, |line, s, _| line.nearest(s)),
        }
    }

    /// Mortar weights with affine correction on the line through `nodes` (m): row i is the mean of the nodes' shape
    /// functions over the segment of point i (halfway to its neighbours, cut at the ends of the line), plus
    /// (s_i - centre of the segment) times their mean slope there. Constant and linear fields are reproduced exactly,
    /// so that N^T conserves force and moment; the mean keeps a uniform pressure nearly uniform.
    ///
    /// Places along the line are counted on its chord, so that linear fields stay linear on a curved line too.
    pub fn mortar(nodes: &[[f64; 2]], points: &[[f64; 2]]) -> Result<Mapping, MappingError> {
        Mapping::along(nodes, points, |line, s, segment| line.row(s, segment))
    }

    /// Rows made from each point's place and segment on the line through the nodes; a single node carries all.
    fn along(
        nodes: &[[f64; 2]],
        points: &[[f64; 2]],
        row: impl Fn(&Line, f64, [f64; 2]) -> Vec<(usize, f64)>,
    ) -> Result<Mapping, MappingError> {
        if nodes.is_empty() || points.is_empty() {
            return Err(MappingError::Empty);
        }
        if nodes.len() == 1 {
            let rows = points.iter().map(|_| vec![(0, 1.0)]).collect();
            return Ok(Mapping { rows, nodes: 1 });
        }
        let line = Line::through(nodes)?;
        let places: Vec<f64> = points.iter().map(|point| line.place(*point)).collect();
        line.check(points, &places)?;
        let mut rows = vec![Vec::new(); points.len()];
        for (point, low, high) in segments(points, &places)? {
            rows[point] = row(&line, places[point], [low, high]);
        }
        Ok(Mapping {
            rows,
            nodes: nodes.len(),
        })
    }

    /// Nodes that carry any weight, in order.
    pub fn active(&self) -> Vec<usize> {
        let mut carries = vec![false; self.nodes];
        for (node, weight) in self.rows.iter().flatten() {
            carries[*node] |= *weight != 0.0;
        }
        (0..self.nodes).filter(|node| carries[*node]).collect()
    }

    /// The same mapping on `active` nodes only, which must hold all nodes with weight.
    pub fn restricted(&self, active: &[usize]) -> Mapping {
        let mut position = vec![usize::MAX; self.nodes];
        for (index, node) in active.iter().enumerate() {
            position[*node] = index;
        }
        let rows = self
            .rows
            .iter()
            .map(|row| {
                row.iter()
                    .filter(|(_, weight)| *weight != 0.0)
                    .map(|(node, weight)| (position[*node], *weight))
                    .collect()
            })
            .collect();
        Mapping {
            rows,
            nodes: active.len(),
        }
    }

    /// A mapping of so many points that carries nothing yet.
    pub fn empty(nodes: usize, points: usize) -> Mapping {
        Mapping {
            rows: vec![Vec::new(); points],
            nodes,
        }
    }

    /// Puts another mapping in place, from the point `first_point` and the node `first_node` on.
    pub fn put(&mut self, first_point: usize, first_node: usize, other: &Mapping) {
        for (row, theirs) in self.rows[first_point..].iter_mut().zip(&other.rows) {
            *row = theirs
                .iter()
                .map(|(node, weight)| (first_node + node, *weight))
                .collect();
        }
    }

    /// What some points see of some nodes; all other nodes count as held.
    pub fn block(&self, points: &Range<usize>, nodes: &Range<usize>) -> Mapping {
        let rows = self.rows[points.clone()].iter();
        let inside = |row: &Vec<(usize, f64)>| {
            row.iter()
                .filter(|(node, _)| nodes.contains(node))
                .map(|(node, weight)| (node - nodes.start, *weight))
                .collect()
        };
        Mapping {
            rows: rows.map(inside).collect(),
            nodes: nodes.len(),
        }
    }

    /// N applied to both components: motion of the nodes to motion of the points.
    pub fn motion(&self, nodal: &[f64]) -> Vec<f64> {
        let mut result = Vec::with_capacity(2 * self.rows.len());
        for row in &self.rows {
            for component in 0..2 {
                result.push(
                    row.iter()
                        .map(|(node, weight)| weight * nodal[2 * node + component])
                        .sum(),
                );
            }
        }
        result
    }

    /// N^T applied to both components: forces on the points to forces on the nodes.
    pub fn force(&self, point: &[f64]) -> Vec<f64> {
        let mut result = vec![0.0; 2 * self.nodes];
        for (i, row) in self.rows.iter().enumerate() {
            for (node, weight) in row {
                result[2 * node] += weight * point[2 * i];
                result[2 * node + 1] += weight * point[2 * i + 1];
            }
        }
        result
    }

    /// N C N^T for a nodal matrix C (2 nodes x 2 nodes): the compliance that the points feel.
    pub fn condense(&self, nodal: &DMatrix<f64>) -> DMatrix<f64> {
        let size = 2 * self.rows.len();
        let mut half = DMatrix::zeros(2 * self.nodes, size);
        for column in 0..2 * self.nodes {
            let moved = self.motion(nodal.column(column).as_slice());
            half.row_mut(column).copy_from_slice(&moved);
        }
        let mut result = DMatrix::zeros(size, size);
        for column in 0..size {
            let moved = self.motion(half.column(column).as_slice());
            result.row_mut(column).copy_from_slice(&moved);
        }
        result
    }
}

/// The surface line with its nodes in order along the chord.
struct Line {
    origin: [f64; 2],
    chord: [f64; 2],
    /// Node index and place along the chord (m), ascending.
    nodes: Vec<(usize, f64)>,
}

impl Line {
    fn through(nodes: &[[f64; 2]]) -> Result<Line, MappingError> {
        let (first, last) = farthest(nodes);
        let span = [
            nodes[last][0] - nodes[first][0],
            nodes[last][1] - nodes[first][1],
        ];
        let length = span[0].hypot(span[1]);
        let mut line = Line {
            origin: nodes[first],
            chord: [span[0] / length, span[1] / length],
            nodes: Vec::new(),
        };
        line.nodes = nodes
            .iter()
            .enumerate()
            .map(|(i, node)| (i, line.place(*node)))
            .collect();
        line.nodes.sort_by(|a, b| a.1.total_cmp(&b.1));
        for pair in line.nodes.windows(2) {
            // A chord of zero length (all nodes in one place) gives NaN places, which also end here.
            let spacing = pair[1].1 - pair[0].1;
            if spacing.is_nan() || spacing <= 1e-12 * length {
                let [x_m, y_m] = nodes[pair[0].0];
                return Err(MappingError::RepeatedNode {
                    first: pair[0].0.min(pair[1].0),
                    second: pair[0].0.max(pair[1].0),
                    x_m,
                    y_m,
                });
            }
        }
        Ok(line)
    }

    fn place(&self, point: [f64; 2]) -> f64 {
        (point[0] - self.origin[0]) * self.chord[0] + (point[1] - self.origin[1]) * self.chord[1]
    }

    fn ends(&self) -> (f64, f64) {
        (self.nodes[0].1, self.nodes[self.nodes.len() - 1].1)
    }

    fn check(&self, points: &[[f64; 2]], places: &[f64]) -> Result<(), MappingError> {
        let (low, high) = self.ends();
        let margin = 1e-9 * (high - low);
        match places
            .iter()
            .position(|s| !(*s >= low - margin && *s <= high + margin))
        {
            None => Ok(()),
            Some(point) => Err(MappingError::Beyond {
                point,
                x_m: points[point][0],
                y_m: points[point][1],
            }),
        }
    }

    /// The row of a point at `s` whose segment is [low, high].
    fn row(&self, s: f64, [low, high]: [f64; 2]) -> Vec<(usize, f64)> {
        let (first, last) = self.ends();
        let (low, high) = (low.max(first), high.min(last));
        let length = high - low;
        if length <= 1e-12 * (last - first) {
            return self.interpolation(s);
        }
        let centre = 0.5 * (low + high);
        let mut row: Vec<(usize, f64)> = Vec::new();
        let start = self
            .nodes
            .partition_point(|(_, place)| *place <= low)
            .saturating_sub(1);
        for pair in self.nodes[start..].windows(2) {
            let ((left, a), (right, b)) = (pair[0], pair[1]);
            if a >= high {
                break;
            }
            let (l, r) = (low.max(a), high.min(b));
            if r <= l {
                continue;
            }
            let share = (r - l) / length;
            let middle = (0.5 * (l + r) - a) / (b - a);
            let tilt = (s - centre) * share / (b - a);
            add(&mut row, left, share * (1.0 - middle) - tilt);
            add(&mut row, right, share * middle + tilt);
        }
        row
    }

    fn nearest(&self, s: f64) -> Vec<(usize, f64)> {
        let row = self.interpolation(s);
        let (node, _) = if row[0].1 >= row[1].1 { row[0] } else { row[1] };
        vec![(node, 1.0)]
    }

    /// Plain interpolation, the limit of a segment without length.
    fn interpolation(&self, s: f64) -> Vec<(usize, f64)> {
        let right = self
            .nodes
            .partition_point(|(_, place)| *place < s)
            .clamp(1, self.nodes.len() - 1);
        let ((i, a), (j, b)) = (self.nodes[right - 1], self.nodes[right]);
        let share = (s - a) / (b - a);
        vec![(i, 1.0 - share), (j, share)]
    }
}

fn add(row: &mut Vec<(usize, f64)>, node: usize, weight: f64) {
    match row.last_mut() {
        Some((last, sum)) if *last == node => *sum += weight,
        _ => row.push((node, weight)),
    }
}

/// Two nodes at the ends of the line: the farthest from the first, and the farthest from that one, ordered
/// so that the chord points along the larger coordinate.
fn farthest(nodes: &[[f64; 2]]) -> (usize, usize) {
    let from = |origin: usize| {
        let distance =
            |i: usize| (nodes[i][0] - nodes[origin][0]).hypot(nodes[i][1] - nodes[origin][1]);
        (0..nodes.len()).fold(origin, |best, i| {
            if distance(i) > distance(best) {
                i
            } else {
                best
            }
        })
    };
    let one = from(0);
    let other = from(one);
    let ascending = (nodes[one][0], nodes[one][1]) <= (nodes[other][0], nodes[other][1]);
    if ascending {
        (one, other)
    } else {
        (other, one)
    }
}

/// (point, low, high) for each point: halfway to its neighbours; at the ends as far out as in. A single point
/// has a segment without length.
fn segments(points: &[[f64; 2]], places: &[f64]) -> Result<Vec<(usize, f64, f64)>, MappingError> {
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|a, b| places[*a].total_cmp(&places[*b]));
    for pair in order.windows(2) {
        if places[pair[0]] == places[pair[1]] {
            let [x_m, y_m] = points[pair[0]];
            return Err(MappingError::RepeatedPoint {
                first: pair[0].min(pair[1]),
                second: pair[0].max(pair[1]),
                x_m,
                y_m,
            });
        }
    }
    let result = (0..order.len()).map(|k| {
        let s = places[order[k]];
        let inner_left = k.checked_sub(1).map(|j| 0.5 * (s - places[order[j]]));
        let inner_right = order.get(k + 1).map(|j| 0.5 * (places[*j] - s));
        let left = inner_left.or(inner_right).unwrap_or(0.0);
        let right = inner_right.or(inner_left).unwrap_or(0.0);
        (order[k], s - left, s + right)
    });
    Ok(result.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn uneven_points(count: usize, low: f64, high: f64) -> Vec<[f64; 2]> {
        (0..count)
            .map(|i| {
                let t = (i as f64 + 0.3 + 0.4 * ((i * 7 % 5) as f64 / 5.0)) / count as f64;
                [low + (high - low) * t, 0.01]
            })
            .collect()
    }

    fn crown(x: f64) -> [f64; 2] {
        [x, (0.09 - x * x).sqrt() - 0.3]
    }

    fn both(values: impl Fn(usize) -> f64, count: usize) -> Vec<f64> {
        (0..count)
            .flat_map(|i| [values(i), -2.0 * values(i)])
            .collect()
    }

    #[test]
    fn linear_fields_are_reproduced_on_flat_and_curved_lines() {
        let flat: Vec<[f64; 2]> = (0..41).map(|i| [-0.01 + 5e-4 * i as f64, 0.0]).collect();
        let curved: Vec<[f64; 2]> = (0..41).map(|i| crown(-0.01 + 5e-4 * i as f64)).collect();
        let points = uneven_points(97, -0.008, 0.008);
        for nodes in [flat, curved] {
            let mapping = Mapping::mortar(&nodes, &points).expect("regular input");
            let field = both(|i| 3.0 + 700.0 * nodes[i][0], nodes.len());
            let mapped = mapping.motion(&field);
            for (i, point) in points.iter().enumerate() {
                let exact = 3.0 + 700.0 * point[0];
                assert!(
                    (mapped[2 * i] - exact).abs() < 2e-13 * 10.0,
                    "{} {exact}",
                    mapped[2 * i]
                );
                assert!((mapped[2 * i + 1] + 2.0 * exact).abs() < 4e-13 * 10.0);
            }
        }
    }

    #[test]
    fn force_moment_and_power_are_conserved() {
        let nodes: Vec<[f64; 2]> = (0..41).map(|i| [-0.01 + 5e-4 * i as f64, 0.0]).collect();
        let points = uneven_points(97, -0.008, 0.008);
        let mapping = Mapping::mortar(&nodes, &points).expect("regular input");
        let force = both(|i| 1.0 + (i as f64).sin(), points.len());
        let nodal = mapping.force(&force);
        let sum = |f: &[f64], c: usize| f.iter().skip(c).step_by(2).sum::<f64>();
        let total = sum(&force, 1);
        assert!((sum(&nodal, 1) - total).abs() < 1e-12 * total.abs());
        let moment = |f: &[f64], x: &[[f64; 2]]| {
            x.iter()
                .enumerate()
                .map(|(i, p)| p[0] * f[2 * i + 1])
                .sum::<f64>()
        };
        assert!((moment(&nodal, &nodes) - moment(&force, &points)).abs() < 1e-14 * total.abs());
        let motion = both(|i| (0.3 * i as f64).cos(), nodes.len());
        let power: f64 = mapping
            .motion(&motion)
            .iter()
            .zip(&force)
            .map(|(v, f)| v * f)
            .sum();
        let nodal_power: f64 = motion.iter().zip(&nodal).map(|(v, f)| v * f).sum();
        assert!((power - nodal_power).abs() < 1e-12 * power.abs());
    }

    #[test]
    fn every_kind_conserves_force_and_power() {
        let nodes: Vec<[f64; 2]> = (0..41).map(|i| [-0.01 + 5e-4 * i as f64, 0.0]).collect();
        let points = uneven_points(97, -0.008, 0.008);
        for kind in [
            MappingKind::Mortar,
            MappingKind::Linear,
            MappingKind::Nearest,
        ] {
            let mapping = Mapping::new(kind, &nodes, &points).expect("regular input");
            let force = both(|i| 1.0 + (i as f64).sin(), points.len());
            let sum = |f: &[f64]| f.iter().step_by(2).sum::<f64>();
            assert!(
                (sum(&mapping.force(&force)) / sum(&force) - 1.0).abs() < 1e-13,
                "{kind:?}"
            );
        }
    }

    /// Ripple of a uniform pressure, |t - mean| / mean over the nodes well inside: what the kinds differ by.
    #[test]
    fn mortar_keeps_a_uniform_pressure_more_even_than_the_others() {
        let nodes: Vec<[f64; 2]> = (0..121).map(|i| [1e-4 * i as f64, 0.0]).collect();
        let points = uneven_points(80, 0.0, 0.012);
        let ripple = |kind| {
            let mapping = Mapping::new(kind, &nodes, &points).expect("regular input");
            let mut places: Vec<f64> = points.iter().map(|p| p[0]).collect();
            places.sort_by(f64::total_cmp);
            let force: Vec<f64> = points
                .iter()
                .flat_map(|p| {
                    let k = places
                        .iter()
                        .position(|x| *x == p[0])
                        .expect("it is one of them");
                    let left = if k > 0 { places[k - 1] } else { -places[k] };
                    let right = if k + 1 < places.len() {
                        places[k + 1]
                    } else {
                        0.024 - places[k]
                    };
                    [0.5 * (right - left), 0.0]
                })
                .collect();
            let nodal = mapping.force(&force);
            let inside: Vec<f64> = (10..110).map(|i| nodal[2 * i] / 1e-4).collect();
            let mean = inside.iter().sum::<f64>() / inside.len() as f64;
            (inside.iter().map(|t| (t - mean).powi(2)).sum::<f64>() / inside.len() as f64).sqrt()
                / mean
        };
        let [mortar, linear, nearest] = [
            MappingKind::Mortar,
            MappingKind::Linear,
            MappingKind::Nearest,
        ]
        .map(ripple);
        println!("ripple: mortar {mortar:.3}, linear {linear:.3}, nearest {nearest:.3}");
        assert!(mortar < 0.5 * linear && linear < nearest);
    }

    #[test]
    fn condensing_is_n_c_nt() {
        let nodes = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]];
        let points = [[0.4, 0.0], [1.5, 0.0]];
        let mapping = Mapping::mortar(&nodes, &points).expect("regular input");
        let c = DMatrix::from_fn(6, 6, |i, j| 1.0 / (1.0 + i as f64 + j as f64));
        let mut n = DMatrix::zeros(4, 6);
        for column in 0..6 {
            let mut unit = vec![0.0; 6];
            unit[column] = 1.0;
            n.column_mut(column).copy_from_slice(&mapping.motion(&unit));
        }
        assert!((mapping.condense(&c) - &n * &c * n.transpose()).amax() < 1e-15);
    }

    #[test]
    fn only_nodes_under_the_points_are_active() {
        let nodes: Vec<[f64; 2]> = (0..11).map(|i| [i as f64, 0.0]).collect();
        let mapping = Mapping::mortar(&nodes, &[[3.4, 0.0], [4.4, 0.0]]).expect("regular input");
        assert_eq!(mapping.active(), vec![2, 3, 4, 5]);
    }

    #[test]
    fn degenerate_input_is_named() {
        let nodes = [[0.0, 0.0], [1.0, 0.0]];
        assert_eq!(Mapping::mortar(&nodes, &[]), Err(MappingError::Empty));
        let beyond = Mapping::mortar(&nodes, &[[0.5, 0.0], [1.5, 0.0]]);
        assert!(matches!(beyond, Err(MappingError::Beyond { point: 1, .. })));
        let twice = Mapping::mortar(&nodes, &[[0.5, 0.0], [0.5, 0.1]]);
        assert!(matches!(
            twice,
            Err(MappingError::RepeatedPoint {
                first: 0,
                second: 1,
                ..
            })
        ));
        let same = Mapping::mortar(&[[0.0, 0.0], [0.0, 0.0]], &[[0.0, 0.0]]);
        assert!(matches!(same, Err(MappingError::RepeatedNode { .. })));
        let single = Mapping::mortar(&nodes, &[[0.25, 0.0]]).expect("one point interpolates");
        assert_eq!(single.motion(&[0.0, 0.0, 4.0, 8.0]), vec![1.0, 2.0]);
    }
}
