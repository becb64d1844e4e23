//! Constants of the elements, by packs of neighbours.

use super::layout::Layout;
use crate::mesh::Mesh;
use crate::pack::lanes::{LANES, Pack};

/// N constants of each pack of elements, row after row; zero in the padding. The constants of a pack lie side by side: they have one address, and a
/// loop over a row checks one bound for all.
#[derive(Clone, Debug)]
pub(super) struct Constants<const N: usize> {
    packs: Vec<[Pack; N]>,
    of_row: usize,
}

impl<const N: usize> Constants<N> {
    pub(super) fn new(
        mesh: &Mesh,
        layout: Layout,
        of_element: impl Fn(&[[f64; 2]; 4]) -> [f64; N],
    ) -> Constants<N> {
        let mut constants = Constants::zero(layout);
        for element in mesh.element_indices() {
            constants.set(element, of_element(&mesh.corner_points(element)));
        }
        constants
    }

    /// Constants of the piece whose first column of elements is `first`.
    pub(super) fn piece(&self, layout: Layout, first: usize) -> Constants<N> {
        let mut piece = Constants::zero(layout);
        for (i, j) in (0..layout.rows).flat_map(|j| (0..layout.columns).map(move |i| (i, j))) {
            piece.set([i, j], self.get([first + i, j]));
        }
        piece
    }

    /// The packs of a row.
    #[inline(always)]
    pub(super) fn row(&self, row: usize) -> &[[Pack; N]] {
        &self.packs[row * self.of_row..(row + 1) * self.of_row]
    }

    fn zero(layout: Layout) -> Constants<N> {
        let of_row = layout.padded_columns() / LANES;
        Constants {
            packs: vec![[Pack::splat(0.0); N]; layout.rows * of_row],
            of_row,
        }
    }

    fn get(&self, [i, j]: [usize; 2]) -> [f64; N] {
        self.packs[j * self.of_row + i / LANES].map(|constant| constant.0[i % LANES])
    }

    fn set(&mut self, [i, j]: [usize; 2], constants: [f64; N]) {
        let pack = &mut self.packs[j * self.of_row + i / LANES];
        for (pack, constant) in pack.iter_mut().zip(constants) {
            pack.0[i % LANES] = constant;
        }
    }
}
