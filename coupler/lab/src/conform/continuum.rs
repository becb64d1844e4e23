//! Rules for a participant that receives forces and answers with motion.

use nalgebra::DVector;
use protocol::{Kind, Window, larger};

use super::launch::Launch;
use super::plain::{RuleTrial, WINDOWS, apart, dot, greatest, minus};
use super::rule::{RuleFinding, broken, exceeds, not_tested, offered, within};
use coordinator::participants::admission::fault_of_columns;
use scenario::error::Error;
use scheme::participants::HeatRequest;

/// Largest difference of two motions that differ only by rounding, over the larger.
const ROUNDING: f64 = 1e-7;

/// Largest difference between an answer and linear columns, over the answer: the loads are small.
const LINEAR: f64 = 1e-4;

/// The reason why answers depend on the windows and the points before.
const LATE: &str = "its distant points follow a change of force one window late (`late_far_field`)";

/// Heat at each point (J), and windows in which it spreads.
const HEAT: f64 = 1e-6;
const HEATED_WINDOWS: u64 = 100;

/// Heats all points, which must be warmer after some windows.
pub fn heat(trial: &RuleTrial) -> RuleFinding {
    let offers = trial.tested.description.capabilities.heat;
    offered(offers, "it takes no heat")?;
    let mut launch = trial.begin()?;
    let (none, some) = (vec![0.0; launch.size() / 2], vec![HEAT; launch.size() / 2]);
    let (window, still) = (launch.window(0), vec![0.0; launch.size()]);
    let start = launch.exchange_heat(&window, HeatRequest::Heat(&none))?;
    if let Some(kelvins) = start.iter().find(|kelvins| **kelvins <= 0.0) {
        return broken(format!("a point has {kelvins} K: temperatures are above 0"));
    }
    launch.exchange_heat(&window, HeatRequest::Heat(&some))?;
    for index in 0..HEATED_WINDOWS {
        launch.go(&launch.window(index), &still)?;
    }
    let last = launch.window(HEATED_WINDOWS - 1);
    let end = launch.exchange_heat(&last, HeatRequest::Heat(&none))?;
    let warmed = end.iter().zip(&start).map(|(end, start)| end - start);
    let least = warmed.fold(f64::INFINITY, f64::min);
    if least > 0.0 {
        Ok(format!(
            "{HEAT} J at each point warmed each by {least:.1e} K or more"
        ))
    } else {
        broken(format!(
            "{HEAT} J at each point changed a temperature by {least:e} K in {HEATED_WINDOWS} windows"
        ))
    }
}

/// Sends `Advance` early, which is used or discarded.
pub fn early(trial: &RuleTrial) -> RuleFinding {
    let offers = trial.tested.description.capabilities.rollback;
    let otherwise = "it cannot repeat a window, and gets no early requests";
    offered(offers, otherwise)?;
    let mut launch = trial.begin()?;
    let (mut answers, mut reports) = (Vec::new(), Vec::new());
    for index in 0..WINDOWS {
        let window = launch.window(index);
        let answer = launch.ask(&window, &trial.loads.of_window(index, 0))?;
        launch.accept_without_reading(&window, &answer)?;
        // Used, then discarded because another force comes, then because another request comes.
        let draw = u64::from(index % 3 == 1);
        let next = launch.window(index + 1);
        launch.ask_early(&next, &trial.loads.of_window(index + 1, draw))?;
        reports.push(launch.report()?);
        if index % 3 == 2 {
            launch.snapshot("conform")?;
        }
        answers.push(answer);
    }
    launch.finish()?;
    trial.compare(0, &answers, &reports)
}

/// Number of loads that must move it along.
const LOADS: u64 = 2;

/// Motions under a constant force: of two windows, and of one window of their length.
fn pair(trial: &RuleTrial) -> Result<[Vec<f64>; 3], Error> {
    let load = trial.loads.of_window(0, 0);
    let mut launch = trial.begin()?;
    let (first, _) = launch.go(&launch.window(0), &load)?;
    let second = launch.ask(&launch.window(1), &load)?;
    let clock = &trial.tested.clock;
    let long = clock.window(0, 0, 2 * clock.substeps);
    let both = trial.begin()?.ask(&long, &load)?;
    Ok([first, second, both])
}

/// Compares the second of two windows with the whole motion of both.
pub fn increments(trial: &RuleTrial) -> RuleFinding {
    let [first, second, both] = pair(trial)?;
    let sum = minus(&both, &first);
    let off = greatest(&minus(&second, &sum)) / greatest(&both);
    // A body that stops has increments of zero, and displacements as after the first window.
    let total = apart(&second, &both);
    if total < off {
        return broken(format!(
            "the answer to the second of two windows is the motion of both, up to {total:.1e}: these are displacements since the start"
        ));
    }
    Ok(format!(
        "the second of two windows continues from the first, up to {off:.1e}"
    ))
}

/// Compares two windows with one window of their length.
pub fn substeps(trial: &RuleTrial) -> RuleFinding {
    let offers = trial.tested.description.step_s.is_some();
    offered(offers, "it has no step of its own: a window is one step")?;
    offered(!trial.tested.description.late_far_field, LATE)?;
    let [first, second, both] = pair(trial)?;
    let sum: Vec<f64> = first.iter().zip(&second).map(|(a, b)| a + b).collect();
    let one = trial.tested.clock.substeps;
    let two = 2 * one;
    let what = format!("windows of {one} + {one} and of {two} substeps differ by");
    within(&what, apart(&sum, &both), ROUNDING)
}

/// The motion under a load minus the motion without load.
fn response(trial: &RuleTrial, window: &Window, load: &[f64]) -> Result<Vec<f64>, Error> {
    let mut launch = trial.begin()?;
    let loaded = launch.ask(window, load)?;
    if !trial.tested.description.capabilities.rollback {
        launch = trial.begin()?;
    }
    let unloaded = launch.ask(window, &trial.loads.none())?;
    Ok(minus(&loaded, &unloaded))
}

/// Checks the work of small forces on the motion that they cause.
pub fn passive(trial: &RuleTrial) -> RuleFinding {
    let clock = &trial.tested.clock;
    let window = clock.window(0, 0, clock.substeps);
    for draw in 0..LOADS {
        let load = trial.loads.of_window(0, draw);
        let moved = response(trial, &window, &load)?;
        let share = dot(&load, &moved) / dot(&load, &load).sqrt() / dot(&moved, &moved).sqrt();
        if exceeds(-share, 0.0) || share == 0.0 {
            return broken(format!(
                "a load moves it against its direction: the cosine between force and motion is {share:.3}"
            ));
        }
    }
    Ok(format!("{LOADS} loads, each moves it along"))
}

/// Compares columns with the answers to forces, for whole and half windows.
pub fn columns(trial: &RuleTrial) -> RuleFinding {
    let offers = trial.tested.description.capabilities.columns;
    offered(offers, "it has no columns")?;
    let clock = &trial.tested.clock;
    let half = clock.substeps / 2;
    let mut worst = 0.0;
    for substeps in [clock.substeps, half].into_iter().filter(|n| *n > 0) {
        let window = clock.window(0, 0, substeps);
        let kinds = (Kind::Columns, Kind::Compliance);
        let matrix = trial.begin()?.matrix(kinds, &window)?;
        if let Some(why) = fault_of_columns(&matrix) {
            return broken(why);
        }
        let load = trial.loads.of_window(0, 0);
        let expected = &matrix * DVector::from_column_slice(&load);
        let moved = response(trial, &window, &load)?;
        let off = apart(expected.as_slice(), &moved);
        worst = larger(worst, off);
    }
    let what = "columns times a load differ from the answer to it by";
    within(what, worst, LINEAR)
}

/// Prescribes velocities that increase linearly and then stay.
pub fn velocity(trial: &RuleTrial) -> RuleFinding {
    let offers = trial.tested.description.capabilities.prescribed_velocity;
    offered(offers, "it cannot follow velocities (no `follow`)")?;
    let mut launch = trial.begin()?;
    let (first, second) = (launch.window(0), launch.window(1));
    let length = first.t1_s - first.t0_s;
    let kinds = (Kind::ImpedanceColumns, Kind::Impedance);
    let impedance = launch.matrix(kinds, &first)?;
    if let Some(why) = fault_of_columns(&impedance) {
        return broken(why);
    }
    let force = trial.loads.of_window(0, 0);
    let moved = response(trial, &first, &force)?;
    let wanted = |i: usize| match impedance[(i, i)] {
        0.0 => 0.0,
        _ => 2.0 * moved[i] / length,
    };
    let wanted: Vec<f64> = (0..force.len()).map(wanted).collect();
    let unloaded = launch.follow(&first, &trial.loads.none())?;
    let answer = launch.follow(&first, &wanted)?;
    let again = launch.follow(&first, &wanted)?;
    if answer != again {
        return broken("a repeated velocity has another answer");
    }
    let due = |share: f64| -> Vec<f64> { wanted.iter().map(|v| share * length * v).collect() };
    let off = apart(&answer.increment, &due(0.5));
    let what = "increments of the first window differ from H v / 2 by";
    within(what, off, ROUNDING)?;
    let expected = &impedance * DVector::from_column_slice(&wanted);
    let forces = minus(&answer.force, &unloaded.force);
    let off = apart(&forces, expected.as_slice());
    within("forces differ from the impedance times v by", off, LINEAR)?;
    launch.accept(&first, &answer.increment)?;
    let on = launch.follow(&second, &wanted)?;
    let what = "increments at a constant velocity differ from H v by";
    within(what, apart(&on.increment, &due(1.0)), ROUNDING)?;
    Ok("three windows along given velocities".into())
}

/// Exchanges every other point, and compares with all points without a load on the rest.
pub fn select(trial: &RuleTrial) -> RuleFinding {
    offered(!trial.tested.description.late_far_field, LATE)?;
    let chosen = |point: usize| point.is_multiple_of(2);
    let points = trial.surface.len();
    if points < 2 {
        return not_tested("it has fewer than two points");
    }
    let pick = |vector: &[f64]| -> Vec<f64> {
        let components = (0..vector.len()).filter(|i| chosen(i / 2));
        components.map(|i| vector[i]).collect()
    };
    let mut all = trial.begin()?;
    let mut some = Launch::exchanging(trial.tested, 1, chosen)?;
    let mut worst = 0.0;
    for index in 0..2 {
        let window = all.window(index);
        let own = pick(&trial.loads.of_window(index, 0));
        let mut load = trial.loads.none();
        for (i, force) in own.iter().enumerate() {
            load[4 * (i / 2) + i % 2] = *force;
        }
        let (whole, _) = all.go(&window, &load)?;
        let (part, _) = some.go(&window, &own)?;
        worst = larger(worst, apart(&part, &pick(&whole)));
    }
    let some = points.div_ceil(2);
    let what = format!("with {some} of {points} points selected, answers differ by");
    within(&what, worst, ROUNDING)
}
