//! Fixed-point and staggered coupling with exchanged roles: the layer takes forces (Neumann side), the continuum takes
//! motion (Dirichlet side).
//!
//! The continuum's velocity is linear in time from v_0 to v, as in [`super::velocity`], and lambda is the force that
//! this motion requires at the end. The points of the layer ride on the line of nodes and push it by F_g. With the
//! points' own masses M_p, M_n = N^T M_p N and -lambda on the line, one implicit step gives the velocity of the line at
//! the end,
//!
//! ```text
//! v' = v_0 + M_n^-1 (H N^T F_g - H lambda),   v_g = N v',   v <- accelerated (v, v')
//! ```
//!
//! until H N (v - v') is within the tolerance. With p = H F_g this is a free velocity and a compliance for the layer:
//! a_g = N (v_0 - H M_n^-1 lambda), W_g = N M_n^-1 N^T, as in [`super::dual_schur`] with C = H^2 M_n^-1. Components
//! that the continuum holds are held on the line too.
//!
//! The converged solution equals scheme `velocity` for a continuum with the additional mass M_n: here the masses of the
//! points are part of the model, unlike in schemes whose layer takes the motion. A repeat contracts by |1 - omega (1 +
//! 1 / (C S))| with C = H D^-1, D the impedance of the continuum, and S the resistance of the layer with its points.
//! The continuum follows a heavy layer well: the added mass of Causin, Gerbeau and Nobile (2005) acts in reverse
//! (relaxations: Kuettler and Wall 2008).
//!
//! The points' own inertia belongs to the layer: the nodes get F_g - M_p (v_g - N v_0) / H.

use protocol::{Reaction, Window};

use super::acceleration::Accelerator;
use super::criteria::starved;
use super::fixed_point::FixedPoint;
use super::problem::WindowProblem;
use super::vectors::{difference, motion_of};
use super::window::{Answer, SolvedWindow};
use crate::error::Result;
use crate::keys::Order;

/// Answer of the layers to a force.
struct Pushed {
    /// With the forces that remain for the nodes.
    answer: Answer,
    /// The part of the layers' forces that the masses of the points take (N).
    inertia: Vec<f64>,
    /// v' (m/s).
    velocity: Vec<f64>,
}

/// Advice for a fixed point that was not reached.
const ADVICE: &str = "the fixed point was not reached; raise repeats_max, take acceleration = \"iqn-ils\", lower relaxation, or take dirichlet = \"wall\" for a wall that is light compared with the continuum";

/// Solves a window in one pass, without repeats or a judged gap. In serial order the continuum follows the layers'
/// velocity at the end of the previous window, then the layers take its force. In parallel order each side uses the
/// other's previous answer.
pub fn solve_staggered(
    problem: &mut WindowProblem,
    order: Order,
    window: Window,
) -> Result<SolvedWindow> {
    problem.prepare_boundaries(&window)?;
    let followed = problem.start.velocity.clone();
    let (reaction, pushed) = match order {
        Order::Serial => one_by_one(problem, &window, &followed)?,
        Order::Parallel => at_once(problem, &window, &followed)?,
    };
    let faults = starved(problem.group, &window, &pushed.answer);
    let increment = motion_of(&pushed.velocity, problem.group.window_s(&window));
    let solved = solved(problem, window, &followed, reaction, pushed);
    Ok(SolvedWindow {
        increment,
        faults,
        ..solved
    })
}

/// Solves a window by v -> v'(lambda(v)), accelerated, until both agree; `relaxation` applies to a first parallel pass.
pub fn solve_fixed_point(
    problem: &mut WindowProblem,
    rules: FixedPoint,
    relaxation: f64,
    mut window: Window,
) -> Result<SolvedWindow> {
    problem.prepare_boundaries(&window)?;
    let window_s = problem.group.window_s(&window);
    let mut accelerator: Accelerator = rules.accelerator;
    let mut velocity = problem.start.velocity.clone();
    if rules.order == Order::Parallel {
        // This is not an answer to this velocity, so it has no information on the slope of the fixed point.
        let (_, pushed) = at_once(problem, &window, &velocity)?;
        for (v, answer) in velocity.iter_mut().zip(&pushed.velocity) {
            *v += relaxation * (answer - *v);
        }
        window.iteration += 1;
    }
    loop {
        let (reaction, pushed) = one_by_one(problem, &window, &velocity)?;
        let increment = motion_of(&velocity, window_s);
        let verdict = problem.judge(&window, &increment, &pushed.answer, ADVICE);
        // Otherwise a tolerance above the change in a window would keep the velocity of the previous window.
        let first = window.iteration == 0 && verdict.starved.is_empty();
        if (verdict.wants_repeat() || first) && window.iteration < rules.repeats_max {
            velocity = accelerator.next(&velocity, &pushed.velocity);
            window.iteration += 1;
            continue;
        }
        let solved = solved(problem, window, &velocity, reaction, pushed);
        return Ok(SolvedWindow {
            velocity: Some(velocity),
            faults: verdict.faults(),
            ..solved
        });
    }
}

/// The window in which the continua followed a velocity and the layers took forces.
fn solved(
    problem: &WindowProblem,
    window: Window,
    followed: &[f64],
    reaction: Reaction,
    pushed: Pushed,
) -> SolvedWindow {
    let increment = motion_of(followed, problem.group.window_s(&window));
    let lambda = acting(problem, &window, &reaction, &pushed.answer);
    SolvedWindow {
        wanted: increment.clone(),
        increment,
        borne: lambda.clone(),
        lambda,
        work: reaction.work,
        velocity: Some(pushed.velocity),
        inertia: pushed.inertia,
        answer: pushed.answer,
        faults: Vec::new(),
        window,
    }
}

/// Moves the continua along a velocity, then the layers under the force that this requires.
fn one_by_one(
    problem: &mut WindowProblem,
    window: &Window,
    velocity: &[f64],
) -> Result<(Reaction, Pushed)> {
    let reaction = problem.prescribe_velocity(window, velocity)?;
    let pushed = push(problem, window, &reaction.force)?;
    Ok((reaction, pushed))
}

/// Moves both at once, the layers under the force of the previous window.
fn at_once(
    problem: &mut WindowProblem,
    window: &Window,
    velocity: &[f64],
) -> Result<(Reaction, Pushed)> {
    problem.begin_prescribed_velocity(window, velocity)?;
    let start = problem.start;
    let pushed = push(problem, window, &start.lambda);
    let reaction = problem.finish_prescribed_velocity(window);
    Ok((reaction?, pushed?))
}

/// Solves the layers with -lambda (N) on the line of the nodes.
fn push(problem: &mut WindowProblem, window: &Window, lambda: &[f64]) -> Result<Pushed> {
    let (group, v_0) = (problem.group, &problem.start.velocity);
    let window_s = group.window_s(window);
    let c_lambda = problem.carried(window, lambda);
    let a_g = problem.free_velocity(window, &motion_of(v_0, window_s), &c_lambda);
    let mut answer = problem.solve(window, &a_g)?;
    let pushing = difference(&group.mapping.force(&answer.force), lambda);
    let gained = problem.compliance.times(window.substeps, &pushing);
    let velocity = v_0.iter().zip(&gained);
    let velocity = velocity.map(|(v_0, du)| v_0 + du / window_s).collect();
    let inertia = inertia(problem, window_s, &answer.velocity);
    for (force, inertia) in answer.force.iter_mut().zip(&inertia) {
        *force -= inertia;
    }
    Ok(Pushed {
        answer,
        inertia,
        velocity,
    })
}

/// M_p (v_g - N v_0) / H (N).
fn inertia(problem: &WindowProblem, window_s: f64, velocity: &[f64]) -> Vec<f64> {
    let before = problem.group.mapping.motion(&problem.start.velocity);
    let change = velocity.iter().zip(&before).enumerate();
    let mass_kg = &problem.group.points.mass_kg;
    let change = change.map(|(i, (v, v_0))| mass_kg[i / 2] * (v - v_0) / window_s);
    change.collect()
}

/// Force on the nodes (N): the force that the continua took and, on held components, the force that the layers leave.
fn acting(
    problem: &WindowProblem,
    window: &Window,
    reaction: &Reaction,
    answer: &Answer,
) -> Vec<f64> {
    let left = problem.group.mapping.force(&answer.force);
    let moves = problem.compliance.moves(window.substeps);
    let taken = reaction.force.iter().zip(left).zip(moves);
    let taken = taken.map(|((taken, left), moves)| if moves { *taken } else { left });
    taken.collect()
}
