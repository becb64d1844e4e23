//! Fixed point with forces one way and motion the other: the continuum takes forces (Neumann side), the layer takes
//! motion (Dirichlet side). [`super::neumann_dirichlet`] exchanges the roles.
//!
//! ```text
//! du_k       = advance(lambda_k)
//! F_g        = solve(v_g = N du_k / H)
//! lambda_k+1 = accelerated(lambda_k, N^T F_g)             constant relaxation, Aitken or IQN-ILS
//! |N du_k+1 - N du_k| <= tolerance                        decides
//! ```
//!
//! The black-box scheme for a solver that cannot stand on a yielding boundary. With C the continuum's compliance in the
//! window and S the other side's resistance -dF/du, a constant relaxation omega contracts by |1 - omega (1 + C S)| a
//! repeat (Causin, Gerbeau and Nobile 2005; Kuettler and Wall 2008). A rigid confined layer must never be the plain
//! Dirichlet side: its force is not a function of the motion.

use protocol::Window;

use super::acceleration::Accelerator;
use super::problem::WindowProblem;
use super::window::SolvedWindow;
use crate::error::Result;
use crate::keys::Order;

/// The rules of a fixed point.
pub struct FixedPoint {
    /// Order in which the sides run.
    pub order: Order,
    /// Acceleration, with an empty history.
    pub accelerator: Accelerator,
    /// Repeats before the window counts as not converged.
    pub repeats_max: u32,
}

/// Advice for a fixed point that was not reached.
const ADVICE: &str = "the fixed point was not reached; raise repeats_max, take acceleration = \"iqn-ils\", lower relaxation, or take a dual-schur scheme";

/// Solves a window.
pub fn solve(
    problem: &mut WindowProblem,
    rules: FixedPoint,
    mut window: Window,
) -> Result<SolvedWindow> {
    let FixedPoint {
        order,
        mut accelerator,
        repeats_max,
    } = rules;
    problem.prepare_boundaries(&window)?;
    let mut lambda = problem.start.lambda.clone();
    let mut motion = match order {
        Order::Serial => {
            let du = problem.advance(&window, &lambda)?;
            problem.group.mapping.motion(&du)
        }
        Order::Parallel => problem.start.last_motion.clone(),
    };
    loop {
        let answer = match order {
            Order::Serial => problem.solve_rigid(&window, &motion)?,
            Order::Parallel => {
                problem.begin_advance(&window, &lambda)?;
                let answer = problem.solve_rigid(&window, &motion);
                problem.finish_advance(&window)?;
                answer?
            }
        };
        lambda = accelerator.next(&lambda, &problem.group.mapping.force(&answer.force));
        window.iteration += 1;
        let du = problem.advance(&window, &lambda)?;
        let verdict = problem.judge(&window, &du, &answer, ADVICE);
        motion = problem.group.mapping.motion(&du);
        if verdict.wants_repeat() && window.iteration < repeats_max {
            continue;
        }
        let acting = lambda.clone();
        let faults = verdict.faults();
        return Ok(SolvedWindow::under_constant_force(
            window, &acting, du, lambda, answer, faults,
        ));
    }
}
