//! Rules for a participant that is told the motion of its points and answers forces.

use nalgebra::DMatrix;

use super::life::Life;
use super::rule::{Found, Verdict, broken, exceeds, holds, not_tested, within};
use super::trial::{Trial, WINDOWS, apart, dot, greatest, minus};
use crate::error::Error;

/// Largest departure from v = a + W p, over the largest velocity.
const BOUNDARY: f64 = 1e-6;

/// Times that the tolerance of a solver that iterates may stand for it.
const TOLERANCES: f64 = 10.0;

/// Part of a motion by which a compliant boundary yields.
const YIELDS: f64 = 0.1;

/// A life that was pressed for all windows, and answers the next.
fn pressed<'a>(trial: &'a Trial) -> Result<Life<'a>, Error> {
    let mut life = trial.begin()?;
    for index in 0..WINDOWS {
        let window = life.window(index);
        let answer = life.ask(&window, &trial.loads.of_window(index, 0))?;
        life.accept(&window, &answer)?;
    }
    Ok(life)
}

/// Change of the forces (N) between two motions of the same window, and of the motion (m/s).
fn stiffness(trial: &Trial) -> Result<(Vec<f64>, Vec<f64>), Error> {
    let one = trial.loads.of_window(WINDOWS, 0);
    let other: Vec<f64> = one.iter().map(|v| 1.5 * v).collect();
    let mut forces = Vec::new();
    for velocity in [&one, &other] {
        let mut life = pressed(trial)?;
        let window = life.window(WINDOWS);
        let answer = life.ask(&window, velocity)?;
        forces.push(answer[..velocity.len()].to_vec());
    }
    Ok((minus(&forces[1], &forces[0]), minus(&other, &one)))
}

/// A faster motion into the layer against the change of the force.
pub fn passive(trial: &Trial) -> Result<Found, Error> {
    let (force, motion) = stiffness(trial)?;
    if greatest(&force) == 0.0 {
        return Ok(not_tested("no force answered a motion of its points"));
    }
    let cosine = dot(&force, &motion) / dot(&force, &force).sqrt() / dot(&motion, &motion).sqrt();
    if cosine < 0.0 {
        return Ok(holds(format!(
            "a faster motion is resisted: the cosine between force and motion is {cosine:.3}"
        )));
    }
    Ok(broken(format!(
        "a faster motion is helped: the cosine between the change of its force and that of the motion is {cosine:.3}; it must answer its force on the boundary, which opposes the motion"
    )))
}

/// v = a on a rigid boundary, v = a + W p on one that yields.
pub fn boundary(trial: &Trial) -> Result<Found, Error> {
    for (index, answer) in trial.plain.answers.iter().enumerate() {
        let free = trial.loads.of_window(index as u64, 0);
        let velocity = &answer[free.len()..2 * free.len()];
        let off = apart(velocity, &free);
        if exceeds(off, BOUNDARY) {
            let what = format!("window {index}: on a rigid boundary, v differs from a by");
            return Ok(within(&what, off, BOUNDARY));
        }
    }
    let (force, motion) = stiffness(trial)?;
    let impedance = trial.subject.clock.window_s() * greatest(&force) / greatest(&motion);
    if impedance == 0.0 {
        return Ok(holds(
            "v = a on a rigid boundary; no force was seen, so that one that yields was not tried",
        ));
    }
    let mut life = pressed(trial)?;
    let window = life.window(WINDOWS);
    let free = trial.loads.of_window(WINDOWS, 0);
    let n = free.len();
    let compliance = DMatrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
        0 => YIELDS / impedance,
        2 => 0.3 * YIELDS / impedance,
        _ => 0.0,
    });
    let window_s = trial.subject.clock.window_s();
    life.set_boundary(window_s, &compliance)?;
    let answer = life.ask(&window, &free)?;
    let (force, velocity) = (&answer[..n], &answer[n..2 * n]);
    let due: Vec<f64> = (0..n)
        .map(|i| {
            let row = compliance.row(i);
            let yields: f64 = row.iter().zip(force).map(|(w, f)| w * f).sum();
            free[i] + window_s * yields
        })
        .collect();
    let own = trial.subject.told.tolerance.as_ref();
    let bound = own.map_or(BOUNDARY, |own| (TOLERANCES * own.value).max(BOUNDARY));
    let found = within(
        "on a boundary that yields, v differs from a + W p by",
        apart(velocity, &due),
        bound,
    );
    let yielded = apart(velocity, &free);
    if found.0 == Verdict::Holds && yielded == 0.0 {
        return Ok(broken("it took a boundary that yields for a rigid one"));
    }
    Ok(found)
}

/// What it says of its own convergence.
pub fn convergence(trial: &Trial) -> Result<Found, Error> {
    let own = trial.subject.told.tolerance.as_ref();
    let mut worst: f64 = 0.0;
    for (index, answer) in trial.plain.answers.iter().enumerate() {
        let [iterations, residual, converged] = answer[answer.len() - 3..] else {
            continue;
        };
        let window = format!("window {index}");
        if !(iterations >= 0.0 && residual >= 0.0 && [0.0, 1.0].contains(&converged)) {
            return Ok(broken(format!(
                "{window}: iterations {iterations}, residual {residual}, converged {converged}"
            )));
        }
        if converged == 0.0 {
            return Ok(broken(format!(
                "{window}: it says that it did not converge (residual {residual:.2e}) under a small motion"
            )));
        }
        if let Some(own) = own.filter(|own| residual > own.value) {
            return Ok(broken(format!(
                "{window}: it says that it converged, with a residual of {residual:.2e} above its {} of {:.2e}",
                own.key, own.value
            )));
        }
        worst = worst.max(residual);
    }
    Ok(holds(format!("largest residual {worst:.2e}")))
}
