//! A mesh of quadrilaterals at rest: its outline, and the lines of nodes along its upper and lower side.

use std::collections::BTreeMap;

use runs::fields::{Arrays, numbers, points};

/// Type number of a quadrilateral in VTK.
const VTK_QUAD: f64 = 9.0;

/// Nodes at rest (m) and elements.
#[derive(Clone, Debug, Default)]
pub struct QuadMesh {
    /// Positions of the nodes.
    pub nodes: Vec<[f64; 2]>,
    /// Corners of the elements.
    pub quads: Vec<[u32; 4]>,
}

/// A side of a mesh that grains lie along.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshSide {
    /// The upper side.
    Top,
    /// The lower side.
    Bottom,
}

impl QuadMesh {
    /// The mesh of a file; `None` if it does not consist of quadrilaterals.
    pub fn of(arrays: &Arrays) -> Option<QuadMesh> {
        let nodes = points(arrays);
        let types = numbers(arrays, "types");
        let corners = numbers(arrays, "connectivity");
        let inside = |node: &f64| (0.0..nodes.len() as f64).contains(node);
        let sound = types.iter().all(|kind| *kind == VTK_QUAD)
            && corners.len() == 4 * types.len()
            && corners.iter().all(inside);
        let quad = |four: &[f64]| [0, 1, 2, 3].map(|k| four[k] as u32);
        let quads: Vec<[u32; 4]> = corners.chunks_exact(4).map(quad).collect();
        (sound && !quads.is_empty()).then_some(QuadMesh { nodes, quads })
    }

    /// Centres of the elements (m).
    pub fn centres(&self) -> Vec<[f64; 2]> {
        let centre = |quad: &[u32; 4]| {
            let corners = quad.map(|node| self.nodes[node as usize]);
            [0, 1].map(|k| 0.25 * corners.iter().map(|corner| corner[k]).sum::<f64>())
        };
        self.quads.iter().map(centre).collect()
    }

    /// The edges that belong to one element only.
    pub fn outline(&self) -> Vec<[u32; 2]> {
        let edges = self.outer_edges().into_iter();
        edges.map(|edge| edge.ends).collect()
    }

    /// The nodes along a side from left to right: the ends of outer edges that face up or down more than sideways.
    pub fn side(&self, side: MeshSide) -> Vec<u32> {
        let faces = |edge: &OuterEdge| {
            let [x, y] = edge.outward;
            let up = if side == MeshSide::Top { y } else { -y };
            up > x.abs()
        };
        let edges = self.outer_edges().into_iter().filter(faces);
        let mut nodes: Vec<u32> = edges.flat_map(|edge| edge.ends).collect();
        let x = |node: &u32| self.nodes[*node as usize][0];
        nodes.sort_by(|a, b| x(a).total_cmp(&x(b)).then(a.cmp(b)));
        nodes.dedup();
        nodes
    }

    fn outer_edges(&self) -> Vec<OuterEdge> {
        let mut found: BTreeMap<[u32; 2], (usize, OuterEdge)> = BTreeMap::new();
        for (quad, centre) in self.quads.iter().zip(self.centres()) {
            for k in 0..4 {
                let ends = [quad[k], quad[(k + 1) % 4]];
                let key = [ends[0].min(ends[1]), ends[0].max(ends[1])];
                let outward = self.outward(ends, centre);
                let edge = OuterEdge { ends, outward };
                found.entry(key).or_insert((0, edge)).0 += 1;
            }
        }
        let outer = found.into_values().filter(|(count, _)| *count == 1);
        outer.map(|(_, edge)| edge).collect()
    }

    /// Normal of an edge with the edge's length, away from the centre of its element.
    fn outward(&self, ends: [u32; 2], centre: [f64; 2]) -> [f64; 2] {
        let [a, b] = ends.map(|node| self.nodes[node as usize]);
        let normal = [b[1] - a[1], a[0] - b[0]];
        let away = [0, 1].map(|k| 0.5 * (a[k] + b[k]) - centre[k]);
        let sign = (normal[0] * away[0] + normal[1] * away[1]).signum();
        normal.map(|part| sign * part)
    }
}

#[derive(Clone, Copy, Debug)]
struct OuterEdge {
    ends: [u32; 2],
    outward: [f64; 2],
}

/// The height of a line of nodes at a position, linear between nodes and constant beyond the ends; `None` without nodes.
pub fn height(line: &[[f64; 2]], x: f64) -> Option<f64> {
    let next = line.partition_point(|node| node[0] < x);
    let (before, after) = line.split_at(next);
    match (before.last(), after.first()) {
        (Some(left), Some(right)) => {
            let share = (x - left[0]) / (right[0] - left[0]);
            Some(left[1] + share * (right[1] - left[1]))
        }
        (left, right) => left.or(right).map(|end| end[1]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two unit squares side by side.
    fn mesh() -> QuadMesh {
        QuadMesh {
            nodes: [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1]]
                .map(|p| p.map(f64::from))
                .into(),
            quads: vec![[0, 1, 4, 3], [1, 2, 5, 4]],
        }
    }

    #[test]
    fn outline_and_sides_leave_out_shared_edges() {
        let mesh = mesh();
        assert_eq!(mesh.outline().len(), 6);
        assert!(!mesh.outline().contains(&[1, 4]) && !mesh.outline().contains(&[4, 1]));
        assert_eq!(mesh.side(MeshSide::Top), [3, 4, 5]);
        assert_eq!(mesh.side(MeshSide::Bottom), [0, 1, 2]);
        assert_eq!(mesh.centres()[1], [1.5, 0.5]);
    }

    #[test]
    fn heights_are_linear_between_nodes() {
        let line = [[0.0, 1.0], [2.0, 3.0]];
        let heights = [-1.0, 0.0, 0.5, 2.0, 9.0].map(|x| height(&line, x));
        assert_eq!(heights, [1.0, 1.0, 1.5, 3.0, 3.0].map(Some));
        assert_eq!(height(&[], 0.0), None);
    }

    #[test]
    fn other_meshes_are_not_read_as_quadrilaterals() {
        let arrays = |kind: f64, node: f64| {
            let points = vec![0.0; 12];
            let list = [("points", points), ("types", vec![kind])];
            let corners = ("connectivity", vec![0.0, 1.0, 2.0, node]);
            let all = list.into_iter().chain([corners]);
            Arrays::from_iter(all.map(|(name, values)| (name.to_string(), values)))
        };
        assert!(QuadMesh::of(&arrays(9.0, 3.0)).is_some());
        assert!(QuadMesh::of(&arrays(5.0, 3.0)).is_none());
        assert!(QuadMesh::of(&arrays(9.0, 4.0)).is_none());
    }
}
