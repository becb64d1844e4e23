//! Forces that a row of elements hands to the nodes above and below it.

use std::ops::Range;

use super::layout::Layout;
use crate::pack::{LANES, Pack, vectorised};

/// Forces of a row of elements on the nodes above and below it, kept until the row below has added its own.
///
/// A node takes from two elements of each row: `left` holds what each node gets from the element on its right,
/// whose left corner it is, `right` what it gets from the element on its left.
#[derive(Clone, Debug)]
pub(crate) struct RowForces {
    /// Forces on the upper nodes, left then right.
    upper: [Vec<f64>; 2],
    lower: [Vec<f64>; 2],
    /// Forces of the row of elements above on the same nodes.
    carried: [Vec<f64>; 2],
}

impl RowForces {
    pub(crate) fn new(layout: Layout) -> RowForces {
        let zero = || [0, 1].map(|_| vec![0.0; 2 * layout.element_stride()]);
        RowForces {
            upper: zero(),
            lower: zero(),
            carried: zero(),
        }
    }

    /// Corner forces f1 = F1 + Q, f2 = F2 - Q, f3 = -F1 + Q, f4 = -F2 - Q.
    #[inline(always)]
    pub(super) fn store(&mut self, i: usize, f1: Pack, f2: Pack, q: Pack) {
        (f1 + q).store(&mut self.lower[0], i);
        (f2 - q).store(&mut self.lower[1], i + 1);
        (q - f1).store(&mut self.upper[1], i + 1);
        (Pack::splat(0.0) - f2 - q).store(&mut self.upper[0], i);
    }

    /// Forces (x1, y1, x2, ..) on the corners of element `i`, `stride` being that of the elements.
    pub(super) fn of_element(&self, stride: usize, i: usize) -> [f64; 8] {
        let corners = [
            (&self.lower[0], i),
            (&self.lower[1], i + 1),
            (&self.upper[1], i + 1),
            (&self.upper[0], i),
        ];
        std::array::from_fn(|k| corners[k / 2].0[corners[k / 2].1 + (k % 2) * stride])
    }

    /// Clears what acts on the upper nodes: no elements lie below the last row of nodes.
    pub(crate) fn clear_upper(&mut self) {
        self.upper.iter_mut().for_each(|forces| forces.fill(0.0));
    }

    /// Clears what is carried: no elements lie above the first row of nodes.
    pub(crate) fn clear_carried(&mut self) {
        self.carried.iter_mut().for_each(|forces| forces.fill(0.0));
    }

    /// Force on these components of a row of nodes: from the elements above it, then from those below it.
    pub(crate) fn assemble(&self, force: &mut [f64], spans: &[Range<usize>]) {
        for span in spans {
            // Whole packs: beyond the span there is room, and nobody reads it.
            let span = span.start..span.start + span.len().next_multiple_of(LANES);
            let [left, right] = self.carried.each_ref().map(|forces| chunks(forces, &span));
            let [below_left, below_right] =
                self.upper.each_ref().map(|forces| chunks(forces, &span));
            let sources = left
                .iter()
                .zip(right)
                .zip(below_left.iter().zip(below_right));
            let force = force[span.clone()].as_chunks_mut::<LANES>().0;
            vectorised(
                #[inline(always)]
                || {
                    for (force, ((left, right), (below_left, below_right))) in
                        force.iter_mut().zip(sources)
                    {
                        let above = Pack(*left) + Pack(*right);
                        *force = (above + (Pack(*below_left) + Pack(*below_right))).0;
                    }
                },
            );
        }
    }

    /// Goes down by one row: the forces on the lower nodes become those that are carried.
    pub(crate) fn advance(&mut self) {
        std::mem::swap(&mut self.carried, &mut self.lower);
    }
}

/// Whole packs of a span.
fn chunks<'a>(forces: &'a [f64], span: &Range<usize>) -> &'a [[f64; LANES]] {
    forces[span.clone()].as_chunks().0
}
