//! The face of the wheel and its gaps above the upper edge.

use kit::rolling::nearest_image;

use super::problem::StaticProblem;
use crate::mesh::Edge;

/// A rigid face, flat and horizontal or round, that just touches the undeformed edge at its lowest point. For small
/// displacements the normals stay as they are in this position:
///
/// ```text
/// g_i = g0_i + n_i . (d - u_i),   d = (lateral, -approach)
/// ```
///
/// A wheel that rolls takes its face along, so that d is (0, -approach). Normals and gaps follow its centre and the displaced nodes, increment by
/// increment: the nodes are displaced sideways as far as the wheel sinks in, and old normals would hold it back by that over R of its load. With
/// theta the angle of a node from the lowest point, the face moves past the node by R (theta_before - theta_after) - R dphi, phi the angle by which
/// the wheel has turned.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Face {
    /// Unit normals from the nodes into the wheel.
    pub(super) normals: Vec<[f64; 2]>,
    /// Gaps in the undeformed state (m).
    pub(super) gaps: Vec<f64>,
    round: Option<Round>,
}

/// The circle of a round face.
#[derive(Clone, Debug, PartialEq)]
struct Round {
    radius: f64,
    /// Centre before any approach (m).
    centre: [f64; 2],
    /// Distance over which the body repeats (m).
    period: Option<f64>,
    /// Undeformed nodes (m).
    points: Vec<[f64; 2]>,
    /// Way past each node of a face that does not turn, in the last increment without its displacements (m).
    passed: Vec<f64>,
}

impl Face {
    /// A face of this radius (m) above the body; 0 = flat. The centre of a round face is above `start`, as low as possible without a node inside
    /// the circle.
    pub(super) fn new(radius: f64, start: f64, problem: &StaticProblem) -> Face {
        let points = problem.mesh.surface_points(Edge::Top);
        if radius == 0.0 {
            return Face::flat(&points);
        }
        let period = problem.mesh.period();
        let apart = |p: &[f64; 2]| nearest_image(p[0] - start, period);
        let above = |p: &[f64; 2]| (radius * radius - apart(p) * apart(p)).sqrt();
        let below = points.iter().filter(|p| apart(p).abs() < radius);
        let height = below.map(|p| p[1] + above(p));
        let round = Round {
            radius,
            centre: [start, height.fold(f64::NEG_INFINITY, f64::max)],
            period,
            passed: vec![0.0; points.len()],
            points,
        };
        let still = vec![[0.0; 2]; round.points.len()];
        let (normals, gaps) = round.above(&still, 0.0);
        Face {
            normals,
            gaps,
            round: Some(round),
        }
    }

    /// Abscissa of the centre (m).
    pub(super) fn centre(&self) -> f64 {
        self.round.as_ref().map_or(0.0, |round| round.centre[0])
    }

    /// The face with its centre above another abscissa (m), after displacements `u` of the nodes and an approach (m) at the present one.
    pub(super) fn rolled_to(&self, x: f64, u: &[[f64; 2]], approach: f64) -> Face {
        let Some(mut round) = self.round.clone() else {
            return self.clone();
        };
        let before = round.arcs(u, approach);
        round.centre[0] = x;
        let after = round.arcs(u, approach);
        let (normals, gaps) = round.above(u, approach);
        let both = before.iter().zip(&after);
        round.passed = both.map(|(before, after)| before - after).collect();
        Face {
            normals,
            gaps,
            round: Some(round),
        }
    }

    /// Way past a node of a face that rolls without turning, in the last increment and without the displacements in it (m).
    pub(super) fn passed(&self, node: usize) -> f64 {
        self.round.as_ref().map_or(0.0, |round| round.passed[node])
    }

    fn flat(points: &[[f64; 2]]) -> Face {
        let heights = points.iter().map(|p| p[1]);
        let height = heights.fold(f64::NEG_INFINITY, f64::max);
        Face {
            normals: vec![[0.0, 1.0]; points.len()],
            gaps: points.iter().map(|p| height - p[1]).collect(),
            round: None,
        }
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

impl Round {
    /// From each displaced node to the centre after an approach (m).
    fn away(&self, u: &[[f64; 2]], approach: f64) -> impl Iterator<Item = [f64; 2]> {
        let nodes = self.points.iter().zip(u);
        nodes.map(move |(point, u)| {
            let aside = nearest_image(point[0] + u[0] - self.centre[0], self.period);
            [-aside, self.centre[1] - approach - (point[1] + u[1])]
        })
    }

    /// Normals at the displaced nodes, and the gaps without the displacements that these normals would give. Nodes beside the wheel have a gap to
    /// it, but can never close it by moving up.
    fn above(&self, u: &[[f64; 2]], approach: f64) -> (Vec<[f64; 2]>, Vec<f64>) {
        let from = |(away, u): ([f64; 2], &[f64; 2])| {
            let distance = away[0].hypot(away[1]);
            let n = away.map(|a| a / distance);
            let moved = n[0] * u[0] + n[1] * (u[1] + approach);
            (n, distance - self.radius + moved)
        };
        self.away(u, approach).zip(u).map(from).unzip()
    }

    /// R theta of each displaced node (m).
    fn arcs(&self, u: &[[f64; 2]], approach: f64) -> Vec<f64> {
        let arc = |[x, y]: [f64; 2]| self.radius * (-x).atan2(y);
        self.away(u, approach).map(arc).collect()
    }
}
