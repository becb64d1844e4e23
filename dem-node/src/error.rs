//! Errors of the node.

use dem_kernel::error::KernelError;
use kit::ConfigError;
use protocol::{Cause, NodeError, WithCure};
use thiserror::Error;

/// Reason for which the node cannot go on.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum DemError {
    #[error("participant.config.{0}")]
    DemConfig(#[from] ConfigError),
    #[error(
        "the bed pressed at {pressure_pa:e} Pa is not at rest after {iterations} relaxation steps: unbalanced force {unbalanced:.2e} of the mean contact force; choose another seed or a smaller sample.half_width_m: a bed of {diameters:.0} diameters may come to rest late, and no layer may be wider than the body below"
    )]
    NotAtRest {
        pressure_pa: f64,
        iterations: usize,
        unbalanced: f64,
        /// Length of the bed over the mean diameter.
        diameters: f64,
    },
    #[error(
        "the grains of the rail are not at rest after {iterations} relaxation steps: unbalanced force {unbalanced:.2e} of the mean contact force, {needed:e} is rest; choose another seed"
    )]
    RailNotAtRest {
        iterations: usize,
        unbalanced: f64,
        needed: f64,
    },
    #[error(
        "the bed is not jammed: {coordination:.2} contacts per grain without rattlers, a frictionless packing needs {needed}; choose another seed or a higher sample.press_pa"
    )]
    NotJammed { coordination: f64, needed: f64 },
    #[error(
        "{pair} overlap by {overlap_m:e} m, {relative:.3} of the smaller radius, and the contacts are rigid: move them apart or give law.contact_stiffness_pa"
    )]
    Overlap {
        pair: String,
        overlap_m: f64,
        relative: f64,
    },
    #[error(transparent)]
    Kernel(#[from] KernelError),
    #[error(
        "window {window}: the contact solver stands at a true residual of {residual:.2e} after {iterations} iterations, the tolerance is {tolerance:.1e}; {}",
        cure(*rigid, *friction, *iterations, *pivots_after)
    )]
    NotConverged {
        window: u64,
        residual: f64,
        iterations: usize,
        tolerance: f64,
        rigid: bool,
        friction: f64,
        /// Sweeps after which the solver looks for the solution by pivoting, if it does.
        pivots_after: Option<usize>,
    },
    #[error(
        "window {window}: the repair of overlaps (law.penetration) stands at a true residual of {residual:.2e} after {iterations} iterations, its tolerance is {tolerance:.1e}; raise solver.max_iterations, lower the step, or write law.penetration = \"iqs\""
    )]
    NotRepaired {
        window: u64,
        residual: f64,
        iterations: usize,
        tolerance: f64,
    },
    #[error("step of {step_s:e} s is above the {bound} of {limit_s:e} s: {help}")]
    Step {
        step_s: f64,
        limit_s: f64,
        bound: &'static str,
        help: &'static str,
    },
    #[error("{0}")]
    Request(String),
    #[error("cannot write {path}: {}", WithCure(.source))]
    Write {
        path: String,
        source: std::io::Error,
    },
}

/// Friction above which sweeps of elastic grains may run in a circle: no layer has been seen to do so below.
const STRONG_FRICTION: f64 = 3.0;

/// Advice for a step that does not converge. More iterations alone seldom help where pivoting has failed.
fn cure(rigid: bool, friction: f64, iterations: usize, pivots_after: Option<usize>) -> String {
    let springs = "give the contacts springs (law.contact_stiffness_pa)";
    if let Some(sweeps) = pivots_after.filter(|sweeps| iterations < *sweeps) {
        return format!(
            "raise solver.max_iterations: after {sweeps} sweeps the solution is looked for by pivoting; or lower the step"
        );
    }
    if pivots_after.is_some() {
        let or_springs = rigid.then(|| format!(" or {springs}"));
        let or_springs = or_springs.unwrap_or_default();
        return format!(
            "lower the step{or_springs}: more sweeps seldom help, and pivoting has not"
        );
    }
    if rigid && friction > 0.0 {
        return format!("write solver.kind = \"nsgs\", {springs} or lower the step");
    }
    let mut cure = "lower the step or raise solver.max_iterations".to_owned();
    if friction >= STRONG_FRICTION {
        cure += &format!(", or lower law.friction: at {friction} the solver may run in a circle");
    }
    cure
}

impl DemError {
    /// Its cause, a word for scripts.
    pub fn cause(&self) -> Cause {
        match self {
            DemError::DemConfig(error) => error.cause,
            DemError::Overlap { .. } => Cause::OverlappingDisks,
            DemError::Step { .. } => Cause::StepTooLong,
            DemError::Kernel(KernelError::Threads { .. }) => Cause::ThreadsUnavailable,
            DemError::Write { .. } => Cause::WriteFailed,
            DemError::Request(_) => Cause::ProtocolViolated,
            DemError::NotAtRest { .. } | DemError::RailNotAtRest { .. } => Cause::SampleNotAtRest,
            DemError::NotJammed { .. } => Cause::SampleNotJammed,
            DemError::Kernel(
                KernelError::Denominator { .. }
                | KernelError::Indefinite { .. }
                | KernelError::Prescribed { .. },
            ) => Cause::SlidingNotUnique,
            DemError::NotConverged { .. } | DemError::NotRepaired { .. } => {
                Cause::ContactNotConverged
            }
            DemError::Kernel(KernelError::NotFinite { .. } | KernelError::Heat { .. }) => {
                Cause::Diverged
            }
        }
    }
}

impl From<DemError> for NodeError {
    fn from(error: DemError) -> NodeError {
        NodeError::of(error.cause(), error.to_string())
    }
}
