//! Displacements at the corners of a row of elements, loaded by packs.

use std::ops::Range;

use crate::material::j2::{HISTORY, History, PointHistory, history_pack};
use crate::pack::lanes::{LANES, Lanes, Pack, Registers};
use crate::pack::packs_of;

/// One displacement component at the corners of a pack of elements, anticlockwise from the lower left one.
#[derive(Clone, Copy)]
pub(crate) struct Corners<V = Pack> {
    u1: V,
    u2: V,
    u3: V,
    u4: V,
}

/// One displacement component at the corners of some packs of elements, corner after corner: slices of one length, so that a
/// loop over them checks no bounds.
pub(crate) struct CornerPacks<'a>([&'a [[f64; LANES]]; 4]);

impl CornerPacks<'_> {
    #[inline(always)]
    pub(crate) fn at<R: Registers>(&self, registers: R, p: usize) -> Corners<R::Vector> {
        let [u1, u2, u3, u4] = self.0;
        Corners {
            u1: registers.load(u1, p),
            u2: registers.load(u2, p),
            u3: registers.load(u3, p),
            u4: registers.load(u4, p),
        }
    }
}

/// A field at the corners of a row of elements, one slice for each corner, anticlockwise from the lower left one:
/// element i finds its x component at i and its y component at [`crate::element::layout::Layout::element_stride`] + i.
#[derive(Clone, Copy)]
pub(crate) struct CornerRows<'a>(pub(super) [&'a [f64]; 4]);

impl<'a> CornerRows<'a> {
    /// Between an upper and a lower row of nodes of a structured mesh, where neighbours share their corners. Empty rows
    /// give empty slices.
    #[inline(always)]
    pub(crate) fn between([upper, lower]: [&'a [f64]; 2]) -> CornerRows<'a> {
        let right = |row: &'a [f64]| row.get(1..).unwrap_or_default();
        CornerRows([lower, right(lower), right(upper), upper])
    }

    /// The component that begins at `component`, at the corners of these packs of elements.
    #[inline(always)]
    pub(crate) fn packs(self, component: usize, packs: &Range<usize>) -> CornerPacks<'a> {
        let [u1, u2, u3, u4] = self.0;
        CornerPacks([
            packs_of(u1, component, packs),
            packs_of(u2, component, packs),
            packs_of(u3, component, packs),
            packs_of(u4, component, packs),
        ])
    }

    /// Both components at the corners of the elements from `i` on.
    #[inline(always)]
    pub(super) fn load(self, stride: usize, i: usize) -> [Corners; 2] {
        [self.corners(i), self.corners(stride + i)]
    }

    #[inline(always)]
    fn corners(self, at: usize) -> Corners {
        let [u1, u2, u3, u4] = self.0;
        Corners {
            u1: Pack::load(u1, at),
            u2: Pack::load(u2, at),
            u3: Pack::load(u3, at),
            u4: Pack::load(u4, at),
        }
    }
}

impl<V: Lanes> Corners<V> {
    #[inline(always)]
    pub(super) fn gradient(&self, bx: [V; 2], by: [V; 2]) -> [V; 2] {
        let (d13, d24) = (self.u1 - self.u3, self.u2 - self.u4);
        [bx[0] * d13 + bx[1] * d24, by[0] * d13 + by[1] * d24]
    }

    /// Four times the means of u,xi and u,eta over the element.
    #[inline(always)]
    pub(super) fn natural(&self) -> (V, V) {
        let (d31, d24) = (self.u3 - self.u1, self.u2 - self.u4);
        (d31 + d24, d31 - d24)
    }

    /// h.u
    #[inline(always)]
    pub(super) fn hourglass(&self) -> V {
        (self.u1 + self.u3) - (self.u2 + self.u4)
    }
}

/// Strain path of a row of elements over a step: displacements of the corners, their increments, and the history variables
/// of the points.
pub(crate) struct StrainPath<'a> {
    pub(crate) u: CornerRows<'a>,
    /// Increments of the last step; empty under a law without history.
    pub(crate) du: CornerRows<'a>,
    /// History of this row: for each point [`HISTORY`] arrays of [`crate::element::layout::Layout::padded_columns`]; empty under a law without
    /// history.
    pub(crate) history: &'a mut [f64],
    /// Dissipation of each element (J), to which the step adds its own; empty where it is not counted.
    pub(crate) dissipated: &'a mut [f64],
}

impl StrainPath<'_> {
    /// Counts the dissipation (J) of the elements from `i` on.
    #[inline(always)]
    pub(super) fn count(&mut self, dissipated: Pack, i: usize) {
        if !self.dissipated.is_empty() {
            dissipated.add_to(self.dissipated, i);
        }
    }

    /// Adds up the equivalent plastic strains of the first `points` points of some packs of elements: above 0 in elements that have flowed. Only
    /// these have history variables other than 0.
    #[inline(always)]
    pub(super) fn write_flow(
        &self,
        [points, padded]: [usize; 2],
        columns: &Range<usize>,
        flow: &mut [[f64; LANES]],
    ) {
        let packs = columns.start / LANES..columns.end / LANES;
        let of = |point: usize| {
            let first = (point * HISTORY + HISTORY - 1) * padded;
            packs_of(self.history, first, &packs)
        };
        flow.copy_from_slice(of(0));
        for point in 1..points {
            for (flow, own) in flow.iter_mut().zip(of(point)) {
                *flow = (Pack(*flow) + Pack(*own)).0;
            }
        }
    }

    /// History of one of the points; empty under a law without history.
    #[inline(always)]
    pub(super) fn point(&mut self, point: usize, padded: usize) -> PointHistory<'_> {
        let size = HISTORY * padded;
        let values = self.history.get_mut(point * size..(point + 1) * size);
        PointHistory {
            values: values.unwrap_or_default(),
            stride: padded,
        }
    }
}

/// Strain state of a row of elements: displacements of the corners and history variables of the points.
#[derive(Clone, Copy)]
pub(crate) struct StrainState<'a> {
    pub(crate) u: CornerRows<'a>,
    pub(crate) history: &'a [f64],
}

impl StrainState<'_> {
    /// True where no element of the pack has ever flowed, [`StrainPath::write_flow`].
    #[inline(always)]
    pub(super) fn is_virgin(&self, points: usize, padded: usize, i: usize) -> bool {
        let flows = |point: usize| {
            let [.., a] = self.history(point, padded, i);
            a.any_above(Pack::splat(0.0))
        };
        !(0..points).any(flows)
    }

    /// History variables of one of the points; zero under a law without history.
    #[inline(always)]
    pub(super) fn history(&self, point: usize, padded: usize, i: usize) -> History {
        if self.history.is_empty() {
            return History::default();
        }
        history_pack(self.history, padded, point * HISTORY * padded + i)
    }
}
