//! The full cycles of the wheel's motion: what each of them took off, cost and moved.
//!
//! With t_s the end of the hold, cycle k lasts from t_s + (k - 1)/f to t_s + k/f. A cycle that the end of the run cuts is none.
//! Heights, accounts and forces are known at the ends of steps and taken as straight between them, so that the sums over all cycles
//! do not depend on where the steps lie.

use std::fmt::Write as _;

use kit::wheel::WheelProgram;
use serde::{Deserialize, Serialize};

use crate::measure::flow::Flow;
use crate::step::StepSummary;
use crate::step::state::GrainState;

/// Part of a step by which a run may end before the cycle does: steps are counted up to that.
const ROUNDING: f64 = 1e-6;

/// What a cycle has: its column in the table, the result of the last cycle, that of all together, and true where that one is a mean.
///
/// - Height that the wheel lost (m);
/// - work of its sideways drive (J), the area of the friction loop;
/// - |T| (N) at D = 0, mean of the crossings in the middle and at the end: at the start of the first cycle nothing has slid;
/// - |T|/N, mean over the time in which the wheel is pressed;
/// - real masses that were detached in the zone, ejected and worn (kg);
/// - third body per length in the middle of the zone, mean over the time (kg/m).
const QUANTITIES: [(&str, &str, &str, bool); 8] = [
    ("sink_m", "cycle_sink_m", "all_cycles_sink_m", false),
    ("work_j", "loop_area_j", "all_cycles_work_j", false),
    (
        "tangential_at_zero_n",
        "cycle_tangential_at_zero_n",
        "all_cycles_tangential_at_zero_n",
        true,
    ),
    (
        "friction_coefficient",
        "cycle_friction_coefficient",
        "all_cycles_friction_coefficient",
        true,
    ),
    (
        "source_kg",
        "cycle_source_kg",
        "all_cycles_source_kg",
        false,
    ),
    (
        "ejected_kg",
        "cycle_ejected_kg",
        "all_cycles_ejected_kg",
        false,
    ),
    ("wear_kg", "cycle_wear_kg", "all_cycles_wear_kg", false),
    (
        "third_body_per_length_kg_per_m",
        "cycle_third_body_kg_per_m",
        "all_cycles_third_body_kg_per_m",
        true,
    ),
];

/// How many of the quantities there are without flows.
const OF_WHEEL: usize = 4;

/// What is read at a time.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Reading {
    /// Height of the wheel (m).
    height: f64,
    /// Force of the grains on it along x (N).
    tangential: f64,
    /// Work of its sideways drive since the start (J).
    work: f64,
    /// Integrals of |T|/N and of 1 over the time in which it is pressed (s).
    friction: [f64; 2],
    /// Detached, ejected and worn since the start (kg), and the integral of third body per length over time (kg s/m).
    flows: [f64; 4],
}

impl Reading {
    /// The reading after this share of the way to a later one.
    fn toward(&self, later: &Reading, share: f64) -> Reading {
        let mix = |from: f64, to: f64| from + share * (to - from);
        Reading {
            height: mix(self.height, later.height),
            tangential: mix(self.tangential, later.tangential),
            work: mix(self.work, later.work),
            friction: [0, 1].map(|k| mix(self.friction[k], later.friction[k])),
            flows: [0, 1, 2, 3].map(|k| mix(self.flows[k], later.flows[k])),
        }
    }
}

/// A full cycle.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct WheelCycle {
    /// Start and end (s).
    times: [f64; 2],
    /// Its [`QUANTITIES`].
    values: [f64; 8],
}

/// The full cycles so far.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct WheelCycles {
    all: Vec<WheelCycle>,
    /// Passages through D = 0 so far, the start of the motion being the first.
    zeros: u64,
    /// Time and reading at the start of the cycle, and |T| in its middle (N).
    start: (f64, Reading),
    middle: f64,
    /// The reading at the end of the last step.
    now: Reading,
}

impl WheelCycles {
    /// Those of a run that begins with the wheel at this height (m).
    pub fn new(wheel_height: f64) -> WheelCycles {
        let mut cycles = WheelCycles::default();
        cycles.now.height = wheel_height;
        cycles
    }

    /// Records the state at the end of a step that lasted from `start` to `end` (s).
    pub fn record(
        &mut self,
        program: &WheelProgram,
        [start, end]: [f64; 2],
        (state, step): (&GrainState, &StepSummary),
        flow: Option<&Flow>,
    ) {
        if program.cycles <= 0.0 {
            return;
        }
        let (before, length) = (self.now, end - start);
        let [tangential, normal] = step.on_wheel;
        self.now = Reading {
            height: state.wheel.position[1],
            tangential,
            work: state.ledger.drive,
            ..before
        };
        if normal > 0.0 {
            self.now.friction[0] += length * tangential.abs() / normal;
            self.now.friction[1] += length;
        }
        if let Some(flow) = flow {
            let ledger = flow.ledger();
            let held = before.flows[3] + length * flow.per_length();
            self.now.flows = [ledger.source, ledger.ejected, ledger.wear, held];
        }
        loop {
            let time = program.motion_start() + 0.5 * self.zeros as f64 * program.period();
            if time > end + ROUNDING * length {
                return;
            }
            let share = ((time - start) / length).clamp(0.0, 1.0);
            self.pass_zero(time, before.toward(&self.now, share));
        }
    }

    /// The wheel passes D = 0, in the middle or at the end of a cycle.
    fn pass_zero(&mut self, time: f64, reading: Reading) {
        if self.zeros % 2 == 1 {
            self.middle = reading.tangential.abs();
        } else {
            if self.zeros > 0 {
                self.end_cycle(time, &reading);
            }
            self.start = (time, reading);
        }
        self.zeros += 1;
    }

    fn end_cycle(&mut self, time: f64, end: &Reading) {
        let (from, start) = self.start;
        let ratio = [0, 1].map(|k| end.friction[k] - start.friction[k]);
        let [source, ejected, wear, held] = [0, 1, 2, 3].map(|k| end.flows[k] - start.flows[k]);
        self.all.push(WheelCycle {
            times: [from, time],
            values: [
                start.height - end.height,
                end.work - start.work,
                0.5 * (self.middle + end.tangential.abs()),
                ratio[0] / ratio[1],
                source,
                ejected,
                wear,
                held / (time - from),
            ],
        });
    }

    /// The cycles as CSV, a line each; `None` without any. `flows` is true where they are followed.
    pub fn csv(&self, flows: bool) -> Option<String> {
        let known = &QUANTITIES[..known(flows)];
        let names: Vec<&str> = known.iter().map(|(column, ..)| *column).collect();
        let mut text = format!("cycle,t0_s,t1_s,{}\n", names.join(","));
        for (number, cycle) in self.all.iter().enumerate() {
            let _ = write!(text, "{}", number + 1);
            for x in cycle.times.iter().chain(&cycle.values[..known.len()]) {
                let _ = write!(text, ",{x:e}");
            }
            text.push('\n');
        }
        (!self.all.is_empty()).then_some(text)
    }

    /// The results of the last cycle and of all together; none without any.
    pub fn results(&self, flows: bool) -> Vec<(&'static str, f64)> {
        let Some(last) = self.all.last() else {
            return Vec::new();
        };
        let count = self.all.len() as f64;
        let mut results = vec![("full_cycles", count)];
        for (k, (_, of_last, of_all, is_mean)) in QUANTITIES[..known(flows)].iter().enumerate() {
            let sum: f64 = self.all.iter().map(|cycle| cycle.values[k]).sum();
            let all = if *is_mean { sum / count } else { sum };
            results.extend([(*of_last, last.values[k]), (*of_all, all)]);
        }
        results.retain(|(_, value)| value.is_finite());
        results
    }
}

/// Number of the quantities that there are.
fn known(flows: bool) -> usize {
    if flows { QUANTITIES.len() } else { OF_WHEEL }
}

#[cfg(test)]
mod tests;
