//! Parts of a mesh that touch or overlap without being joined: they would move apart or count twice without notice.

use std::collections::HashMap;

use kit::ConfigError;

use super::error::refused;
use super::file::{File, FileElement};

/// Distance as a share of the size of elements below which two nodes, or a node and a side, lie in one place. Gmsh's own Geometry.Tolerance leaves
/// 1e-8 of the body; no intended element is as flat.
const IN_ONE_PLACE: f64 = 1e-3;

/// Refuses nodes of the outline that lie on or in an element without being its corner, and sides of the outline that cross an element. Where elements
/// overlap or a seam is open, one of both happens. A grid of cells of 1.5 times the longest side holds the parts of the outline by their middles; a
/// part that meets an element is at most one cell away from its centre.
pub(super) fn check_joints(
    file: &File,
    quads: &[FileElement<4>],
    sides: &HashMap<[u32; 2], u64>,
) -> Result<(), ConfigError> {
    let length = |[a, b]: [u32; 2]| distance(file.point(a), file.point(b));
    let all = || quads.iter().flat_map(FileElement::sides);
    let longest = all().map(length).fold(0.0, f64::max);
    let cell = |nodes: &[u32]| {
        let sum = |k: usize| nodes.iter().map(|node| file.point(*node)[k]).sum::<f64>();
        [0, 1].map(|k| (sum(k) / (1.5 * longest * nodes.len() as f64)).floor() as i64)
    };
    let mut outline: HashMap<[i64; 2], Vec<[u32; 2]>> = HashMap::new();
    let mut shortest = vec![longest; file.nodes.len()];
    for side in all() {
        for node in side {
            let least = &mut shortest[node as usize];
            *least = least.min(length(side));
        }
        let [a, b] = side;
        if !sides.contains_key(&[b, a]) {
            for part in [[a, a], [a, b]] {
                outline.entry(cell(&part)).or_default().push(part);
            }
        }
    }
    let near = |nodes: &[u32]| {
        let sizes = nodes.iter().map(|node| shortest[*node as usize]);
        IN_ONE_PLACE * sizes.fold(longest, f64::min)
    };
    for quad in quads {
        let points = quad.corners.map(|node| file.point(node));
        let most = near(&quad.corners);
        let [i, j] = cell(&quad.corners);
        let around = (0..9).filter_map(|k| outline.get(&[i + k % 3 - 1, j + k / 3 - 1]));
        for part in around.flatten() {
            let ends = part.map(|node| file.point(node));
            let own = part.iter().any(|node| quad.corners.contains(node));
            if own || !meets(&points, ends, most) {
                continue;
            }
            let near = most.min(near(part));
            let slack = if part[0] == part[1] { near } else { -near };
            if meets(&points, ends, slack) {
                return Err(not_joined(file, quad, *part, near));
            }
        }
    }
    Ok(())
}

fn distance([ax, ay]: [f64; 2], [bx, by]: [f64; 2]) -> f64 {
    (ax - bx).hypot(ay - by)
}

/// True where a segment enters a convex quadrilateral that is larger by `slack` on each side.
fn meets(points: &[[f64; 2]; 4], ends: [[f64; 2]; 2], slack: f64) -> bool {
    let [mut from, mut to] = [0.0, 1.0_f64];
    for (p, q) in (0..4).map(|k| (points[k], points[(k + 1) % 4])) {
        let inwards = |[x, y]: [f64; 2]| (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]);
        let [a, b] = ends.map(|end| inwards(end) / distance(p, q) + slack);
        if a < 0.0 && b < 0.0 {
            return false;
        }
        let crossing = a / (a - b);
        if a < 0.0 {
            from = crossing.max(from);
        } else if b < 0.0 {
            to = crossing.min(to);
        }
    }
    from <= to
}

/// Names the node or side on this element.
fn not_joined(file: &File, quad: &FileElement<4>, [a, b]: [u32; 2], near: f64) -> ConfigError {
    let ([x, y], element) = (file.point(a), quad.number);
    let [node, end] = [a, b].map(|node| file.number(node));
    let close = |corner: &&u32| distance(file.point(**corner), [x, y]) <= 2.0 * near;
    let what = match quad.corners.iter().find(close) {
        _ if a != b => format!(
            "elements overlap: the side of nodes {node} and {end} crosses element {element}"
        ),
        Some(other) => format!("nodes {node} and {} lie in one place", file.number(*other)),
        None => format!("node {node} lies on or in element {element} without being its corner"),
    };
    refused(
        format!("{what}, at ({x:?}, {y:?}) in the file's unit"),
        "join the parts there (`Coherence;` before meshing, `Coherence Mesh;`, the same number of nodes on both sides of a seam), and mesh each part once: nodes in one place would leave a crack, and an overlap counts twice. An intended crack needs faces farther apart than a thousandth of its elements",
    )
}
