//! One window of a group, as a scheme sees it: the state at the start, and all participants of the group at once.

use protocol::{Reaction, Window};

use super::compliance::Compliance;
use super::criteria::{open, starved};
use super::group::{Group, Side};
use super::ledger::InterfaceLedger;
use super::participants::{Participants, Request};
use super::vectors::difference;
use super::window::{Answer, InterfaceState, Solve, WindowVerdict};
use crate::error::{Result, SchemeError};

/// A window to solve. A scheme reads the group and the state at the start, calls the participants, and changes only the
/// compliance that it learns.
pub struct WindowProblem<'a> {
    /// The interfaces and the participants that they join.
    pub group: &'a Group,
    /// State of the interfaces at the start of the window.
    pub start: &'a InterfaceState,
    /// C of the force-driven participants and the boundaries from it.
    pub compliance: &'a mut Compliance,
    /// Contact iterations are counted here even if the window is not accepted.
    pub ledgers: &'a mut [InterfaceLedger],
    /// The participants of the run.
    pub participants: &'a mut dyn Participants,
}

impl WindowProblem<'_> {
    /// Makes sure that C for this window is known and that all boundaries yield by it.
    pub fn prepare_boundaries(&mut self, window: &Window) -> Result<()> {
        self.compliance
            .prepare(self.participants, self.group, window)
    }

    /// Increments du (m) of the force-driven participants under a force (N) that is constant in the window.
    pub fn advance(&mut self, window: &Window, force: &[f64]) -> Result<Vec<f64>> {
        self.begin_advance(window, force)?;
        self.finish_advance(window)
    }

    /// The first half of [`WindowProblem::advance`]: all participants are at work after it.
    pub fn begin_advance(&mut self, window: &Window, force: &[f64]) -> Result<()> {
        self.begin(window, |side| Request::Advance(side.of(force)))
    }

    fn begin<'r>(&mut self, window: &Window, request: impl Fn(&Side) -> Request<'r>) -> Result<()> {
        let mut sides = self.group.force_driven.iter();
        sides.try_for_each(|side| {
            let window = side.window(window);
            self.participants.begin(side.peer, &window, request(side))
        })
    }

    /// The increments du (m) of the window begun.
    pub fn finish_advance(&mut self, window: &Window) -> Result<Vec<f64>> {
        let increments = answers_of_all(&self.group.force_driven, |side, n| {
            self.participants
                .finish_advance(side.peer, &side.window(window), n)
        })?;
        Ok(increments.concat())
    }

    /// Reaction of the force-driven participants to a velocity that is linear in time and ends at this one (m/s).
    pub fn prescribe_velocity(&mut self, window: &Window, velocity: &[f64]) -> Result<Reaction> {
        self.begin_prescribed_velocity(window, velocity)?;
        self.finish_prescribed_velocity(window)
    }

    /// The first half of [`WindowProblem::prescribe_velocity`].
    pub fn begin_prescribed_velocity(&mut self, window: &Window, velocity: &[f64]) -> Result<()> {
        self.begin(window, |side| Request::PrescribeVelocity(side.of(velocity)))
    }

    /// The reaction of the window begun.
    pub fn finish_prescribed_velocity(&mut self, window: &Window) -> Result<Reaction> {
        let reactions = answers_of_all(&self.group.force_driven, |side, n| {
            self.participants
                .finish_prescribed_velocity(side.peer, &side.window(window), n)
        })?;
        let mut all = Reaction::default();
        for reaction in reactions {
            all.force.extend(reaction.force);
            all.increment.extend(reaction.increment);
            all.work.extend(reaction.work);
        }
        Ok(all)
    }

    /// Contact solves of the motion-driven participants on boundaries v_g = a_g + W_g p with this a_g (m/s).
    pub fn solve(&mut self, window: &Window, free_velocity: &[f64]) -> Result<Answer> {
        for side in &self.group.motion_driven {
            let request = Request::Solve(side.of(free_velocity));
            self.participants.begin(side.peer, window, request)?;
        }
        let mut index = 0;
        let answers = answers_of_all(&self.group.motion_driven, |side, n| {
            let ledger = &mut self.ledgers[self.group.first_of(index)];
            index += 1;
            let answer = self.participants.finish_solve(side.peer, window, n)?;
            ledger.contact_iterations += answer.iterations;
            Ok(answer)
        })?;
        let mut all = Answer::default();
        for answer in answers {
            all.force.extend(answer.force);
            all.velocity.extend(answer.velocity);
            all.solves.push(Solve {
                iterations: answer.iterations,
                residual: answer.residual,
                converged: answer.converged,
            });
        }
        Ok(all)
    }

    /// Contact solves on boundaries with a prescribed motion (m).
    pub fn solve_rigid(&mut self, window: &Window, motion: &[f64]) -> Result<Answer> {
        let window_s = self.group.window_s(window);
        let velocity: Vec<f64> = motion.iter().map(|du| du / window_s).collect();
        self.solve(window, &velocity)
    }

    /// C_ii lambda_i (m): the motion of each node by the forces (N) of the motion-driven participant on it, without the
    /// forces of others.
    pub fn carried(&self, window: &Window, lambda: &[f64]) -> Vec<f64> {
        self.compliance.own(self.group, window.substeps, lambda)
    }

    /// a_g = N (du - C_ii lambda_i) / H (m/s): the velocity of the glued points without their own participant's contact
    /// forces.
    pub fn free_velocity(&self, window: &Window, increment: &[f64], carried: &[f64]) -> Vec<f64> {
        let window_s = self.group.window_s(window);
        let motion = difference(increment, carried);
        let motion = self.group.mapping.motion(&motion).into_iter();
        motion.map(|du| du / window_s).collect()
    }

    /// Judges contact solves and gap |N du - H v_g| of a repeat; `advice` says how to close the gap.
    pub fn judge(
        &self,
        window: &Window,
        increment: &[f64],
        answer: &Answer,
        advice: &str,
    ) -> WindowVerdict {
        WindowVerdict {
            starved: starved(self.group, window, answer),
            open: open(self.group, window, increment, answer, advice),
        }
    }
}

/// The answers of all sides; `ask` gets the number of components of each. An answer that is not finite becomes an error
/// only after the others have answered, so that the window may be tried again.
fn answers_of_all<T>(
    sides: &[Side],
    mut ask: impl FnMut(&Side, usize) -> Result<T>,
) -> Result<Vec<T>> {
    let mut answers = Vec::with_capacity(sides.len());
    let mut fault = None;
    for side in sides {
        match ask(side, 2 * side.range.len()) {
            Ok(answer) => answers.push(answer),
            Err(error @ SchemeError::NotFinite(_)) => fault = fault.or(Some(error)),
            Err(error) => return Err(error),
        }
    }
    fault.map_or(Ok(answers), Err)
}
