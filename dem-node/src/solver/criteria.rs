//! The choice of a solver, its stopping criteria and the way it ended.

use serde::{Deserialize, Serialize};

/// The algorithm that solves the problem: the words for `solver.kind`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Algorithm {
    /// Block non-linear Gauss-Seidel.
    Nsgs,
    /// Projected conjugate gradient: fewer iterations where there is no friction and many grains.
    Pcg,
}

/// Stopping criteria of a solver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Criteria {
    /// The algorithm.
    pub algorithm: Algorithm,
    /// Bound on the true residual.
    pub tolerance: f64,
    /// Fewest iterations.
    pub min_iterations: usize,
    /// Most iterations.
    pub max_iterations: usize,
    /// True if the rayon pool of the caller may be used. The answer has the same bits either way.
    pub parallel: bool,
}

/// State of convergence in which a solver ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Convergence {
    /// Iterations done.
    pub iterations: usize,
    /// True natural-map residual, relative.
    pub residual: f64,
    /// LMGC90's incremental criterion, the largest of its three norms.
    pub quad: f64,
    /// True if the residual is within the tolerance.
    pub converged: bool,
}
