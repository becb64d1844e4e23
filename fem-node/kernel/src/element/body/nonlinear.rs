//! Rows of elements under a nonlinear law.
//!
//! Without plastic flow plasticity costs next to nothing: packs in which no element has ever flowed take the elastic forces with a bound of the trial
//! stress ([`super::super::q4_2x2`], [`super::super::q4_1point`]). The points are checked only where the bound exceeds the yield surface, and take
//! the radial return only where one of them flows. The return gives an element without plastic strain the elastic bits, so the forces of an element
//! do not depend on its neighbours in a pack.

use std::ops::Range;

use super::super::corners::StrainPath;
use super::super::linear::{BoundedRow, LinearRow};
use super::super::points::{FLOWED, YieldCandidates};
use super::super::row_forces::RowForces;
use super::{Body, Element};
use crate::material::j2::J2;
use crate::material::nonlinear::NonlinearLaw;
use crate::pack::lanes::{LANES, Pack};
use crate::pack::vectorised;

impl Body {
    /// Forces of some elements of a row, in whole packs, under a nonlinear law.
    pub(crate) fn nonlinear_row(
        &self,
        law: &NonlinearLaw,
        row: usize,
        path: StrainPath,
        columns: Range<usize>,
        out: &mut RowForces,
    ) {
        match law {
            NonlinearLaw::Plastic(plastic) => self.plastic_row(plastic, row, path, columns, out),
            NonlinearLaw::Corotational => vectorised!(
                of_kind!(&self.element, elements: elements.corotational_row(row, path, columns, out))
            ),
        }
    }

    fn plastic_row(
        &self,
        plastic: &J2,
        row: usize,
        mut path: StrainPath,
        columns: Range<usize>,
        out: &mut RowForces,
    ) {
        let history = std::mem::take(&mut path.history);
        let (history, factors) = history.split_at_mut(self.history_len());
        path.history = history;
        let own = factors.get(columns.clone()).unwrap_or_default().iter();
        let lowest = own.copied().reduce(f64::min).unwrap_or(1.0);
        let mut excess = std::mem::take(&mut out.excess);
        let packs = columns.start / LANES..columns.end / LANES;
        let points = [self.points(), self.layout.padded_columns()];
        let flowed = mark_flowed(&path, points, &columns, &mut excess);
        let mut next = packs.start;
        while let Some(virgin) = run_below(FLOWED, &excess, next..packs.end) {
            next = virgin.end;
            let linear = LinearRow {
                u: path.u,
                stride: self.layout.element_stride(),
                columns: virgin.start * LANES..virgin.end * LANES,
                out,
            };
            let bounded = BoundedRow {
                row: linear,
                plastic,
                lowest,
                excess: &mut excess,
            };
            self.over_linear(row, bounded);
        }
        let own = &excess[packs.clone()];
        if flowed || vectorised!(any_positive(own)) {
            let candidates = YieldCandidates {
                excess: own,
                first: packs.start,
                factors,
            };
            vectorised!(
                of_kind!(&self.element, elements: elements.plastic_row(plastic, row, path, candidates, out))
            );
        }
        out.excess = excess;
    }
}

/// Writes [`FLOWED`] for each pack in which an element has flowed, 0 for the others; true if any has flowed.
fn mark_flowed(
    path: &StrainPath,
    points: [usize; 2],
    columns: &Range<usize>,
    excess: &mut [[f64; LANES]],
) -> bool {
    let marks = &mut excess[columns.start / LANES..columns.end / LANES];
    vectorised!({
        path.write_flow(points, columns, marks);
        if !any_positive(marks) {
            // A mark that is NaN belongs to no run, and its pack would keep the forces of another row.
            marks.fill([0.0; LANES]);
            return false;
        }
        for mark in marks {
            let flowed = Pack(*mark).any_above(Pack::splat(0.0));
            *mark = [if flowed { FLOWED } else { 0.0 }; LANES];
        }
        true
    })
}

/// True if any number is above 0. One branch for all numbers: in most rows no number is.
#[inline(always)]
fn any_positive(packs: &[[f64; LANES]]) -> bool {
    // NaN is ignored.
    let larger = |largest: Pack, pack: &[f64; LANES]| Pack(*pack).max(largest);
    let largest = packs.iter().fold(Pack::splat(0.0), larger);
    largest.any_above(Pack::splat(0.0))
}

/// The first run of packs whose first number is below a limit.
fn run_below(limit: f64, numbers: &[[f64; LANES]], packs: Range<usize>) -> Option<Range<usize>> {
    let end = packs.end;
    let start = packs.clone().find(|pack| numbers[*pack][0] < limit)?;
    let end = (start..end)
        .find(|pack| numbers[*pack][0] >= limit)
        .unwrap_or(end);
    Some(start..end)
}
