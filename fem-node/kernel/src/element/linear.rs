//! Elements under a linear law, a pack of neighbours at a time.

use std::ops::Range;

use super::corners::{CornerPacks, CornerRows, Corners};
use super::row_forces::{CornerForces, PackForces, RowForces};
use crate::material::j2::J2;
use crate::pack::lanes::{ByPacks, LANES, Lanes, Registers};

/// Elements of a structured mesh whose forces are linear in the displacements of their corners.
pub(super) trait LinearElements {
    /// Constants of a pack of elements.
    type Constants;

    /// The packs of a row of elements.
    fn constants(&self, row: usize) -> &[Self::Constants];

    /// Forces (x, y) of the packs from a number on, with these constants, under the displacements (x, y) of their corners; and the excess of a bound
    /// of the deviatoric strain over the [`limit`](LinearElements::limit). An element that has never flowed does not flow if its excess is not
    /// above 0. The compiler drops an unused excess.
    fn forces_and_excess<R: Registers>(
        &self,
        registers: R,
        packs: (&[Self::Constants], usize),
        u: [Corners<R::Vector>; 2],
        limit: f64,
    ) -> ([CornerForces<R::Vector>; 2], R::Vector);

    /// Limit of the bound under a yield stress.
    fn limit(&self, plastic: &J2) -> f64;
}

/// Share of the exact limit with which the bounds are compared. The margin is far above the rounding of the bounds and costs nothing: an element
/// within the margin is only checked again. The rounding of the strain energy grows with the square of the rotation; it reaches this margin with a
/// rotation of 1e6 times the yield strain, where small strain has lost its meaning long before.
pub(super) const LIMIT_SHARE: f64 = 0.999;

/// A computation over a row of elements, compiled for each kind of elements and registers.
pub(super) trait OverElements {
    /// Runs the computation for the row of elements with `row` rows above; must be inlined.
    fn over<R: Registers>(self, registers: R, elements: &impl LinearElements, row: usize);
}

/// Forces of some elements of a row, in whole packs, for the nodes above and below.
pub(super) struct LinearRow<'a> {
    pub(super) u: CornerRows<'a>,
    /// Distance of the components of the displacements and of the forces.
    pub(super) stride: usize,
    pub(super) columns: Range<usize>,
    pub(super) out: &'a mut RowForces,
}

impl<'a> LinearRow<'a> {
    /// The numbers of its packs, with input and output of their forces.
    #[inline(always)]
    fn packs<E: LinearElements>(
        self,
        elements: &'a E,
        row: usize,
    ) -> (Range<usize>, ElementPass<'a, E>) {
        let packs = self.columns.start / LANES..self.columns.end / LANES;
        let pass = ElementPass {
            elements,
            constants: &elements.constants(row)[packs.clone()],
            // One after the other: `map` on an array is a call, after which the compiler no longer knows that all slices have one length.
            x: self.u.packs(0, &packs),
            y: self.u.packs(self.stride, &packs),
            forces: self.out.packs(self.stride, &packs),
        };
        (packs, pass)
    }
}

impl OverElements for LinearRow<'_> {
    #[inline(always)]
    fn over<R: Registers>(self, registers: R, elements: &impl LinearElements, row: usize) {
        let (packs, mut pass) = self.packs(elements, row);
        pass.over(registers, packs.len());
    }
}

/// The same with the excess of each element.
pub(super) struct BoundedRow<'a> {
    pub(super) row: LinearRow<'a>,
    pub(super) plastic: &'a J2,
    /// Lowest factor on its yield stress.
    pub(super) lowest: f64,
    /// Excess in the packs of the row.
    pub(super) excess: &'a mut [[f64; LANES]],
}

impl OverElements for BoundedRow<'_> {
    #[inline(always)]
    fn over<R: Registers>(self, registers: R, elements: &impl LinearElements, row: usize) {
        let (packs, pass) = self.row.packs(elements, row);
        let mut pass = BoundedPass {
            pass,
            limit: elements.limit(self.plastic) * self.lowest * self.lowest,
            excess: &mut self.excess[packs.clone()],
        };
        pass.over(registers, packs.len());
    }
}

/// Some packs of a row of elements.
struct ElementPass<'a, E: LinearElements> {
    elements: &'a E,
    constants: &'a [E::Constants],
    x: CornerPacks<'a>,
    y: CornerPacks<'a>,
    forces: [PackForces<'a>; 2],
}

impl<E: LinearElements> ElementPass<'_, E> {
    /// Stores the forces of the packs from `p` on, and returns their excess.
    #[inline(always)]
    fn leave_forces<R: Registers>(&mut self, registers: R, p: usize, limit: f64) -> R::Vector {
        let u = [self.x.at(registers, p), self.y.at(registers, p)];
        let packs = (self.constants, p);
        let ([fx, fy], excess) = self.elements.forces_and_excess(registers, packs, u, limit);
        let [x, y] = &mut self.forces;
        x.store(p, fx);
        y.store(p, fy);
        excess
    }
}

impl<E: LinearElements> ByPacks for ElementPass<'_, E> {
    #[inline(always)]
    fn at<R: Registers>(&mut self, registers: R, p: usize) {
        self.leave_forces(registers, p, 0.0);
    }
}

/// The same with a yield limit.
struct BoundedPass<'a, E: LinearElements> {
    pass: ElementPass<'a, E>,
    limit: f64,
    excess: &'a mut [[f64; LANES]],
}

impl<E: LinearElements> ByPacks for BoundedPass<'_, E> {
    #[inline(always)]
    fn at<R: Registers>(&mut self, registers: R, p: usize) {
        let excess = self.pass.leave_forces(registers, p, self.limit);
        excess.put(self.excess, p);
    }
}
