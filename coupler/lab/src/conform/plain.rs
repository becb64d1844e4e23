//! The plain launch, and the comparison of other launches with it.

use nalgebra::DMatrix;
use protocol::{Role, Surface, Window};

use super::launch::{Launch, LaunchEnd};
use super::load::{TrialLoads, into};
use super::rule::{RuleFinding, broken};
use super::tested::{Part, TestedParticipant};
use scenario::error::Error;

/// Part of a motion by which a compliant boundary yields.
const YIELDS: f64 = 0.1;

/// Number of windows of a launch.
pub const WINDOWS: u64 = 12;

/// A participant with the loads of its tests and its plain launch, in which each window is requested once.
pub struct RuleTrial<'a> {
    /// The participant.
    pub tested: &'a TestedParticipant<'a>,
    /// Its points.
    pub surface: Surface,
    /// Its loads.
    pub loads: TrialLoads,
    /// Its answer to a change of motion, if it is motion-driven.
    pub stiffness: Option<LayerStiffness>,
    /// Its plain launch.
    pub plain: LaunchRecord,
}

/// Answers and reports of a launch, window by window.
pub struct LaunchRecord {
    /// Answers to the accepted windows.
    pub answers: Vec<Vec<f64>>,
    /// Reports of these windows.
    pub reports: Vec<Vec<f64>>,
    /// Its end.
    pub end: LaunchEnd,
}

impl LaunchRecord {
    /// Hash of its state at the end.
    pub fn state_hash(&self) -> &str {
        &self.end.farewell.outcome.state_hash
    }
}

/// Requests a window in a special way; returns the window and the answer to accept.
pub type AskWindow<'t> =
    dyn FnMut(&mut Launch, &Window, &[f64]) -> Result<(Window, Vec<f64>), Error> + 't;

impl<'a> RuleTrial<'a> {
    /// Finds loads that fit the participant, and records its plain launch.
    pub fn new(tested: &'a TestedParticipant<'a>) -> Result<RuleTrial<'a>, Error> {
        let (surface, loads) = loads(tested)?;
        let stiffness = match tested.part {
            Part::MotionDriven => Some(stiffness(tested, &loads)?),
            Part::Alone | Part::ForceDriven => None,
        };
        if let Some(stiffness) = stiffness.as_ref()
            && tested.description.capabilities.compliant_boundary
        {
            let boundary = yielding(tested.clock.window_s(), stiffness);
            boundary.map(|boundary| tested.boundary.set(boundary));
        }
        let plain = record(Launch::new(tested, 1)?, &loads, 0, &mut ask_once)?;
        Ok(RuleTrial {
            tested,
            surface,
            loads,
            stiffness,
            plain,
        })
    }

    /// Records a launch in which windows are requested in this way.
    pub fn live(&self, threads: usize, ask: &mut AskWindow) -> Result<LaunchRecord, Error> {
        record(Launch::new(self.tested, threads)?, &self.loads, 0, ask)
    }

    /// A new launch.
    pub fn begin(&self) -> Result<Launch<'a>, Error> {
        Launch::new(self.tested, 1)
    }

    /// Compares answers and reports from window `first` on with the plain launch.
    pub fn compare(&self, first: u64, answers: &[Vec<f64>], reports: &[Vec<f64>]) -> RuleFinding {
        let first = first as usize;
        let plain = &self.plain;
        for (what, plain, other) in [
            ("answer", &plain.answers, answers),
            ("report", &plain.reports, reports),
        ] {
            for (window, other) in (first..).zip(other) {
                if let Some(why) = difference(&plain[window], other) {
                    return broken(format!("window {window}: the {what} {why}"));
                }
            }
        }
        Ok(format!("{} windows, the same bits", answers.len()))
    }

    /// The same for a launch from window `first` to its end, including its final state.
    pub fn compare_to_end(&self, first: u64, other: &LaunchRecord, otherwise: &str) -> RuleFinding {
        let same = self.compare(first, &other.answers, &other.reports)?;
        if self.plain.state_hash() != other.state_hash() {
            return broken(otherwise);
        }
        Ok(same)
    }

    /// The same for a whole launch.
    pub fn compare_life(&self, other: &LaunchRecord) -> RuleFinding {
        let otherwise = "the answers are the same, but the state hashes at the end differ";
        self.compare_to_end(0, other, otherwise)
    }

    /// Sum of the energies (J) of one role at the end of a report.
    pub fn energy(&self, report: &[f64], role: Role) -> f64 {
        let own = &self.tested.description;
        let terms = report.iter().skip(own.signals.len()).zip(&own.ledger);
        let terms = terms.filter(|(_, term)| term.role == role);
        terms.map(|(joules, _)| joules).sum()
    }

    /// Work (J) of a window at the interface: force times increment, or the work done on a layer.
    pub fn work(&self, load: &[f64], answer: &[f64]) -> f64 {
        let n = load.len();
        match self.tested.part {
            Part::MotionDriven => -self.tested.clock.window_s() * dot(&answer[..n], &answer[n..]),
            _ => dot(load, answer),
        }
    }
}

/// Requests the window once.
pub fn ask_once(
    launch: &mut Launch,
    window: &Window,
    load: &[f64],
) -> Result<(Window, Vec<f64>), Error> {
    Ok((*window, launch.ask(window, load)?))
}

/// Records a launch from window `first` to its end.
pub fn record(
    mut launch: Launch,
    loads: &TrialLoads,
    first: u64,
    ask: &mut AskWindow,
) -> Result<LaunchRecord, Error> {
    let (mut answers, mut reports) = (Vec::new(), Vec::new());
    for index in first..WINDOWS {
        let window = launch.window(index);
        let (window, answer) = ask(&mut launch, &window, &loads.of_window(index, 0))?;
        reports.push(launch.accept(&window, &answer)?);
        answers.push(answer);
    }
    Ok(LaunchRecord {
        answers,
        reports,
        end: launch.finish()?,
    })
}

/// Change of the forces (N) of a layer between two motions of a window on a rigid boundary, and of the motion (m/s).
pub struct LayerStiffness {
    /// Change of the forces.
    pub force: Vec<f64>,
    /// Change of the motion.
    pub motion: Vec<f64>,
}

/// A boundary that yields to the layer by a part of the motion; `None` if there was no force.
fn yielding(window_s: f64, of: &LayerStiffness) -> Option<DMatrix<f64>> {
    let impedance = window_s * greatest(&of.force) / greatest(&of.motion);
    let yields = |i: usize, j: usize| match i.abs_diff(j) {
        0 => YIELDS / impedance,
        2 => 0.3 * YIELDS / impedance,
        _ => 0.0,
    };
    let n = of.force.len();
    (impedance > 0.0).then(|| DMatrix::from_fn(n, n, yields))
}

/// Presses the layer for all windows, then once more with a motion and with a faster one.
fn stiffness(tested: &TestedParticipant, loads: &TrialLoads) -> Result<LayerStiffness, Error> {
    let one = loads.of_window(WINDOWS, 0);
    let other: Vec<f64> = one.iter().map(|v| 1.5 * v).collect();
    let mut forces = Vec::new();
    for velocity in [&one, &other] {
        let mut launch = Launch::new(tested, 1)?;
        for index in 0..WINDOWS {
            launch.go(&launch.window(index), &loads.of_window(index, 0))?;
        }
        let window = launch.window(WINDOWS);
        let answer = launch.ask(&window, velocity)?;
        forces.push(answer[..velocity.len()].to_vec());
    }
    Ok(LayerStiffness {
        force: minus(&forces[1], &forces[0]),
        motion: minus(&other, &one),
    })
}

/// Loads under which it moves, or resists, by comparable amounts.
fn loads(tested: &TestedParticipant) -> Result<(Surface, TrialLoads), Error> {
    let mut launch = Launch::new(tested, 1)?;
    let surface = launch.surface.clone();
    let points = surface.len();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / points.max(1) as f64;
    let spacing_m = mean(&surface.length_m);
    let loads = match tested.part {
        Part::Alone => TrialLoads::forces(0, 1.0, 1.0),
        Part::ForceDriven => {
            let window = launch.window(0);
            let unloaded = launch.ask(&window, &vec![0.0; 2 * points])?;
            let loaded = Launch::new(tested, 1)?.ask(&window, &vec![1.0; 2 * points])?;
            let softest = greatest(&minus(&loaded, &unloaded));
            TrialLoads::forces(points, spacing_m, softest)
        }
        Part::MotionDriven => {
            let radius_m = mean(&surface.radius_m);
            let round = radius_m > 0.0;
            let size_m = if round { 2.0 * radius_m } else { spacing_m };
            let direction = into(tested).unwrap_or([0.0, 1.0]);
            TrialLoads::velocities(points, size_m, direction, tested.clock.window_s())
        }
    };
    Ok((surface, loads))
}

/// The first difference of two vectors in their bits.
pub fn difference(plain: &[f64], other: &[f64]) -> Option<String> {
    let (came, due) = (other.len(), plain.len());
    if came != due {
        return Some(format!("has {came} numbers instead of {due}"));
    }
    let mut pairs = plain.iter().zip(other);
    let at = pairs.position(|(one, two)| one.to_bits() != two.to_bits())?;
    let (came, due) = (other[at], plain[at]);
    Some(format!("has {came:e} instead of {due:e} at entry {at}"))
}

/// Sum of products.
pub fn dot(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(a, b)| a * b).sum()
}

/// Difference of two vectors.
pub fn minus(one: &[f64], other: &[f64]) -> Vec<f64> {
    one.iter().zip(other).map(|(a, b)| a - b).collect()
}

/// Largest absolute value of an entry.
pub fn greatest(vector: &[f64]) -> f64 {
    vector.iter().fold(0.0, |most, value| value.abs().max(most))
}

/// Largest difference of two vectors over the largest entry of the second.
pub fn apart(one: &[f64], other: &[f64]) -> f64 {
    greatest(&minus(one, other)) / greatest(other)
}
