//! Compliance of the upper edge.

use serde::{Deserialize, Serialize};

use super::factor::Factor;
use super::problem::StaticProblem;
use crate::mesh::Edge;

/// Displacements of the upper edge under forces on its nodes and under the tractions.
pub(crate) struct EdgeCompliance {
    /// Displacements (x0, y0, x1, ...) under the full tractions (m).
    full: Vec<f64>,
    /// True for each node whose components can both move. A node that cannot move sideways does not stick.
    pub(super) free: Vec<bool>,
    pub(super) known: KnownColumns,
}

/// The part of an [`EdgeCompliance`] that increments change. Columns are kept as they are: solved together with other columns their last bits would
/// differ.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct KnownColumns {
    /// Share of the tractions that acts.
    pub(super) share: f64,
    /// For each node that has been needed, the displacements of all nodes under a unit force in x and in y (m/N).
    columns: Vec<Option<[Vec<f64>; 2]>>,
    /// Compliance of the node that was needed first (m/N), the scale for all nodes.
    pub(super) scale: f64,
}

impl EdgeCompliance {
    /// Restores computed columns; false if they belong to another edge.
    pub(super) fn take_up(&mut self, known: KnownColumns) -> bool {
        let length = self.full.len();
        let mut columns = known.columns.iter().flatten().flatten();
        let fits = known.columns.len() == self.known.columns.len()
            && columns.all(|column| column.len() == length);
        if fits {
            self.known = known;
        }
        fits
    }

    pub(super) fn new(problem: &StaticProblem, factor: &Factor) -> EdgeCompliance {
        let components = components(problem);
        let full = factor.solve(&problem.tractions);
        let nodes = components.chunks_exact(2);
        let free = nodes.map(|c| factor.moves(c[0]) && factor.moves(c[1]));
        EdgeCompliance {
            full: components.iter().map(|c| full[*c]).collect(),
            free: free.collect(),
            known: KnownColumns {
                share: 0.0,
                columns: vec![None; components.len() / 2],
                scale: 0.0,
            },
        }
    }

    /// The current tractions as a field of nodal forces (N).
    pub(super) fn applied(&self, problem: &StaticProblem) -> Vec<f64> {
        let mut load = problem.tractions.clone();
        load.iter_mut().for_each(|f| *f *= self.known.share);
        load
    }

    /// True where the columns of the node are known.
    pub(super) fn knows(&self, node: usize) -> bool {
        self.known.columns[node].is_some()
    }

    /// Computes the columns of these nodes.
    pub(super) fn extend(&mut self, problem: &StaticProblem, factor: &Factor, nodes: &[usize]) {
        let components = components(problem);
        let sources: Vec<usize> = nodes
            .iter()
            .flat_map(|node| [components[2 * node], components[2 * node + 1]])
            .collect();
        let mut columns = factor.columns(&sources, &components).into_iter();
        for node in nodes {
            self.known.columns[*node] = columns.next().zip(columns.next()).map(|(x, y)| [x, y]);
            if self.known.scale == 0.0 {
                self.known.scale = self.moved(*node, *node, [0.0, 1.0])[1];
            }
        }
    }

    /// Displacement of `node` under a force on the node `source`, whose columns are known (m).
    pub(super) fn moved(&self, node: usize, source: usize, force: [f64; 2]) -> [f64; 2] {
        let [x, y] = self.columns_of(source);
        [0, 1].map(|k| x[2 * node + k] * force[0] + y[2 * node + k] * force[1])
    }

    /// Adds the displacements of all nodes under a force on the node `source`, whose columns are known (m).
    pub(super) fn add_moved(&self, source: usize, force: [f64; 2], u: &mut [[f64; 2]]) {
        let [x, y] = self.columns_of(source);
        let columns = x.iter().zip(y);
        for (u, (x, y)) in u.as_flattened_mut().iter_mut().zip(columns) {
            *u += x * force[0] + y * force[1];
        }
    }

    fn columns_of(&self, source: usize) -> &[Vec<f64>; 2] {
        let columns = self.known.columns[source].as_ref();
        columns.expect("columns come before forces")
    }

    /// Displacement of a node under the tractions alone (m).
    pub(super) fn under_tractions(&self, node: usize) -> [f64; 2] {
        [0, 1].map(|k| self.known.share * self.full[2 * node + k])
    }
}

/// Indices of (x0, y0, x1, y1, ...) of the upper edge in a field.
fn components(problem: &StaticProblem) -> Vec<usize> {
    let layout = problem.body.layout;
    let (nodes, _) = problem.mesh.surface(Edge::Top);
    let components = nodes.into_iter().flat_map(|node| layout.components(node));
    components.collect()
}
