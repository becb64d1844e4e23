//! Dual Schur complement on displacement with a force that is constant in the window.
//!
//! The increment of the continuum is du = du_free + C lambda, exactly so if it is linear and C holds its own columns. One
//! repeat k of a window of length H:
//!
//! ```text
//! du_k       = advance(lambda_k)                          force-driven side, lambda constant in the window
//! a_g        = N (du_k - C lambda_k) / H                  motion of the glued points without their own forces
//! v_g        = a_g + W_g p,  W_g = N C N^T / H^2          boundary on which the contacts are solved, p = H F_g
//! lambda_k+1 = N^T F_g
//! |N du_k+1 - H v_g| <= tolerance                         decides, whatever C was
//! ```
//!
//! Of several motion-driven participants each takes the forces of the others as they were in the run before: that is block
//! Jacobi, one block a layer, which the same criterion ends. The layers answer at the same time, each on its part of C,
//!
//! ```text
//! a_i = N_i (du_k - C_ii lambda_i,k) / H,   W_i = N_i C_ii N_i^T / H^2
//! ```
//!
//! and the part C_ij of another layer comes with du one repeat later. It is exactly zero while the layers are further apart than
//! the rings of elements that a window has steps, as a step carries a force by one; one repeat closes the window then. Jacobi converges on a
//! positive definite system if its diagonal blocks less all others are positive definite, too (Young 1971, ch. 4): always for two
//! layers, for more while the others together move a layer less than it moves itself. In windows so long that the body follows as a whole n
//! layers alike have a factor of up to n - 1. The secant update keeps C s = y with the last change of force s and of motion y
//! (see [`Compliance::update`](super::compliance::Compliance::update)).
//!
//! Source: Renouf, Saulot and Berthier 2006 for the two scales; dual Schur complement with subcycling after Gravouil and
//! Combescure 2001, here on displacements at the end of the window.

use protocol::Window;

use super::problem::WindowProblem;
use super::vectors::difference;
use super::window::SolvedWindow;
use crate::error::Result;
use crate::keys::Update;

/// Softness of the first compliance of `dual-schur-cheap` over the true one: it never looks back, so that its compliance
/// errs to the soft side, which is far safer than too stiff.
pub const CHEAP_FACTOR: f64 = 1.2;

/// Solves a window.
pub fn solve(
    problem: &mut WindowProblem,
    update: Update,
    repeats_max: u32,
    mut window: Window,
) -> Result<SolvedWindow> {
    let repeats_max = if update == Update::Cheap {
        1
    } else {
        repeats_max
    };
    let mut lambda = problem.start.lambda.clone();
    problem.prepare_boundaries(&window)?;
    problem.begin_advance(&window, &lambda)?;
    // Formed while the continua are at work.
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
            // One solve a window is the whole of this scheme; its gap is reported, not judged.
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
            "more than two layers close a window of their body only while each is moved less by the others than by itself: lower substeps, raise repeats_max, or accept with on_not_converged = \"accept\"; for a plastic continuum take scheme = \"dual-schur-secant\""
        }
        Update::None => {
            "the compliance does not fit the continuum, as of a plastic one, or of one that does not begin each repeat where the window began; take scheme = \"dual-schur-secant\", lower substeps, or accept with on_not_converged = \"accept\""
        }
        Update::Secant | Update::Cheap => {
            "lower substeps, raise repeats_max, or let on_not_converged = \"halve\" the window"
        }
    }
}
