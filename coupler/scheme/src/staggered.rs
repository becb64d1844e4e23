//! Naive staggered coupling: every side runs once a window with the last answer of the other. It repeats nothing and
//! judges no gap; it is kept to show how it fails where the motion-driven side is heavy (added mass: Causin, Gerbeau
//! and Nobile 2005).
//!
//! ```text
//! serial     du = advance(lambda_0),  F_g = solve(N du),          lambda = N^T F_g
//! parallel   du = advance(lambda_0),  F_g = solve(N du_0),        lambda = N^T F_g
//! ```
//!
//! lambda_0 and du_0 come from the previous window. [`super::neumann_dirichlet`] exchanges the roles.

use protocol::Window;

use super::problem::WindowProblem;
use super::window::SolvedWindow;
use crate::error::Result;
use crate::keys::Order;

/// Solves a window.
pub fn solve(problem: &mut WindowProblem, order: Order, window: Window) -> Result<SolvedWindow> {
    problem.prepare_boundaries(&window)?;
    let start = problem.start;
    let (du, answer) = match order {
        Order::Serial => {
            let du = problem.advance(&window, &start.lambda)?;
            let motion = problem.group.mapping.motion(&du);
            (du, problem.solve_rigid(&window, &motion)?)
        }
        Order::Parallel => {
            problem.begin_advance(&window, &start.lambda)?;
            let answer = problem.solve_rigid(&window, &start.last_motion);
            let du = problem.finish_advance(&window);
            (du?, answer?)
        }
    };
    let lambda = problem.group.mapping.force(&answer.force);
    let faults = super::criteria::starved(problem.group, &window, &answer);
    Ok(SolvedWindow::under_constant_force(
        window,
        &start.lambda,
        du,
        lambda,
        answer,
        faults,
    ))
}
