//! Failures of a step or of an equilibrium.

use protocol::Cause;
use thiserror::Error;

/// Most memory of the directions from which modes are computed (bytes).
pub(crate) const MODES_BYTES: f64 = 2e9;

/// Failure of a step or of an equilibrium.
#[derive(Clone, Debug, Error)]
pub enum KernelError {
    /// A law of contact is violated after a step.
    #[error(
        "step {step}, t = {time_s:.6e} s: the contact with the wheel left a residual of {residual:.2e} after {sweeps} sweeps: a heavier wheel.mass_kg converges faster, a flat wheel (wheel.radius_m = 0) needs no sweeps"
    )]
    Contact {
        /// Own steps since the start of the run.
        step: u64,
        /// Time (s).
        time_s: f64,
        /// Sweeps done.
        sweeps: usize,
        /// Residual after the sweeps.
        residual: f64,
    },
    /// The stiffness is singular.
    #[error(
        "its stiffness ({equations} equations) has no Cholesky factor: {reason}; check base and sides (the body must be held) and the mesh (no element may be inside out)"
    )]
    Factor {
        /// Components that can move.
        equations: usize,
        /// Report of the factorisation.
        reason: String,
    },
    /// Modes need more memory than a set-up may take.
    #[error(
        "its modes need directions of {equations} numbers each, and {directions} of them exceed {MODES_BYTES:.0e} bytes: ask for at most {most} modes, lower reduced.omega_max_per_s, or keep the elements, which cost less than so large a number of modes"
    )]
    TooManyModes {
        /// Components that can move.
        equations: usize,
        /// Directions of the iteration.
        directions: usize,
        /// Most modes within the memory.
        most: usize,
    },
    /// A law of contact is violated after an increment.
    #[error(
        "increment {increment} of the static contact (load {load_n:?} N, sideways {lateral_m:?} m, friction {friction:?}): after {iterations} rounds a law of contact is still violated by {violation_n:.3e} N; lower statics.increment_n (of a wheel that rolls, its creepage), or lower contact.friction"
    )]
    ContactNotConverged {
        /// Increment of the load or of the motion.
        increment: usize,
        /// Vertical force on the wheel (N).
        load_n: f64,
        /// Sideways position of the wheel (m).
        lateral_m: f64,
        /// Coefficient of friction.
        friction: f64,
        /// Violation of a law, as a force (N).
        violation_n: f64,
        /// Rounds done.
        iterations: usize,
    },
    /// The contact is too wide for the normals of the undeformed edge.
    #[error(
        "the static contact has become {half_width_m:.3e} m wide on each side under {load_n:?} N, more than half of wheel.radius_m = {radius_m:?} m, but is solved with the normals of the undeformed edge: raise the radius, or lower wheel.load_n"
    )]
    NarrowWheel {
        /// Radius of the face (m).
        radius_m: f64,
        /// Half of the width of the contact (m).
        half_width_m: f64,
        /// Vertical force on the wheel (N).
        load_n: f64,
    },
    /// A displacement exceeds the size of the body.
    #[error(
        "in equilibrium a node or the wheel has moved by {displacement_m:.3e} m, but the body is {size_m:.3e} m large: check the units of wheel.load_n (N), boundary tractions (Pa), material.young_pa (Pa) and run.thickness_m (m)"
    )]
    StaticSize {
        /// Displacement of a node or the wheel (m).
        displacement_m: f64,
        /// Larger extent of the mesh (m).
        size_m: f64,
    },
}

impl KernelError {
    /// The cause as a word for scripts.
    pub fn cause(&self) -> Cause {
        match self {
            KernelError::Contact { .. } | KernelError::ContactNotConverged { .. } => {
                Cause::ContactNotConverged
            }
            KernelError::Factor { .. } => Cause::SingularStiffness,
            KernelError::TooManyModes { .. } => Cause::TooMany,
            KernelError::NarrowWheel { .. } => Cause::ContactTooWide,
            KernelError::StaticSize { .. } => Cause::DisplacementTooLarge,
        }
    }
}
