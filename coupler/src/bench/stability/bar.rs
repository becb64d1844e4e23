//! The continuum of the bench, stepped element by element. Spacing, element mass and element stiffness are one.

use nalgebra::{DMatrix, DVector};

use crate::scheme::predict::response::{PrescribedResponse, Response, matrix_power};

/// An elastic bar of unit elements, held at its far end, coupled at the other; explicit steps without damping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bar {
    /// Elements.
    pub elements: usize,
    /// Step (s), 1 being the stability limit.
    pub step_s: f64,
}

/// The end node has the half mass of its one element.
pub(super) const END_MASS_KG: f64 = 0.5;

/// Displacements (m) and velocities (m/s) of the free nodes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct State {
    pub(super) u: Vec<f64>,
    pub(super) v: Vec<f64>,
}

impl Bar {
    /// Stability limit of the step (s): omega_max is 2 for unit masses and springs.
    pub const LIMIT_S: f64 = 1.0;

    /// First period (s): omega_1 = 2 sin(pi / (4 n)).
    pub fn first_period_s(&self) -> f64 {
        let angle = std::f64::consts::PI / (4 * self.elements) as f64;
        std::f64::consts::PI / angle.sin()
    }

    /// The window of `substeps` steps as a matrix: one step for each unit state, then squared up.
    pub fn response(&self, substeps: u32) -> Response {
        let n = self.elements;
        let step = self.step_matrix(|state, force| self.run(state, force, 1));
        let window = matrix_power(&step, substeps);
        let mut place = DVector::zeros(2 * n);
        place[n - 1] = 1.0;
        Response {
            carry: window.view((0, 0), (2 * n, 2 * n)).into_owned(),
            push: window.column(2 * n).rows(0, 2 * n).into_owned(),
            place,
            prescribed: self.prescribed(substeps),
        }
    }

    /// The same along a velocity: one step for each unit state and for a unit acceleration of the end.
    fn prescribed(&self, substeps: u32) -> PrescribedResponse {
        let n = self.elements;
        let step = self.step_matrix(|state, acceleration| {
            self.run_prescribed(state, acceleration, 1);
        });
        let mut pull = DVector::zeros(2 * n);
        pull[n - 1] = 1.0;
        if n > 1 {
            pull[n - 2] = -1.0;
        }
        PrescribedResponse::new(step, substeps, END_MASS_KG, pull)
    }

    /// One step as a matrix: done for each unit state, and for a unit of what acts on the end.
    fn step_matrix(&self, act: impl Fn(&mut State, f64)) -> DMatrix<f64> {
        let n = self.elements;
        let size = 2 * n + 1;
        let mut step = DMatrix::identity(size, size);
        for column in 0..size {
            let unit = |index: usize| if index == column { 1.0 } else { 0.0 };
            let mut state = State {
                u: (0..n).map(unit).collect(),
                v: (n..2 * n).map(unit).collect(),
            };
            act(&mut state, unit(2 * n));
            let moved = state.u.iter().chain(&state.v);
            for (row, value) in moved.enumerate() {
                step[(row, column)] = *value;
            }
        }
        step
    }

    fn accelerations(&self, u: &[f64], force: f64) -> Vec<f64> {
        let n = self.elements;
        (0..n)
            .map(|i| {
                let left = if i > 0 { u[i - 1] } else { 0.0 };
                if i + 1 < n {
                    left + u[i + 1] - 2.0 * u[i]
                } else {
                    (left - u[i] + force) / END_MASS_KG
                }
            })
            .collect()
    }

    /// Steps under a constant force on the end.
    pub(super) fn run(&self, state: &mut State, force: f64, substeps: u32) {
        self.steps(state, substeps, |u| self.accelerations(u, force));
    }

    /// Steps with a constant acceleration of the end; returns the force that this takes after them (N), and its work (J).
    pub(super) fn run_prescribed(
        &self,
        state: &mut State,
        acceleration: f64,
        substeps: u32,
    ) -> (f64, f64) {
        let end = self.elements - 1;
        let (mut force, mut place, mut work) = (0.0, state.u[end], 0.0);
        self.steps(state, substeps, |u| {
            let mut a = self.accelerations(u, 0.0);
            let new = END_MASS_KG * (acceleration - a[end]);
            work += 0.5 * (force + new) * (u[end] - place);
            (force, place) = (new, u[end]);
            a[end] = acceleration;
            a
        });
        (force, work)
    }

    fn steps(
        &self,
        state: &mut State,
        substeps: u32,
        mut accelerations: impl FnMut(&[f64]) -> Vec<f64>,
    ) {
        let h = self.step_s;
        let mut a = accelerations(&state.u);
        for _ in 0..substeps {
            for (u, (v, a)) in state.u.iter_mut().zip(state.v.iter().zip(&a)) {
                *u += h * v + 0.5 * h * h * a;
            }
            let next = accelerations(&state.u);
            for (v, (old, new)) in state.v.iter_mut().zip(a.iter().zip(&next)) {
                *v += 0.5 * h * (old + new);
            }
            a = next;
        }
    }
}
