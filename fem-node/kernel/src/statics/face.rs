//! The face of the wheel and its gaps above the upper edge.

use super::problem::StaticProblem;
use crate::mesh::Edge;

/// A rigid face, flat and horizontal or round, that just touches the undeformed edge at its lowest point. For small
/// displacements the normals stay as they are in this position:
///
/// ```text
/// g_i = g0_i + n_i . (d - u_i),   d = (lateral, -approach)
/// ```
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Face {
    /// Unit normals from the nodes into the wheel.
    pub(super) normals: Vec<[f64; 2]>,
    /// Gaps in the undeformed state (m).
    pub(super) gaps: Vec<f64>,
}

impl Face {
    /// A face of this radius (m) above the body; 0 = flat.
    pub(super) fn new(radius: f64, problem: &StaticProblem) -> Face {
        let points = problem.mesh.surface_points(Edge::Top);
        if radius > 0.0 {
            Face::round(radius, &points)
        } else {
            Face::flat(&points)
        }
    }

    fn flat(points: &[[f64; 2]]) -> Face {
        let height = points
            .iter()
            .map(|p| p[1])
            .fold(f64::NEG_INFINITY, f64::max);
        Face {
            normals: vec![[0.0, 1.0]; points.len()],
            gaps: points.iter().map(|p| height - p[1]).collect(),
        }
    }

    /// The centre is above x = 0, as low as possible without a node inside the circle. Nodes beside the wheel have a gap to it, but can never close
    /// it by moving up.
    fn round(radius: f64, points: &[[f64; 2]]) -> Face {
        let above = |p: &[f64; 2]| (radius * radius - p[0] * p[0]).sqrt();
        let below = points.iter().filter(|p| p[0].abs() < radius);
        let centre = below
            .map(|p| p[1] + above(p))
            .fold(f64::NEG_INFINITY, f64::max);
        let from = |p: &[f64; 2]| {
            let away = [-p[0], centre - p[1]];
            let distance = away[0].hypot(away[1]);
            (away.map(|a| a / distance), distance - radius)
        };
        let (normals, gaps) = points.iter().map(from).unzip();
        Face { normals, gaps }
    }

    /// The tangent (n_y, -n_x).
    pub(super) fn tangent(&self, node: usize) -> [f64; 2] {
        let [nx, ny] = self.normals[node];
        [ny, -nx]
    }

    /// The force -r_n n + r_t t on a node (N).
    pub(super) fn force(&self, node: usize, normal: f64, tangential: f64) -> [f64; 2] {
        let (n, t) = (self.normals[node], self.tangent(node));
        [0, 1].map(|k| tangential * t[k] - normal * n[k])
    }

    /// Gap of a node (m).
    pub(super) fn gap(&self, node: usize, wheel: [f64; 2], u: [f64; 2]) -> f64 {
        let [nx, ny] = self.normals[node];
        self.gaps[node] + nx * (wheel[0] - u[0]) + ny * (wheel[1] - u[1])
    }
}
