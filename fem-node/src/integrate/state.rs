//! The moving state of a body.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::load::Load;
use crate::element::body::Body;
use crate::material::nonlinear::NonlinearLaw;
use crate::pack::line::Lines;
use crate::pack::vectorised;

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
    /// Force of the stiffness damping (N), empty where nothing has been damped so.
    pub damping_force: Lines,
    /// History variables of a plastic body, empty for any other; see [`Body::plastic_strain`].
    pub history: Vec<f64>,
}

impl NodalState {
    /// At rest, undeformed, without history.
    pub fn at_rest(body: &Body) -> NodalState {
        NodalState::at_rest_under(body, None)
    }

    /// At rest, undeformed, under a law that may be nonlinear.
    pub fn at_rest_under(body: &Body, law: Option<&NonlinearLaw>) -> NodalState {
        let zero = Lines::zeros(body.layout.len());
        let rows = body.layout.rows;
        let history = law.map_or(0, |law| rows * body.history_row_len(law));
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
    pub(crate) fn nodal_mut(&mut self) -> [&mut [f64]; 5] {
        [
            &mut self.u,
            &mut self.v,
            &mut self.a,
            &mut self.force,
            &mut self.damping_force,
        ]
    }

    /// The same, to be read.
    pub(crate) fn nodal(&self) -> [&[f64]; 5] {
        [&self.u, &self.v, &self.a, &self.force, &self.damping_force]
    }

    /// Takes over the start of a window; the accelerations follow from it.
    pub fn restore(&mut self, start: &NodalState) {
        self.u.copy_from_slice(&start.u);
        self.v.copy_from_slice(&start.v);
        self.force.copy_from_slice(&start.force);
        self.history.copy_from_slice(&start.history);
        self.damping_force.clone_from(&start.damping_force);
    }

    /// Takes over the start of a window, the accelerations included: contact forces do not jump there.
    pub(crate) fn resume(&mut self, start: &NodalState) {
        self.restore(start);
        self.a.copy_from_slice(&start.a);
    }

    /// a = M^-1 (f - F(u) - d) - c v
    pub(crate) fn accelerate(&mut self, body: &Body, damping: f64, load: &Load) {
        let forces = load.values.iter().zip(&self.force).zip(&body.inverse_mass);
        for ((a, v), ((f, internal), w)) in self.a.iter_mut().zip(&self.v).zip(forces) {
            *a = w * (f - internal) - damping * v;
        }
        let damped = self.damping_force.iter().zip(&body.inverse_mass);
        for (a, (d, w)) in self.a.iter_mut().zip(damped) {
            *a -= w * d;
        }
        body.layout.repeat_period(&mut self.a);
    }

    /// The same of some components of one row.
    pub(crate) fn accelerate_part(
        &mut self,
        body: &Body,
        damping: f64,
        load: &Load,
        part: Range<usize>,
    ) {
        let row = body.layout.row_of(part.start);
        let first = body.layout.row(row).start;
        let loads = &load.row(row)[part.start - first..part.end - first];
        let (v, internal) = (&self.v[part.clone()], &self.force[part.clone()]);
        let (a, w) = (&mut self.a[part.clone()], &body.inverse_mass[part.clone()]);
        let damped = self.damping_force.get(part);
        vectorised!({
            let forces = loads.iter().zip(internal).zip(w);
            for ((a, v), ((f, internal), w)) in a.iter_mut().zip(v).zip(forces) {
                *a = w * (f - internal) - damping * v;
            }
            for (a, (d, w)) in a.iter_mut().zip(damped.unwrap_or_default().iter().zip(w)) {
                *a -= w * d;
            }
        });
    }

    /// The same of one component.
    pub(crate) fn acceleration(&self, body: &Body, damping: f64, load: &Load, k: usize) -> f64 {
        let w = body.inverse_mass[k];
        let a = w * (load.values[k] - self.force[k]) - damping * self.v[k];
        match self.damping_force.get(k) {
            Some(d) => a - w * d,
            None => a,
        }
    }
}
