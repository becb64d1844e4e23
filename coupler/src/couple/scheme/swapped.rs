//! The roles of [`super::fixed_point`] swapped: the wall takes forces (Neumann side), the continuum takes motion (Dirichlet
//! side).
//!
//! The continuum's velocity goes in a straight line from v_0 to v, as in [`super::velocity`], and lambda is the force that
//! it takes at the end. The points of the wall ride on the line of the nodes and push it by F_g; with their own masses M_p,
//! M_n = N^T M_p N and -lambda on the line its velocity at the end is that of one implicit step,
//!
//! ```text
//! v' = v_0 + M_n^-1 (H N^T F_g - H lambda),   v_g = N v',   v <- accelerated (v, v')
//! ```
//!
//! until H N (v - v') is within the tolerance. With p = H F_g the wall is told just that as its free velocity and its
//! compliance: a_g = N (v_0 - H M_n^-1 lambda), W_g = N M_n^-1 N^T, which is what [`super::dual_schur`] tells it with
//! C = H^2 M_n^-1. What cannot move of the continuum cannot on the line.
//!
//! What it comes to is scheme `velocity` for a continuum that is M_n heavier: the masses of the points are a part of the
//! model, which they are not where the wall follows. A repeat contracts by |1 - omega (1 + 1 / (C S))| with C = H D^-1,
//! D the impedance of the continuum, and S what the wall with its points resists: where the wall is heavy the continuum is
//! a good follower, and the added mass of Causin, Gerbeau and Nobile (2005) works the other way round (relaxations: Kuettler
//! and Wall 2008).
//!
//! The points' own inertia counts to the wall: what the nodes are given is F_g - M_p (v_g - N v_0) / H.

use protocol::{Kind, Window};

use super::Coupling;
use super::acceleration::Accelerator;
use super::outcome::{Answer, Solved};
use super::velocity::{Reaction, motion};
use crate::couple::conversation::Conversation;
use crate::error::Error;
use crate::scenario::Scheme;

/// What the walls do under a force.
struct Pushed {
    /// With the forces that are left for the nodes.
    answer: Answer,
    /// What the masses of the points take of those of the walls (N).
    inertia: Vec<f64>,
    /// v' (m/s).
    velocity: Vec<f64>,
}

const ADVICE: &str = "the fixed point was not reached; raise repeats_max, take acceleration = \"iqn-ils\", lower relaxation, or take dirichlet = \"wall\" for a wall that is light beside the continuum";

impl Coupling {
    /// One pass: the continuum follows the velocity that the walls had at the end of the window before, and they take its
    /// force, or both at once, each with what the other did one window before. Nothing is repeated and no gap is judged.
    pub(super) fn swapped_staggered(
        &mut self,
        conversation: &mut Conversation,
        window: Window,
    ) -> Result<Solved, Error> {
        self.compliance
            .prepare(conversation, &self.group, &window)?;
        let followed = self.velocity.clone();
        let (reaction, pushed) = match self.rules.scheme {
            Scheme::StaggeredParallel => self.at_once(conversation, &window, &followed)?,
            _ => self.one_by_one(conversation, &window, &followed)?,
        };
        let window_s = self.group.window_s(&window);
        let faults = self.starved(&window, &pushed.answer);
        Ok(Solved {
            wanted: motion(&followed, window_s),
            increment: motion(&pushed.velocity, window_s),
            lambda: self.acting(&window, &reaction, &pushed.answer),
            work: reaction.work,
            velocity: Some(pushed.velocity),
            inertia: pushed.inertia,
            answer: pushed.answer,
            faults,
            window,
        })
    }

    /// v -> v'(lambda(v)), accelerated, until both are the same.
    pub(super) fn swapped_fixed_point(
        &mut self,
        conversation: &mut Conversation,
        mut window: Window,
    ) -> Result<Solved, Error> {
        self.compliance
            .prepare(conversation, &self.group, &window)?;
        let window_s = self.group.window_s(&window);
        let mut accelerator = Accelerator::new(self.rules.acceleration, self.rules.relaxation);
        let mut velocity = self.velocity.clone();
        if self.rules.scheme == Scheme::FixedPointParallel {
            // No answer to this velocity, so that it says nothing of the fixed point's own slope.
            let (_, pushed) = self.at_once(conversation, &window, &velocity)?;
            for (v, answer) in velocity.iter_mut().zip(&pushed.velocity) {
                *v += self.rules.relaxation * (answer - *v);
            }
            window.iteration += 1;
        }
        loop {
            let (reaction, pushed) = self.one_by_one(conversation, &window, &velocity)?;
            let starved = self.starved(&window, &pushed.answer);
            let increment = motion(&velocity, window_s);
            let open = self.open(&window, &increment, &pushed.answer, ADVICE);
            let last = window.iteration >= self.rules.repeats_max || !starved.is_empty();
            // A tolerance above what a window changes would else keep the velocity of the window before.
            if (!open.is_empty() || window.iteration == 0) && !last {
                velocity = accelerator.next(&velocity, &pushed.velocity);
                window.iteration += 1;
                continue;
            }
            return Ok(Solved {
                wanted: increment.clone(),
                increment,
                lambda: self.acting(&window, &reaction, &pushed.answer),
                work: reaction.work,
                velocity: Some(velocity),
                inertia: pushed.inertia,
                answer: pushed.answer,
                faults: match starved.is_empty() {
                    true => open,
                    false => starved,
                },
                window,
            });
        }
    }

    /// The continua along a velocity, then the walls under the force that this takes.
    fn one_by_one(
        &mut self,
        conversation: &mut Conversation,
        window: &Window,
        velocity: &[f64],
    ) -> Result<(Reaction, Pushed), Error> {
        let reaction = self.follow(conversation, window, velocity)?;
        let pushed = self.push(conversation, window, &reaction.force)?;
        Ok((reaction, pushed))
    }

    /// Both at once, the walls under the force of the window before.
    fn at_once(
        &mut self,
        conversation: &mut Conversation,
        window: &Window,
        velocity: &[f64],
    ) -> Result<(Reaction, Pushed), Error> {
        self.tell_continua(conversation, window, Kind::PrescribeVelocity, velocity)?;
        let pushed = self.push(conversation, window, &self.lambda.clone());
        let reaction = self.hear_reaction(conversation, window);
        Ok((reaction?, pushed?))
    }

    /// The walls with -lambda (N) on the line of the nodes.
    fn push(
        &mut self,
        conversation: &mut Conversation,
        window: &Window,
        lambda: &[f64],
    ) -> Result<Pushed, Error> {
        let window_s = self.group.window_s(window);
        let carried = self.carried(window, lambda);
        let free = self.free_velocity(window, &motion(&self.velocity, window_s), &carried);
        let mut answer = self.solve(conversation, window, free)?;
        let force = self.group.mapping.force(&answer.force);
        let pairs = force.iter().zip(lambda);
        let pushing: Vec<f64> = pairs.map(|(force, lambda)| force - lambda).collect();
        let gained = self.compliance.times(window.substeps, &pushing);
        let velocity = self.velocity.iter().zip(&gained);
        let velocity = velocity.map(|(v_0, du)| v_0 + du / window_s).collect();
        let inertia = self.inertia(window_s, &answer.velocity);
        for (force, inertia) in answer.force.iter_mut().zip(&inertia) {
            *force -= inertia;
        }
        Ok(Pushed {
            answer,
            inertia,
            velocity,
        })
    }

    /// M_p (v_g - N v_0) / H (N).
    fn inertia(&self, window_s: f64, velocity: &[f64]) -> Vec<f64> {
        let before = self.group.mapping.motion(&self.velocity);
        let change = velocity.iter().zip(&before).enumerate();
        let mass_kg = &self.group.points.mass_kg;
        change
            .map(|(i, (v, v_0))| mass_kg[i / 2] * (v - v_0) / window_s)
            .collect()
    }

    /// Force on the nodes (N): the one that the continua took, and on what cannot move what the walls leave for it.
    fn acting(&self, window: &Window, reaction: &Reaction, answer: &Answer) -> Vec<f64> {
        let left = self.group.mapping.force(&answer.force);
        let moves = self.compliance.moves(window.substeps);
        let taken = reaction.force.iter().zip(left).zip(moves);
        taken
            .map(|((taken, left), moves)| if moves { *taken } else { left })
            .collect()
    }
}
