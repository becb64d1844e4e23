//! The moving state of a body.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::load::Load;
use crate::element::body::Body;
use crate::material::nonlinear::NonlinearLaw;
use crate::pack::line::Lines;

/// The state of the body, every field in the order of [`crate::element::layout::Layout`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NodalState {
    /// Displacement (m).
    pub u: Lines,
    /// Velocity (m/s).
    pub v: Lines,
    /// Internal force F(u) (N).
    pub force: Lines,
    /// Acceleration (m/s2); computed anew at the start of each window of a body without wheel.
    pub a: Lines,
    /// Force of the stiffness damping (N), empty until there is any.
    pub damping_force: Lines,
    /// History variables of a plastic body, empty for any other; see [`Body::plastic_strain`].
    pub history: Vec<f64>,
    /// Stress (Pa) that warmth would give each element if it could not expand, row after row: as the accelerations have it, and now. Empty without
    /// expansion.
    pub thermal: [Vec<f64>; 2],
}

impl NodalState {
    /// At rest, undeformed, without history.
    pub fn at_rest(body: &Body) -> NodalState {
        NodalState::at_rest_under(body, None)
    }

    /// At rest, undeformed, under a law that may be nonlinear.
    pub fn at_rest_under(body: &Body, law: Option<&NonlinearLaw>) -> NodalState {
        let zero = Lines::zeros(body.layout.len());
        let history = body.layout.rows * body.history_row_len(law);
        NodalState {
            u: zero.clone(),
            v: zero.clone(),
            force: zero.clone(),
            a: zero,
            history: vec![0.0; history],
            ..NodalState::default()
        }
    }

    /// Nodal fields: u, v, a, F, d.
    pub fn nodal_mut(&mut self) -> [&mut [f64]; 5] {
        [
            &mut self.u,
            &mut self.v,
            &mut self.a,
            &mut self.force,
            &mut self.damping_force,
        ]
    }

    /// The same, read-only.
    pub fn nodal(&self) -> [&[f64]; 5] {
        [&self.u, &self.v, &self.a, &self.force, &self.damping_force]
    }

    /// Copies the start of a window; the accelerations follow from it.
    pub fn restore(&mut self, start: &NodalState) {
        self.u.copy_from_slice(&start.u);
        self.v.copy_from_slice(&start.v);
        self.force.copy_from_slice(&start.force);
        self.history.copy_from_slice(&start.history);
        self.damping_force.clone_from(&start.damping_force);
        self.thermal.clone_from(&start.thermal);
    }

    /// Copies the start of a window, the accelerations included: contact forces do not jump there.
    pub fn resume(&mut self, start: &NodalState) {
        self.restore(start);
        self.a.copy_from_slice(&start.a);
    }

    /// Copies the components `theirs` of the start of a window to `part`; the accelerations follow from them.
    pub fn restore_part(&mut self, part: Range<usize>, start: &NodalState, theirs: Range<usize>) {
        let fields = [
            (&mut self.u, &start.u),
            (&mut self.v, &start.v),
            (&mut self.force, &start.force),
            (&mut self.damping_force, &start.damping_force),
        ];
        for (field, start) in fields {
            // Empty until something has been damped.
            match start.get(theirs.clone()) {
                Some(start) => field[part.clone()].copy_from_slice(start),
                None => field.get_mut(part.clone()).unwrap_or_default().fill(0.0),
            }
        }
    }

    /// a = M^-1 (f - F(u) - d) - c v of one component.
    pub fn acceleration(&self, body: &Body, damping: f64, load: &Load, k: usize) -> f64 {
        let w = body.inverse_mass[k];
        let a = w * (load.values[k] - self.force[k]) - damping * self.v[k];
        match self.damping_force.get(k) {
            Some(d) => a - w * d,
            None => a,
        }
    }
}
