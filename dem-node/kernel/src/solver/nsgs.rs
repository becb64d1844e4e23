//! Non-linear block Gauss-Seidel on velocities (Jean 1999; Jourdan, Alart, Jean 1998).
//!
//! Each contact in turn takes the impulse that its own law wants under the present velocities, and changes the velocities of its two bodies at once.
//! The matrix W is never formed: stored rows cost four times as much.

use super::acceleration::{Accelerator, FIRST_TURNS};
use super::groups::Sweeper;
use super::problem::Problem;
use super::residual::{Convergence, Defect, Quad, convergence, measured};
use crate::solver::criteria::Criteria;
use crate::solver::lemke;

/// Sweeps between two computations of the true residual while sweeps are accelerated, for any increments.
const CHECK_EVERY: usize = 20;

/// Residual above which sweeps have found next to nothing: without impulses it is 1. This happens where a run has blown up, and the path to a
/// solution is long.
const NOTHING_FOUND: f64 = 0.9;

/// Sweeps until the true residual is within the tolerance.
///
/// The gate is the increment of a sweep, with dr its change of r and D the bodies' part of the diagonal of W,
/// ```text
/// increment = sqrt(sum |D dr|^2) / sqrt(sum |D r|^2)  <=  bound,    bound = tolerance at first
/// ```
/// It is LMGC90's QuadDV with two differences: r is taken after the sweep, where LMGC90 takes the mean of the squares before and after, and dr is the
/// change contact after contact, where LMGC90 offers all contacts their impulse at once. The increment costs a sweep nothing, but alone it misleads:
/// in a layer under its wheel two of five sweeps that it accepts are above the tolerance. Only when it passes is the true residual computed
/// ([`super::residual`]), which decides: within the tolerance the sweeps end, else the bound becomes increment x max(0.1, tolerance / residual), as
/// in Siconos, and sweeping continues. The whole criterion of LMGC90 (see [`crate::solver::residual::Quad`]) is reported for the answer and decides
/// nothing: with it as a second condition every sixth accepted answer took more sweeps.
pub fn solve(problem: &mut Problem, sweeper: &mut Sweeper, criteria: &Criteria) -> Convergence {
    sweeper.load(problem);
    sweep(problem, sweeper, criteria)
}

/// Sweeps from the present impulses and velocities; the impulses are the sweeper's.
pub(super) fn sweep(
    problem: &mut Problem,
    sweeper: &mut Sweeper,
    criteria: &Criteria,
) -> Convergence {
    let mut bound = criteria.tolerance;
    let mut iterations = 0;
    let mut accelerator = Accelerator::default();
    let mut pivoted = false;
    while iterations < criteria.max_iterations {
        let [changed, size] = accelerator.sweep(problem, sweeper, criteria.parallel);
        let change = problem.relative(changed.sqrt(), size.sqrt());
        iterations += 1;
        if change.is_nan() {
            break;
        }
        let is_due = accelerator.is_at_work() && iterations.is_multiple_of(CHECK_EVERY);
        if iterations < criteria.min_iterations || (change > bound && !is_due) {
            continue;
        }
        let left = sweeper.measured(problem, criteria.parallel);
        let residual = left.0.residual(problem);
        if residual <= criteria.tolerance {
            sweeper.store(problem);
            return convergence(problem, left, iterations, criteria);
        }
        let stuck = iterations >= FIRST_TURNS && residual < NOTHING_FOUND;
        if stuck && !pivoted && problem.has_friction() && problem.couples.is_empty() {
            pivoted = true;
            sweeper.store(problem);
            if let Some(left) = pivot(problem, criteria) {
                sweeper.load(problem);
                return convergence(problem, left, iterations, criteria);
            }
        }
        if change <= bound {
            bound = change * (criteria.tolerance / residual).max(0.1);
        }
    }
    sweeper.store(problem);
    convergence(
        problem,
        measured(problem, criteria.parallel),
        iterations,
        criteria,
    )
}

/// Takes the solution that pivoting finds, if it is one; else nothing changes.
fn pivot(problem: &mut Problem, criteria: &Criteria) -> Option<(Defect, Quad)> {
    let solved = lemke::solve(problem, criteria.tolerance)?;
    let left = measured(&solved, criteria.parallel);
    let holds = left.0.residual(&solved) <= criteria.tolerance;
    holds.then(|| {
        *problem = solved;
        left
    })
}
