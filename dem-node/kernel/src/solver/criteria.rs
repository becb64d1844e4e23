//! The choice of a solver and its stopping criteria.

use serde::Serialize;

/// The algorithm that solves the problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Algorithm {
    /// Block non-linear Gauss-Seidel.
    Nsgs,
    /// Projected conjugate gradient.
    Pcg,
}

/// The solver of the contact problem and its stopping criteria.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Criteria {
    /// The algorithm.
    pub algorithm: Algorithm,
    /// Bound on the relative true natural-map residual.
    pub tolerance: f64,
    /// Iterations after which a step counts as not converged.
    pub max_iterations: usize,
    /// Least number of iterations.
    pub min_iterations: usize,
    /// True if the rayon pool of the caller may be used. The answer has the same bits either way.
    pub parallel: bool,
}
