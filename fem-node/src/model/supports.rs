//! Supports of a body: its lower edge and its sides.

use fem_kernel::element::layout::Layout;
use fem_kernel::mesh::{Edge, Mesh};

use crate::config::choice::{Base, Sides};

/// Components that the supports of these edges hold at zero.
pub(super) fn fixed_components(
    mesh: &Mesh,
    layout: Layout,
    (base, sides): (Base, Sides),
) -> Vec<usize> {
    let bottom = mesh.edge(Edge::Bottom);
    let mut fixed: Vec<usize> = bottom.iter().map(|node| layout.index(*node, 1)).collect();
    match (base, sides) {
        (Base::Free, _) => fixed.clear(),
        (Base::Clamped, _) => fixed.extend(bottom.iter().map(|node| layout.index(*node, 0))),
        (Base::Roller, Sides::Free) => {
            let middle = bottom.get(bottom.len() / 2);
            fixed.extend(middle.map(|node| layout.index(*node, 0)));
        }
        (Base::Roller, Sides::FixedX) => {}
    }
    if sides == Sides::FixedX {
        for edge in [Edge::Left, Edge::Right] {
            fixed.extend(mesh.edge(edge).iter().map(|node| layout.index(*node, 0)));
        }
    }
    fixed
}
