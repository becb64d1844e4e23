//! Errors of the kernel.

use rayon::ThreadPoolBuildError;
use thiserror::Error;

/// Reason for which a step cannot be made.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum KernelError {
    #[error(
        "contact of bodies {a} and {b}: W_nn - friction |W_nt| = {denominator:e} (1/kg) is not positive, sliding has no unique impulse; lower law.friction, or check the wall's compliance or the shape of the cluster that jams (Painleve)"
    )]
    Denominator { a: u32, b: u32, denominator: f64 },
    #[error(
        "contact of bodies {a} and {b}: W_nn W_tt - W_nt^2 = {determinant:e} (1/kg2) is negative or no number, which no bodies have; check the wall's compliance"
    )]
    Indefinite { a: u32, b: u32, determinant: f64 },
    #[error(
        "contact of bodies {a} and {b}: the motion of both is prescribed along its normal, and the contact is rigid, so that no force is determined; give the contacts springs (law.contact_stiffness_pa), or let one of the bodies move freely along the normal"
    )]
    Prescribed { a: u32, b: u32 },
    #[error(
        "the contact impulses are NaN or infinite after {iterations} iterations; lower the step or check the wall's compliance"
    )]
    NotFinite { iterations: usize },
    #[error(
        "heat: contacts pass on {passed:.1e} times the heat of body {body} in a step of heat, and 1e11 is the most that can be computed; look at the units of heat.capacity_j_per_kg_k, of the conductivity or conductance and of half-spaces, or lower heat.every_steps"
    )]
    Heat { body: usize, passed: f64 },
    #[error("cannot start {threads} threads for the contact solver: {error}; run with --threads 1")]
    Threads {
        threads: usize,
        error: ThreadPoolBuildError,
    },
}
