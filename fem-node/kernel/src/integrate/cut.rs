//! A piece of the columns of a body, and the part of a region that lies in it.
//!
//! A piece has copies of some neighbouring columns. Each step spoils one more column of the copies, from the end of the piece on. With k steps left,
//! the columns within k of the piece's own columns are still good. A repeat of a window steps the good columns of each front, so it needs neither the
//! other pieces nor a barrier.

use std::ops::Range;

use super::front::Front;
use super::region::{Region, Ring};
use super::tally::blocks_of;
use crate::element::layout::Layout;
use crate::pack::lanes::LANES;

/// Columns of nodes of a piece.
#[derive(Clone, Debug)]
pub struct Cut {
    /// Columns of the body that only this piece has.
    pub own: Range<usize>,
    /// The own and the copied columns; they begin with a whole pack of the body.
    pub columns: Range<usize>,
    /// Layout of the body.
    pub body: Layout,
    /// Layout of the piece.
    pub piece: Layout,
}

/// The part of a region that a piece steps.
#[derive(Clone, Debug, Default)]
pub struct CutRegion {
    /// Components that the first step steps, from the start of the window.
    pub begin: Vec<Range<usize>>,
    /// Steps of the window.
    pub steps: Vec<CutStep>,
    /// Blocks of [`crate::integrate::tally::Tally`] with own components that are stepped.
    pub blocks: Vec<usize>,
    /// Blocks with own components on which the changed force acts.
    pub sources: Vec<usize>,
}

/// The part of a front that a piece steps, columns in each row.
#[derive(Clone, Debug)]
pub struct CutStep {
    /// Stepped columns.
    pub(super) stepped: Vec<[usize; 2]>,
    /// The stepped columns and the columns beside them that the step before left good.
    pub(super) predicted: Vec<[usize; 2]>,
    /// The ring beyond the stepped columns.
    pub ring: Ring,
}

impl Cut {
    /// Columns of the body that must still be good when `left` steps are left.
    pub fn good(&self, left: usize) -> Range<usize> {
        let start = self.own.start.saturating_sub(left);
        start.max(self.columns.start)..(self.own.end + left).min(self.columns.end)
    }

    /// Its own columns in the numbering of the piece.
    pub(crate) fn own_in_piece(&self) -> Range<usize> {
        self.own.start - self.columns.start..self.own.end - self.columns.start
    }

    /// Components of the piece in some columns of the body, in a line: one component of a row of nodes.
    pub fn in_line(&self, line: usize, columns: &Range<usize>) -> Range<usize> {
        let start = line * self.piece.stride + columns.start - self.columns.start;
        start..start + columns.len()
    }

    /// Line and columns of the body of a range of components in one line of the piece.
    pub fn in_body(&self, range: &Range<usize>) -> (usize, Range<usize>) {
        let line = range.start / self.piece.stride;
        let first = range.start - line * self.piece.stride + self.columns.start;
        (line, first..first + range.len())
    }

    /// Good columns in the numbering of the piece.
    pub fn good_in_piece(&self, left: usize) -> [usize; 2] {
        let good = self.good(left);
        [good.start, good.end].map(|column| column - self.columns.start)
    }

    /// Components that the piece has in some columns of the body, of a range in one of the body's rows.
    fn within(&self, range: &Range<usize>, columns: &Range<usize>) -> Range<usize> {
        let (line, first) = (range.start / self.body.stride, self.columns.start);
        let in_line = |index: usize| index - line * self.body.stride;
        let start = in_line(range.start).max(columns.start);
        let end = in_line(range.end).min(columns.end).max(start);
        let line = line * self.piece.stride;
        line + start - first..line + end - first
    }

    /// The ranges that are not empty.
    fn all_within(&self, ranges: &[Range<usize>], columns: &Range<usize>) -> Vec<Range<usize>> {
        let within = ranges.iter().map(|range| self.within(range, columns));
        within.filter(|range| !range.is_empty()).collect()
    }

    /// Copies its own columns from a field of the body.
    pub fn take(&self, body: &[f64], piece: &mut [f64]) {
        let lines = piece.chunks_mut(self.piece.stride);
        for (line, body) in lines.zip(body.chunks(self.body.stride)) {
            line[self.own_in_piece()].copy_from_slice(&body[self.own.clone()]);
        }
    }

    /// Copies its own columns into a field of the body.
    pub fn put(&self, piece: &[f64], body: &mut [f64]) {
        let lines = body.chunks_mut(self.body.stride);
        for (body, line) in lines.zip(piece.chunks(self.piece.stride)) {
            body[self.own.clone()].copy_from_slice(&line[self.own_in_piece()]);
        }
    }

    /// Good columns of a row of a front in the numbering of the piece, and the rest of their packs where the front has it: spoilt columns are never
    /// read, and whole packs need no care at their ends.
    fn stepped(&self, row: [usize; 2], good: &Range<usize>) -> [usize; 2] {
        let first = self.columns.start;
        let end = (good.end - first).next_multiple_of(LANES) + first;
        let packs = good.start / LANES * LANES..end;
        let has_any = !clipped(row, good).is_empty();
        self.in_piece(clipped(row, &packs))
            .filter(|_| has_any)
            .unwrap_or_default()
    }

    /// Good columns of a row of a front in the numbering of the piece.
    fn predicted(&self, row: [usize; 2], good: &Range<usize>) -> [usize; 2] {
        self.in_piece(clipped(row, good)).unwrap_or_default()
    }

    /// Columns in the numbering of the piece, if there are any.
    fn in_piece(&self, columns: Range<usize>) -> Option<[usize; 2]> {
        let count = |column: usize| column - self.columns.start;
        (!columns.is_empty()).then(|| [columns.start, columns.end].map(count))
    }
}

impl CutRegion {
    /// The part of a region that lies in a piece.
    pub fn new(region: &Region, cut: &Cut) -> CutRegion {
        let substeps = region.rings.len();
        let step = |(k, (front, ring)): (usize, (&Front, &Ring))| {
            let Front::Columns(rows) = front else {
                unreachable!("a piece has a structured mesh")
            };
            let [before, after] = [substeps - k, substeps - k - 1].map(|left| cut.good(left));
            let stepped = rows.iter().map(|row| cut.stepped(*row, &after));
            let predicted = rows.iter().map(|row| cut.predicted(*row, &before));
            CutStep {
                stepped: stepped.collect(),
                predicted: predicted.collect(),
                // No piece has a law with history.
                ring: Ring {
                    enters: cut.all_within(&ring.enters, &before),
                    ..Ring::default()
                },
            }
        };
        let fronts = region.fronts.iter().zip(&region.rings).enumerate();
        let steps: Vec<CutStep> = fronts.map(step).collect();
        let last = steps.last().map_or(&[][..], |step| &step.stepped);
        let reached = last.iter().enumerate().flat_map(|(row, columns)| {
            let start = cut.piece.row(row).start;
            let spans = cut.piece.spans(*columns);
            spans.map(|span| start + span.start..start + span.end)
        });
        let sources = region.components.iter().map(|k| *k..*k + 1);
        let sources = cut.all_within(&sources.collect::<Vec<_>>(), &cut.own);
        CutRegion {
            begin: cut.all_within(&region.begin, &cut.good(substeps)),
            blocks: blocks_of(cut.piece, reached),
            sources: blocks_of(cut.piece, sources.into_iter()),
            steps,
        }
    }
}

/// Columns of a row that lie within others.
fn clipped([first, end]: [usize; 2], columns: &Range<usize>) -> Range<usize> {
    first.max(columns.start)..end.min(columns.end)
}
