//! Rules for every participant: bits, reports, energies, checkpoints.

use protocol::{Role, Window};

use super::plain::{RuleTrial, WINDOWS, ask_once, difference, minus, record};
use super::rule::{RuleFinding, Stop, broken, exceeds, not_tested, offered, within};
use super::tested::{Part, TestedParticipant};

/// Largest difference between the work summed on both sides, over the sum of its absolute values: rounding leaves 1e-12.
const WORK: f64 = 1e-6;

/// Largest part of the work that may be missing after a slow load: a force that is constant within windows leaves a part of 5 / windows.
const BALANCE: f64 = 0.1;
const SLOW_WINDOWS: u64 = 200;
const SUDDEN_WINDOWS: u64 = 40;

/// Compares two launches, the second with two threads.
pub fn same_bits(trial: &RuleTrial) -> RuleFinding {
    let other = trial.live(2, &mut ask_once)?;
    trial.compare_life(&other)
}

/// Requests every window three times.
pub fn repeats(trial: &RuleTrial) -> RuleFinding {
    repeats_offered(trial)?;
    let mut first = Vec::new();
    let last = trial.live(1, &mut |launch, window, load| {
        first.push(launch.ask(window, load)?);
        first.push(launch.ask(&repeat(window, 1), load)?);
        let window = repeat(window, 2);
        Ok((window, launch.ask(&window, load)?))
    })?;
    for (index, answer) in first.iter().enumerate() {
        let (window, repeat) = (index / 2, index % 2);
        if let Some(why) = difference(&trial.plain.answers[window], answer) {
            let place = format!("window {window}, iteration {repeat}");
            return broken(format!("{place}: the answer {why}"));
        }
    }
    trial.compare_life(&last)
}

/// Requests every window under another load first, and with half its length.
pub fn rollback(trial: &RuleTrial) -> RuleFinding {
    repeats_offered(trial)?;
    let other = trial.live(1, &mut |launch, window, load| {
        launch.ask(window, &trial.loads.of_window(window.index, 1))?;
        let half = half(trial, window).filter(|_| trial.tested.part == Part::ForceDriven);
        if let Some(half) = half {
            launch.ask(&repeat(&half, 1), load)?;
        }
        let window = repeat(window, 2);
        Ok((window, launch.ask(&window, load)?))
    })?;
    trial.compare_life(&other)
}

/// The first half of a window, if it has at least two substeps.
fn half(trial: &RuleTrial, window: &Window) -> Option<Window> {
    let substeps = window.substeps / 2;
    let clock = &trial.tested.clock;
    let half = clock.window(window.index, window.step, substeps);
    (substeps > 0).then_some(half)
}

fn repeat(window: &Window, iteration: u32) -> Window {
    Window {
        iteration,
        ..*window
    }
}

fn repeats_offered(trial: &RuleTrial) -> Result<(), Stop> {
    let offers = trial.tested.description.capabilities.rollback;
    offered(offers, "it cannot repeat a window (no `checkpoint`)")
}

/// Checks the lengths of reports, and that their numbers are finite.
pub fn report(trial: &RuleTrial) -> RuleFinding {
    let own = &trial.tested.description;
    let terms = own.ledger.iter().map(|term| &term.name);
    let names: Vec<&String> = own.signals.iter().chain(terms).collect();
    let due = names.len();
    for (window, report) in trial.plain.reports.iter().enumerate() {
        let came = report.len();
        if came != due {
            let why = format!("{came} values, but {due} were announced");
            return broken(format!("window {window}: {why}"));
        }
        if let Some(at) = report.iter().position(|value| !value.is_finite()) {
            let (name, value) = (names[at], report[at]);
            return broken(format!("window {window}: `{name}` is {value}"));
        }
    }
    let counted = |count: usize, words: [&str; 2]| {
        let word = words[usize::from(count != 1)];
        format!("{count} {word}")
    };
    let signals = counted(own.signals.len(), ["signal", "signals"]);
    let energies = counted(own.ledger.len(), ["energy", "energies"]);
    Ok(format!("{signals}, {energies}"))
}

/// Compares the work in its ledger with the exchanged work.
pub fn work(trial: &RuleTrial) -> RuleFinding {
    let mut terms = trial.tested.description.ledger.iter();
    let offers = terms.any(|term| term.role == Role::InterfaceWork);
    offered(offers, "its ledger has no term `interface_work`")?;
    let (mut exchanged, mut sizes, mut worst) = (0.0, 0.0, (0.0, 0));
    for (index, answer) in trial.plain.answers.iter().enumerate() {
        let joules = trial.work(&trial.loads.of_window(index as u64, 0), answer);
        exchanged += joules;
        sizes += f64::abs(joules);
        let report = trial
            .plain
            .reports
            .get(index)
            .map_or(&[][..], Vec::as_slice);
        let off = (trial.energy(report, Role::InterfaceWork) - exchanged).abs() / sizes;
        if sizes > 0.0 && exceeds(off, worst.0) {
            worst = (off, index);
        }
    }
    if sizes == 0.0 {
        return not_tested("no work was done at the interface");
    }
    let what = format!("interface work in window {} off by", worst.1);
    within(&what, worst.0, WORK)
}

/// Checks the balance of the ledger over a load that comes and goes slowly, whose work is stored and returned. For a continuum, also over a
/// sudden load that stays, which mass and damping bear.
pub fn balance(trial: &RuleTrial) -> RuleFinding {
    let part = trial.tested.part;
    let offers = !trial.tested.description.ledger.is_empty();
    offered(offers, "it keeps no ledger")?;
    let slow = |index| trial.loads.slow(index, SLOW_WINDOWS, part);
    let [fell, defect, _] = defects(trial, SLOW_WINDOWS, slow)?;
    within("dissipated energy decreased by", fell, BALANCE)?;
    let what = format!("largest defect in {SLOW_WINDOWS} windows over the work done");
    let slowly = within(&what, defect, BALANCE)?;
    if part != Part::ForceDriven {
        return Ok(slowly);
    }
    let load = trial.loads.of_window(0, 0);
    let [_, defect, in_equilibrium] = defects(trial, SUDDEN_WINDOWS, |_| load.clone())?;
    // A continuum that is always in equilibrium has no mass for the work of the force beyond its mean over the motion.
    let defect = defect.min(in_equilibrium);
    let sudden = within("under a sudden load", defect, BALANCE)?;
    Ok(format!("{slowly}; {sudden}"))
}

/// Errors of a ledger under some loads, relative to the work done or the energy stored, the larger of both: the largest decrease of the
/// dissipated energy; the largest part of the work that is neither stored nor dissipated, or is counted twice; and the same part for the
/// work of the mean of the forces at the ends of each window.
fn defects(
    trial: &RuleTrial,
    windows: u64,
    load: impl Fn(u64) -> Vec<f64>,
) -> Result<[f64; 3], Stop> {
    let mut launch = trial.begin()?;
    let (mut gross, mut stored, mut excess) = (0.0, 0.0, 0.0);
    let (mut work, mut lost): (f64, f64) = (0.0, 0.0);
    let [mut fell, mut defect, mut in_equilibrium] = [0.0; 3];
    let mut before = trial.loads.none();
    for index in 0..windows {
        let load = load(index);
        let (answer, report) = launch.go(&launch.window(index), &load)?;
        let of = |role| trial.energy(&report, role);
        let now = of(Role::InterfaceWork) + of(Role::Work);
        gross += f64::abs(now - work);
        work = now;
        stored = of(Role::Stored).abs().max(stored);
        lost = of(Role::Dissipated).max(lost);
        fell = f64::max(lost - of(Role::Dissipated), fell);
        let left = work - of(Role::Stored) - of(Role::Dissipated);
        defect = left.abs().max(defect);
        excess += 0.5 * trial.work(&minus(&load, &before), &answer);
        in_equilibrium = f64::abs(left - excess).max(in_equilibrium);
        before = load;
    }
    let scale = gross.max(stored);
    if scale == 0.0 {
        return not_tested("no work was done");
    }
    Ok([fell, defect, in_equilibrium].map(|joules| joules / scale))
}

/// Requests fields in the middle of a launch.
pub fn snapshot(trial: &RuleTrial) -> RuleFinding {
    let other = trial.live(1, &mut |launch, window, load| {
        if window.index == WINDOWS / 2 {
            launch.snapshot("conform")?;
        }
        ask_once(launch, window, load)
    })?;
    trial.compare_life(&other)
}

/// Requests a checkpoint in the middle of a launch, from which another launch continues.
pub fn checkpoint(trial: &RuleTrial) -> RuleFinding {
    let offers = trial.tested.description.capabilities.resume;
    offered(offers, "it writes no checkpoints (no `resume`)")?;
    let half = WINDOWS / 2;
    let mut saved = None;
    let kept = trial.live(1, &mut |launch, window, load| {
        if window.index == half {
            saved = Some((launch.checkpoint()?, launch.displacement.clone()));
        }
        ask_once(launch, window, load)
    })?;
    let (state, displacement) = saved.expect("the window came");
    if let Err(Stop::Verdict(_, why)) = trial.compare_life(&kept) {
        return broken(format!("after a checkpoint, {why}"));
    }
    let mut launch = trial.begin()?;
    launch.restore(&state, &displacement)?;
    launch.repeat_boundary()?;
    let resumed = record(launch, &trial.loads, half, &mut ask_once)?;
    let otherwise =
        "a new launch from the checkpoint gives the same answers and ends with another state hash";
    trial.compare_to_end(half, &resumed, otherwise)
}

/// Requests windows without an interface.
pub fn alone(trial: &RuleTrial) -> RuleFinding {
    let own = &trial.tested.description;
    offered(own.capabilities.alone, "it cannot run alone")?;
    if own.step_s.is_none() {
        return not_tested("it has no step of its own here");
    }
    let alone = TestedParticipant {
        part: Part::Alone,
        sets: Vec::new(),
        ..trial.tested.clone()
    };
    let reported = report(&RuleTrial::new(&alone)?)?;
    Ok(format!("{WINDOWS} windows, {reported}"))
}
