//! Non-linear block Gauss-Seidel on velocities (Jean 1999; Jourdan, Alart, Jean 1998).
//!
//! Each contact in turn takes the impulse that its own law wants under the velocities of the moment, and changes the
//! velocities of its two bodies at once. The matrix W is never formed: stored rows cost four times as much.

use super::groups::Sweeper;
use super::{Criteria, Problem, Verdict};

/// Sweeps until the true residual is within the tolerance.
///
/// QuadDV of LMGC90's incremental criterion is watched because a sweep has it for nothing, but it alone lies: in a layer
/// under its wheel two of five sweeps that it accepts are above the tolerance. The true residual decides: where it refuses
/// what QuadDV accepted, the bound on QuadDV is tightened in proportion, as Siconos does, and sweeping goes on. The whole
/// criterion (see [`super::Quad`]) is reported; asking for it as well made every sixth accepted answer do more sweeps.
pub fn solve(problem: &mut Problem, criteria: &Criteria) -> Verdict {
    let mut sweeper = std::mem::take(&mut problem.sweeper);
    sweeper.load(problem);
    let verdict = iterate(problem, &mut sweeper, criteria);
    problem.sweeper = sweeper;
    verdict
}

fn iterate(problem: &mut Problem, sweeper: &mut Sweeper, criteria: &Criteria) -> Verdict {
    let mut bound = criteria.tolerance;
    let mut iterations = 0;
    while iterations < criteria.max_iterations {
        let [changed, size] = sweeper.sweep(problem, criteria.parallel);
        let change = problem.relative(changed.sqrt(), size.sqrt());
        iterations += 1;
        if change.is_nan() {
            break;
        }
        if iterations < criteria.min_iterations || change > bound {
            continue;
        }
        sweeper.store(problem);
        let residual = problem.residual();
        if residual <= criteria.tolerance {
            break;
        }
        bound = change * (criteria.tolerance / residual).max(0.1);
    }
    sweeper.store(problem);
    problem.verdict(iterations, criteria)
}
