//! Sweeps for problems in which plain sweeps do not converge: extrapolated and averaged sweeps in turn.
//!
//! A solution exists, but sweeps creep along a mode with the eigenvalue 0.9998 where the forces of rigid grains are not unique, and with friction
//! they may circle round the solution or diverge from it. Extrapolation (`super::extrapolation`) removes such modes while the contacts keep their
//! states; where they do not, averages
//!
//! ```text
//! r' = (1 - s) r + s T(r)
//! ```
//!
//! (Krasnoselskii 1955) damp oscillations: an eigenvalue l of T becomes 1 - s + s l, and the fixed points stay the same. Without friction the problem
//! is convex, sweeps always descend, and stay plain.

use super::extrapolation::Extrapolation;
use super::groups::Sweeper;
use super::problem::Problem;

/// Number of plain sweeps at first: no window of a shipped scene takes as many.
const PLAIN: usize = 200;

/// Consecutive extrapolated sweeps, and averaged sweeps.
const EXTRAPOLATED: usize = 600;
const AVERAGED: usize = 600;

/// Sweeps after which each kind has been tried, and pivoting looks for the solution.
pub const FIRST_TURNS: usize = PLAIN + EXTRAPOLATED + AVERAGED;

/// s of the averaged sweeps, turn by turn.
const WEIGHTS: [f64; 4] = [0.5, 0.8, 0.25, 0.1];

/// Kinds of sweeps.
#[derive(Clone, Copy, Debug, PartialEq)]
enum SweepKind {
    Plain,
    Extrapolated,
    /// With the weight s.
    Averaged(f64),
}

/// The sweeps of one problem.
#[derive(Clone, Debug, Default)]
pub(super) struct Accelerator {
    sweeps: usize,
    extrapolation: Extrapolation,
}

impl Accelerator {
    /// A sweep. The squares belong to the whole sweep, so that the criterion keeps its meaning. A sweep that is not plain loads its contacts again
    /// and costs as much as ten.
    pub(super) fn sweep(
        &mut self,
        problem: &mut Problem,
        sweeper: &mut Sweeper,
        parallel: bool,
    ) -> [f64; 2] {
        let friction = self.sweeps >= PLAIN && problem.has_friction();
        let kind = sweep_kind(self.sweeps, friction);
        self.sweeps += 1;
        if kind == SweepKind::Plain {
            return sweeper.sweep(problem, parallel);
        }
        sweeper.store(problem);
        let before: Vec<f64> = numbers(problem).map(|number| *number).collect();
        let squares = sweeper.sweep(problem, parallel);
        sweeper.store(problem);
        if let SweepKind::Averaged(s) = kind {
            self.extrapolation.forget();
            for (new, old) in numbers(problem).zip(&before) {
                *new = (1.0 - s) * old + s * *new;
            }
        } else {
            let diagonal: Vec<f64> = problem.contacts.iter().flat_map(|c| c.diagonal()).collect();
            let after: Vec<f64> = numbers(problem).map(|number| *number).collect();
            let next = self.extrapolation.next(&diagonal, before, &after);
            numbers(problem)
                .zip(next)
                .for_each(|(number, next)| *number = next);
        }
        sweeper.load(problem);
        squares
    }

    /// True where the increment of a sweep says little about the distance from the solution.
    pub(super) fn is_at_work(&self) -> bool {
        self.sweeps > PLAIN
    }
}

fn sweep_kind(sweeps: usize, friction: bool) -> SweepKind {
    let Some(since) = sweeps.checked_sub(PLAIN).filter(|_| friction) else {
        return SweepKind::Plain;
    };
    let both = EXTRAPOLATED + AVERAGED;
    let (turn, within) = (since / both, since % both);
    if within < EXTRAPOLATED {
        SweepKind::Extrapolated
    } else {
        SweepKind::Averaged(WEIGHTS[turn % WEIGHTS.len()])
    }
}

/// Impulses and velocities of contacts, bodies and boundary. Velocities are linear in the impulses, so all take the same
/// combination.
fn numbers(problem: &mut Problem) -> impl Iterator<Item = &mut f64> {
    let impulses = problem.contacts.iter_mut().flat_map(|c| &mut c.impulse);
    let velocities = problem.records.iter_mut().flat_map(|r| &mut r.velocity);
    let boundary = &mut problem.boundary;
    let boundary = boundary.velocity.iter_mut().chain(&mut boundary.impulse);
    let couples = problem.couples.iter_mut().map(|couple| &mut couple.impulse);
    impulses.chain(velocities).chain(boundary).chain(couples)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::boundary::CompliantBoundary;
    use crate::solver::contact::{BodyRecord, Contact, NO_BOND, NO_LEVERS};

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
        problem.prepare(1.0, false).expect("it is well posed");
        problem
    }

    #[test]
    fn half_a_sweep_moves_impulses_bodies_and_wall_by_half() {
        let mut problem = falling();
        let mut sweeper = Sweeper::default();
        sweeper.load(&problem);
        let mut accelerator = Accelerator {
            sweeps: PLAIN + EXTRAPOLATED,
            ..Accelerator::default()
        };
        accelerator.sweep(&mut problem, &mut sweeper, false);
        let near = |value: f64, expected: f64| assert!((value - expected).abs() < 1e-15, "{value}");
        near(problem.contacts[0].impulse[0], 1.0 / 6.0);
        near(problem.records[0].velocity[1], -2.0 / 3.0);
        near(problem.boundary.impulse[1], -1.0 / 6.0);
        near(problem.boundary.velocity[1], -1.0 / 6.0);
    }

    #[test]
    fn an_extrapolated_sweep_keeps_velocities_and_impulses_together() {
        let mut problem = falling();
        let mut sweeper = Sweeper::default();
        sweeper.load(&problem);
        let mut accelerator = Accelerator {
            sweeps: PLAIN,
            ..Accelerator::default()
        };
        for _ in 0..3 {
            accelerator.sweep(&mut problem, &mut sweeper, false);
        }
        let r = problem.contacts[0].impulse[0];
        assert!((r - 1.0 / 3.0).abs() < 1e-15, "{r}");
        assert!((problem.records[0].velocity[1] - (2.0 * r - 1.0)).abs() < 1e-15);
        assert!((problem.boundary.velocity[1] + r).abs() < 1e-15);
    }

    #[test]
    fn turns_follow_the_plain_sweeps_and_only_with_friction() {
        assert_eq!(sweep_kind(PLAIN - 1, true), SweepKind::Plain);
        assert_eq!(sweep_kind(PLAIN, true), SweepKind::Extrapolated);
        assert_eq!(
            sweep_kind(PLAIN + EXTRAPOLATED, true),
            SweepKind::Averaged(0.5)
        );
        let second = PLAIN + EXTRAPOLATED + AVERAGED;
        assert_eq!(sweep_kind(second, true), SweepKind::Extrapolated);
        assert_eq!(
            sweep_kind(second + EXTRAPOLATED, true),
            SweepKind::Averaged(0.8)
        );
        assert_eq!(sweep_kind(second, false), SweepKind::Plain);
    }
}
