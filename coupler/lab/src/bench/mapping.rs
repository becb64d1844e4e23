//! Errors and cost of each mapping of forces and motions between nodes and glued points.

use std::hint::black_box;
use std::time::Instant;

use nalgebra::DVector;
use serde::Serialize;

use scenario::error::{Error, Refusal};
use scheme::keys::MappingKind;
use scheme::mapping::Mapping;

/// One kind of mapping on one line.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MappingRow {
    /// `mortar`, `linear` or `nearest`.
    pub mapping: MappingKind,
    /// `flat`, or `curved` like a crown.
    pub line: &'static str,
    /// Surface nodes.
    pub nodes: usize,
    /// Glued points.
    pub points: usize,
    /// |sum of nodal forces - sum of point forces| / sum of |point forces|.
    pub force_rel: f64,
    /// Error of the moment of forces across the line about its middle, over the sum of its parts.
    pub moment_rel: f64,
    /// |F.(N v) - (N^T F).v| / sum of |F.(N v)|: the energy that the mapping makes or loses.
    pub power_rel: f64,
    /// Spread of the traction on the inner nodes under a uniform pressure, over its mean.
    pub ripple: f64,
    /// Nodes between the first and the last point that get no force.
    pub empty_nodes: usize,
    /// One N and one N^T of all points (ns).
    pub application_ns: f64,
}

/// Length of the line (m).
const LENGTH_M: f64 = 0.02;
/// Radius of the crown (m).
const CROWN_M: f64 = 0.3;
/// Time spent on each measurement (s).
const LONG_ENOUGH_S: f64 = 0.02;

/// All kinds on flat and curved lines of 10 to 10 000 nodes.
pub fn bench() -> Result<Vec<MappingRow>, Error> {
    use MappingKind::{Linear, Mortar, Nearest};
    let mut rows = Vec::new();
    for line in ["flat", "curved"] {
        for nodes in [10, 100, 1_000, 10_000] {
            for kind in [Mortar, Linear, Nearest] {
                rows.push(row(kind, line, nodes)?);
            }
        }
    }
    Ok(rows)
}

/// One row of the table.
pub fn row(kind: MappingKind, line: &'static str, count: usize) -> Result<MappingRow, Error> {
    let height = |x: f64| match line {
        "flat" => 0.0,
        _ => (CROWN_M * CROWN_M - x * x).sqrt() - CROWN_M,
    };
    let nodes = (0..count).map(|i| LENGTH_M * (i as f64 / (count - 1) as f64 - 0.5));
    let nodes: Vec<[f64; 2]> = nodes.map(|x| [x, height(x)]).collect();
    let places = uneven(2 * count / 3);
    let points: Vec<[f64; 2]> = places.iter().map(|x| [*x, height(*x)]).collect();
    let mapping = Mapping::new(kind, &nodes, &points, None)
        .map_err(|error| Refusal::Benchmark(format!("{count} nodes: {error}")))?;
    let force = components(points.len(), |i| 1.0 + (0.7 * i as f64).sin());
    let motion = components(count, |i| (0.3 * i as f64).cos());
    let nodal = mapping.force(&force);
    let moved = mapping.motion(&motion);
    let pressed = mapping.force(&components(points.len(), |i| segment(&places, i)));
    let inner = inside(&nodes, &places);
    let pressed_inside = DVector::from_iterator(inner.len(), inner.map(|i| pressed[2 * i + 1]));
    Ok(MappingRow {
        mapping: kind,
        line,
        nodes: count,
        points: points.len(),
        force_rel: apart(y(&nodal), y(&force)),
        moment_rel: apart(
            y(&nodal).zip(&nodes).map(|(f, place)| f * place[0]),
            y(&force).zip(&points).map(|(f, place)| f * place[0]),
        ),
        power_rel: apart(
            nodal.iter().zip(&motion).map(|(f, v)| f * v),
            force.iter().zip(&moved).map(|(f, v)| f * v),
        ),
        ripple: pressed_inside.variance().sqrt() / pressed_inside.mean(),
        empty_nodes: pressed_inside.iter().filter(|p| **p == 0.0).count(),
        application_ns: time(&mapping, &force, &motion),
    })
}

/// Positions of points with uneven gaps, from end to end (m).
fn uneven(count: usize) -> Vec<f64> {
    let part = |i: usize| (i as f64 + 0.3 + 0.4 * ((i * 7 % 5) as f64 / 5.0)) / count as f64;
    (0..count).map(|i| LENGTH_M * (part(i) - 0.5)).collect()
}

/// Length that a point stands for: halfway to its neighbours.
fn segment(places: &[f64], i: usize) -> f64 {
    let left = i.checked_sub(1).map(|i| places[i]);
    let right = places.get(i + 1).copied();
    let ends = [-LENGTH_M - places[0], LENGTH_M - places[i]];
    0.5 * (right.unwrap_or(ends[1]) - left.unwrap_or(ends[0]))
}

fn components(count: usize, value: impl Fn(usize) -> f64) -> Vec<f64> {
    let pairs = (0..count).map(|i| [-2.0 * value(i), value(i)]);
    pairs.flatten().collect()
}

fn y(vector: &[f64]) -> impl Iterator<Item = f64> + '_ {
    vector.iter().skip(1).step_by(2).copied()
}

/// |sum a - sum b| / sum |b|.
fn apart(a: impl Iterator<Item = f64>, b: impl Iterator<Item = f64>) -> f64 {
    let b: Vec<f64> = b.collect();
    let size: f64 = b.iter().map(|value| value.abs()).sum();
    (a.sum::<f64>() - b.iter().sum::<f64>()).abs() / size
}

/// Nodes a tenth of the line away from its ends.
fn inside(nodes: &[[f64; 2]], places: &[f64]) -> std::ops::Range<usize> {
    let margin = 0.1 * LENGTH_M;
    let (low, high) = (places[0] + margin, places[places.len() - 1] - margin);
    let below = |limit: f64| nodes.iter().filter(|node| node[0] < limit).count();
    below(low)..below(high)
}

fn time(mapping: &Mapping, force: &[f64], motion: &[f64]) -> f64 {
    let start = Instant::now();
    let mut rounds = 0;
    while start.elapsed().as_secs_f64() < LONG_ENOUGH_S {
        black_box(mapping.motion(black_box(motion)));
        black_box(mapping.force(black_box(force)));
        rounds += 1;
    }
    1e9 * start.elapsed().as_secs_f64() / f64::from(rounds)
}
