//! Forces of a row of elements on the nodes above and below it.

use std::ops::Range;

use super::layout::Layout;
use crate::pack::lanes::{LANES, Lanes, Pack};
use crate::pack::line::Lines;
use crate::pack::{packs_of, packs_of_mut, vectorised};

/// Forces along one axis on the corners of a pack of elements: f1 = F1 + Q, f2 = F2 - Q, f3 = -F1 + Q, f4 = -F2 - Q.
#[derive(Clone, Copy)]
pub(crate) struct CornerForces<V = Pack> {
    /// F1
    pub(super) first: V,
    /// F2
    pub(super) second: V,
    /// Q
    pub(super) hourglass: V,
}

impl<V: Lanes> CornerForces<V> {
    /// Forces on the lower left, the lower right, the upper right and the upper left corner.
    #[inline(always)]
    pub(super) fn on_corners(self) -> [V; 4] {
        let (f1, f2, q) = (self.first, self.second, self.hourglass);
        [f1 + q, f2 - q, q - f1, q.all(0.0) - f2 - q]
    }
}

/// Forces of a row of elements on the nodes above and below it, kept until the row below has added its own.
///
/// Two elements of each row act on a node: `left` holds the force from the element on its right, whose left corner it is, `right` the force from the
/// element on its left.
#[derive(Clone, Debug)]
pub(crate) struct RowForces {
    /// Forces on the upper nodes, left then right.
    upper: [Lines; 2],
    lower: [Lines; 2],
    /// Forces of the row of elements above on the same nodes.
    carried: [Lines; 2],
    /// Room for a number of each element of the current row, by packs.
    pub(super) excess: Vec<[f64; LANES]>,
}

/// One component of the forces on the corners of some packs of elements: slices of one length, so that a loop over them checks no
/// bounds.
pub(super) struct PackForces<'a> {
    lower_left: &'a mut [[f64; LANES]],
    lower_right: &'a mut [[f64; LANES]],
    upper_left: &'a mut [[f64; LANES]],
    upper_right: &'a mut [[f64; LANES]],
}

impl<'a> PackForces<'a> {
    #[inline(always)]
    fn new(
        [lower_left, lower_right]: [&'a mut [f64]; 2],
        [upper_left, upper_right]: [&'a mut [f64]; 2],
        packs: &Range<usize>,
    ) -> PackForces<'a> {
        PackForces {
            lower_left: packs_of_mut(lower_left, 0, packs),
            lower_right: packs_of_mut(lower_right, 1, packs),
            upper_left: packs_of_mut(upper_left, 0, packs),
            upper_right: packs_of_mut(upper_right, 1, packs),
        }
    }

    #[inline(always)]
    pub(super) fn store(&mut self, p: usize, forces: CornerForces<impl Lanes>) {
        let [f1, f2, f3, f4] = forces.on_corners();
        f1.put(self.lower_left, p);
        f2.put(self.lower_right, p);
        f3.put(self.upper_right, p);
        f4.put(self.upper_left, p);
    }
}

impl RowForces {
    pub(crate) fn new(layout: Layout) -> RowForces {
        let zero = || [0, 1].map(|_| Lines::zeros(2 * layout.element_stride()));
        RowForces {
            upper: zero(),
            lower: zero(),
            carried: zero(),
            excess: vec![[0.0; LANES]; layout.padded_columns() / LANES],
        }
    }

    /// Forces on the corners of the elements from `i` on.
    #[inline(always)]
    pub(super) fn store(&mut self, i: usize, forces: CornerForces) {
        let [f1, f2, f3, f4] = forces.on_corners();
        f1.store(&mut self.lower[0], i);
        f2.store(&mut self.lower[1], i + 1);
        f3.store(&mut self.upper[1], i + 1);
        f4.store(&mut self.upper[0], i);
    }

    /// Both components of the forces on the corners of these packs of elements.
    #[inline(always)]
    pub(super) fn packs(&mut self, stride: usize, packs: &Range<usize>) -> [PackForces<'_>; 2] {
        let ([lower_left, lower_right], [upper_left, upper_right]) =
            (&mut self.lower, &mut self.upper);
        let (lower_left, lower_left_y) = lower_left.split_at_mut(stride);
        let (lower_right, lower_right_y) = lower_right.split_at_mut(stride);
        let (upper_left, upper_left_y) = upper_left.split_at_mut(stride);
        let (upper_right, upper_right_y) = upper_right.split_at_mut(stride);
        [
            PackForces::new([lower_left, lower_right], [upper_left, upper_right], packs),
            PackForces::new(
                [lower_left_y, lower_right_y],
                [upper_left_y, upper_right_y],
                packs,
            ),
        ]
    }

    /// Forces on these packs of a component of a row of nodes: of the elements above on the right and on the left, then of the elements below.
    #[inline(always)]
    pub(crate) fn on_nodes(&self, component: usize, packs: &Range<usize>) -> [&[[f64; LANES]]; 4] {
        let ([left, right], [below_left, below_right]) = (&self.carried, &self.upper);
        [
            packs_of(left, component, packs),
            packs_of(right, component, packs),
            packs_of(below_left, component, packs),
            packs_of(below_right, component, packs),
        ]
    }

    /// Forces (x1, y1, x2, ..) on the corners of element `i`, with the `stride` of the elements.
    pub(super) fn of_element(&self, stride: usize, i: usize) -> [f64; 8] {
        let corners = [
            (&self.lower[0], i),
            (&self.lower[1], i + 1),
            (&self.upper[1], i + 1),
            (&self.upper[0], i),
        ];
        std::array::from_fn(|k| corners[k / 2].0[corners[k / 2].1 + (k % 2) * stride])
    }

    /// Clears the forces on the upper nodes: no elements lie below the last row of nodes.
    pub(crate) fn clear_upper(&mut self) {
        self.upper.iter_mut().for_each(|forces| forces.fill(0.0));
    }

    /// Clears the carried forces: no elements lie above the first row of nodes.
    pub(crate) fn clear_carried(&mut self) {
        self.carried.iter_mut().for_each(|forces| forces.fill(0.0));
    }

    /// Force on these components of a row of nodes: from the elements above the row, then from the elements below.
    pub(crate) fn assemble(&self, force: &mut [f64], spans: &[Range<usize>]) {
        for span in spans {
            // Whole packs: there is room beyond the span, which is never read.
            let span = span.start..span.start + span.len().next_multiple_of(LANES);
            let [left, right] = self.carried.each_ref().map(|forces| chunks(forces, &span));
            let [below_left, below_right] =
                self.upper.each_ref().map(|forces| chunks(forces, &span));
            let sources = left
                .iter()
                .zip(right)
                .zip(below_left.iter().zip(below_right));
            let force = force[span.clone()].as_chunks_mut::<LANES>().0;
            vectorised!({
                for (force, ((left, right), (below_left, below_right))) in
                    force.iter_mut().zip(sources)
                {
                    let above = Pack(*left) + Pack(*right);
                    *force = (above + (Pack(*below_left) + Pack(*below_right))).0;
                }
            });
        }
    }

    /// Goes down by one row: the forces on the lower nodes become the carried forces.
    pub(crate) fn advance(&mut self) {
        std::mem::swap(&mut self.carried, &mut self.lower);
    }
}

/// Whole packs of a span.
#[inline(always)]
fn chunks<'a>(forces: &'a [f64], span: &Range<usize>) -> &'a [[f64; LANES]] {
    forces[span.clone()].as_chunks().0
}
