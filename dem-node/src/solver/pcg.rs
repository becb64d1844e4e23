//! Projected conjugate gradient (Renouf and Alart, Comput. Methods Appl. Mech. Engrg. 194, 2005, algorithm CPG),
//! scaled by the diagonal.
//!
//! Without friction the impulses minimise r.(W + C) r / 2 + r.b over r_n >= 0, C the springs and b the free relative
//! velocities with their bias. With friction |r_t| <= s is held at s = mu r_n, the box problem is solved, s is taken
//! anew, and so on: a fixed point of Coulomb's law (Panagiotopoulos 1975). With u = (W + C) r + b, D the diagonal of
//! W + C and P the projection on the box, an iteration is
//! ```text
//! alpha = -u.p / p.q,  q = (W + C) p          r' = P(r + alpha p)
//! w = -u'/D where r' may move that way         z = p where r' may move that way
//! beta = -w.q / p.q                            p' = w + beta z
//! ```
//! A bond pulls: below r_n = 0 it has the compliance 1/kappa instead of that of its spring. Both branches have the same u
//! at r_n = 0, so the energy stays convex and smooth; a contact is on the branch of its impulse, and at 0 on the one to which u
//! pushes it, and its direction ends at 0 as at any bound. The bond's shear has 1/kappa_t and no threshold.
//!
//! `tests/textbook.rs` has these equations as they stand, u, q and all velocities formed anew; the tests compare every iteration
//! with it. Here is what the fast form does differently:
//!
//! W = H^T M^-1 H is never formed, and neither u nor q is kept: what the equations ask of them are sums over the bodies.
//! While w is found it is scattered to H w, and then
//! ```text
//! w.q   = (H w).M^-1 (H p) + w.C p             H z  = H p - H (p - z), where contacts have just come to a bound
//! p'.q' = ww + 2 beta wz + beta^2 zz           ww = (H w).M^-1 (H w) + w.C w, and wz and zz likewise
//! -u.p' = -u.w - beta u.z                      H p' = H w + beta H z
//! ```
//! q belongs to the branches of bonds where p was made: with those where r' has come to, a bonded layer under its wheel did
//! not converge. The velocities of r' are v + alpha M^-1 H p' plus what the projection took away, which few contacts feel.
//! So an iteration gathers velocities once and scatters impulses once.
//!
//! D only weighs, and any positive numbers would lead to the same solution: it is kept to seven digits, since the time of an
//! iteration on a large sample is that of its bytes.

mod batch;
mod body_state;
mod branches;
mod constrained;
mod group;
#[cfg(test)]
mod tests;
pub mod workspace;

use super::problem::Problem;
use super::residual::{Convergence, convergence, measured};
use crate::config::solver::Criteria;
use batch::Pass;
use group::{Features, PassSums, With};
use workspace::Workspace;

/// Part of the true residual below which the box problem is solved well enough to take its thresholds anew. At 10 000
/// disks 0.1 costs a fifth more iterations, and 1, anew in every iteration, five times as many.
const INNER: f64 = 0.5;
/// Least and largest part of a bound that was reached in vain to ask for next.
const TIGHTER: [f64; 2] = [0.1, 0.9];
/// Part of w.(W + C) w below which what is left of it in p.(W + C) p is rounding.
const CANCELLED: f64 = 1e-12;

/// End of an inner solve.
struct InnerSolve {
    iterations: usize,
    /// True if the residual, as the passes see it, is within the bound.
    reached: bool,
}

/// Iterates until the true residual is within the tolerance.
///
/// The passes see it with seven digits of D, and a bond on the branch of its impulse, where [`super::residual`] looks at both.
/// If they are satisfied and it is not, iterations begin anew where they are, with a tighter bound.
pub fn solve(problem: &mut Problem, workspace: &mut Workspace, criteria: &Criteria) -> Convergence {
    compiled(problem)(problem, workspace, criteria, None)
}

/// Goes on from the solution of this problem in the workspace: since then only the bonds of these contacts have become softer.
pub fn go_on(
    problem: &mut Problem,
    workspace: &mut Workspace,
    criteria: &Criteria,
    softened: &[u32],
) -> Convergence {
    compiled(problem)(problem, workspace, criteria, Some(softened))
}

type Solve = fn(&mut Problem, &mut Workspace, &Criteria, Option<&[u32]>) -> Convergence;

/// The solver compiled for what this problem contains.
fn compiled(problem: &Problem) -> Solve {
    let soft = || problem.contacts.iter().any(|c| c.compliance != [0.0; 2]);
    match (!problem.bonds.is_empty(), problem.friction > 0.0) {
        (true, _) => solve_as::<With<true, true, true>>,
        (false, true) => solve_as::<With<true, false, true>>,
        (false, false) if soft() => solve_as::<With<false, false, true>>,
        (false, false) => solve_as::<With<false, false, false>>,
    }
}

/// Solves a problem anew, or goes on where bonds have softened.
fn solve_as<F: Features>(
    problem: &mut Problem,
    workspace: &mut Workspace,
    criteria: &Criteria,
    softened: Option<&[u32]>,
) -> Convergence {
    match softened {
        None => workspace.load::<F>(problem, criteria.parallel),
        Some(softened) => {
            workspace.soften(problem, softened);
            workspace.restart(criteria.parallel);
        }
    }
    let mut asked = *criteria;
    let mut iterations = 0;
    loop {
        let inner = iterate::<F>(workspace, problem, &asked);
        workspace.store(problem, criteria.parallel);
        iterations += inner.iterations;
        let left = measured(problem, criteria.parallel);
        let convergence = convergence(problem, left, iterations, criteria);
        if convergence.converged || !inner.reached {
            return convergence;
        }
        let missed = criteria.tolerance / convergence.residual;
        asked.tolerance *= missed.clamp(TIGHTER[0], TIGHTER[1]);
        asked.max_iterations -= inner.iterations;
        asked.min_iterations = 0;
        workspace.restart(criteria.parallel);
    }
}

/// Iterations from where the workspace is.
fn iterate<F: Features>(
    workspace: &mut Workspace,
    problem: &Problem,
    criteria: &Criteria,
) -> InnerSolve {
    let mut run = |pass| workspace.run::<F>(problem, pass, criteria.parallel);
    let ended = |iterations: usize, reached: bool| InnerSolve {
        iterations,
        reached,
    };
    let mut sums = run(Pass::Measure);
    // p.(W + C) p of the last direction: the first has none before it.
    let mut curvature = f64::INFINITY;
    for iteration in 0..criteria.max_iterations {
        let residual = problem.relative(sums.defect.sqrt(), sums.size.sqrt());
        if residual <= criteria.tolerance && iteration >= criteria.min_iterations {
            return ended(iteration, true);
        }
        let mut beta = -sums.products.wp / curvature;
        if F::FRICTION && sums.held.sqrt() <= INNER * sums.defect.sqrt() {
            sums = run(Pass::RenewThresholds);
            beta = 0.0;
        }
        let Some(direction) = Direction::choose(&sums, beta) else {
            return ended(iteration + 1, false);
        };
        curvature = direction.curvature;
        sums = run(Pass::Step {
            alpha: direction.descent / curvature,
            beta: direction.beta,
        });
    }
    ended(criteria.max_iterations, false)
}

/// p = w + beta z.
struct Direction {
    beta: f64,
    /// -u.p.
    descent: f64,
    /// p.(W + C) p.
    curvature: f64,
}

impl Direction {
    /// The conjugate direction, or the steepest one where that has lost its way; none where nothing descends.
    fn choose(sums: &PassSums<f64>, beta: f64) -> Option<Direction> {
        let conjugate = Direction::new(sums, beta);
        if conjugate.descent > 0.0 && conjugate.curvature > CANCELLED * sums.products.ww {
            return Some(conjugate);
        }
        let steepest = Direction::new(sums, 0.0);
        (steepest.descent > 0.0 && steepest.curvature > 0.0).then_some(steepest)
    }

    fn new(sums: &PassSums<f64>, beta: f64) -> Direction {
        let products = &sums.products;
        Direction {
            beta,
            descent: -sums.uw - beta * sums.uz,
            curvature: products.ww + 2.0 * beta * products.wz + beta * beta * products.zz,
        }
    }
}
