//! `solver`: the choice of a solver and its stopping criteria.

use kit::ConfigError;
use schemars::JsonSchema;
use serde::Deserialize;

use dem_kernel::solver::criteria::{self, Criteria};

/// The algorithm that solves the problem: the words for `solver.kind`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Algorithm {
    /// Block non-linear Gauss-Seidel (NSGS), for all problems.
    Nsgs,
    /// Projected conjugate gradient: fewer iterations for many grains without friction.
    Pcg,
}

/// Treatment of a step that did not converge: the words for `solver.on_not_converged`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OnNotConverged {
    /// The run ends with exit code 3.
    #[default]
    Stop,
    /// The step is accepted and counted.
    Accept,
}

/// `solver`: the solver of the contact problem and its stopping criteria.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SolverConfig {
    /// The algorithm: `nsgs` for all problems, `pcg` for many grains without friction. `pcg` refuses rolling, healing, `law.pairs`, a surface's own
    /// friction, and rigid bonds with friction.
    #[serde(rename = "kind")]
    pub algorithm: Algorithm,
    /// Bound on the true natural-map residual: the norm of D (r - P(r - U/D)) over the norm of D r. D is the diagonal of the Delassus operator, r the
    /// impulses, U the relative velocities and P the projection on the contact law.
    #[schemars(range(min = 1e-14, max = 0.1))]
    pub tolerance: f64,
    /// Iterations after which a step, or the window of a coupled run, counts as not converged.
    #[schemars(range(min = 1))]
    pub max_iterations: usize,
    /// Least number of iterations of a step.
    pub min_iterations: usize,
    /// Treatment of a step of a run alone whose iterations end above the tolerance; the run stops when absent. In a coupled run the interface's key
    /// of this name decides.
    #[serde(default)]
    pub on_not_converged: OnNotConverged,
}

impl SolverConfig {
    /// The criteria of a step, which may use the rayon pool of the caller if it is `parallel`.
    pub fn criteria(&self, parallel: bool) -> Criteria {
        Criteria {
            algorithm: match self.algorithm {
                Algorithm::Nsgs => criteria::Algorithm::Nsgs,
                Algorithm::Pcg => criteria::Algorithm::Pcg,
            },
            tolerance: self.tolerance,
            max_iterations: self.max_iterations,
            min_iterations: self.min_iterations,
            parallel,
        }
    }

    pub(super) fn validate(&self) -> Result<(), ConfigError> {
        let (least, most) = (self.min_iterations, self.max_iterations);
        if least > most {
            let problem = format!("must be at least solver.min_iterations = {least}, got {most}");
            return Err(ConfigError::new("solver.max_iterations", problem));
        }
        Ok(())
    }
}
