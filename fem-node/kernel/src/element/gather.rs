//! Elements of an unstructured mesh: they gather the displacements of their corners from one row of nodes, and every node
//! sums the forces of the elements around it in its own order, on any thread.

use super::corners::CornerRows;
use super::layout::Layout;
use super::row_forces::RowForces;
use crate::mesh::connectivity::Connectivity;

/// Numbers per element: x and y of the force on each corner.
pub(crate) const CORNER_FORCES: usize = 8;

/// Buffers for one row of elements.
#[derive(Clone, Debug)]
pub(crate) struct GatherBuffers {
    /// Displacements of the four corners.
    pub(super) u: [Vec<f64>; 4],
    /// Their increments; empty under a law without history.
    pub(super) du: [Vec<f64>; 4],
    pub(super) forces: RowForces,
}

impl GatherBuffers {
    /// Buffers for displacements and forces, and for increments under a law with history.
    pub(crate) fn new(layout: Layout, history: bool) -> GatherBuffers {
        let zero = || [0; 4].map(|_| vec![0.0; 2 * layout.element_stride()]);
        GatherBuffers {
            u: zero(),
            du: if history { zero() } else { Default::default() },
            forces: RowForces::new(layout),
        }
    }
}

/// A nodal field and its increments in the last step, the latter empty under a law without history.
#[derive(Clone, Copy)]
pub(crate) struct NodalFields<'a> {
    pub(crate) u: &'a [f64],
    pub(crate) du: &'a [f64],
}

/// Copies a field to the corners of a row of elements. Beyond the last element of a row older numbers remain: their forces are not used, and their
/// volume in the energies is zero.
pub(super) fn gather(
    elements: &[[u32; 4]],
    layout: Layout,
    field: &[f64],
    into: &mut [Vec<f64>; 4],
) {
    let (x, y) = field.split_at(layout.stride);
    let stride = layout.element_stride();
    for (corner, into) in into.iter_mut().enumerate() {
        let (into_x, into_y) = into.split_at_mut(stride);
        for ((element, into_x), into_y) in elements.iter().zip(into_x).zip(into_y) {
            let node = element[corner] as usize;
            (*into_x, *into_y) = (x[node], y[node]);
        }
    }
}

/// The corners of a row, each in a slice of its own.
pub(super) fn corner_rows(corners: &[Vec<f64>; 4]) -> CornerRows<'_> {
    CornerRows([0, 1, 2, 3].map(|corner| corners[corner].as_slice()))
}

/// Sums the forces on the nodes from `first` on over the elements around each, x and y separately.
pub(crate) fn sum_corners(
    connectivity: &Connectivity,
    corners: &[f64],
    first: usize,
    [x, y]: [&mut [f64]; 2],
) {
    let nodes = connectivity.nodes().saturating_sub(first);
    for (k, (x, y)) in x.iter_mut().zip(y).enumerate().take(nodes) {
        (*x, *y) = (0.0, 0.0);
        for corner in connectivity.corners_at(first + k) {
            *x += corners[2 * *corner as usize];
            *y += corners[2 * *corner as usize + 1];
        }
    }
}
