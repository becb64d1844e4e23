//! Pieces of columns that threads step side by side for a whole window.
//!
//! Each piece has copies of as many neighbouring columns as the window has steps. In these copies each step spoils one more column from the cut
//! inwards, but never a column of the piece itself: no thread waits for another before the end of the window. The numbers have the bits of the whole
//! body.
//!
//! The committed state stays in the pieces from one window to the next, close to the threads. It is copied into the body's state only on request.

use std::sync::Arc;

use fem_kernel::element::layout::Layout;
use fem_kernel::integrate::region::Region;
use fem_kernel::integrate::state::NodalState;
use fem_kernel::integrate::tally::{BLOCK, Tally};

use super::extent::{BodyWindow, Extent, WindowInput};
use super::piece::Piece;
use super::start::PieceStart;
use super::team::Team;
use crate::interface::window::committed::Committed;
use crate::model::Model;

/// Element steps per thread in a window, below which waking the thread costs more than it saves.
const WORTH_WAKING: u64 = 25_000;

/// Largest overlap of a piece as a share of its own columns, on average over the window.
const OVERLAP_MAX: f64 = 0.4;

/// The pieces of a body, cut at the first window that runs in them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Partition {
    /// Empty where the body is stepped as a whole.
    pieces: Vec<Piece>,
    /// States from which the pieces begin a window.
    starts: Vec<PieceStart>,
    /// Own columns of each piece except the last.
    size: usize,
    /// Steps and threads for which the pieces were cut.
    cut_for: Option<(u32, usize)>,
    /// The last whole run was in pieces.
    pub(super) is_run: bool,
    /// The starts are the committed state.
    is_current: bool,
    /// The state of the body is older than the pieces.
    pub(crate) is_ahead: bool,
    /// Region whose rings the pieces record.
    region: Option<Arc<Region>>,
}

impl Partition {
    /// True if a window runs in pieces, which are cut here. A repeat runs like the window before it.
    pub(super) fn takes(
        &mut self,
        model: &Model,
        committed: &mut Committed,
        (input, extent): (&WindowInput, &Extent),
        threads: usize,
    ) -> bool {
        if extent.is_part() {
            return self.is_run;
        }
        if threads < 2 || !input.velocity.is_empty() || model.expands() {
            return false;
        }
        let known = |(most, of): (u32, usize)| input.substeps <= most && of == threads;
        if !self.cut_for.is_some_and(known) {
            self.catch_up(&mut committed.state);
            let count = worthwhile(model, input.substeps, threads);
            *self = Partition::in_parts(model, input.substeps, count);
            self.cut_for = Some((input.substeps, threads));
        }
        !self.pieces.is_empty()
    }

    /// `count` pieces for windows of up to `substeps` steps; no pieces if they would overlap too much.
    fn in_parts(model: &Model, substeps: u32, count: usize) -> Partition {
        let nodes = model.body.layout.nodes_in_row;
        let size = nodes.div_ceil(count.max(1)).next_multiple_of(BLOCK);
        if count < 2 || f64::from(substeps) > OVERLAP_MAX * size as f64 {
            return Partition::default();
        }
        // The first step reads one column beyond the spoilt ones.
        let overlap = (substeps as usize + 1).next_multiple_of(BLOCK);
        let cut = |(index, first): (usize, usize)| {
            Piece::new(model, index, first..(first + size).min(nodes), overlap)
        };
        let pieces: Vec<Piece> = (0..nodes).step_by(size).enumerate().map(cut).collect();
        Partition {
            starts: pieces.iter().map(Piece::start).collect(),
            pieces,
            size,
            ..Partition::default()
        }
    }

    /// Runs or repeats a window in the pieces, records the rings of a region, and enters the sums of the pieces into the body's.
    pub(super) fn run(
        &mut self,
        team: &Team,
        window: BodyWindow,
        extent: &Extent,
        tally: &mut Tally,
    ) {
        self.is_run = true;
        self.follow(extent.region());
        if !self.is_current {
            let starts = self.starts.iter_mut();
            starts.for_each(|start| start.take(&window.committed.state));
            self.is_current = true;
        }
        let starts = &self.starts;
        let repeats = extent.is_part();
        team.side_by_side(&mut self.pieces, |piece| {
            if repeats {
                piece.repeat(window, starts);
            } else {
                piece.run(window, starts);
            }
        });
        for Piece {
            tally: its, cut, ..
        } in &self.pieces
        {
            let layout = window.model.body.layout;
            tally.take(layout, (its, cut.piece), &cut.own, cut.columns.start);
        }
    }

    fn follow(&mut self, region: Option<&Arc<Region>>) {
        let same = match (&self.region, region) {
            (Some(known), Some(region)) => Arc::ptr_eq(known, region),
            (known, region) => known.is_none() && region.is_none(),
        };
        if !same {
            self.region = region.cloned();
            let pieces = self.pieces.iter_mut();
            pieces.for_each(|piece| piece.follow(region));
        }
    }

    /// The pieces where they hold the end of the last window.
    pub(super) fn held(&self) -> Option<&Partition> {
        self.is_run.then_some(self)
    }

    /// Displacement of a component since the start of the window (m).
    pub(super) fn moved(&self, layout: Layout, index: usize) -> f64 {
        let (line, column) = (index / layout.stride, index % layout.stride);
        let piece = column / self.size;
        let (Piece { cut, fields, .. }, start) = (&self.pieces[piece], &self.starts[piece]);
        let at = cut.in_line(line, &(column..column + 1)).start;
        fields.state.u[at] - start.state.u[at]
    }

    /// Displacements of the body at the end of the last window (m).
    pub(super) fn displacements(&self, layout: Layout) -> Vec<f64> {
        let mut whole = vec![0.0; layout.len()];
        let pieces = self.pieces.iter();
        pieces.for_each(|piece| piece.cut.put(&piece.fields.state.u, &mut whole));
        whole
    }

    /// Makes the end of the last window the committed state if the pieces hold it, and gives `state` the motion of some rows of nodes. False if they
    /// do not hold it.
    pub(super) fn accept(&mut self, state: &mut NodalState, rows: &[usize]) -> bool {
        if !self.is_run {
            self.forget();
            return false;
        }
        for (piece, start) in self.pieces.iter_mut().zip(&mut self.starts) {
            std::mem::swap(&mut piece.fields.state, &mut start.state);
            start.put_motion(state, rows);
        }
        (self.is_current, self.is_ahead) = (true, true);
        true
    }

    /// Updates the committed state of the body from the pieces.
    pub(crate) fn catch_up(&mut self, state: &mut NodalState) {
        if std::mem::take(&mut self.is_ahead) {
            self.starts.iter().for_each(|start| start.put(state));
        }
    }

    /// The committed state; `state` is the body's older one.
    pub(crate) fn gathered(&self, state: &NodalState) -> NodalState {
        let mut whole = state.clone();
        self.starts.iter().for_each(|start| start.put(&mut whole));
        whole
    }

    /// Forgets the committed state, which has changed elsewhere.
    pub(super) fn forget(&mut self) {
        (self.is_current, self.is_ahead) = (false, false);
    }

    /// Cuts the body into this many pieces, however small.
    #[cfg(test)]
    pub(super) fn cut(&mut self, model: &Model, substeps: u32, count: usize) {
        *self = Partition::in_parts(model, substeps, count);
        self.cut_for = Some((substeps, count));
        assert!(!self.pieces.is_empty());
    }
}

/// Number of pieces that pays: one per thread with enough work, 0 for a body in which a step needs more than neighbouring nodes.
fn worthwhile(model: &Model, substeps: u32, threads: usize) -> usize {
    let layout = model.body.layout;
    let structured = model.body.connectivity.is_none() && !layout.periodic;
    let followed = !model.tractions.is_empty() || !model.motions.is_empty();
    if !structured || followed || model.wheel.is_some() || model.plastic().is_some() {
        return 0;
    }
    let work = u64::from(substeps) * model.mesh.elements() as u64;
    threads.min((work / WORTH_WAKING) as usize)
}
