//! Glued points as weighted means of surface nodes: N maps motion, its transpose maps force.

mod error;
mod line;
#[cfg(test)]
mod tests;

use std::ops::Range;

use nalgebra::DMatrix;

use crate::keys::MappingKind;
pub use error::MappingError;
use line::Line;

/// N (points x nodes), row by row; every row sums to one.
#[derive(Clone, Debug, PartialEq)]
pub struct Mapping {
    rows: Vec<Vec<(usize, f64)>>,
    nodes: usize,
}

impl Mapping {
    /// Makes each row from its point's position and segment on the line through `nodes` (m); a single node carries all
    /// points.
    ///
    /// Mortar weights have an affine correction: row i is the mean of the nodes' shape functions over the segment of
    /// point i (halfway to its neighbours, cut at the ends of the line), plus (s_i - centre of the segment) times their
    /// mean slope there. Constant and linear fields are exact, so that N^T conserves force and moment; the mean keeps a
    /// uniform pressure nearly uniform.
    ///
    /// Positions along the line are measured on its chord, so that linear fields stay linear on a curved line too. A
    /// line with the period `period_m` along x has images of its nodes and points on both sides, and no ends. Each node
    /// is then listed once, within one period; points may lie in any period. Positions are measured along x. Constant
    /// fields are exact, so that N^T conserves force. Linear fields do not repeat: they are exact only away from the
    /// seam, and the moment of forces that cross the seam has no meaning.
    pub fn new(
        kind: MappingKind,
        nodes: &[[f64; 2]],
        points: &[[f64; 2]],
        period_m: Option<f64>,
    ) -> Result<Mapping, MappingError> {
        if nodes.is_empty() || points.is_empty() {
            return Err(MappingError::Empty);
        }
        if nodes.len() == 1 {
            let rows = points.iter().map(|_| vec![(0, 1.0)]).collect();
            return Ok(Mapping { rows, nodes: 1 });
        }
        let line = match period_m {
            None => Line::through(nodes)?,
            Some(period_m) => Line::repeating(nodes, period_m)?,
        };
        let positions: Vec<f64> = points.iter().map(|point| line.position(*point)).collect();
        line.check(points, &positions)?;
        let mut rows = vec![Vec::new(); points.len()];
        for (point, low, high) in line.segments(points, &positions)? {
            let s = positions[point];
            rows[point] = match kind {
                MappingKind::Mortar => line.row(s, [low, high]),
                MappingKind::Linear => line.interpolation(s),
                MappingKind::Nearest => line.nearest(s),
            };
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
        let row = |row: &Vec<(usize, f64)>| {
            let carries = row.iter().filter(|(_, weight)| *weight != 0.0);
            let moved = carries.map(|(node, weight)| (position[*node], *weight));
            moved.collect()
        };
        Mapping {
            rows: self.rows.iter().map(row).collect(),
            nodes: active.len(),
        }
    }

    /// A mapping with this many nodes and points, without any weight yet.
    pub fn empty(nodes: usize, points: usize) -> Mapping {
        Mapping {
            rows: vec![Vec::new(); points],
            nodes,
        }
    }

    /// Inserts another mapping at the point `first_point` and the node `first_node`.
    pub fn put(&mut self, first_point: usize, first_node: usize, other: &Mapping) {
        for (row, theirs) in self.rows[first_point..].iter_mut().zip(&other.rows) {
            let moved = |(node, weight): &(usize, f64)| (first_node + node, *weight);
            *row = theirs.iter().map(moved).collect();
        }
    }

    /// The part between these points and these nodes; all other nodes count as fixed.
    pub fn block(&self, points: &Range<usize>, nodes: &Range<usize>) -> Mapping {
        let rows = self.rows[points.clone()].iter();
        let inside = |row: &Vec<(usize, f64)>| {
            let inside = row.iter().filter(|(node, _)| nodes.contains(node));
            let moved = inside.map(|(node, weight)| (node - nodes.start, *weight));
            moved.collect()
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
            for k in 0..2 {
                let part = |(node, weight): &(usize, f64)| weight * nodal[2 * node + k];
                result.push(row.iter().map(part).sum());
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

    /// N applied to one number a node.
    pub fn means(&self, nodal: &[f64]) -> Vec<f64> {
        let mean = |row: &Vec<(usize, f64)>| {
            let parts = row.iter().map(|(node, weight)| weight * nodal[*node]);
            parts.sum()
        };
        self.rows.iter().map(mean).collect()
    }

    /// Heat of the nodes (J) for the heat of the points (J) and their heat per kelvin h (J/K), while the nodes had these temperatures (K):
    /// Q_i = N_ni (Q_n + h_n (T_n - T_i)), which is N_ni times what a node of temperature T_i takes in the place of the mean T_n. The sum of the heat
    /// stays, except for rounding.
    pub fn spread(&self, heat: &[f64], per_kelvin: &[f64], nodal: &[f64]) -> Vec<f64> {
        let mut result = vec![0.0; self.nodes];
        let means = self.means(nodal);
        for (((row, heat), h), mean) in self.rows.iter().zip(heat).zip(per_kelvin).zip(means) {
            for (node, weight) in row {
                result[*node] += weight * (heat + h * (mean - nodal[*node]));
            }
        }
        result
    }

    /// N C N^T for a nodal matrix C (2 nodes x 2 nodes): the compliance that the points feel.
    pub fn condense(&self, nodal: &DMatrix<f64>) -> DMatrix<f64> {
        self.motions(&self.motions(nodal))
    }

    /// The motions of the points for each column of nodal motions, row by row.
    fn motions(&self, nodal: &DMatrix<f64>) -> DMatrix<f64> {
        let mut result = DMatrix::zeros(nodal.ncols(), 2 * self.rows.len());
        for (column, motion) in nodal.column_iter().enumerate() {
            let moved = self.motion(motion.as_slice());
            result.row_mut(column).copy_from_slice(&moved);
        }
        result
    }
}
