//! Equal velocities at the end of each window (Gravouil and Combescure 2001, with the layer as the coarse side).
//!
//! The velocity of the continuum's interface changes linearly in time to v. The continuum answers with the force at the
//! end of the window, lambda = lambda_f + D v; this is exact if it is linear and D is its own impedance. With C = H
//! D^-1, and H v in place of du, the layer gets the same boundary as in [`super::dual_schur`],
//!
//! ```text
//! W_g = N C N^T / H^2,   a_g = N (H v_k - C lambda_k) / H,   v_k+1 = v_k + C (N^T F_g - lambda_k) / H
//! ```
//!
//! and the run along v_k+1 decides: C times the difference between its force and N^T F_g must be within the tolerance.
//!
//! H D = M_i + H^2/2 K_i + sum L L^T (1 - cos(omega H)) is never less than the lumped masses of the interface, so that
//! C exists for any window. Differentiated once, the continuum conserves W = a.(M - h^2/4 K).a / 2 + v.K v / 2 inside a
//! window except for the work a_s.(lambda - lambda_0) of the layer, a_s = (v - v_0) / H, and the implicit layer takes
//! up exactly this work. At the bend of the velocity between two windows W loses M_i (a_s - a_s0)^2 / 2 and the jump of
//! h^2/8 a.K a. Hence for theta = 1 only that term of h^2 can make W grow, while the mechanical energy itself may rise
//! for a window. With the *mean* force of the window instead of the force at its end there is no such balance, and the
//! scheme is unstable.
//!
//! The price: the displacements of both sides differ by H (v - v_0) / 2, which does not accumulate, and the impulse on
//! the continuum comes from its own force along the window, not from H lambda. The force residual therefore compares
//! the forces at the end, and the energy of the interface is the work along the window. With several layers each uses
//! the forces that the others had in the previous repeat, which needs many repeats where the continuum between them is
//! nearly rigid.

use protocol::{Reaction, Window};

use super::problem::WindowProblem;
use super::vectors::{difference, motion_of};
use super::window::SolvedWindow;
use crate::error::Result;

/// Advice for velocities that did not become equal.
const ADVICE: &str = "the continuum does not follow its own impedance (it is nonlinear, say), or it carries several walls that act on each other; raise repeats_max, take scheme = \"dual-schur-secant\", lower substeps, or let on_not_converged = \"halve\" the window";

/// Solves a window.
pub fn solve(
    problem: &mut WindowProblem,
    repeats_max: u32,
    mut window: Window,
) -> Result<SolvedWindow> {
    let window_s = problem.group.window_s(&window);
    let mut velocity = problem.start.velocity.clone();
    let mut reaction = problem.prescribe_velocity(&window, &velocity)?;
    loop {
        problem.prepare_boundaries(&window)?;
        let c_lambda = problem.carried(&window, &reaction.force);
        let a_g = problem.free_velocity(&window, &motion_of(&velocity, window_s), &c_lambda);
        let answer = problem.solve(&window, &a_g)?;
        let force = problem.group.mapping.force(&answer.force);
        let more = missing(problem, &window, &force, &reaction);
        for (v, du) in velocity.iter_mut().zip(&more) {
            *v += du / window_s;
        }
        window.iteration += 1;
        reaction = problem.prescribe_velocity(&window, &velocity)?;
        let increment = motion_of(&velocity, window_s);
        let more = missing(problem, &window, &force, &reaction);
        let wanted: Vec<f64> = increment.iter().zip(&more).map(|(a, b)| a + b).collect();
        let verdict = problem.judge(&window, &wanted, &answer, ADVICE);
        if verdict.wants_repeat() && window.iteration < repeats_max {
            continue;
        }
        return Ok(SolvedWindow {
            window,
            increment,
            wanted,
            borne: reaction.force,
            work: reaction.work,
            velocity: Some(velocity),
            inertia: Vec::new(),
            lambda: force,
            answer,
            faults: verdict.faults(),
        });
    }
}

/// C (F - lambda) (m): the further motion of the nodes that brings their force to F at the end.
fn missing(
    problem: &WindowProblem,
    window: &Window,
    force: &[f64],
    reaction: &Reaction,
) -> Vec<f64> {
    let missing = difference(force, &reaction.force);
    problem.compliance.times(window.substeps, &missing)
}
