//! Rules for a participant that is told forces and answers motion.

use nalgebra::DVector;
use protocol::{Kind, Window, larger};

use super::launch::Launch;
use super::plain::{RuleTrial, WINDOWS, apart, dot, greatest, minus};
use super::rule::{Finding, RuleVerdict, broken, exceeds, holds, not_offered, not_tested, within};
use coordinator::error::Error;
use coordinator::participants::admission::fault_of_columns;

/// Largest difference of two motions that are the same but for rounding, over the larger.
const ROUNDING: f64 = 1e-7;

/// Largest difference of an answer from what linear columns say, over the answer: the loads are small.
const LINEAR: f64 = 1e-4;

/// An advance that comes early, is used, and is discarded.
pub fn early(trial: &RuleTrial) -> Result<Finding, Error> {
    if !trial.subject.told.capabilities.rollback {
        return Ok(not_offered(
            "it cannot repeat a window, and is not asked early",
        ));
    }
    let mut life = trial.begin()?;
    let (mut answers, mut reports) = (Vec::new(), Vec::new());
    for index in 0..WINDOWS {
        let window = life.window(index);
        let answer = life.ask(&window, &trial.loads.of_window(index, 0))?;
        life.accept_without_reading(&window, &answer)?;
        // Used, then in vain because another force comes, then because something else comes.
        let draw = u64::from(index % 3 == 1);
        let next = life.window(index + 1);
        life.ask_early(&next, &trial.loads.of_window(index + 1, draw))?;
        reports.push(life.report()?);
        if index % 3 == 2 {
            life.snapshot("conform")?;
        }
        answers.push(answer);
    }
    life.finish()?;
    Ok(trial.compare(0, &answers, &reports))
}

/// Loads that must move it along.
const LOADS: u64 = 2;

/// Motions under one force that stays: of two windows, and of one that is as long as both.
struct Pair {
    first: Vec<f64>,
    second: Vec<f64>,
    both: Vec<f64>,
}

fn pair(trial: &RuleTrial) -> Result<Pair, Error> {
    let load = trial.loads.of_window(0, 0);
    let mut life = trial.begin()?;
    let first = life.ask(&life.window(0), &load)?;
    life.accept(&life.window(0), &first)?;
    let second = life.ask(&life.window(1), &load)?;
    let clock = &trial.subject.clock;
    let long = clock.window(0, 0, 2 * clock.substeps);
    let both = trial.begin()?.ask(&long, &load)?;
    Ok(Pair {
        first,
        second,
        both,
    })
}

/// The second of two windows, against the whole motion of both.
pub fn increments(trial: &RuleTrial) -> Result<Finding, Error> {
    let pair = pair(trial)?;
    let sum = minus(&pair.both, &pair.first);
    // A body that does not move on has increments of zero, and its totals are those of the first window.
    let off = greatest(&minus(&pair.second, &sum)) / greatest(&pair.both);
    let total = apart(&pair.second, &pair.both);
    if total < off {
        return Ok(broken(format!(
            "the second of two windows is answered with the motion of both, as far as {total:.1e}: these are displacements since the start"
        )));
    }
    Ok(holds(format!(
        "the second of two windows goes on from the first, as far as {off:.1e}"
    )))
}

/// Two windows against one that is as long as both.
pub fn substeps(trial: &RuleTrial) -> Result<Finding, Error> {
    if trial.subject.told.step_s.is_none() {
        return Ok(not_offered("it has no step of its own: a window is one"));
    }
    let pair = pair(trial)?;
    let sum: Vec<f64> = pair
        .first
        .iter()
        .zip(&pair.second)
        .map(|(a, b)| a + b)
        .collect();
    let what = format!(
        "windows of {0} + {0} and of {1} substeps differ by",
        trial.subject.clock.substeps,
        2 * trial.subject.clock.substeps
    );
    Ok(within(&what, apart(&sum, &pair.both), ROUNDING))
}

/// The motion under a load, less that without one.
fn response(trial: &RuleTrial, window: &Window, load: &[f64]) -> Result<Vec<f64>, Error> {
    let mut life = trial.begin()?;
    let loaded = life.ask(window, load)?;
    if !trial.subject.told.capabilities.rollback {
        life = trial.begin()?;
    }
    let unloaded = life.ask(window, &trial.loads.none())?;
    Ok(minus(&loaded, &unloaded))
}

/// Work of small forces on the motion that they make.
pub fn passive(trial: &RuleTrial) -> Result<Finding, Error> {
    let clock = &trial.subject.clock;
    let window = clock.window(0, 0, clock.substeps);
    for draw in 0..LOADS {
        let load = trial.loads.of_window(0, draw);
        let moved = response(trial, &window, &load)?;
        let share = dot(&load, &moved) / dot(&load, &load).sqrt() / dot(&moved, &moved).sqrt();
        if exceeds(-share, 0.0) || share == 0.0 {
            return Ok(broken(format!(
                "a load moves it against its direction: the cosine between force and motion is {share:.3}"
            )));
        }
    }
    Ok(holds(format!("{LOADS} loads, each moves it along")))
}

/// Columns against the answers to forces, for whole and half windows.
pub fn columns(trial: &RuleTrial) -> Result<Finding, Error> {
    if !trial.subject.told.capabilities.columns {
        return Ok(not_offered("it has no columns"));
    }
    let clock = &trial.subject.clock;
    let half = clock.substeps / 2;
    let mut worst = 0.0;
    for substeps in [clock.substeps, half].into_iter().filter(|n| *n > 0) {
        let window = clock.window(0, 0, substeps);
        let matrix = trial
            .begin()?
            .matrix((Kind::Columns, Kind::Compliance), &window)?;
        if let Some(why) = fault_of_columns(&matrix) {
            return Ok(broken(why));
        }
        let load = trial.loads.of_window(0, 0);
        let expected = &matrix * DVector::from_column_slice(&load);
        let moved = response(trial, &window, &load)?;
        let off = apart(expected.as_slice(), &moved);
        worst = larger(worst, off);
    }
    Ok(within(
        "columns times a load differ from the answer to it by",
        worst,
        LINEAR,
    ))
}

/// Velocities that go up in a straight line and stay.
pub fn velocity(trial: &RuleTrial) -> Result<Finding, Error> {
    if !trial.subject.told.capabilities.prescribed_velocity {
        return Ok(not_offered("it follows no velocity (no `follow`)"));
    }
    let mut life = trial.begin()?;
    let (first, second) = (life.window(0), life.window(1));
    let length = first.t1_s - first.t0_s;
    let kinds = (Kind::ImpedanceColumns, Kind::Impedance);
    let impedance = life.matrix(kinds, &first)?;
    if let Some(why) = fault_of_columns(&impedance) {
        return Ok(broken(why));
    }
    let force = trial.loads.of_window(0, 0);
    let moved = response(trial, &first, &force)?;
    let wanted: Vec<f64> = (0..force.len())
        .map(|i| match impedance[(i, i)] {
            0.0 => 0.0,
            _ => 2.0 * moved[i] / length,
        })
        .collect();
    let unloaded = life.follow(&first, &trial.loads.none())?;
    let answer = life.follow(&first, &wanted)?;
    let again = life.follow(&first, &wanted)?;
    if answer != again {
        return Ok(broken(
            "a velocity that is asked for again is answered otherwise",
        ));
    }
    let due = |share: f64| -> Vec<f64> { wanted.iter().map(|v| share * length * v).collect() };
    let off = apart(&answer.increment, &due(0.5));
    if exceeds(off, ROUNDING) {
        return Ok(within(
            "increments on the way up differ from H v / 2 by",
            off,
            ROUNDING,
        ));
    }
    let expected = &impedance * DVector::from_column_slice(&wanted);
    let forces = minus(&answer.force, &unloaded.force);
    let off = apart(&forces, expected.as_slice());
    if exceeds(off, LINEAR) {
        return Ok(within(
            "forces differ from the impedance times v by",
            off,
            LINEAR,
        ));
    }
    life.accept(&first, &answer.increment)?;
    let on = life.follow(&second, &wanted)?;
    let found = within(
        "increments at a velocity that stays differ from H v by",
        apart(&on.increment, &due(1.0)),
        ROUNDING,
    );
    if found.0 == RuleVerdict::Broken {
        return Ok(found);
    }
    Ok(holds("three windows along given velocities"))
}

/// Every other point exchanged, against all of them with no load on the rest.
pub fn select(trial: &RuleTrial) -> Result<Finding, Error> {
    let chosen = |point: usize| point.is_multiple_of(2);
    let points = trial.surface.len();
    if points < 2 {
        return Ok(not_tested("it has one point"));
    }
    let pick = |vector: &[f64]| -> Vec<f64> {
        let components = vector.iter().enumerate();
        let components = components.filter(|(i, _)| chosen(i / 2));
        components.map(|(_, value)| *value).collect()
    };
    let (mut all, mut some) = (
        trial.begin()?,
        Launch::exchanging(trial.subject, 1, chosen)?,
    );
    let mut worst = 0.0;
    for index in 0..2 {
        let window = all.window(index);
        let own = pick(&trial.loads.of_window(index, 0));
        let mut load = trial.loads.none();
        for (i, force) in own.iter().enumerate() {
            load[4 * (i / 2) + i % 2] = *force;
        }
        let (whole, part) = (all.ask(&window, &load)?, some.ask(&window, &own)?);
        worst = larger(worst, apart(&part, &pick(&whole)));
        all.accept(&window, &whole)?;
        some.accept(&window, &part)?;
    }
    let what = format!(
        "{} of {points} points answer otherwise by",
        points.div_ceil(2)
    );
    Ok(within(&what, worst, ROUNDING))
}
