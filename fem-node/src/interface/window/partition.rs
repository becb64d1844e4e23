//! The pieces of a body, and what they hold of it.

use super::extent::{Extent, WindowInput};
use super::pieces::Pieces;
use super::team::Team;
use crate::integrate::state::NodalState;
use crate::integrate::tally::Tally;
use crate::interface::window::committed::Committed;
use crate::model::Model;

/// Pieces that are cut when the first window is run in them.
#[derive(Clone, Debug, Default)]
pub(super) struct Partition {
    /// None where the body is stepped as a whole.
    pieces: Option<Pieces>,
    /// Steps and threads that they were cut for.
    cut_for: Option<(u32, usize)>,
    /// The last whole run was one of pieces.
    is_run: bool,
}

impl Partition {
    /// True if a window is run in pieces, which are made here. A repeat is run as the window was.
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
        if threads < 2 || !input.velocity.is_empty() {
            return false;
        }
        let known = |(most, of): (u32, usize)| input.substeps <= most && of == threads;
        if !self.cut_for.is_some_and(known) {
            self.catch_up(&mut committed.state);
            self.pieces = Pieces::new(model, input.substeps, threads);
            self.cut_for = Some((input.substeps, threads));
        }
        self.pieces.is_some()
    }

    /// Runs a window that they take, and enters their sums into those of the body.
    pub(super) fn run(
        &mut self,
        team: &Team,
        (model, committed): (&Model, &Committed),
        (input, extent): (&WindowInput, &Extent),
        tally: &mut Tally,
    ) {
        self.is_run = true;
        if let Some(pieces) = &mut self.pieces {
            pieces.run(team, model, committed, input, extent);
            pieces.enter(model.body.layout, tally);
        }
    }

    /// A window begins that is not run in pieces.
    pub(super) fn stand_aside(&mut self) {
        self.is_run = false;
    }

    /// Pieces that hold the end of the last window.
    pub(super) fn held(&self) -> Option<&Pieces> {
        self.pieces.as_ref().filter(|_| self.is_run)
    }

    /// Makes the end of the last window the committed state where they hold it; `state` gets the motion of some rows of nodes. False
    /// where they do not.
    pub(super) fn accept(&mut self, state: &mut NodalState, rows: &[usize]) -> bool {
        if let Some(pieces) = self.pieces.as_mut().filter(|_| self.is_run) {
            pieces.accept();
            pieces.put_motion(state, rows);
            return true;
        }
        self.forget();
        false
    }

    /// Brings the committed state of the body up to that of the pieces.
    pub(super) fn catch_up(&mut self, state: &mut NodalState) {
        self.pieces
            .iter_mut()
            .for_each(|pieces| pieces.catch_up(state));
    }

    /// The committed state where that of the body, which is given, is an older one.
    pub(super) fn ahead_of(&self, state: &NodalState) -> Option<NodalState> {
        let pieces = self.pieces.as_ref().filter(|pieces| pieces.is_ahead())?;
        let mut ahead = state.clone();
        pieces.put(&mut ahead);
        Some(ahead)
    }

    /// Forgets the committed state: it has become another one elsewhere.
    pub(super) fn forget(&mut self) {
        self.pieces.iter_mut().for_each(Pieces::forget);
    }

    /// Cuts the body into so many pieces, however small.
    #[cfg(test)]
    pub(super) fn cut(&mut self, model: &Model, substeps: u32, count: usize) {
        self.pieces = Pieces::in_parts(model, substeps, count);
        self.cut_for = Some((substeps, count));
        assert!(self.pieces.is_some());
    }
}
