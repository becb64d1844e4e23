//! Room for the forces of a block of rows, and copies of the rows beside it.

use super::scheme::Scheme;
use super::state::State;
use crate::element::{Body, RowForces};
use crate::material::point::PointLaw;

/// Room for the forces of one block of rows.
#[derive(Clone, Debug)]
pub(super) struct Scratch {
    pub(super) elements: RowForces,
    pub(super) force: Vec<f64>,
    pub(super) acceleration: Vec<f64>,
    /// Loads less the stiffness damping.
    pub(super) net: Vec<f64>,
    pub(super) above: Vec<f64>,
    pub(super) below: Vec<f64>,
    pub(super) memory: Memory,
}

impl Scratch {
    pub(super) fn new(body: &Body) -> Scratch {
        let zero = vec![0.0; body.layout().row_len()];
        Scratch {
            elements: RowForces::new(body.layout()),
            force: zero.clone(),
            acceleration: zero.clone(),
            net: zero.clone(),
            above: zero.clone(),
            below: zero,
            memory: Memory::default(),
        }
    }
}

/// What a block needs besides when the points remember: increments of displacements, and a copy of the histories
/// above it, whose owner changes them at the same time. Empty when they do not.
#[derive(Clone, Debug, Default)]
pub(super) struct Memory {
    /// Increments of the row at hand and of the one below it.
    pub(super) here: Vec<f64>,
    pub(super) next: Vec<f64>,
    pub(super) above: Vec<f64>,
    pub(super) below: Vec<f64>,
    pub(super) history: Vec<f64>,
}

impl Memory {
    pub(super) fn new(body: &Body, law: &PointLaw) -> Memory {
        let zero = match law.plastic {
            Some(_) => vec![0.0; body.layout().row_len()],
            None => Vec::new(),
        };
        Memory {
            here: zero.clone(),
            next: zero.clone(),
            above: zero.clone(),
            below: zero,
            history: vec![0.0; body.history_row_len(law)],
        }
    }

    /// Goes down by one row.
    pub(super) fn advance(&mut self) {
        std::mem::swap(&mut self.here, &mut self.next);
    }
}

pub(super) fn copy_neighbours(
    body: &Body,
    scheme: &Scheme,
    state: &State,
    [first, end]: [usize; 2],
    room: &mut Scratch,
) {
    let memory = &mut room.memory;
    if first > 0 {
        predict_copy(body, scheme, state, first - 1, &mut room.above);
        increment_copy(body, scheme, state, first - 1, &mut memory.above);
        let size = memory.history.len();
        let above = (first - 1) * size..first * size;
        memory.history.copy_from_slice(&state.history[above]);
    }
    if end < body.layout().node_rows() {
        predict_copy(body, scheme, state, end, &mut room.below);
        increment_copy(body, scheme, state, end, &mut memory.below);
    }
}

fn predict_copy(body: &Body, scheme: &Scheme, state: &State, row: usize, into: &mut [f64]) {
    let row = body.layout().row(row);
    let (u, v, a) = (&state.u[row.clone()], &state.v[row.clone()], &state.a[row]);
    for (copy, ((u, v), a)) in into.iter_mut().zip(u.iter().zip(v).zip(a)) {
        *copy = scheme.predicted(*u, *v, *a);
    }
}

/// The increments that [`predict_copy`] adds; `into` is empty where nobody asks for them.
fn increment_copy(body: &Body, scheme: &Scheme, state: &State, row: usize, into: &mut [f64]) {
    let row = body.layout().row(row);
    let rates = state.v[row.clone()].iter().zip(&state.a[row]);
    for (copy, (v, a)) in into.iter_mut().zip(rates) {
        *copy = scheme.increment(*v, *a);
    }
}
