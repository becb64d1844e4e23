//! The fields that a step reads and changes.

use std::ops::Range;

use super::dissipation::{Dissipated, Mechanisms};
use super::load::Load;
use super::state::NodalState;
use crate::element::body::Body;
use crate::material::nonlinear::NonlinearLaw;
use crate::pack::vectorised;

/// State of a body, the forces applied to it, and the energies that it has dissipated in the current window.
#[derive(Clone, Debug, Default)]
pub struct StepFields {
    /// Displacements, velocities, accelerations, internal forces and histories.
    pub state: NodalState,
    /// Applied forces.
    pub load: Load,
    /// Energies dissipated in the window.
    pub dissipated: Dissipated<Vec<f64>>,
}

impl StepFields {
    /// A body at rest, undeformed and without load, which counts these mechanisms.
    pub fn at_rest(body: &Body, law: Option<&NonlinearLaw>, counted: Mechanisms) -> StepFields {
        StepFields {
            state: NodalState::at_rest_under(body, law),
            load: Load::none(body),
            dissipated: Dissipated::new(body.layout, counted),
        }
    }

    /// a = M^-1 (f - F(u) - d) - c v
    pub fn accelerate(&mut self, body: &Body, damping: f64) {
        for row in 0..body.layout.node_rows {
            self.accelerate_part(body, damping, body.layout.row(row));
        }
        body.layout.repeat_period(&mut self.state.a);
    }

    /// The same for some components of one row.
    pub fn accelerate_part(&mut self, body: &Body, damping: f64, part: Range<usize>) {
        let StepFields { state, load, .. } = self;
        let row = body.layout.row_of(part.start);
        let first = body.layout.row(row).start;
        let loads = &load.row(row)[part.start - first..part.end - first];
        let (v, internal) = (&state.v[part.clone()], &state.force[part.clone()]);
        let (a, w) = (&mut state.a[part.clone()], &body.inverse_mass[part.clone()]);
        let damped = state.damping_force.get(part);
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
}
