//! The choice of a solver, its stopping criteria and the way it ended.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The algorithm that solves the problem: the words for `solver.kind`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Algorithm {
    /// Block non-linear Gauss-Seidel.
    Nsgs,
    /// Projected conjugate gradient: fewer iterations where there is no friction and many grains.
    Pcg,
}

/// What becomes of a step that did not converge: the words for `solver.on_not_converged`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OnNotConverged {
    /// The run ends with exit code 3.
    #[default]
    Stop,
    /// The step stands and is counted.
    Accept,
}

/// `solver`: the solver of the contact problem and its stopping criteria.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Criteria {
    /// The algorithm.
    #[serde(rename = "kind")]
    pub algorithm: Algorithm,
    /// Bound on the true natural-map residual, relative.
    #[schemars(range(min = 1e-14, max = 0.1))]
    pub tolerance: f64,
    /// Iterations after which a window counts as not converged.
    #[schemars(range(min = 1))]
    pub max_iterations: usize,
    /// Iterations that are always done.
    pub min_iterations: usize,
    /// What becomes of a step of a run alone whose iterations end above the tolerance; stopped when absent. In a coupled run
    /// the key of the interface decides.
    #[serde(default)]
    pub on_not_converged: OnNotConverged,
    /// True if the rayon pool of the caller may be used, which no key says. The answer has the same bits either way.
    #[serde(skip)]
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
    /// True if the residual is within the tolerance only because it is measured against rounding, not against the impulses.
    pub rounding: bool,
}
