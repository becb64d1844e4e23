//! The contact problem of one step and its solvers.
//!
//! Unknown are the contact impulses r (N s) and the velocities v after the step:
//! v = v_free + M^-1 H r, u = H^T v, and at each contact U = u + (g/h, d_t/h) + r/(k h^2) obeys Signorini-Coulomb
//! (equation 8 of Renouf, Saulot and Berthier 2006, with one law per contact).
//!
//! In reading order:
//! - [`criteria`]: the choice of a solver and its stopping criteria;
//! - [`contact`], [`partition`], `pieces`: a contact, and problems in pieces;
//! - [`problem`], [`residual`]: the contact problem, and the distance of a guess from the solution;
//! - `groups`, `extrapolation`, [`acceleration`]: sweeps by packs of contacts, and their acceleration;
//! - `lemke`: pivoting, where sweeps fail;
//! - [`nsgs`], [`pcg`]: the two solvers.

pub mod acceleration;
pub mod contact;
pub mod criteria;
pub(crate) mod extrapolation;
pub(crate) mod groups;
pub(crate) mod lemke;
pub mod nsgs;
pub mod partition;
pub mod pcg;
pub(crate) mod pieces;
pub mod problem;
pub mod residual;
pub mod rolling;

use crate::error::KernelError;
use criteria::{Algorithm, Criteria};
use problem::Problem;
use residual::Convergence;

/// The solvers with their buffers.
#[derive(Clone, Debug, Default)]
pub struct Solver {
    sweeper: groups::Sweeper,
    conjugate: pcg::Buffers,
}

impl Solver {
    /// Solves for impulses and velocities. The impulses found in the contacts are the first guess; the velocities
    /// must be the free ones. `converged = false` is a valid answer, NaN is an error.
    pub fn solve(
        &mut self,
        problem: &mut Problem,
        criteria: &Criteria,
    ) -> Result<Convergence, KernelError> {
        problem.prepare(criteria.tolerance, criteria.parallel)?;
        let convergence = match criteria.algorithm {
            Algorithm::Nsgs => nsgs::solve(problem, &mut self.sweeper, criteria),
            Algorithm::Pcg => pcg::solve(problem, &mut self.conjugate, criteria),
        };
        finite(problem, convergence)
    }

    /// Continues from the last solution after the bonds of these contacts have become softer: the loaded data stays, and few iterations are needed.
    pub fn go_on(
        &mut self,
        problem: &mut Problem,
        criteria: &Criteria,
        softened: &[u32],
    ) -> Result<Convergence, KernelError> {
        problem.prepare_bonds(softened)?;
        let convergence = match criteria.algorithm {
            Algorithm::Nsgs => {
                self.sweeper.take_bonds(problem);
                nsgs::sweep(problem, &mut self.sweeper, criteria)
            }
            Algorithm::Pcg => self.conjugate.solve(problem, criteria, Some(softened)),
        };
        finite(problem, convergence)
    }
}

impl Solver {
    /// Contacts whose bonds may fall under the last solution; `None` where all bonds have to be tried.
    pub fn falling(&self, problem: &Problem) -> Option<Vec<u32>> {
        self.sweeper.falling(problem)
    }
}

/// Refuses an answer that is NaN or infinite.
fn finite(problem: &mut Problem, convergence: Convergence) -> Result<Convergence, KernelError> {
    problem.boundary.evaluate();
    if convergence.residual.is_finite() {
        return Ok(convergence);
    }
    Err(KernelError::NotFinite {
        iterations: convergence.iterations,
    })
}
