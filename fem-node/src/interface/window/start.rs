//! The state from which the pieces of a body begin a window, each in its own columns.

use std::ops::Range;

use fem_kernel::integrate::cut::Cut;
use fem_kernel::integrate::state::NodalState;

/// The committed state in the own columns of a piece; the other columns are older.
#[derive(Clone, Debug)]
pub(super) struct PieceStart {
    pub(super) cut: Cut,
    pub(super) state: NodalState,
}

impl PieceStart {
    /// Takes its columns out of the state of the body.
    pub(super) fn take(&mut self, whole: &NodalState) {
        let (cut, own) = (&self.cut, &mut self.state);
        let damped = cut.piece.len().min(whole.damping_force.len());
        own.damping_force.resize(damped);
        let pairs = own.nodal_mut().into_iter().zip(whole.nodal());
        for (field, whole) in pairs {
            cut.take(whole, field);
        }
    }

    /// Puts its columns into the state of the body.
    pub(super) fn put(&self, whole: &mut NodalState) {
        let (cut, own) = (&self.cut, &self.state);
        let is_damped = !own.damping_force.is_empty();
        let damped = if is_damped { cut.body.len() } else { 0 };
        whole.damping_force.resize(damped);
        for (whole, field) in whole.nodal_mut().into_iter().zip(own.nodal()) {
            cut.put(field, whole);
        }
    }

    /// Puts displacements and velocities of its columns of some rows of nodes into the state of the body.
    pub(super) fn put_motion(&self, whole: &mut NodalState, rows: &[usize]) {
        let (cut, own) = (&self.cut, &self.state);
        let lines = rows.iter().flat_map(|row| [2 * row, 2 * row + 1]);
        for line in lines {
            let start = line * cut.body.stride;
            let to = start + cut.own.start..start + cut.own.end;
            let from = cut.in_line(line, &cut.own);
            whole.u[to.clone()].copy_from_slice(&own.u[from.clone()]);
            whole.v[to].copy_from_slice(&own.v[from]);
        }
    }

    /// Copies columns of one line (a component of a row of nodes) to the state of another piece: the columns that this piece owns and the other one
    /// has.
    pub(super) fn give(
        &self,
        line: usize,
        columns: &Range<usize>,
        to: &Cut,
        state: &mut NodalState,
    ) {
        let columns = columns.start.max(self.cut.own.start)..columns.end.min(self.cut.own.end);
        if columns.is_empty() {
            return;
        }
        let (from, to) = (self.cut.in_line(line, &columns), to.in_line(line, &columns));
        state.restore_part(to, &self.state, from);
    }
}
