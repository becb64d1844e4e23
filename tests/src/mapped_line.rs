//! A line of surface nodes, flat or with a crown, and glued points at uneven places along it.

use scheme::keys::MappingKind;
use scheme::mapping::{Mapping, MappingError};

/// Length of the line (m).
pub const LENGTH_M: f64 = 0.02;
/// Radius of the crown (m).
const CROWN_M: f64 = 0.3;

/// The line, its points and the mapping between them.
pub struct MappedLine {
    /// Nodes.
    pub nodes: Vec<[f64; 2]>,
    /// Positions of the points along the line (m).
    pub places: Vec<f64>,
    /// Points.
    pub points: Vec<[f64; 2]>,
    /// The mapping.
    pub mapping: Mapping,
}

impl MappedLine {
    /// `count` nodes and two thirds as many points; `shape` is `flat`, or `curved` like a crown.
    pub fn new(kind: MappingKind, shape: &str, count: usize) -> Result<MappedLine, MappingError> {
        let height = |x: f64| match shape {
            "flat" => 0.0,
            _ => (CROWN_M * CROWN_M - x * x).sqrt() - CROWN_M,
        };
        let nodes = (0..count).map(|i| LENGTH_M * (i as f64 / (count - 1) as f64 - 0.5));
        let nodes: Vec<[f64; 2]> = nodes.map(|x| [x, height(x)]).collect();
        let places = uneven(2 * count / 3);
        let points: Vec<[f64; 2]> = places.iter().map(|x| [*x, height(*x)]).collect();
        Ok(MappedLine {
            mapping: Mapping::new(kind, &nodes, &points, None)?,
            nodes,
            places,
            points,
        })
    }

    /// A force on each point.
    pub fn force(&self) -> Vec<f64> {
        components(self.points.len(), |i| 1.0 + (0.7 * i as f64).sin())
    }

    /// A motion of each node.
    pub fn motion(&self) -> Vec<f64> {
        components(self.nodes.len(), |i| (0.3 * i as f64).cos())
    }
}

/// Positions of points with uneven gaps, from end to end (m).
fn uneven(count: usize) -> Vec<f64> {
    let part = |i: usize| (i as f64 + 0.3 + 0.4 * ((i * 7 % 5) as f64 / 5.0)) / count as f64;
    (0..count).map(|i| LENGTH_M * (part(i) - 0.5)).collect()
}

/// Pairs of components, of which x is -2 y.
pub fn components(count: usize, value: impl Fn(usize) -> f64) -> Vec<f64> {
    let pairs = (0..count).map(|i| [-2.0 * value(i), value(i)]);
    pairs.flatten().collect()
}
