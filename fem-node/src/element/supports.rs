//! Supports of a body: its lower edge and its sides.

use crate::config::choice::{Base, Sides};
use crate::mesh::{Edge, Mesh};

use super::layout::Layout;

/// Supports of the edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Supports {
    /// Lower edge.
    pub base: Base,
    /// Lateral edges.
    pub sides: Sides,
}

/// Components that a body's supports hold at zero.
pub(super) fn fixed_components(mesh: &Mesh, supports: Supports, layout: Layout) -> Vec<usize> {
    let bottom = mesh.edge(Edge::Bottom);
    let mut fixed: Vec<usize> = bottom.iter().map(|node| layout.index(*node, 1)).collect();
    match (supports.base, supports.sides) {
        (Base::Free, _) => fixed.clear(),
        (Base::Clamped, _) => fixed.extend(bottom.iter().map(|node| layout.index(*node, 0))),
        (Base::Roller, Sides::Free) => {
            let middle = bottom.get(bottom.len() / 2);
            fixed.extend(middle.map(|node| layout.index(*node, 0)));
        }
        (Base::Roller, Sides::FixedX) => {}
    }
    if supports.sides == Sides::FixedX {
        for edge in [Edge::Left, Edge::Right] {
            fixed.extend(mesh.edge(edge).iter().map(|node| layout.index(*node, 0)));
        }
    }
    fixed
}
