//! Elements under a linear law, a pack of neighbours at a time.

use std::ops::Range;

use super::corners::{CornerRows, Corners};
use super::row_forces::{CornerForces, RowForces};
use crate::pack::{LANES, Registers};

/// Elements of a structured mesh whose forces are linear in the displacements of their corners.
pub(super) trait LinearElements {
    /// Constants of a pack of elements.
    type Constants;

    /// The packs of a row of elements.
    fn constants(&self, row: usize) -> &[Self::Constants];

    /// Forces (x, y) of a pack under the displacements (x, y) of its corners.
    fn forces<R: Registers>(
        &self,
        registers: R,
        constants: &Self::Constants,
        u: [Corners<R::Vector>; 2],
    ) -> [CornerForces<R::Vector>; 2];
}

/// A computation over a row of elements, compiled for each kind of them and of registers.
pub(super) trait OverElements {
    /// Runs it for the row of elements that has `row` of them above it; must be inlined.
    fn over<R: Registers>(self, registers: R, elements: &impl LinearElements, row: usize);
}

/// Forces of some elements of a row, whole packs of them, left to the nodes above and below.
pub(super) struct LinearRow<'a> {
    pub(super) u: CornerRows<'a>,
    /// Distance of the components of the displacements and of the forces.
    pub(super) stride: usize,
    pub(super) columns: Range<usize>,
    pub(super) out: &'a mut RowForces,
}

impl OverElements for LinearRow<'_> {
    #[inline(always)]
    fn over<R: Registers>(self, registers: R, elements: &impl LinearElements, row: usize) {
        let packs = self.columns.start / LANES..self.columns.end / LANES;
        let constants = &elements.constants(row)[packs.clone()];
        let [ux, uy] = [0, self.stride].map(|component| self.u.packs(component, &packs));
        let [mut fx, mut fy] = self.out.packs(self.stride, &packs);
        for (p, constants) in constants.iter().enumerate() {
            let u = [ux.at(registers, p), uy.at(registers, p)];
            let [x, y] = elements.forces(registers, constants, u);
            fx.store(p, x);
            fy.store(p, y);
        }
    }
}
