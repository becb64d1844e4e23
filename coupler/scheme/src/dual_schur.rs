//! Dual Schur complement on displacement with a force that is constant in the window.
//!
//! The increment of the continuum is du = du_free + C lambda; this is exact for a linear continuum if C holds its own
//! columns. One repeat k of a window of length H:
//!
//! ```text
//! du_k       = advance(lambda_k)                          force-driven side, lambda constant in the window
//! a_g        = N (du_k - C lambda_k) / H                  motion of the glued points without their own forces
//! v_g        = a_g + W_g p,  W_g = N C N^T / H^2          boundary on which the contacts are solved, p = H F_g
//! lambda_k+1 = N^T F_g
//! |N du_k+1 - H v_g| <= tolerance                         decides, for any C
//! ```
//!
//! With several motion-driven participants, each uses the forces that the others had in the previous repeat. This is
//! block Jacobi with one block for each layer, ended by the same criterion. The layers answer at the same time, each
//! with its part of C,
//!
//! ```text
//! a_i = N_i (du_k - C_ii lambda_i,k) / H,   W_i = N_i C_ii N_i^T / H^2
//! ```
//!
//! and the part C_ij of another layer arrives with du one repeat later. A step carries a force across one ring of
//! elements: while the layers are further apart than a window has steps, C_ij is exactly zero and one repeat closes the
//! window. Jacobi converges on a positive definite system if the diagonal blocks minus all others are positive definite
//! too (Young 1971, ch. 4). Two layers always fulfil this; more do while the others together move a layer less than it
//! moves itself. In windows so long that the body follows as a whole, n equal layers have a factor of up to n - 1. The
//! secant update keeps C s = y with the last change of force s and of motion y (see
//! [`Compliance::update`](super::compliance::Compliance::update)).
//!
//! Source: Renouf, Saulot and Berthier 2006 for the two scales; dual Schur complement with subcycling after Gravouil and
//! Combescure 2001, here on displacements at the end of the window.

use protocol::Window;

use super::problem::WindowProblem;
use super::vectors::difference;
use super::window::SolvedWindow;
use crate::error::Result;
use crate::keys::Update;

/// Factor of the first compliance of `dual-schur-cheap` over the true one. The scheme never repeats a window, so its
/// compliance errs to the soft side, which is much safer than the stiff one.
pub const CHEAP_FACTOR: f64 = 1.2;

/// Solves a window.
pub fn solve(
    problem: &mut WindowProblem,
    update: Update,
    repeats_max: u32,
    mut window: Window,
) -> Result<SolvedWindow> {
    let repeats_max = match update {
        Update::Cheap => 1,
        _ => repeats_max,
    };
    let mut lambda = problem.start.lambda.clone();
    problem.prepare_boundaries(&window)?;
    problem.begin_advance(&window, &lambda)?;
    // Computed while the continua work.
    let mut c_lambda = problem.carried(&window, &lambda);
    let mut du = problem.finish_advance(&window)?;
    loop {
        let a_g = problem.free_velocity(&window, &du, &c_lambda);
        let answer = problem.solve(&window, &a_g)?;
        let lambda_next = problem.group.mapping.force(&answer.force);
        window.iteration += 1;
        let du_next = problem.advance(&window, &lambda_next)?;
        if update != Update::None {
            let s = difference(&lambda_next, &lambda);
            let y = difference(&du_next, &du);
            problem.compliance.update(window.substeps, &s, &y);
        }
        (lambda, du) = (lambda_next, du_next);
        let layers = problem.group.motion_driven.len();
        let mut verdict = problem.judge(&window, &du, &answer, advice(update, layers));
        if verdict.wants_repeat() && window.iteration < repeats_max {
            problem.prepare_boundaries(&window)?;
            c_lambda = problem.carried(&window, &lambda);
            continue;
        }
        if update == Update::Cheap {
            // This scheme solves once a window; its gap is reported, not judged.
            verdict.open.clear();
        }
        let acting = lambda.clone();
        let faults = verdict.faults();
        return Ok(SolvedWindow::under_constant_force(
            window, &acting, du, lambda, answer, faults,
        ));
    }
}

fn advice(update: Update, layers: usize) -> &'static str {
    match update {
        Update::None if layers > 2 => {
            "with more than two layers on a body, a window converges only while each layer is moved less by the others than by itself: lower substeps, raise repeats_max, or accept the gap with on_not_converged = \"accept\"; for a plastic continuum take scheme = \"dual-schur-secant\""
        }
        Update::None => {
            "the compliance does not fit the continuum: it is plastic, say, or does not start each repeat at the start of the window; take scheme = \"dual-schur-secant\", lower substeps, or accept the gap with on_not_converged = \"accept\""
        }
        Update::Secant | Update::Cheap => {
            "lower substeps, raise repeats_max, or let on_not_converged = \"halve\" the window"
        }
    }
}
