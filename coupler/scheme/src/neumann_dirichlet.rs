//! Fixed point and staggered coupling with the roles exchanged: the layer takes forces (Neumann side), the continuum takes
//! motion (Dirichlet side).
//!
//! The continuum's velocity goes in a straight line from v_0 to v, as in [`super::velocity`], and lambda is the force that
//! it takes at the end. The points of the layer ride on the line of the nodes and push it by F_g; with their own masses M_p,
//! M_n = N^T M_p N and -lambda on the line its velocity at the end is that of one implicit step,
//!
//! ```text
//! v' = v_0 + M_n^-1 (H N^T F_g - H lambda),   v_g = N v',   v <- accelerated (v, v')
//! ```
//!
//! until H N (v - v') is within the tolerance. With p = H F_g the layer is told just that as its free velocity and its
//! compliance: a_g = N (v_0 - H M_n^-1 lambda), W_g = N M_n^-1 N^T, which is what [`super::dual_schur`] tells it with
//! C = H^2 M_n^-1. What cannot move of the continuum cannot on the line.
//!
//! Converged, it equals scheme `velocity` for a continuum that is M_n heavier: the masses of the points are a part of the
//! model, which they are not where the layer takes the motion. A repeat contracts by |1 - omega (1 + 1 / (C S))| with C = H D^-1,
//! D the impedance of the continuum, and S what the layer with its points resists: where the layer is heavy the continuum is
//! a good follower, and the added mass of Causin, Gerbeau and Nobile (2005) works the other way round (relaxations: Kuettler
//! and Wall 2008).
//!
//! The points' own inertia counts to the layer: what the nodes are given is F_g - M_p (v_g - N v_0) / H.

use protocol::{Reaction, Window};

use super::acceleration::Accelerator;
use super::criteria::starved;
use super::fixed_point::FixedPoint;
use super::problem::WindowProblem;
use super::vectors::{difference, motion_of};
use super::window::{Answer, SolvedWindow};
use crate::error::Result;
use crate::keys::Order;

/// Motion of the layers under a force.
struct Pushed {
    /// With the forces that are left for the nodes.
    answer: Answer,
    /// The part of those of the layers that the masses of the points take (N).
    inertia: Vec<f64>,
    /// v' (m/s).
    velocity: Vec<f64>,
}

/// Advice to a user whose fixed point was not reached.
const ADVICE: &str = "the fixed point was not reached; raise repeats_max, take acceleration = \"iqn-ils\", lower relaxation, or take dirichlet = \"wall\" for a wall that is light beside the continuum";

/// Solves a window in one pass: the continuum follows the velocity that the layers had at the end of the window before, and they
/// take its force, or both at once, each with the answer of the other one window before. Nothing is repeated and no gap is judged.
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

/// Solves a window by v -> v'(lambda(v)), accelerated, until both are the same; `relaxation` is that of a first parallel pass.
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
        // No answer to this velocity, so that it says nothing of the fixed point's own slope.
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
        // A tolerance above what a window changes would else keep the velocity of the window before.
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

/// The window in which the continua went along a velocity and the layers were pushed.
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

/// The continua along a velocity, then the layers under the force that this takes.
fn one_by_one(
    problem: &mut WindowProblem,
    window: &Window,
    velocity: &[f64],
) -> Result<(Reaction, Pushed)> {
    let reaction = problem.prescribe_velocity(window, velocity)?;
    let pushed = push(problem, window, &reaction.force)?;
    Ok((reaction, pushed))
}

/// Both at once, the layers under the force of the window before.
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

/// The layers with -lambda (N) on the line of the nodes.
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

/// Force on the nodes (N): the one that the continua took, and on what cannot move the rest that the layers leave for it.
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
