//! Projected conjugate gradient (Renouf and Alart, Comput. Methods Appl. Mech. Engrg. 194, 2005, algorithm CPG),
//! scaled by the diagonal.
//!
//! Without friction the impulses minimise r.(W + C) r / 2 + r.b over r_n >= 0, C the springs and b the free relative
//! velocities with their bias. With friction |r_t| <= s is held at s = mu r_n, the box problem is solved, s is updated, and so on: a fixed point of
//! Coulomb's law (Panagiotopoulos 1975). With u = (W + C) r + b, D the diagonal of W + C and P the projection on the box, an iteration is
//! ```text
//! alpha = -u.p / p.q,  q = (W + C) p          r' = P(r + alpha p)
//! w = -u'/D where r' may move that way         z = p where r' may move that way
//! beta = -w.q / p.q                            p' = w + beta z
//! ```
//! A bond pulls: below r_n = 0 it has the compliance 1/kappa instead of its spring's. Both branches have the same u at r_n = 0, so the energy stays
//! convex and smooth. A contact is on the branch of its impulse, and at 0 on the branch to which u pushes it; its direction ends at 0 as at any
//! bound. The bond's shear has 1/kappa_t and no threshold.
//!
//! `tests/textbook.rs` has these equations literally, with u, q and all velocities computed again; the tests compare every iteration with it. The
//! fast form has these differences:
//!
//! W = H^T M^-1 H is never formed, and neither u nor q is stored: the equations need only sums over the bodies. w is scattered to H w as it is
//! computed, and then
//! ```text
//! w.q   = (H w).M^-1 (H p) + w.C p             H z  = H p - H (p - z), where contacts have just come to a bound
//! p'.q' = ww + 2 beta wz + beta^2 zz           ww = (H w).M^-1 (H w) + w.C w, and wz and zz likewise
//! -u.p' = -u.w - beta u.z                      H p' = H w + beta H z
//! ```
//! q belongs to the branches of bonds where p was computed: with the branches of r', a bonded layer under its wheel did not converge. The velocities
//! of r' are v + alpha M^-1 H p' plus the effect of the projection, which concerns few contacts. So an iteration gathers velocities once and scatters
//! impulses once.
//!
//! D is only a weight, and any positive numbers would lead to the same solution: it is stored with seven digits, since the time of an iteration on a
//! large sample is the time to load its bytes.
//!
//! Large bonded problems without friction are iterated in single precision, see [`correction`].

mod batch;
mod body_state;
pub mod bonded;
mod branches;
mod constrained;
pub mod correction;
mod group;
#[cfg(test)]
mod tests;
pub mod workspace;

use std::marker::PhantomData;

use super::problem::Problem;
use super::residual::{Convergence, convergence, measured};
use crate::solver::criteria::Criteria;
use batch::Pass;
use correction::Correction;
use group::{Features, PassSums, With};
use workspace::Workspace;

/// Part of the true residual below which the box problem is solved well enough to update its thresholds. At 10 000 disks 0.1 costs a fifth more
/// iterations, and 1, an update in every iteration, five times as many.
const INNER: f64 = 0.5;
/// Least and largest factor on a bound whose tolerance was not reached.
const TIGHTER: [f64; 2] = [0.1, 0.9];

/// Buffers of the solver.
#[derive(Clone, Debug, Default)]
pub struct Buffers {
    workspace: Workspace,
    correction: Correction,
    /// The form that holds the last problem.
    holds: Holder,
}

/// The form that continues where bonds soften.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Holder {
    #[default]
    None,
    Double,
    Single,
}

/// A form of the iterations, with its loaded problem.
trait Form {
    /// True if thresholds of friction are updated.
    const THRESHOLDS: bool;
    /// Part of w.(W + C) w below which p.(W + C) p is a rounding error.
    const CANCELLED: f64;
    /// Part of the first residual at which iterations restart: smaller residuals are rounding errors.
    const REDUCED: f64;
    /// Iterations without a smaller residual after which another form is tried.
    const PATIENCE: usize;

    /// One pass over all contacts.
    fn run(&mut self, problem: &Problem, pass: Pass) -> PassSums<f64>;

    /// Writes impulses and velocities back.
    fn store(&mut self, problem: &mut Problem);

    /// Restarts at the impulses and velocities of the problem, which it has written.
    fn restart(&mut self, problem: &mut Problem);
}

/// Double precision, compiled for the features of a problem.
struct Double<'a, F> {
    workspace: &'a mut Workspace,
    parallel: bool,
    features: PhantomData<F>,
}

impl<F: Features> Form for Double<'_, F> {
    const THRESHOLDS: bool = F::FRICTION;
    const CANCELLED: f64 = 1e-12;
    const REDUCED: f64 = 0.0;
    const PATIENCE: usize = usize::MAX;

    fn run(&mut self, problem: &Problem, pass: Pass) -> PassSums<f64> {
        self.workspace.run::<F>(problem, pass, self.parallel)
    }

    fn store(&mut self, problem: &mut Problem) {
        self.workspace.store(problem, self.parallel);
    }

    fn restart(&mut self, _problem: &mut Problem) {
        self.workspace.restart(self.parallel);
    }
}

/// The correction in single precision.
struct Single<'a> {
    correction: &'a mut Correction,
    parallel: bool,
}

impl Form for Single<'_> {
    const THRESHOLDS: bool = false;
    const CANCELLED: f64 = 1e-5;
    const REDUCED: f64 = 1e-3;
    const PATIENCE: usize = 50;

    fn run(&mut self, _problem: &Problem, pass: Pass) -> PassSums<f64> {
        self.correction.run(pass, self.parallel)
    }

    fn store(&mut self, problem: &mut Problem) {
        self.correction.store(problem, self.parallel);
    }

    fn restart(&mut self, problem: &mut Problem) {
        // It has loaded this problem before, and no bond has changed since.
        self.correction.load(problem, self.parallel);
    }
}

/// Reason for the end of iterations.
#[derive(Clone, Copy, PartialEq)]
enum End {
    /// The residual of the passes is within the bound.
    Reached,
    /// The residual is so much smaller than at the start that it will soon be a rounding error.
    Reduced,
    /// No direction descends, the residual stays, or there were too many iterations.
    Stuck,
}

/// Iterates until the true residual is within the tolerance.
///
/// The passes compute it with seven digits of D, and with bonds on the branch of their impulse, where [`super::residual`] takes both branches. If the
/// passes are satisfied and the true residual is not, iterations restart with a tighter bound.
pub fn solve(problem: &mut Problem, buffers: &mut Buffers, criteria: &Criteria) -> Convergence {
    buffers.solve(problem, criteria, None)
}

impl Buffers {
    /// Solves in single precision where this suits the problem, and the rest in double precision.
    pub(super) fn solve(
        &mut self,
        problem: &mut Problem,
        criteria: &Criteria,
        softened: Option<&[u32]>,
    ) -> Convergence {
        let parallel = criteria.parallel;
        let mut found = Convergence::default();
        let mut left = *criteria;
        let held = std::mem::take(&mut self.holds);
        let of_single = softened.filter(|_| held == Holder::Single);
        let mut softened = softened.filter(|_| held == Holder::Double);
        let goes_on =
            of_single.is_some_and(|bonds| self.correction.soften(problem, bonds, parallel));
        let taken =
            goes_on || correction::suits(problem) && self.correction.load(problem, parallel);
        if taken {
            self.holds = Holder::Single;
            let single = Single {
                correction: &mut self.correction,
                parallel,
            };
            found = solve_with(problem, single, criteria);
            if found.converged || found.iterations >= criteria.max_iterations {
                return found;
            }
            left.max_iterations -= found.iterations;
            softened = None;
        }
        self.holds = Holder::Double;
        let solve = compiled(problem);
        let more = solve(problem, &mut self.workspace, &left, softened);
        Convergence {
            iterations: found.iterations + more.iterations,
            ..more
        }
    }
}

type Solve = fn(&mut Problem, &mut Workspace, &Criteria, Option<&[u32]>) -> Convergence;

/// The solver compiled for the features of this problem.
fn compiled(problem: &Problem) -> Solve {
    let soft = || problem.contacts.iter().any(|c| c.compliance != [0.0; 2]);
    match (!problem.bonds.is_empty(), problem.friction > 0.0) {
        (true, _) => solve_as::<With<true, true, true>>,
        (false, true) => solve_as::<With<true, false, true>>,
        (false, false) if soft() => solve_as::<With<false, false, true>>,
        (false, false) => solve_as::<With<false, false, false>>,
    }
}

/// Solves a problem, or continues where bonds have softened.
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
    let form = Double::<F> {
        workspace,
        parallel: criteria.parallel,
        features: PhantomData,
    };
    solve_with(problem, form, criteria)
}

/// Solves with a form that has loaded the problem.
fn solve_with<F: Form>(problem: &mut Problem, mut form: F, criteria: &Criteria) -> Convergence {
    let mut asked = *criteria;
    let mut iterations = 0;
    loop {
        let (done, end) = iterate(&mut form, problem, &asked);
        form.store(problem);
        iterations += done;
        let left = measured(problem, criteria.parallel);
        let convergence = convergence(problem, left, iterations, criteria);
        // A form without any residual would never end.
        if convergence.converged || end == End::Stuck || asked.tolerance == 0.0 {
            return convergence;
        }
        if end == End::Reached {
            let missed = criteria.tolerance / convergence.residual;
            asked.tolerance *= missed.clamp(TIGHTER[0], TIGHTER[1]);
        }
        asked.max_iterations -= done;
        asked.min_iterations = 0;
        form.restart(problem);
    }
}

/// Iterates from the present point of the form. Returns the number of iterations, and the reason for their end.
fn iterate<F: Form>(form: &mut F, problem: &Problem, criteria: &Criteria) -> (usize, End) {
    let mut sums = form.run(problem, Pass::Measure);
    let relative = |sums: &PassSums<f64>| problem.relative(sums.defect.sqrt(), sums.size.sqrt());
    let first = relative(&sums);
    let (mut least, mut since) = (f64::INFINITY, 0);
    // p.(W + C) p of the last direction; infinite before the first.
    let mut curvature = f64::INFINITY;
    for iteration in 0..criteria.max_iterations {
        let residual = relative(&sums);
        if residual <= criteria.tolerance && iteration >= criteria.min_iterations {
            return (iteration, End::Reached);
        }
        if residual < F::REDUCED * first {
            return (iteration, End::Reduced);
        }
        if residual < least {
            (least, since) = (residual, iteration);
        }
        if iteration - since > F::PATIENCE {
            return (iteration, End::Stuck);
        }
        let mut beta = -sums.products.wp / curvature;
        if F::THRESHOLDS && sums.held.sqrt() <= INNER * sums.defect.sqrt() {
            sums = form.run(problem, Pass::RenewThresholds);
            beta = 0.0;
        }
        let Some(direction) = Direction::choose(&sums, beta, F::CANCELLED) else {
            return (iteration + 1, End::Stuck);
        };
        curvature = direction.curvature;
        let pass = Pass::Step {
            alpha: direction.descent / curvature,
            beta: direction.beta,
        };
        sums = form.run(problem, pass);
    }
    (criteria.max_iterations, End::Stuck)
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
    /// The conjugate direction, or the steepest descent where the former does not descend; `None` where neither does.
    fn choose(sums: &PassSums<f64>, beta: f64, cancelled: f64) -> Option<Direction> {
        let conjugate = Direction::new(sums, beta);
        if conjugate.descent > 0.0 && conjugate.curvature > cancelled * sums.products.ww {
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
