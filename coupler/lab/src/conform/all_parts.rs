//! Rules for every participant: bits, reports, energies, checkpoints.

use std::cell::OnceCell;

use protocol::{Role, Window};

use super::plain::{RuleTrial, WINDOWS, ask_once, difference};
use super::rule::{Finding, RuleVerdict, broken, exceeds, holds, not_offered, not_tested, within};
use super::subject::{Part, TestedParticipant};
use coordinator::error::Error;

/// Largest difference of a work that is summed up on both sides, over the sum of its sizes: rounding leaves 1e-12.
const WORK: f64 = 1e-6;

/// Largest part of the work that may be missing after a slow load: an increment under a force that is constant in the window
/// leaves 5 / windows of it.
const BALANCE: f64 = 0.1;
const SLOW_WINDOWS: u64 = 200;

/// Two lives, the second with two threads.
pub fn same_bits(trial: &RuleTrial) -> Result<Finding, Error> {
    let other = trial.live(2, &mut ask_once)?;
    Ok(trial.compare_life(&other))
}

/// Every window is asked for three times.
pub fn repeats(trial: &RuleTrial) -> Result<Finding, Error> {
    if let Some(why) = cannot_repeat(trial) {
        return Ok(why);
    }
    let mut first = Vec::new();
    let last = trial.live(1, &mut |life, window, load| {
        first.push(life.ask(window, load)?);
        first.push(life.ask(&repeat(window, 1), load)?);
        let window = repeat(window, 2);
        Ok((window, life.ask(&window, load)?))
    })?;
    for (index, answer) in first.iter().enumerate() {
        let (window, repeat) = (index / 2, index % 2);
        if let Some(why) = difference(&trial.plain.answers[window], answer) {
            return Ok(broken(format!(
                "window {window}, iteration {repeat}: the answer {why}"
            )));
        }
    }
    Ok(trial.compare_life(&last))
}

/// Every window is asked for under another load first, and half as long.
pub fn rollback(trial: &RuleTrial) -> Result<Finding, Error> {
    if let Some(why) = cannot_repeat(trial) {
        return Ok(why);
    }
    let other = trial.live(1, &mut |life, window, load| {
        life.ask(window, &trial.loads.of_window(window.index, 1))?;
        if let Some(half) = half(trial, window).filter(|_| trial.subject.part == Part::ForceDriven)
        {
            life.ask(&repeat(&half, 1), load)?;
        }
        let window = repeat(window, 2);
        Ok((window, life.ask(&window, load)?))
    })?;
    Ok(trial.compare_life(&other))
}

/// The first half of a window, where it has one.
fn half(trial: &RuleTrial, window: &Window) -> Option<Window> {
    let substeps = window.substeps / 2;
    let half = trial
        .subject
        .clock
        .window(window.index, window.step, substeps);
    (substeps > 0).then_some(half)
}

fn repeat(window: &Window, iteration: u32) -> Window {
    Window {
        iteration,
        ..*window
    }
}

fn cannot_repeat(trial: &RuleTrial) -> Option<Finding> {
    let subject = trial.subject;
    let offers = subject.told.capabilities.rollback;
    (!offers).then(|| not_offered("it cannot repeat a window (no `checkpoint`)"))
}

/// Lengths of reports, and numbers in them.
pub fn report(trial: &RuleTrial) -> Result<Finding, Error> {
    let told = &trial.subject.told;
    let due = told.signals.len() + told.ledger.len();
    let terms = told.ledger.iter().map(|term| &term.name);
    let names: Vec<&String> = told.signals.iter().chain(terms).collect();
    for (window, report) in trial.plain.reports.iter().enumerate() {
        if report.len() != due {
            return Ok(broken(format!(
                "window {window}: {} values, {due} were announced",
                report.len()
            )));
        }
        if let Some(at) = report.iter().position(|value| !value.is_finite()) {
            let (name, value) = (names[at], report[at]);
            return Ok(broken(format!("window {window}: `{name}` is {value}")));
        }
    }
    let (signals, terms) = (told.signals.len(), told.ledger.len());
    Ok(holds(format!("{signals} signals, {terms} energies")))
}

/// The work that it books against the work that was exchanged.
pub fn work(trial: &RuleTrial) -> Result<Finding, Error> {
    let booked = |role: &Role| trial.subject.told.ledger.iter().any(|t| t.role == *role);
    if !booked(&Role::InterfaceWork) {
        return Ok(not_offered("its ledger has no term `interface_work`"));
    }
    let (mut exchanged, mut sizes, mut worst) = (0.0, 0.0, (0.0, 0));
    for (index, answer) in trial.plain.answers.iter().enumerate() {
        let joules = trial.work(&trial.loads.of_window(index as u64, 0), answer);
        exchanged += joules;
        sizes += f64::abs(joules);
        let report = trial
            .plain
            .reports
            .get(index)
            .map_or(&[][..], |report| report);
        let off = (trial.energy(report, Role::InterfaceWork) - exchanged).abs() / sizes;
        if sizes > 0.0 && exceeds(off, worst.0) {
            worst = (off, index);
        }
    }
    if sizes == 0.0 {
        return Ok(not_tested("no work was done at the interface"));
    }
    let what = format!("interface work in window {} off by", worst.1);
    Ok(within(&what, worst.0, WORK))
}

/// The balance of the ledger over a load that comes and goes slowly.
pub fn balance(trial: &RuleTrial) -> Result<Finding, Error> {
    let part = trial.subject.part;
    if trial.subject.told.ledger.is_empty() {
        return Ok(not_offered("it keeps no ledger"));
    }
    let mut life = trial.begin()?;
    let (mut gross, mut stored, mut defect) = (0.0, 0.0, 0.0);
    let mut work = 0.0;
    for index in 0..SLOW_WINDOWS {
        let (window, load) = (
            life.window(index),
            trial.loads.slow(index, SLOW_WINDOWS, part),
        );
        let answer = life.ask(&window, &load)?;
        let report = life.accept(&window, &answer)?;
        let of = |role| trial.energy(&report, role);
        let now = of(Role::InterfaceWork) + of(Role::Work);
        gross += f64::abs(now - work);
        work = now;
        stored = of(Role::Stored).abs().max(stored);
        defect = f64::abs(work - of(Role::Stored) - of(Role::Dissipated)).max(defect);
    }
    let scale = gross.max(stored);
    if scale == 0.0 {
        return Ok(not_tested("no work was done"));
    }
    let what = format!("largest defect in {SLOW_WINDOWS} windows over the work done");
    Ok(within(&what, defect / scale, BALANCE))
}

/// Fields are written in the middle of a life.
pub fn snapshot(trial: &RuleTrial) -> Result<Finding, Error> {
    let other = trial.live(1, &mut |life, window, load| {
        if window.index == WINDOWS / 2 {
            life.snapshot("conform")?;
        }
        ask_once(life, window, load)
    })?;
    Ok(trial.compare_life(&other))
}

/// A checkpoint in the middle of a life, which another life takes up.
pub fn checkpoint(trial: &RuleTrial) -> Result<Finding, Error> {
    if !trial.subject.told.capabilities.resume {
        return Ok(not_offered("it writes no checkpoints (no `resume`)"));
    }
    let mut saved = None;
    let kept = trial.live(1, &mut |life, window, load| {
        if window.index == WINDOWS / 2 {
            saved = Some((life.checkpoint()?, life.place()));
        }
        ask_once(life, window, load)
    })?;
    let found = trial.compare_life(&kept);
    let (state, place) = saved.expect("the window came");
    if found.0 == RuleVerdict::Broken {
        return Ok(broken(format!("after a checkpoint, {}", found.1)));
    }
    let mut life = trial.begin()?;
    life.restore(&state, &place)?;
    life.repeat_boundary()?;
    let (mut answers, mut reports) = (Vec::new(), Vec::new());
    for index in WINDOWS / 2..WINDOWS {
        let window = life.window(index);
        let answer = life.ask(&window, &trial.loads.of_window(index, 0))?;
        reports.push(life.accept(&window, &answer)?);
        answers.push(answer);
    }
    let hash = life.finish()?.farewell.outcome.state_hash;
    let found = trial.compare((WINDOWS / 2) as usize, &answers, &reports);
    if found.0 == RuleVerdict::Holds && hash != trial.plain.death.farewell.outcome.state_hash {
        return Ok(broken(
            "a new life that took up the checkpoint answers the same and ends with another state hash",
        ));
    }
    Ok(found)
}

/// Windows without an interface.
pub fn alone(trial: &RuleTrial) -> Result<Finding, Error> {
    let told = &trial.subject.told;
    if !told.capabilities.alone {
        return Ok(not_offered("it cannot run alone"));
    }
    if told.step_s.is_none() {
        return Ok(not_tested("it has no step of its own here"));
    }
    let alone = TestedParticipant {
        stage: trial.subject.stage,
        participant: trial.subject.participant,
        part: Part::Alone,
        sets: Vec::new(),
        told: told.clone(),
        clock: trial.subject.clock,
        boundary: OnceCell::new(),
    };
    let trial = RuleTrial::new(&alone)?;
    let found = report(&trial)?;
    Ok(match found.0 {
        RuleVerdict::Broken => found,
        _ => holds(format!("{WINDOWS} windows, {}", found.1)),
    })
}
