//! Rules for a participant that receives the motion of its points and answers with forces.

use nalgebra::{DMatrix, DVector};
use protocol::larger;

use super::plain::{LayerStiffness, RuleTrial, WINDOWS, apart, dot, greatest};
use super::rule::{RuleFinding, broken, not_tested, offered, within};
use scheme::participants::HeatRequest;

/// Largest departure from v = a + W p, over the largest velocity.
const BOUNDARY: f64 = 1e-6;

/// Bound for an iterative solver, in units of its tolerance.
const TOLERANCES: f64 = 10.0;

/// Compares a faster motion into the layer with the change of the force.
pub fn passive(trial: &RuleTrial) -> RuleFinding {
    let Some(LayerStiffness { force, motion }) = &trial.stiffness else {
        return not_tested("it receives no motion");
    };
    if greatest(force) == 0.0 {
        return not_tested("a motion of its points changed no force");
    }
    let cosine = dot(force, motion) / dot(force, force).sqrt() / dot(motion, motion).sqrt();
    if cosine < 0.0 {
        return Ok(format!(
            "it resists a faster motion: the cosine between force and motion is {cosine:.3}"
        ));
    }
    broken(format!(
        "it helps a faster motion: the cosine between the changes of its force and of the motion is {cosine:.3}; it must answer its force on the boundary, which opposes the motion"
    ))
}

/// Checks v = a on a rigid boundary, v = a + W p on a boundary that yields.
pub fn boundary(trial: &RuleTrial) -> RuleFinding {
    let mut launch = trial.begin()?;
    let (window_s, n) = (trial.tested.clock.window_s(), launch.size());
    launch.set_boundary(window_s, &DMatrix::zeros(n, n))?;
    for index in 0..WINDOWS {
        let (window, free) = (launch.window(index), trial.loads.of_window(index, 0));
        let answer = launch.ask(&window, &free)?;
        let what = format!("window {index}: on a rigid boundary, v differs from a by");
        within(&what, apart(&answer[n..2 * n], &free), BOUNDARY)?;
        launch.accept(&window, &answer)?;
    }
    let Some(compliance) = trial.tested.boundary.get() else {
        return Ok("v = a on a rigid boundary; a boundary that yields was not tested".into());
    };
    let (mut worst, mut yielded) = (0.0, 0.0);
    for (index, answer) in trial.plain.answers.iter().enumerate() {
        let free = trial.loads.of_window(index as u64, 0);
        let impulse = DVector::from_column_slice(&answer[..n]) * window_s;
        let due = DVector::from_column_slice(&free) + compliance * impulse;
        worst = larger(worst, apart(&answer[n..2 * n], due.as_slice()));
        yielded = larger(yielded, apart(due.as_slice(), &free));
    }
    let own = trial.tested.description.tolerance.as_ref();
    let bound = own.map_or(BOUNDARY, |own| (TOLERANCES * own.value).max(BOUNDARY));
    let what = format!("on a boundary that yields by {yielded:.0e}, v differs from a + W p by");
    within(&what, worst, bound)
}

/// Temperatures of two bodies below the layer (K).
const BODIES: [f64; 2] = [300.0, 400.0];

/// Most that the heat per kelvin may change from the one to the other, where conductivities depend on temperature.
const CONDUCTIVITIES: f64 = 2.0;

/// Compares the heat into a cold and a hot body, and its difference with the heat per kelvin.
pub fn heat(trial: &RuleTrial) -> RuleFinding {
    let offers = trial.tested.description.capabilities.heat;
    offered(offers, "it gives no heat")?;
    let (mut given, mut most) = (Vec::new(), 0.0);
    for kelvins in BODIES {
        let mut launch = trial.begin()?;
        let body = vec![kelvins; launch.size() / 2];
        launch.exchange_heat(&launch.window(0), HeatRequest::Temperatures(&body))?;
        for index in 0..WINDOWS {
            let window = launch.window(index);
            launch.go(&window, &trial.loads.of_window(index, 0))?;
        }
        let last = launch.window(WINDOWS - 1);
        let heat = launch.exchange_heat(&last, HeatRequest::Temperatures(&body))?;
        let (heat, per_kelvin) = heat.split_at(body.len());
        given.push(heat.iter().sum::<f64>());
        most = larger(most, per_kelvin.iter().sum());
    }
    let [cold, hot] = [given[0], given[1]];
    if cold == hot {
        return not_tested("no heat passes into a body below it");
    }
    let [below, above] = BODIES;
    let compared =
        format!("{cold:.2e} J into a body of {below} K, {hot:.2e} J into one of {above} K");
    if hot < cold {
        let most = (above - below) * most;
        let bound = format!("{compared}; by the heat per kelvin at most {most:.2e} J less");
        let follows = cold - hot <= CONDUCTIVITIES * most;
        return if follows { Ok(bound) } else { broken(bound) };
    }
    broken(format!("{compared}: heat flows from hot to cold"))
}

/// Compares its claims of convergence with its residuals.
pub fn convergence(trial: &RuleTrial) -> RuleFinding {
    let own = trial.tested.description.tolerance.as_ref();
    let mut worst: f64 = 0.0;
    for (index, answer) in trial.plain.answers.iter().enumerate() {
        let [iterations, residual, converged] = answer[answer.len() - 3..] else {
            continue;
        };
        let refuse = |why: String| broken(format!("window {index}: {why}"));
        if !(iterations >= 0.0 && residual >= 0.0 && [0.0, 1.0].contains(&converged)) {
            let solve = format!("iterations {iterations}, residual {residual}");
            return refuse(format!("{solve}, converged {converged}"));
        }
        if converged == 0.0 {
            return refuse(format!(
                "it reports that it did not converge (residual {residual:.2e}) under a small motion"
            ));
        }
        if let Some(own) = own.filter(|own| residual > own.value) {
            return refuse(format!(
                "it reports convergence with a residual of {residual:.2e} above its {} of {:.2e}",
                own.key, own.value
            ));
        }
        worst = worst.max(residual);
    }
    Ok(format!("largest residual {worst:.2e}"))
}
