//! What the coupler says to the continua and the walls in a window, and what they answer.

use protocol::serve::unpack_boundary_answer;
use protocol::{BoundaryAnswer, Kind, Window};

use super::Coupling;
use super::compliance::tell_walls;
use super::outcome::{Answer, Solve};
use crate::couple::conversation::Conversation;
use crate::error::Error;

impl Coupling {
    /// All continua at once.
    pub(super) fn advance(
        &self,
        conversation: &mut Conversation,
        window: &Window,
        lambda: &[f64],
    ) -> Result<Vec<f64>, Error> {
        self.tell_continua(conversation, window, Kind::Advance, lambda)?;
        self.hear_continua(conversation, window)
    }

    /// To each continuum its part of forces (N) or velocities (m/s).
    pub(super) fn tell_continua(
        &self,
        conversation: &mut Conversation,
        window: &Window,
        kind: Kind,
        numbers: &[f64],
    ) -> Result<(), Error> {
        self.group.continua.iter().try_for_each(|side| {
            let own = side.of(numbers).to_vec();
            conversation.tell(side.peer, kind, &side.window(window), own)
        })
    }

    pub(super) fn hear_continua(
        &self,
        conversation: &mut Conversation,
        window: &Window,
    ) -> Result<Vec<f64>, Error> {
        let mut increment = Vec::with_capacity(2 * self.group.nodes.len());
        let mut fault = None;
        for side in &self.group.continua {
            let due = 2 * side.places.len();
            let window = side.window(window);
            match conversation.hear_exactly(side.peer, Kind::Motion, &window, due) {
                Ok(motion) => increment.extend(motion),
                // The others have answered too, and the window may be tried again.
                Err(error @ Error::NotFinite(_)) => fault = fault.or(Some(error)),
                Err(error) => return Err(error),
            }
        }
        fault.map_or(Ok(increment), Err)
    }

    /// All walls at once.
    pub(super) fn solve(
        &mut self,
        conversation: &mut Conversation,
        window: &Window,
        free: Vec<f64>,
    ) -> Result<Answer, Error> {
        for side in &self.group.walls {
            conversation.tell(side.peer, Kind::Solve, window, side.of(&free).to_vec())?;
        }
        let mut all = Answer {
            force: Vec::with_capacity(free.len()),
            velocity: Vec::with_capacity(free.len()),
            solves: Vec::new(),
        };
        let mut fault = None;
        for (wall, side) in self.group.walls.iter().enumerate() {
            let answer = match hear_wall(conversation, side.peer, window, 2 * side.places.len()) {
                Ok(answer) => answer,
                Err(error @ Error::NotFinite(_)) => {
                    fault = fault.or(Some(error));
                    continue;
                }
                Err(error) => return Err(error),
            };
            self.ledgers[self.group.first_of(wall)].contact_iterations += answer.iterations;
            all.force.extend(answer.force);
            all.velocity.extend(answer.velocity);
            all.solves.push(Solve {
                iterations: answer.iterations,
                residual: answer.residual,
                converged: answer.converged,
            });
        }
        fault.map_or(Ok(all), Err)
    }

    /// Walls that move exactly as they are told.
    pub(super) fn rigid_wall(
        &mut self,
        conversation: &mut Conversation,
        window: &Window,
    ) -> Result<(), Error> {
        if self.rigid_wall != Some(window.substeps) {
            tell_walls(conversation, &self.group, window, None)?;
            self.rigid_wall = Some(window.substeps);
        }
        Ok(())
    }
}

fn hear_wall(
    conversation: &mut Conversation,
    peer: usize,
    window: &Window,
    components: usize,
) -> Result<BoundaryAnswer, Error> {
    let due = 2 * components + 3;
    let numbers = conversation.hear_exactly(peer, Kind::Force, window, due)?;
    Ok(unpack_boundary_answer(&numbers, components).expect("the length was checked"))
}
