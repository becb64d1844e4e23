//! Averaged sweeps, for strong friction, which makes plain ones cycle.
//!
//! With strong friction block Gauss-Seidel r' = T(r) may circle round a solution that exists. With
//! ```text
//! r' = (1 - s) r + s T(r)
//! ```
//! (Krasnoselskii 1955) an eigenvalue l of T becomes 1 - s + s l: what oscillates (Re l < 1) dies out for s small enough, and the
//! fixed points stay the same. Without friction the problem is convex, sweeps always descend, and nothing is averaged.

use super::groups::Sweeper;
use super::problem::Problem;

/// Sweeps without gain after which they are taken to cycle. A column of a hundred disks, the slowest honest case,
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
    /// [`numbers`] before a sweep.
    before: Vec<f64>,
}

impl Averager {
    /// Plain sweeps until they circle.
    pub fn new() -> Averager {
        Averager {
            weight: 1.0,
            least: f64::INFINITY,
            since: 0,
            before: Vec::new(),
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
        self.before.clear();
        self.before.extend(numbers(problem).map(|number| *number));
        let squares = sweeper.sweep(problem, parallel);
        sweeper.store(problem);
        let s = self.weight;
        for (new, old) in numbers(problem).zip(&self.before) {
            *new = (1.0 - s) * old + s * *new;
        }
        sweeper.load(problem);
        squares
    }
}

/// Impulses and velocities of contacts, bodies and boundary. Velocities are linear in the impulses, so all take the same
/// average.
fn numbers(problem: &mut Problem) -> impl Iterator<Item = &mut f64> {
    let impulses = problem.contacts.iter_mut().flat_map(|c| &mut c.impulse);
    let velocities = problem.records.iter_mut().flat_map(|r| &mut r.velocity);
    let boundary = &mut problem.boundary;
    let boundary = boundary.velocity.iter_mut().chain(&mut boundary.impulse);
    impulses.chain(velocities).chain(boundary)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::CompliantBoundary;
    use crate::solver::{BodyRecord, Contact, NO_BOND, NO_LEVERS};

    /// A grain with 1/m = 2 falls at 1 m/s on a glued disk whose boundary yields by 1: a whole sweep gives it 1/3.
    fn falling() -> Problem {
        let mut boundary = CompliantBoundary::compliant(1, vec![1.0, 0.0, 0.0, 1.0]);
        boundary.start(&[0.0; 2]);
        let grain = BodyRecord {
            velocity: [0.0, -1.0, 0.0],
            inverse_mass: 2.0,
        };
        let contact = Contact {
            a: 0,
            b: 1,
            glued: true,
            normal: [0.0, 1.0],
            bond: NO_BOND,
            levers: NO_LEVERS,
            ..Contact::default()
        };
        let mut problem = Problem {
            contacts: vec![contact],
            records: vec![grain, BodyRecord::default()],
            first_glued: 1,
            boundary,
            friction: 0.5,
            ..Problem::default()
        };
        problem.prepare(1.0).expect("it is well posed");
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
        near(problem.records[0].velocity[1], -2.0 / 3.0);
        near(problem.boundary.impulse[1], -1.0 / 6.0);
        near(problem.boundary.velocity[1], -1.0 / 6.0);
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
