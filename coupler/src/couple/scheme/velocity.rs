//! Velocities that are equal at the end of each window (Gravouil and Combescure 2001, with the wall for the coarse side).
//!
//! The velocity of the continuum's interface goes in a straight line from what it is to v; what the continuum answers is
//! the force at the end of the window, lambda = lambda_f + D v, exactly so if it is linear and D is its own impedance. With
//! C = H D^-1 and the motion H v in place of du the wall is told what [`super::dual_schur`] tells it,
//!
//! ```text
//! W_g = N C N^T / H^2,   a_g = N (H v_k - C lambda_k) / H,   v_k+1 = v_k + C (N^T F_g - lambda_k) / H
//! ```
//!
//! and the run along v_k+1 decides: C times what its force is off N^T F_g must be within the tolerance.
//!
//! H D = M_i + H^2/2 K_i + sum L L^T (1 - cos(omega H)) is never less than the lumped masses of the interface, so that C
//! exists for any window. Differentiated once, the continuum keeps W = a.(M - h^2/4 K).a / 2 + v.K v / 2 inside a window but
//! for the work a_s.(lambda - lambda_0) of the wall, a_s = (v - v_0) / H, and the implicit wall takes that very work in.
//! Where the line bends from one window to the next W loses M_i (a_s - a_s0)^2 / 2, and what h^2/8 a.K a jumps by. Hence W
//! does not grow for theta = 1 but by that term of h^2, while the mechanical energy itself may rise for a window. The *mean*
//! force of the window in place of that at its end has no such balance and is unstable.
//!
//! What it costs: the displacements of both sides differ by H (v - v_0) / 2, which does not accumulate, and the impulse on
//! the continuum is that of its own force along the line, not H lambda. Of several walls each takes the forces of the
//! others as they were in the run before, which takes many repeats where the continuum between them is nearly rigid.

use protocol::{Kind, Window};

use super::Coupling;
use super::outcome::Solved;
use crate::couple::conversation::Conversation;
use crate::error::Error;

/// What the continua answer that followed a velocity, by component.
pub(super) struct Reaction {
    /// At the end of the window (N).
    pub(super) force: Vec<f64>,
    /// Over the window (J).
    pub(super) work: Vec<f64>,
}

impl Coupling {
    pub(super) fn velocity(
        &mut self,
        conversation: &mut Conversation,
        mut window: Window,
    ) -> Result<Solved, Error> {
        let window_s = self.group.window_s(&window);
        let mut velocity = self.velocity.clone();
        let mut reaction = self.follow(conversation, &window, &velocity)?;
        loop {
            self.compliance
                .prepare(conversation, &self.group, &window)?;
            let carried = self.carried(&window, &reaction.force);
            let free = self.free_velocity(&window, &motion(&velocity, window_s), &carried);
            let answer = self.solve(conversation, &window, free)?;
            let starved = self.starved(&window, &answer);
            let force = self.group.mapping.force(&answer.force);
            let more = self.missing(&window, &force, &reaction);
            for (v, du) in velocity.iter_mut().zip(&more) {
                *v += du / window_s;
            }
            window.iteration += 1;
            reaction = self.follow(conversation, &window, &velocity)?;
            let increment = motion(&velocity, window_s);
            let more = self.missing(&window, &force, &reaction);
            let wanted: Vec<f64> = increment.iter().zip(&more).map(|(a, b)| a + b).collect();
            let open = self.open(&window, &wanted, &answer, ADVICE);
            let last = window.iteration >= self.rules.repeats_max || !starved.is_empty();
            if !open.is_empty() && !last {
                continue;
            }
            return Ok(Solved {
                window,
                increment,
                wanted,
                work: reaction.work,
                velocity: Some(velocity),
                inertia: Vec::new(),
                lambda: force,
                answer,
                faults: match starved.is_empty() {
                    true => open,
                    false => starved,
                },
            });
        }
    }

    /// C (F - lambda): how much further the nodes have to go for the force F at their end (m).
    fn missing(&self, window: &Window, force: &[f64], reaction: &Reaction) -> Vec<f64> {
        let pairs = force.iter().zip(&reaction.force);
        let missing: Vec<f64> = pairs.map(|(force, lambda)| force - lambda).collect();
        self.compliance.times(window.substeps, &missing)
    }

    /// All continua at once, along straight lines of velocities.
    pub(super) fn follow(
        &self,
        conversation: &mut Conversation,
        window: &Window,
        velocity: &[f64],
    ) -> Result<Reaction, Error> {
        self.tell_continua(conversation, window, Kind::PrescribeVelocity, velocity)?;
        self.hear_reaction(conversation, window)
    }

    pub(super) fn hear_reaction(
        &self,
        conversation: &mut Conversation,
        window: &Window,
    ) -> Result<Reaction, Error> {
        let components = 2 * self.group.nodes.len();
        let mut reaction = Reaction {
            force: Vec::with_capacity(components),
            work: Vec::with_capacity(components),
        };
        let mut fault = None;
        for side in &self.group.continua {
            let size = 2 * side.places.len();
            let window = side.window(window);
            match conversation.hear_exactly(side.peer, Kind::Reaction, &window, 3 * size) {
                Ok(numbers) => {
                    reaction.force.extend(&numbers[..size]);
                    reaction.work.extend(&numbers[2 * size..]);
                }
                // The others have answered too, and the window may be tried again.
                Err(error @ Error::NotFinite(_)) => fault = fault.or(Some(error)),
                Err(error) => return Err(error),
            }
        }
        fault.map_or(Ok(reaction), Err)
    }
}

const ADVICE: &str = "the continuum does not answer by its own impedance, as a nonlinear one does not, or bears several walls that feel each other; raise repeats_max, take scheme = \"dual-schur-secant\", lower substeps, or let on_not_converged = \"halve\" the window";

/// H v (m).
pub(super) fn motion(velocity: &[f64], window_s: f64) -> Vec<f64> {
    velocity.iter().map(|v| v * window_s).collect()
}
