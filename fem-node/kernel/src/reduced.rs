//! A linear body as its lowest modes and its static flexibility.
//!
//! A body that is loaded on a few nodes moves by its low modes; all others follow the load as in equilibrium. With the modes Phi, Omega that are kept
//! and the static flexibility F = K^-1 of the loaded components, the displacement under the force f is
//!
//! ```text
//! u = Phi eta + F_res f,     F_res = F - Phi Omega^-2 Phi^T     MacNeal (1971), residual flexibility
//! ```
//!
//! Each mode is moved by the scheme of the body itself ([`oscillator`]), so that a body with all of its modes moves like the body. The
//! flexibility F_res of the modes left out has no mass: under a constant force the body comes to K^-1 f with any number of modes.
//!
//! # Near and far
//!
//! Over a window of n steps under a constant interface force lambda the compliance is C = Phi q Phi^T + F_res, with q of the n-fold step. It is full:
//! a static flexibility reaches through the whole body, and a dense boundary makes a contact problem dear. So the part of C between points
//! further apart than a distance R acts one window late,
//!
//! ```text
//! u+ = Phi eta+ + F_res lambda - C_far (lambda - lambda_prev),     C_far = C where |x_i - x_j| > R
//!    = (motion without lambda) + C_near lambda
//! ```
//!
//! which leaves constant forces exact. The windows are stable for a boundary of any inertia while C_near is positive definite and the spectral radius
//! of C_near^-1 C_far stays below one; [`near`] chooses R by a bound on both.
//!
//! # Energies
//!
//! The modes store eta Omega^2 eta / 2 and the residual stores f F_res f / 2. Scheme and mass damping act on the modes. The residual moves at once when
//! its force jumps, and loses df F_res df / 2; the far field adds lambda d(-C_far dlambda), which has either sign and tends to 0 with the change of the
//! force. [`surface::ReducedSurface::commit`] computes them.
//!
//! - [`modes`]: the lowest modes;
//! - [`oscillator`]: a mode over a window;
//! - [`near`]: the near and the far part of a compliance;
//! - [`surface`]: the components that are exchanged, loaded or reported, over a window.

pub mod modes;
pub mod near;
pub mod oscillator;
pub mod surface;

use crate::error::KernelError;
use crate::statics::factor::Factor;
use crate::statics::problem::StaticProblem;

use modes::{ModeChoice, Modes, add, dot};
use oscillator::ModeState;

/// A supported linear body with its modes.
#[derive(Default)]
pub struct ReducedBody {
    /// The modes that are kept.
    pub modes: Modes,
    /// The factor of its stiffness, once something needs it.
    factor: Option<Factor>,
}

impl ReducedBody {
    /// The lowest modes of the body of this problem.
    pub fn lowest(
        &mut self,
        problem: &StaticProblem,
        choice: ModeChoice,
    ) -> Result<Modes, KernelError> {
        Modes::lowest(problem.body, factor(&mut self.factor, problem)?, choice)
    }

    /// Displacements (m) and velocities (m/s) of the whole body under these forces (N), as fields.
    pub fn recovered(
        &mut self,
        problem: &StaticProblem,
        states: &[ModeState],
        force: &[f64],
    ) -> Result<[Vec<f64>; 2], KernelError> {
        let factor = factor(&mut self.factor, problem)?;
        let components = factor.components();
        let own: Vec<f64> = components.iter().map(|c| force[*c]).collect();
        let mut moved = vec![own.clone()];
        factor.solve_columns(&mut moved);
        let mut u = moved.swap_remove(0);
        let mut v = vec![0.0; u.len()];
        let modes = self.modes.shapes.iter().zip(&self.modes.omega);
        for ((shape, omega), state) in modes.zip(states) {
            add(&mut u, state.u - dot(shape, &own) / (omega * omega), shape);
            add(&mut v, state.v, shape);
        }
        Ok([u, v].map(|numbers| factor.field(&numbers, force.len())))
    }
}

/// The factor, made if it is not there: modes and surfaces that are known need none.
fn factor<'a>(
    known: &'a mut Option<Factor>,
    problem: &StaticProblem,
) -> Result<&'a Factor, KernelError> {
    let made = match known.take() {
        Some(factor) => factor,
        None => Factor::new(problem)?,
    };
    Ok(known.insert(made))
}
