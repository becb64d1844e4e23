//! Errors after the configuration was accepted.

use std::io;
use std::path::{Path, PathBuf};

use fem_kernel::error::KernelError;
use fem_kernel::reduced::near::RADIUS_MAX;
use kit::ConfigError;
use protocol::{Cause, NodeError, Window, WithCure};
use rayon::{ThreadPool, ThreadPoolBuilder};
use thiserror::Error;

/// Failure to build a body, or to answer a request.
#[derive(Clone, Debug, Error)]
#[allow(missing_docs)]
pub enum FemError {
    #[error("participant.config.{0}")]
    FemConfig(#[from] ConfigError),
    #[error(transparent)]
    Kernel(#[from] KernelError),
    #[error(
        "its pool of {threads} threads cannot be started: {reason}; ask for fewer with --threads"
    )]
    Pool { threads: usize, reason: String },
    #[error(
        "it has no set `{set}` that is one open line on its outline: an interface can name {known}"
    )]
    UnknownSet { set: String, known: String },
    #[error(
        "its set `bottom` is the support of the body and does not move: an interface can name top, left or right, or bottom with base = \"free\""
    )]
    SupportedSet,
    #[error(
        "its set `{set}` moves as boundary.{set} prescribes and takes no force: name another set, or remove the motion"
    )]
    MovedSet { set: String },
    #[error(
        "point {point} was selected; the coupled sets have {count} points, and each may be selected once"
    )]
    Point { point: usize, count: usize },
    #[error(
        "window {window}: the interface {what} holds {given} numbers, but {expected} are expected"
    )]
    GivenLength {
        window: u64,
        what: &'static str,
        given: usize,
        expected: usize,
    },
    #[error("a run of 0 steps was requested; it needs at least 1")]
    NoSteps,
    #[error("window {window} is to be committed, {}", .advanced.map_or("but none was advanced".into(), |w| format!("but window {w} was advanced last")))]
    NotAdvanced { window: u64, advanced: Option<u64> },
    #[error(
        "window {window}: displacements of {count} components were prescribed, but this body computes its own from the forces"
    )]
    Dictated { window: u64, count: usize },
    #[error(
        "window {window}, iteration {iteration}, t = {time_s:.6e} s: a displacement of {displacement_m:?} m exceeds the size of the body: the solution diverged; {}",
        cure(*step_s, *limit_s)
    )]
    Diverged {
        window: u64,
        iteration: u32,
        time_s: f64,
        displacement_m: f64,
        step_s: f64,
        limit_s: f64,
    },
    #[error(
        "window {window}, iteration {iteration}: the {component} component of the {what} on exchanged point {point} is {number:?} {unit}, which is not finite: the other participant or the coupler diverged; lower the window or the step there"
    )]
    GivenNotFinite {
        window: u64,
        iteration: u32,
        point: usize,
        component: char,
        what: &'static str,
        number: f64,
        unit: &'static str,
    },
    #[error(
        "window {window}, iteration {iteration}, step {step}, t = {time_s:.6e} s: the kinetic energy of the body, {kinetic_j:.3e} J, is more than ten times the {supplied_j:.3e} J supplied by all forces: the solution diverged; {}",
        cure(*step_s, *limit_s)
    )]
    EnergyExcess {
        window: u64,
        iteration: u32,
        step: u64,
        time_s: f64,
        kinetic_j: f64,
        supplied_j: f64,
        step_s: f64,
        limit_s: f64,
    },
    #[error(
        "the columns of its {what} over {substeps} steps are not finite; {}",
        cure(*step_s, *limit_s)
    )]
    DivergedColumns {
        what: &'static str,
        substeps: u32,
        step_s: f64,
        limit_s: f64,
    },
    #[error("it has no `heat` and takes none: give it [participant.config.heat]")]
    NoHeat,
    #[error(
        "its set `{set}` cannot be coupled: the body carries a wheel of its own on its upper edge; remove [participant.config.wheel], or give the wheel to the other participant"
    )]
    CoupledWithWheel { set: String },
    #[error(
        "its set `{set}` cannot be coupled: the body has `heat`, whose layers lie at `{layers}`; couple `{layers}`, or remove [participant.config.heat]"
    )]
    CoupledWithHeat { set: String, layers: &'static str },
    #[error(
        "it cannot follow a velocity on its coupled set: its material is nonlinear, or it carries a wheel of its own; give it an elastic small-strain material, or join it by scheme = \"dual-schur-secant\""
    )]
    NoPrescribedVelocity,
    #[error(
        "a static analysis cannot be coupled through its set `{set}`: write analysis = \"dynamic\", or remove the [[interface]]"
    )]
    CoupledStatics { set: String },
    #[error(
        "reduced.near_m = {near_m:e} m is too short for windows of {substeps} substeps ({window_s:.3e} s) with {modes} modes: {} (bound {RADIUS_MAX}); with these modes {needed_m:.2e} m would do (\"auto\" finds it), and more modes need less",
        radius_in_words(*radius)
    )]
    NearTooShort {
        near_m: f64,
        radius: f64,
        needed_m: f64,
        modes: usize,
        substeps: u32,
        window_s: f64,
    },
    #[error("fields cannot be written to {}: {reason}", .path.display())]
    Write { path: PathBuf, reason: String },
    #[error("`{name}` cannot name a snapshot: use letters, digits, `-`, `_` and `.`")]
    SnapshotName { name: String },
}

/// The advice after divergence with steps (s) and this stability limit (s): a step below the limit is not the cause.
fn cure(step_s: f64, limit_s: f64) -> String {
    let steps = format!("its step is {step_s:.4e} s, the stability limit {limit_s:.4e} s");
    if step_s > limit_s {
        return format!("{steps}: lower time.step_s, the window, or the load");
    }
    format!(
        "{steps}, so a shorter step does not help: check the load, the dimensions and the units of material.young_pa and material.density_kg_per_m3, or shorten the window"
    )
}

/// The spectral radius of a split compliance, infinite where its near part is not positive definite.
fn radius_in_words(radius: f64) -> String {
    if radius.is_finite() {
        return format!(
            "a force on points further away comes back {radius:.3} times as large in the next window"
        );
    }
    "its compliance is not positive definite".into()
}

impl FemError {
    /// A pool of this many threads.
    pub(crate) fn pool(threads: usize) -> Result<ThreadPool, FemError> {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        pool.map_err(|error| FemError::Pool {
            threads,
            reason: error.to_string(),
        })
    }

    /// The data of this window, out of the number and the data of the window advanced last.
    pub(crate) fn advanced<T>(window: &Window, last: Option<(u64, T)>) -> Result<T, FemError> {
        let advanced = last.as_ref().map(|(index, _)| *index);
        let kept = last.filter(|(index, _)| *index == window.index);
        kept.map(|(_, kept)| kept).ok_or(FemError::NotAdvanced {
            window: window.index,
            advanced,
        })
    }

    /// The outcome of writing a file.
    pub(crate) fn written(path: &Path, outcome: io::Result<()>) -> Result<(), FemError> {
        outcome.map_err(|error| FemError::Write {
            path: path.into(),
            reason: WithCure(&error).to_string(),
        })
    }

    /// The cause as a word for scripts.
    pub fn cause(&self) -> Cause {
        match self {
            FemError::FemConfig(error) => error.cause,
            FemError::Kernel(error) => error.cause(),
            FemError::Pool { .. } => Cause::ThreadsUnavailable,
            FemError::UnknownSet { .. } => Cause::UnknownSet,
            FemError::SupportedSet | FemError::MovedSet { .. } => Cause::SetIsHeld,
            FemError::CoupledWithWheel { .. } => Cause::WheelOnCoupledBody,
            FemError::CoupledWithHeat { .. } | FemError::NoHeat => Cause::NotOffered,
            FemError::CoupledStatics { .. } => Cause::StaticBodyCoupled,
            FemError::NoPrescribedVelocity => Cause::NotOffered,
            FemError::NearTooShort { .. } => Cause::OutOfRange,
            FemError::SnapshotName { .. } => Cause::ParticipantRefused,
            FemError::Diverged { .. }
            | FemError::EnergyExcess { .. }
            | FemError::DivergedColumns { .. } => Cause::Diverged,
            FemError::GivenNotFinite { .. } => Cause::InputNotFinite,
            FemError::Point { .. }
            | FemError::GivenLength { .. }
            | FemError::NoSteps
            | FemError::NotAdvanced { .. }
            | FemError::Dictated { .. } => Cause::ProtocolViolated,
            FemError::Write { .. } => Cause::WriteFailed,
        }
    }
}

impl From<FemError> for NodeError {
    fn from(error: FemError) -> NodeError {
        NodeError::of(error.cause(), error.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 70 Pa instead of 70 GPa: the stability limit of such a soft body is 40 000 times the step.
    #[test]
    fn a_step_below_the_stability_limit_is_not_blamed() {
        let blames = |step_s: f64| {
            let diverged = FemError::DivergedColumns {
                what: "flexibility",
                substeps: 9,
                step_s,
                limit_s: 2.8e-3,
            };
            diverged.to_string().contains("lower time.step_s")
        };
        assert_eq!([6.8e-8, 2.8e-3, 2.9e-3].map(blames), [false, false, true]);
    }
}
