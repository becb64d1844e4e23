//! Averaged sweeps, for friction that makes plain ones run in a circle.
//!
//! With strong friction block Gauss-Seidel r' = T(r) may circle round a solution that exists. With
//! ```text
//! r' = (1 - s) r + s T(r)
//! ```
//! (Krasnoselskii 1955) an eigenvalue l of T becomes 1 - s + s l: what oscillates (Re l < 1) dies out for s small enough, and the
//! fixed points stay the same. Without friction the problem is convex, sweeps always descend, and nothing is averaged.

use super::Problem;
use super::groups::Sweeper;

/// Sweeps without gain after which they are taken to run in a circle. A column of a hundred disks, the slowest honest case,
/// gains 5 % in as many.
const PATIENCE: usize = 200;
/// A gain: an increment below this part of the least one before.
const GAIN: f64 = 0.99;

/// Watches the increments of sweeps, and weighs the sweeps.
#[derive(Clone, Debug)]
pub struct Averager {
    /// s.
    weight: f64,
    least: f64,
    since: usize,
    impulses: Vec<[f64; 2]>,
    velocities: Vec<[f64; 3]>,
    /// Velocities of the wall, then the impulses on it.
    wall: Vec<f64>,
}

impl Averager {
    /// Plain sweeps until they circle.
    pub fn new() -> Averager {
        Averager {
            weight: 1.0,
            least: f64::INFINITY,
            since: 0,
            impulses: Vec::new(),
            velocities: Vec::new(),
            wall: Vec::new(),
        }
    }

    /// Takes note of the increment of a sweep; halves the weight when there was no gain for long.
    pub fn watch(&mut self, problem: &Problem, increment: f64) {
        if problem.friction == 0.0 {
            return;
        }
        self.since += 1;
        if increment < GAIN * self.least {
            (self.least, self.since) = (increment, 0);
        } else if self.since >= PATIENCE {
            self.weight *= 0.5;
            (self.least, self.since) = (f64::INFINITY, 0);
        }
    }

    /// A sweep, averaged with where it started. The squares are those of the whole sweep, so that the criterion keeps its
    /// meaning. An averaged sweep sorts its contacts anew and costs as much as some plain ones.
    pub fn sweep(
        &mut self,
        problem: &mut Problem,
        sweeper: &mut Sweeper,
        parallel: bool,
    ) -> [f64; 2] {
        if self.weight == 1.0 {
            return sweeper.sweep(problem, parallel);
        }
        sweeper.store(problem);
        self.remember(problem);
        let squares = sweeper.sweep(problem, parallel);
        sweeper.store(problem);
        self.blend(problem);
        sweeper.load(problem);
        squares
    }

    fn remember(&mut self, problem: &Problem) {
        self.impulses.clear();
        self.impulses
            .extend(problem.contacts.iter().map(|contact| contact.impulse));
        self.velocities.clear();
        self.velocities
            .extend(problem.movers.iter().map(|mover| mover.velocity));
        self.wall.clear();
        let wall = &problem.wall;
        self.wall.extend(wall.velocity.iter().chain(&wall.impulse));
    }

    /// Velocities are linear in the impulses, so both take the same average.
    fn blend(&self, problem: &mut Problem) {
        let s = self.weight;
        let mix = |new: &mut f64, old: &f64| *new = (1.0 - s) * old + s * *new;
        for (contact, old) in problem.contacts.iter_mut().zip(&self.impulses) {
            contact
                .impulse
                .iter_mut()
                .zip(old)
                .for_each(|(n, o)| mix(n, o));
        }
        for (mover, old) in problem.movers.iter_mut().zip(&self.velocities) {
            mover
                .velocity
                .iter_mut()
                .zip(old)
                .for_each(|(n, o)| mix(n, o));
        }
        let wall = &mut problem.wall;
        let now = wall.velocity.iter_mut().chain(&mut wall.impulse);
        now.zip(&self.wall).for_each(|(n, o)| mix(n, o));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::{Contact, Mover, UNARMED, UNBONDED};
    use crate::wall::Wall;

    /// A grain with 1/m = 2 falls at 1 m/s on a glued disk whose wall yields by 1: a whole sweep gives it 1/3.
    fn falling() -> Problem {
        let mut wall = Wall::compliant(1, vec![1.0, 0.0, 0.0, 1.0]);
        wall.start(&[0.0; 2]);
        let grain = Mover {
            velocity: [0.0, -1.0, 0.0],
            inverse_mass: 2.0,
        };
        let contact = Contact {
            a: 0,
            b: 1,
            glued: true,
            normal: [0.0, 1.0],
            bond: UNBONDED,
            arms: UNARMED,
            ..Contact::default()
        };
        let mut problem = Problem {
            contacts: vec![contact],
            movers: vec![grain, Mover::default()],
            first_glued: 1,
            wall,
            friction: 0.5,
            ..Problem::default()
        };
        problem.prepare().expect("it is well posed");
        problem
    }

    #[test]
    fn half_a_sweep_moves_impulses_bodies_and_wall_by_half() {
        let mut problem = falling();
        let mut sweeper = Sweeper::default();
        sweeper.load(&problem);
        let mut averager = Averager::new();
        averager.weight = 0.5;
        averager.sweep(&mut problem, &mut sweeper, false);
        let near = |value: f64, expected: f64| assert!((value - expected).abs() < 1e-15, "{value}");
        near(problem.contacts[0].impulse[0], 1.0 / 6.0);
        near(problem.movers[0].velocity[1], -2.0 / 3.0);
        near(problem.wall.impulse[1], -1.0 / 6.0);
        near(problem.wall.velocity[1], -1.0 / 6.0);
    }

    #[test]
    fn only_a_circle_with_friction_halves_the_weight() {
        let mut problem = falling();
        let mut averager = Averager::new();
        for sweep in 0..1000 {
            averager.watch(&problem, 0.9999f64.powi(sweep));
        }
        assert_eq!(averager.weight, 1.0);
        for sweep in 0..=PATIENCE {
            averager.watch(&problem, 1e-3 + 1e-4 * (sweep % 2) as f64);
        }
        assert_eq!(averager.weight, 0.5);
        problem.friction = 0.0;
        let mut convex = Averager::new();
        (0..1000).for_each(|_| convex.watch(&problem, 1e-3));
        assert_eq!(convex.weight, 1.0);
    }
}
