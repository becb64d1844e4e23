//! The bar under prescribed velocities of its coupled nodes: their acceleration is the constant a_s = (v_end - v_0) / H, and
//! the force for it is M (a_s - a), where a is the acceleration without that force.

use protocol::Reaction;

use super::{Bar, State};

impl Bar {
    /// D (kg/s) over both components of the coupled nodes, column after column; component 1 does not move.
    pub(super) fn resists(&self, substeps: u32) -> Vec<f64> {
        let elastic = self.elastic();
        let size = 2 * self.coupled.len();
        let mut matrix = Vec::with_capacity(size * size);
        for column in 0..size {
            let mut velocity = vec![0.0; size];
            velocity[column] = 1.0;
            matrix.extend(match column % 2 {
                0 => {
                    let mut rest = elastic.at_rest();
                    elastic.lead(&mut rest, &velocity, substeps).force
                }
                _ => vec![0.0; size],
            });
        }
        matrix
    }

    /// Steps in which the velocity of each coupled node changes linearly to `velocity`; the caller fills in the increments.
    pub(super) fn lead(&self, state: &mut State, velocity: &[f64], substeps: u32) -> Reaction {
        let (h, b) = (self.config.step_s, self.config.damping);
        let window_s = h * f64::from(substeps);
        let ends = self.coupled.iter().zip(velocity.iter().step_by(2));
        let led: Vec<(usize, f64)> = ends
            .map(|(node, end)| (*node, (end - state.v[*node]) / window_s))
            .collect();
        let size = velocity.len();
        let (mut a, mut force) = self.led_acceleration(state, &led);
        let mut work = vec![0.0; size];
        for _ in 0..substeps {
            let before = state.u.clone();
            for (u, (v, a)) in state.u.iter_mut().zip(state.v.iter().zip(&a)) {
                *u += h * v + 0.5 * h * h * a;
            }
            self.yield_where_due(&state.u, &mut state.plastic);
            let (next, new) = self.led_acceleration(state, &led);
            for (v, (old, new)) in state.v.iter_mut().zip(a.iter().zip(&next)) {
                *v += h * ((1.0 - b) * old + b * new);
            }
            for (i, (node, _)) in led.iter().enumerate() {
                let du = state.u[*node] - before[*node];
                work[2 * i] += ((1.0 - b) * force[i] + b * new[i]) * du;
            }
            (a, force) = (next, new);
        }
        let mut both = vec![0.0; size];
        for (i, force) in force.iter().enumerate() {
            both[2 * i] = *force;
        }
        Reaction {
            force: both,
            increment: vec![0.0; size],
            work,
        }
    }

    /// Accelerations, with the given values at the led nodes, and the force on each led node (N).
    fn led_acceleration(&self, state: &State, led: &[(usize, f64)]) -> (Vec<f64>, Vec<f64>) {
        let mut a = self.acceleration(&state.u, &state.plastic, &[]);
        let force = led.iter().map(|(node, given)| {
            let force = self.mass[*node] * (given - a[*node]);
            a[*node] = *given;
            force
        });
        let force = force.collect();
        (a, force)
    }
}
