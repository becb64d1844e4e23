//! Pieces of columns that threads step side by side for a whole window.
//!
//! Each piece has copies of as many columns beside its own as the window has steps. What it computes there is spoilt from the
//! cut on, one column with each step, and its own columns never are: no thread waits for another before the end of the window.
//! The numbers are those of the whole body, to the bit.
//!
//! The committed state stays in the pieces from one window to the next, where the threads have it at hand, and goes into that of
//! the body only when somebody asks for it.

use std::sync::Arc;

use super::extent::{Extent, WindowInput};
use super::piece::{Piece, PieceWindow};
use super::start::PieceStart;
use super::team::Team;
use crate::element::layout::Layout;
use crate::integrate::region::Region;
use crate::integrate::state::NodalState;
use crate::integrate::tally::{BLOCK, Tally};
use crate::interface::window::committed::Committed;
use crate::model::Model;

/// Steps of elements in a window for each thread, below which waking it costs more than it saves.
const WORTH_WAKING: u64 = 25_000;

/// Largest share of its own columns that a piece may have besides, on average over the window.
const OVERLAP_MAX: f64 = 0.4;

/// Pieces of a body.
#[derive(Clone, Debug)]
pub(super) struct Pieces {
    pieces: Vec<Piece>,
    /// States from which they begin a window.
    starts: Vec<PieceStart>,
    /// Own columns of each but the last one.
    size: usize,
    /// The starts are the committed state.
    is_current: bool,
    /// The state of the body is older than they are.
    is_ahead: bool,
    /// Region whose rings the pieces record.
    region: Option<Arc<Region>>,
}

impl Pieces {
    /// One piece for each thread, where that pays; none for a body that needs more than neighbours in a step.
    pub(super) fn new(model: &Model, substeps: u32, threads: usize) -> Option<Pieces> {
        let layout = model.body.layout;
        let structured = model.body.connectivity.is_none() && !layout.is_periodic();
        let followed = !model.tractions.is_empty() || !model.motions.is_empty();
        if !structured || followed || model.wheel.is_some() || model.plastic().is_some() {
            return None;
        }
        let work = u64::from(substeps) * model.mesh.elements() as u64;
        let threads = threads.min((work / WORTH_WAKING) as usize);
        Pieces::in_parts(model, substeps, threads)
    }

    /// So many pieces for windows of up to so many steps, unless they would overlap too much.
    pub(super) fn in_parts(model: &Model, substeps: u32, count: usize) -> Option<Pieces> {
        let nodes = model.body.layout.nodes_in_row;
        let size = nodes.div_ceil(count.max(1)).next_multiple_of(BLOCK);
        if count < 2 || f64::from(substeps) > OVERLAP_MAX * size as f64 {
            return None;
        }
        // A column beside those that are spoilt is read at the first step.
        let overlap = (substeps as usize + 1).next_multiple_of(BLOCK);
        let cut = |(index, first): (usize, usize)| {
            Piece::new(model, index, first..(first + size).min(nodes), overlap)
        };
        let pieces: Vec<Piece> = (0..nodes).step_by(size).enumerate().map(cut).collect();
        Some(Pieces {
            starts: pieces.iter().map(Piece::start).collect(),
            pieces,
            size,
            is_current: false,
            is_ahead: false,
            region: None,
        })
    }

    /// Runs a window or repeats it, recording the rings of a region.
    pub(super) fn run(
        &mut self,
        team: &Team,
        model: &Model,
        committed: &Committed,
        input: &WindowInput,
        extent: &Extent,
    ) {
        self.follow(extent.region());
        if !self.is_current {
            let starts = self.starts.iter_mut();
            starts.for_each(|start| start.take(&committed.state));
            self.is_current = true;
        }
        let window = PieceWindow {
            model,
            steps: committed.steps,
            input,
            starts: &self.starts,
        };
        let repeats = extent.is_part();
        team.side_by_side(&mut self.pieces, |piece| {
            if repeats {
                piece.repeat(window);
            } else {
                piece.run(window);
            }
        });
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

    /// Enters the sums of all pieces into those of the body.
    pub(super) fn enter(&self, layout: Layout, tally: &mut Tally) {
        for Piece {
            tally: its, cut, ..
        } in &self.pieces
        {
            tally.take(layout, (its, cut.piece), &cut.own, cut.columns.start);
        }
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

    /// Makes the end of the last window the committed state.
    pub(super) fn accept(&mut self) {
        for (piece, start) in self.pieces.iter_mut().zip(&mut self.starts) {
            std::mem::swap(&mut piece.fields.state, &mut start.state);
        }
        (self.is_current, self.is_ahead) = (true, true);
    }

    /// The committed state has become another one.
    pub(super) fn forget(&mut self) {
        (self.is_current, self.is_ahead) = (false, false);
    }

    /// True where the committed state is in the pieces only.
    pub(super) fn is_ahead(&self) -> bool {
        self.is_ahead
    }

    /// Puts the committed state into that of the body.
    pub(super) fn put(&self, state: &mut NodalState) {
        self.starts.iter().for_each(|start| start.put(state));
    }

    /// The same, after which the body has it too.
    pub(super) fn catch_up(&mut self, state: &mut NodalState) {
        if self.is_ahead {
            self.put(state);
            self.is_ahead = false;
        }
    }

    /// Puts committed displacements and velocities of some rows of nodes into the state of the body.
    pub(super) fn put_motion(&self, state: &mut NodalState, rows: &[usize]) {
        let starts = self.starts.iter();
        starts.for_each(|start| start.put_motion(state, rows));
    }
}
