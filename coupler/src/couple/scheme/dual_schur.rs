//! Dual Schur complement on displacement with a force that is constant in the window.
//!
//! The continuum's increment is du = du_free + C lambda, exactly so if it is linear and C holds its own columns. The other
//! side solves its contacts on the wall v_g = a_g + W_g p with a_g = N (du_k - C lambda_k) / H and W_g = N C N^T / H^2; its
//! forces F_g are given back as lambda = N^T F_g, and the run of the continuum under this very lambda decides:
//! |N du - H v_g| must be within the tolerance, whatever C was. Of several walls each takes the forces of the others as
//! they were in the run before: that is block Jacobi on a positive definite system of two blocks, which the same test
//! ends.

use protocol::{Kind, Window};

use super::Coupling;
use super::outcome::{Solved, work};
use crate::couple::conversation::Conversation;
use crate::error::Error;
use crate::scenario::Scheme;

impl Coupling {
    pub(super) fn dual_schur(
        &mut self,
        conversation: &mut Conversation,
        mut window: Window,
    ) -> Result<Solved, Error> {
        let secant = self.rules.scheme != Scheme::DualSchur;
        let repeats = match self.rules.scheme {
            Scheme::DualSchurCheap => 1,
            _ => self.rules.repeats_max,
        };
        let mut lambda = self.lambda.clone();
        self.compliance
            .prepare(conversation, &self.group, &window)?;
        self.tell_continua(conversation, &window, Kind::Advance, &lambda)?;
        // While the continua are at work.
        let mut carried = self.carried(&window, &lambda);
        let mut increment = self.hear_continua(conversation, &window)?;
        loop {
            let free = self.free_velocity(&window, &increment, &carried);
            let answer = self.solve(conversation, &window, free)?;
            let starved = self.starved(&window, &answer);
            let next = self.group.mapping.force(&answer.force);
            window.iteration += 1;
            let moved = self.advance(conversation, &window, &next)?;
            if secant {
                let s: Vec<f64> = next.iter().zip(&lambda).map(|(a, b)| a - b).collect();
                let y: Vec<f64> = moved.iter().zip(&increment).map(|(a, b)| a - b).collect();
                self.compliance.update(window.substeps, &s, &y);
            }
            (lambda, increment) = (next, moved);
            let open = self.open(&window, &increment, &answer, self.advice());
            let last = window.iteration >= repeats || !starved.is_empty();
            if !open.is_empty() && !last {
                self.compliance
                    .prepare(conversation, &self.group, &window)?;
                carried = self.carried(&window, &lambda);
                continue;
            }
            let faults = match self.rules.scheme {
                _ if !starved.is_empty() => starved,
                // One solve a window is what this scheme is; its gap is reported, not judged.
                Scheme::DualSchurCheap => Vec::new(),
                _ => open,
            };
            return Ok(Solved {
                window,
                wanted: increment.clone(),
                work: work(&lambda, &increment),
                increment,
                velocity: None,
                inertia: Vec::new(),
                lambda,
                answer,
                faults,
            });
        }
    }

    fn advice(&self) -> &'static str {
        match self.rules.scheme {
            Scheme::DualSchur => {
                "the compliance does not fit the continuum any more, as of a plastic one; take scheme = \"dual-schur-secant\", lower substeps, or accept with on_not_converged = \"accept\""
            }
            _ => {
                "lower substeps, raise repeats_max, or let on_not_converged = \"halve\" the window"
            }
        }
    }

    /// C lambda (m) of the forces that each wall bears.
    pub(super) fn carried(&self, window: &Window, lambda: &[f64]) -> Vec<Vec<f64>> {
        let of = |wall| {
            let own = self.group.borne_by(wall, lambda);
            self.compliance.times(window.substeps, &own)
        };
        (0..self.group.walls.len()).map(of).collect()
    }

    /// N (du - C lambda) / H: how the glued points would move without the contact forces of their own wall (m/s).
    pub(super) fn free_velocity(
        &self,
        window: &Window,
        increment: &[f64],
        carried: &[Vec<f64>],
    ) -> Vec<f64> {
        let window_s = self.group.window_s(window);
        let mut velocity = Vec::with_capacity(2 * self.group.points.len());
        for (side, carried) in self.group.walls.iter().zip(carried) {
            let free: Vec<f64> = increment
                .iter()
                .zip(carried)
                .map(|(du, c)| du - c)
                .collect();
            let motion = self.group.mapping.motion(&free);
            velocity.extend(side.of(&motion).iter().map(|v| v / window_s));
        }
        velocity
    }
}
