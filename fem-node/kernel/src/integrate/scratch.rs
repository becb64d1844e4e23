//! Buffers for the forces of a strip of rows, and copies of the rows beside it.

use super::state::NodalState;
use crate::element::body::Body;
use crate::element::row_forces::RowForces;
use crate::material::nonlinear::NonlinearLaw;
use crate::scheme::NewmarkScheme;

/// Buffers of one strip of rows.
#[derive(Clone, Debug)]
pub(super) struct Scratch {
    pub(super) elements: RowForces,
    pub(super) force: Vec<f64>,
    pub(super) acceleration: Vec<f64>,
    /// Loads less the stiffness damping.
    pub(super) net: Vec<f64>,
    pub(super) above: Vec<f64>,
    pub(super) below: Vec<f64>,
    pub(super) increments: Increments,
    /// Copy of the history of the elements above the strip, whose owner changes it at the same time; empty under a law without history.
    pub(super) history: Vec<f64>,
}

/// Increments of displacements, a row each; empty under a law without history.
#[derive(Clone, Debug, Default)]
pub(super) struct Increments {
    /// Increments of the current row.
    pub(super) here: Vec<f64>,
    /// Increments of the row below it.
    pub(super) next: Vec<f64>,
    pub(super) above: Vec<f64>,
    pub(super) below: Vec<f64>,
}

impl Scratch {
    pub(super) fn new(body: &Body, law: Option<&NonlinearLaw>) -> Scratch {
        let zero = vec![0.0; body.layout.row_len()];
        let history = body.history_row_len(law);
        let increment = vec![0.0; if history > 0 { zero.len() } else { 0 }];
        Scratch {
            elements: RowForces::new(body.layout),
            force: zero.clone(),
            acceleration: zero.clone(),
            net: zero.clone(),
            above: zero.clone(),
            below: zero,
            increments: Increments {
                here: increment.clone(),
                next: increment.clone(),
                above: increment.clone(),
                below: increment,
            },
            history: vec![0.0; history],
        }
    }
}

impl Increments {
    /// Goes down by one row.
    pub(super) fn advance(&mut self) {
        std::mem::swap(&mut self.here, &mut self.next);
    }
}

/// Copies the rows beside `first .. end` as they will be after the prediction, and the history of the elements above.
pub(super) fn copy_neighbours(
    body: &Body,
    scheme: &NewmarkScheme,
    state: &NodalState,
    [first, end]: [usize; 2],
    buffers: &mut Scratch,
) {
    let copy = |row: usize, u: &mut [f64], increments: &mut [f64]| {
        let row = body.layout.row(row);
        let rates = || state.v[row.clone()].iter().zip(&state.a[row.clone()]);
        for (copy, (u, (v, a))) in u.iter_mut().zip(state.u[row.clone()].iter().zip(rates())) {
            *copy = scheme.predicted(*u, *v, *a);
        }
        for (copy, (v, a)) in increments.iter_mut().zip(rates()) {
            *copy = scheme.increment(*v, *a);
        }
    };
    if first > 0 {
        copy(first - 1, &mut buffers.above, &mut buffers.increments.above);
        let size = buffers.history.len();
        let above = (first - 1) * size..first * size;
        buffers.history.copy_from_slice(&state.history[above]);
    }
    if end < body.layout.node_rows {
        copy(end, &mut buffers.below, &mut buffers.increments.below);
    }
}
