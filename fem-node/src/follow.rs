//! Components whose velocity goes in a straight line over a window, and the force that this takes.
//!
//! The acceleration of such a component is the constant a_s = (v_end - v_start) / H. A step is done as if no force acted on
//! it, which gives it the acceleration a_0; the force that makes it a_s is what is left,
//!
//! ```text
//! f  = M (a_s - a_0)                       at the start of the window
//! f' = M (1 + b h c) (a_s - a_0')          after each step, c being the mass damping
//! ```
//!
//! its displacement u' = u + h v + h^2/2 a_s is then exact. What the step has entered into the energy sums with a_0' is put
//! right: -b h^2/2 da M da and b c' v' M du of [`crate::integrate`]. The force does the work [(1-b) f + b f'] du.

use crate::element::Body;
use crate::integrate::{RowSums, Rule, State};

/// Components on their way.
#[derive(Clone, Debug)]
pub(crate) struct Ramp {
    followers: Vec<Follower>,
    /// Force on each component now (N), zero where it cannot move.
    pub(crate) force: Vec<f64>,
    /// Work of each since the start of the window (J).
    pub(crate) work: Vec<f64>,
}

/// One component.
#[derive(Clone, Copy, Debug)]
struct Follower {
    index: usize,
    mass: f64,
    start: f64,
    end: f64,
    acceleration: f64,
    /// Its velocity now (m/s).
    velocity: f64,
}

impl Ramp {
    /// Sets out from the velocities of a state whose accelerations are those without these forces.
    pub(crate) fn start(
        body: &Body,
        state: &mut State,
        ends: &[(usize, f64)],
        window_s: f64,
    ) -> Ramp {
        let follower = |(index, end): &(usize, f64)| {
            let (index, start) = (*index, state.v[*index]);
            let moves = body.inverse_mass[index] > 0.0;
            Follower {
                index,
                // What is held needs no force from here.
                mass: if moves { body.mass[index] } else { 0.0 },
                start,
                end: if moves { *end } else { start },
                acceleration: if moves { (end - start) / window_s } else { 0.0 },
                velocity: start,
            }
        };
        let followers: Vec<Follower> = ends.iter().map(follower).collect();
        let mut force = Vec::with_capacity(followers.len());
        for follower in &followers {
            let a = &mut state.a[follower.index];
            force.push(follower.mass * (follower.acceleration - *a));
            *a = follower.acceleration;
        }
        body.layout().spread(&mut state.a);
        Ramp {
            work: vec![0.0; followers.len()],
            followers,
            force,
        }
    }

    /// Puts right what a step has made of the components; `share` of the window has passed.
    pub(crate) fn step(
        &mut self,
        body: &Body,
        rule: &Rule,
        state: &mut State,
        sums: &mut RowSums,
        share: f64,
    ) {
        let (h, b) = (rule.scheme.step, rule.scheme.damping);
        let c = rule.damping.end;
        let reactions = self.force.iter_mut().zip(&mut self.work);
        for (follower, (force, work)) in self.followers.iter_mut().zip(reactions) {
            let (index, mass, a_s) = (follower.index, follower.mass, follower.acceleration);
            let du = h * follower.velocity + 0.5 * h * h * a_s;
            let missing = a_s - state.a[index];
            let needed = mass * (1.0 + b * h * c) * missing;
            *work += ((1.0 - b) * *force + b * needed) * du;
            if b > 0.5 {
                sums.rotation += 0.5 * b * h * h * mass * missing * missing;
            }
            sums.damping += b * c * (b * h * missing) * mass * du;
            *force = needed;
            follower.velocity = follower.start + share * (follower.end - follower.start);
            state.a[index] = a_s;
            state.v[index] = follower.velocity;
        }
        body.layout().spread(&mut state.a);
        body.layout().spread(&mut state.v);
    }

    /// Work of all forces since the start of the window (J).
    pub(crate) fn total_work(&self) -> f64 {
        self.work.iter().sum()
    }
}
