//! Motion one way, force the other: the continuum takes forces (Neumann side), the wall takes motion (Dirichlet side). The
//! other way round is [`super::swapped`].
//!
//! Done once a window these are the naive staggered schemes; repeated with relaxation or quasi-Newton updates of the force
//! they are the black-box schemes for a solver that cannot stand on a compliant wall. A rigid confined layer must never
//! be the plain Dirichlet side: its force is not a function of the motion.

use protocol::{Kind, Window};

use super::Coupling;
use super::acceleration::Accelerator;
use super::outcome::{Answer, Solved, work};
use crate::couple::conversation::Conversation;
use crate::error::Error;
use crate::scenario::Scheme;

impl Coupling {
    /// The continuum runs under the force of the window before, the other side follows its motion exactly, and its
    /// force is used one window later. Nothing is repeated and no gap is judged.
    pub(super) fn staggered_serial(
        &mut self,
        conversation: &mut Conversation,
        window: Window,
    ) -> Result<Solved, Error> {
        self.rigid_wall(conversation, &window)?;
        let increment = self.advance(conversation, &window, &self.lambda.clone())?;
        let motion = self.group.mapping.motion(&increment);
        let answer = self.solve_rigid(conversation, &window, &motion)?;
        Ok(self.naive(window, increment, answer))
    }

    /// Both sides run at once: the continuum under the last force, the other side on the last motion.
    pub(super) fn staggered_parallel(
        &mut self,
        conversation: &mut Conversation,
        window: Window,
    ) -> Result<Solved, Error> {
        self.rigid_wall(conversation, &window)?;
        let motion = self.last_motion.clone();
        let (increment, answer) =
            self.both(conversation, &window, &self.lambda.clone(), &motion)?;
        Ok(self.naive(window, increment, answer))
    }

    fn naive(&self, window: Window, increment: Vec<f64>, answer: Answer) -> Solved {
        Solved {
            window,
            wanted: increment.clone(),
            work: work(&self.lambda, &increment),
            increment,
            velocity: None,
            inertia: Vec::new(),
            lambda: self.group.mapping.force(&answer.force),
            faults: self.starved(&window, &answer),
            answer,
        }
    }

    /// lambda -> F(motion(lambda)), accelerated, until the motion that the wall was given is the continuum's own.
    pub(super) fn fixed_point(
        &mut self,
        conversation: &mut Conversation,
        mut window: Window,
    ) -> Result<Solved, Error> {
        self.rigid_wall(conversation, &window)?;
        let parallel = self.rules.scheme == Scheme::FixedPointParallel;
        let mut accelerator = Accelerator::new(self.rules.acceleration, self.rules.relaxation);
        let mut lambda = self.lambda.clone();
        let mut motion = match parallel {
            true => self.last_motion.clone(),
            false => self
                .group
                .mapping
                .motion(&self.advance(conversation, &window, &lambda)?),
        };
        loop {
            let answer = match parallel {
                true => self.both(conversation, &window, &lambda, &motion)?.1,
                false => self.solve_rigid(conversation, &window, &motion)?,
            };
            let starved = self.starved(&window, &answer);
            let next = accelerator.next(&lambda, &self.group.mapping.force(&answer.force));
            window.iteration += 1;
            let moved = self.advance(conversation, &window, &next)?;
            let advice = "the fixed point was not reached; raise repeats_max, take acceleration = \"iqn-ils\", lower relaxation, or take a dual-schur scheme";
            let open = self.open(&window, &moved, &answer, advice);
            let last = window.iteration >= self.rules.repeats_max || !starved.is_empty();
            lambda = next;
            motion = self.group.mapping.motion(&moved);
            if !open.is_empty() && !last {
                continue;
            }
            let faults = match starved.is_empty() {
                true => open,
                false => starved,
            };
            return Ok(Solved {
                window,
                wanted: moved.clone(),
                work: work(&lambda, &moved),
                increment: moved,
                velocity: None,
                inertia: Vec::new(),
                lambda,
                answer,
                faults,
            });
        }
    }

    /// The other side follows a motion (m) exactly.
    fn solve_rigid(
        &mut self,
        conversation: &mut Conversation,
        window: &Window,
        motion: &[f64],
    ) -> Result<Answer, Error> {
        let window_s = self.group.window_s(window);
        let velocity = motion.iter().map(|du| du / window_s).collect();
        self.solve(conversation, window, velocity)
    }

    /// Both sides at once.
    fn both(
        &mut self,
        conversation: &mut Conversation,
        window: &Window,
        lambda: &[f64],
        motion: &[f64],
    ) -> Result<(Vec<f64>, Answer), Error> {
        self.tell_continua(conversation, window, Kind::Advance, lambda)?;
        let answer = self.solve_rigid(conversation, window, motion);
        let increment = self.hear_continua(conversation, window);
        Ok((increment?, answer?))
    }
}
