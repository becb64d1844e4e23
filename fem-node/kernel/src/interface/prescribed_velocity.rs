//! Components whose velocity is prescribed, linear in time over a window, and their reactions.
//!
//! The acceleration of such a component is the constant a_s = (v_end - v_start) / H. A step without the reaction gives the acceleration a_0; the
//! reaction f changes it to a_s,
//!
//! ```text
//! f  = M (a_s - a_0)                       at the start of the window
//! f' = M (1 + b h c) (a_s - a_0')          after each step, c being the mass damping
//! ```
//!
//! its displacement u' = u + h v + h^2/2 a_s is then exact. The energies that the step has entered with a_0'
//! are corrected: -b h^2/2 da M da and b c' v' M du of [`crate::integrate`]. The reaction does the work [(1-b) f + b f'] du.

use crate::element::body::Body;
use crate::integrate::fields::StepFields;
use crate::integrate::state::NodalState;
use crate::scheme::Rule;

/// Components of prescribed velocity during a window.
#[derive(Clone, Debug)]
pub struct PrescribedVelocity {
    components: Vec<DrivenComponent>,
    /// Reaction on each component now (N), zero where it cannot move.
    pub force: Vec<f64>,
    /// Work of each reaction since the start of the window (J).
    pub work: Vec<f64>,
}

/// One component of prescribed velocity.
#[derive(Clone, Copy, Debug)]
struct DrivenComponent {
    index: usize,
    mass: f64,
    start: f64,
    end: f64,
    acceleration: f64,
    /// Its velocity now (m/s).
    velocity: f64,
}

impl PrescribedVelocity {
    /// Starts from the velocities of a state whose accelerations do not include the reactions: f = M (a_s - a_0).
    pub fn start(
        body: &Body,
        state: &mut NodalState,
        ends: &[(usize, f64)],
        window_s: f64,
    ) -> PrescribedVelocity {
        let component = |(index, end): &(usize, f64)| {
            let (index, start) = (*index, state.v[*index]);
            let moves = body.inverse_mass[index] > 0.0;
            DrivenComponent {
                index,
                // A fixed component needs no force from here.
                mass: if moves { body.mass[index] } else { 0.0 },
                start,
                end: if moves { *end } else { start },
                acceleration: if moves { (end - start) / window_s } else { 0.0 },
                velocity: start,
            }
        };
        let components: Vec<DrivenComponent> = ends.iter().map(component).collect();
        let mut force = Vec::with_capacity(components.len());
        for component in &components {
            let a = &mut state.a[component.index];
            force.push(component.mass * (component.acceleration - *a));
            *a = component.acceleration;
        }
        body.layout.repeat_period(&mut state.a);
        PrescribedVelocity {
            work: vec![0.0; components.len()],
            components,
            force,
        }
    }

    /// Corrects the components after a step, f' = M (1 + b h c) (a_s - a_0'); `share` of the window has passed.
    pub fn step(&mut self, body: &Body, rule: &Rule, fields: &mut StepFields, share: f64) {
        let (state, dissipated) = (&mut fields.state, &mut fields.dissipated);
        let (h, b) = (rule.scheme.step, rule.scheme.damping);
        let c = rule.damping.end;
        let reactions = self.force.iter_mut().zip(&mut self.work);
        for (component, (force, work)) in self.components.iter_mut().zip(reactions) {
            let (index, mass, a_s) = (component.index, component.mass, component.acceleration);
            let du = h * component.velocity + 0.5 * h * h * a_s;
            let missing = a_s - state.a[index];
            let needed = mass * (1.0 + b * h * c) * missing;
            *work += ((1.0 - b) * *force + b * needed) * du;
            if let Some(numerical) = dissipated.numerical.get_mut(index) {
                *numerical += 0.5 * b * h * h * mass * missing * missing;
            }
            if let Some(mass_damping) = dissipated.mass_damping.get_mut(index) {
                *mass_damping += b * c * (b * h * missing) * mass * du;
            }
            *force = needed;
            component.velocity = component.start + share * (component.end - component.start);
            state.a[index] = a_s;
            state.v[index] = component.velocity;
        }
        body.layout.repeat_period(&mut state.a);
        body.layout.repeat_period(&mut state.v);
    }
}
