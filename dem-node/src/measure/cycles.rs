//! The full cycles of the wheel's motion: what each of them took off, cost and moved.
//!
//! With t_s the end of the hold, cycle k lasts from t_s + (k - 1)/f to t_s + k/f. A cycle that the end of the run cuts is none.
//! Heights, accounts and forces are known at the ends of steps and taken as straight between them, so that the sums over all cycles
//! do not depend on where the steps lie.

use kit::wheel::WheelProgram;
use serde::{Deserialize, Serialize};

use crate::measure::flow::Flow;
use crate::step::StepSummary;
use crate::step::state::GrainState;

/// Part of a step by which a run may end before the cycle does: steps are counted up to that.
const ROUNDING: f64 = 1e-6;

/// What a cycle has:
///
/// - height that the wheel lost (m);
/// - work of its sideways drive (J), the area of the friction loop;
/// - |T| (N) at D = 0, mean of the crossings in the middle and at the end: at the start of the first cycle nothing has slid;
/// - |T|/N, mean over the time in which the wheel is pressed;
/// - real masses that were detached in the zone, ejected and worn (kg);
/// - third body per length in the middle of the zone, mean over the time (kg/m).
const QUANTITIES: [&str; 8] = [
    "sink_m",
    "work_j",
    "tangential_at_zero_n",
    "friction_coefficient",
    "source_kg",
    "ejected_kg",
    "wear_kg",
    "third_body_kg_per_m",
];
/// How many of them there are without flows.
const OF_WHEEL: usize = 4;
/// Those of which all cycles together have the mean; of the others they have the sum.
const MEANS: [&str; 3] = [
    "tangential_at_zero_n",
    "friction_coefficient",
    "third_body_kg_per_m",
];

/// What is read at a time: way of the wheel downwards (m), work of its sideways drive (J), integrals of |T|/N and of 1 over the time in
/// which it is pressed (s), masses detached, ejected and worn (kg), integral of third body per length over time (kg s/m), and T (N).
type Reading = [f64; 9];

/// The full cycles so far.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct WheelCycles {
    /// Start and end (s), and the [`QUANTITIES`] of each.
    all: Vec<([f64; 2], [f64; 8])>,
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
        cycles.now[0] = -wheel_height;
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
        let [_, _, ratio, pressed, .., held, _] = before;
        let [tangential, normal] = step.on_wheel;
        let [more, time] = match normal > 0.0 {
            true => [length * tangential.abs() / normal, length],
            false => [0.0; 2],
        };
        let ledger = flow.map(|flow| *flow.ledger()).unwrap_or_default();
        self.now = [
            -state.wheel.position[1],
            state.ledger.drive,
            ratio + more,
            pressed + time,
            ledger.source,
            ledger.ejected,
            ledger.wear,
            held + length * flow.map_or(0.0, Flow::per_length),
            tangential,
        ];
        loop {
            let time = program.motion_start() + 0.5 * self.zeros as f64 * program.period();
            if time > end + ROUNDING * length {
                return;
            }
            let share = ((time - start) / length).clamp(0.0, 1.0);
            let now = std::array::from_fn(|k| before[k] + share * (self.now[k] - before[k]));
            self.pass_zero(time, now);
        }
    }

    /// The wheel passes D = 0, in the middle or at the end of a cycle.
    fn pass_zero(&mut self, time: f64, reading: Reading) {
        let tangential = reading[8].abs();
        if self.zeros % 2 == 1 {
            self.middle = tangential;
        } else {
            let (from, start) = self.start;
            let [sink, work, ratio, pressed, source, ejected, wear, held, _]: Reading =
                std::array::from_fn(|k| reading[k] - start[k]);
            let at_zero = 0.5 * (self.middle + tangential);
            let [friction, held] = [ratio / pressed, held / (time - from)];
            let values = [sink, work, at_zero, friction, source, ejected, wear, held];
            if self.zeros > 0 {
                self.all.push(([from, time], values));
            }
            self.start = (time, reading);
        }
        self.zeros += 1;
    }

    /// The cycles as CSV, a line each; `None` without any. `flows` is true where they are followed.
    pub fn csv(&self, flows: bool) -> Option<String> {
        let names = names(flows);
        let mut text = format!("cycle,t0_s,t1_s,{}\n", names.join(","));
        for (number, (times, values)) in self.all.iter().enumerate() {
            let numbers = times.iter().chain(&values[..names.len()]);
            let words: String = numbers.map(|x| format!(",{x:e}")).collect();
            text += &format!("{}{words}\n", number + 1);
        }
        (!self.all.is_empty()).then_some(text)
    }

    /// The results of the last cycle and of all together; none without any.
    pub fn results(&self, flows: bool) -> Vec<(String, f64)> {
        let Some((_, last)) = self.all.last() else {
            return Vec::new();
        };
        let count = self.all.len() as f64;
        let mut results = vec![("full_cycles".to_string(), count)];
        for (k, name) in names(flows).iter().enumerate() {
            let of_last = match *name {
                "work_j" => "loop_area_j".into(),
                _ => format!("cycle_{name}"),
            };
            let sum: f64 = self.all.iter().map(|(_, values)| values[k]).sum();
            let all = sum / if MEANS.contains(name) { count } else { 1.0 };
            results.extend([(of_last, last[k]), (format!("all_cycles_{name}"), all)]);
        }
        results.retain(|(_, value)| value.is_finite());
        results
    }
}

/// The quantities that there are.
fn names(flows: bool) -> &'static [&'static str] {
    &QUANTITIES[..if flows { QUANTITIES.len() } else { OF_WHEEL }]
}

#[cfg(test)]
mod tests;
