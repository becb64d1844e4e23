//! The full cycles of the wheel's motion: sinking, work, slip and flows of each.
//!
//! With t_s the end of the hold, cycle k lasts from t_s + (k - 1)/f to t_s + k/f. A cycle that the end of the run cuts does not count. Heights,
//! accounts and forces are known at the ends of steps and linear between them, so that the sums over all cycles do not depend on the position of the
//! steps.

use dem_kernel::bodies::Bodies;
use dem_kernel::step::StepSummary;
use dem_kernel::step::state::GrainState;
use kit::cycle_drift::Mean;
use kit::traction::GrossSliding;
use kit::wheel::WheelProgram;
use serde::{Deserialize, Serialize};

use crate::measure::accommodation::Accommodation;
use crate::measure::flow::Flow;
use crate::measure::trend::slope;

kit::results! {
    /// # Load and approach
    /// - `p0_1mm_motion_pa`: Largest mean over 1 mm of the pressure on the base of the grains, rigid or not, averaged over the first full cycle of
    ///   the wheel. A ground layer later bears the wheel on few grains.
    /// - `cycle_p0_1mm_pa`: `p0_1mm_motion_pa` over the last full cycle.
    /// # Cycles of the wheel on grains
    /// - `full_cycles`: Cycles of the motion that ended within the run.
    /// - `cycle_sink_m`: Height that the wheel lost in the last full cycle.
    /// - `all_cycles_sink_m`: Height that the wheel lost in all full cycles.
    /// - `all_cycles_work_j`: Work of the tangential force in all full cycles; `loop_area_j` is the work of the last.
    /// - `cycle_tangential_at_zero_n`: |F_T| at D = 0, mean of the middle and the end of the last
    ///   full cycle.
    /// - `all_cycles_tangential_at_zero_n`: |F_T| at D = 0, mean over all full cycles.
    /// - `cycle_traction_ratio`: |F_T|/F_N, mean over the last full cycle, sticking included.
    /// - `all_cycles_traction_ratio`: |F_T|/F_N, mean over all full cycles, sticking included.
    /// - `cycle_friction_coefficient`: Old name of `cycle_traction_ratio`, which the next release drops.
    /// - `all_cycles_friction_coefficient`: Old name of `all_cycles_traction_ratio`, which the next
    ///   release drops.
    /// - `slip_amplitude_m`: Half the way by which wheel and base slide past each other in a stroke, without sticking: the amplitude less the motion
    ///   of the base and the shear of the layer, mean over all full cycles.
    /// - `cycle_slip_amplitude_m`: `slip_amplitude_m` of the last full cycle.
    /// - `slip_by_work_m`: Work of the wheel's drive over 4 F, mean over the loops from reversal to
    ///   reversal from the second cycle on; F is the mean of |F_T| over the slip.
    /// - `accommodated_by_body_m`: Half the range of the displacement of the base below the wheel in a cycle, weighted by the pressure on it, mean
    ///   over all full cycles.
    /// - `cycle_accommodated_by_body_m`: `accommodated_by_body_m` of the last full cycle.
    /// - `cycle_source_kg`: Qs of the last full cycle: mass that was detached within the zone.
    /// - `all_cycles_source_kg`: Qs of all full cycles: mass that was detached within the zone.
    /// - `cycle_ejected_kg`: Mass that left the zone by its own motion in the last full cycle.
    /// - `all_cycles_ejected_kg`: Mass that left the zone by its own motion in all full cycles.
    /// - `cycle_wear_kg`: Qw of the last full cycle: mass that had stayed outside for long enough.
    /// - `all_cycles_wear_kg`: Qw of all full cycles: mass that had stayed outside for long enough.
    /// - `cycle_third_body_kg_per_m`: Third body per length in the middle of the zone, mean over
    ///   the last full cycle.
    /// - `all_cycles_third_body_kg_per_m`: Third body per length in the middle of the zone, mean
    ///   over all full cycles.
    /// - `third_body_trend_kg_per_m`: Change of the third body per length in a cycle, by the
    ///   straight line through the last half of at least eight cycles.
    /// - `third_body_trend_interval_kg_per_m`: Half of the 95 % interval of `third_body_trend_kg_per_m`; correlated cycles count less.
    /// - `wheel_trend_m`: Change of the wheel's height in a cycle, by the same line.
    /// - `wheel_trend_interval_m`: Half of the 95 % interval of `wheel_trend_m`.
}

/// Part of a step by which a run may end before its last cycle, which then still counts.
const ROUNDING: f64 = 1e-6;

/// Quantities of a cycle:
///
/// - height that the wheel lost (m);
/// - work of its sideways drive (J), the area of the friction loop;
/// - |T| (N) at D = 0, mean of the crossings in the middle and at the end: at the start of the first cycle nothing has slid;
/// - |T|/N, mean over the time in which the wheel is pressed;
/// - slip over the layer, amplitude of the base (m) and pressure on it (Pa), see [`Accommodation`];
/// - real masses that were detached in the zone, ejected and worn (kg);
/// - third body per length in the middle of the zone, mean over the time (kg/m).
const QUANTITIES: [&str; 11] = [
    "sink_m",
    "work_j",
    "tangential_at_zero_n",
    "traction_ratio",
    "slip_amplitude_m",
    "accommodated_by_body_m",
    "p0_1mm_pa",
    "source_kg",
    "ejected_kg",
    "wear_kg",
    "third_body_kg_per_m",
];
/// Number of quantities without flows.
const OF_WHEEL: usize = 7;
/// Quantities whose value for all cycles is the mean; for the others it is the sum.
const MEANS: [&str; 3] = [
    "tangential_at_zero_n",
    "traction_ratio",
    "third_body_kg_per_m",
];

/// Values at a time: way of the wheel downwards (m), work of its sideways drive (J), integrals of |T|/N and of 1 over the time in which it is pressed
/// (s), masses detached, ejected and worn (kg), integral of third body per length over time (kg s/m), and T (N).
type Reading = [f64; 9];

/// The full cycles so far.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct WheelCycles {
    /// Start and end (s) of each cycle, and its [`QUANTITIES`].
    all: Vec<([f64; 2], [f64; 11])>,
    /// Number of passages through D = 0, the start of the motion being the first, and of reversals, which alternate.
    quarters: u64,
    slip: Accommodation,
    /// Work of the drive at the last reversal at D = A from the second cycle on (J), the slip since then, and the slip W/(4 F) of each loop (m).
    reversal: Option<f64>,
    of_loop: GrossSliding,
    loops: Mean,
    /// The slip of all strokes that are over.
    sliding: GrossSliding,
    /// Time and reading at the start of the cycle, and |T| in its middle (N).
    start: (f64, Reading),
    middle: f64,
    /// The reading at the end of the last step.
    now: Reading,
}

impl WheelCycles {
    /// The cycles of a run that begins with the wheel at this height, in a scene of this thickness (m).
    pub fn new(wheel_height: f64, thickness_m: f64) -> WheelCycles {
        let mut cycles = WheelCycles {
            slip: Accommodation::new(thickness_m),
            ..WheelCycles::default()
        };
        cycles.now[0] = -wheel_height;
        cycles
    }

    /// Records the state at the end of a step that lasted from `start` to `end` (s), and the impulses on the points of the boundary (2 n).
    pub fn record(
        &mut self,
        program: &WheelProgram,
        [start, end]: [f64; 2],
        (bodies, state, step): (&Bodies, &GrainState, &StepSummary),
        impulses: &[f64],
        flow: Option<&Flow>,
    ) {
        if program.cycles <= 0.0 {
            return;
        }
        let (before, length) = (self.now, end - start);
        let [_, _, ratio, pressed, .., held, _] = before;
        let [tangential, normal] = step.on_wheel;
        let [more, time] = if normal > 0.0 {
            [length * tangential.abs() / normal, length]
        } else {
            [0.0; 2]
        };
        let ledger = flow.map(|flow| *flow.ledger()).unwrap_or_default();
        if 0.5 * (start + end) > program.motion_start() {
            self.slip.record(length, state, step.on_wheel, impulses);
        }
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
            let time = program.motion_start() + 0.25 * self.quarters as f64 * program.period();
            if time > end + ROUNDING * length {
                return;
            }
            let share = ((time - start) / length).clamp(0.0, 1.0);
            let now = std::array::from_fn(|k| before[k] + share * (self.now[k] - before[k]));
            match self.quarters % 4 {
                0 => self.end_cycle(bodies, time, now),
                2 => self.middle = now[8].abs(),
                _ => self.turn(now[1]),
            }
            self.quarters += 1;
        }
    }

    /// The wheel passes D = 0 at the end of a cycle, or starts.
    fn end_cycle(&mut self, bodies: &Bodies, time: f64, reading: Reading) {
        let (from, start) = self.start;
        let [sink, work, ratio, pressed, source, ejected, wear, held, _]: Reading =
            std::array::from_fn(|k| reading[k] - start[k]);
        let at_zero = 0.5 * (self.middle + reading[8].abs());
        let [friction, held] = [ratio / pressed, held / (time - from)];
        let [slip, by_body, pressure] = self.slip.end_cycle(bodies);
        let values = [
            sink, work, at_zero, friction, slip, by_body, pressure, source, ejected, wear, held,
        ];
        if self.quarters > 0 {
            self.all.push(([from, time], values));
        }
        self.start = (time, reading);
    }

    /// The wheel turns back, at D = A after a whole loop. With a slip s behind a spring the loop has the area F s, F being the mean of |T| over the
    /// slip: a quarter of s is W/(4 F).
    fn turn(&mut self, work: f64) {
        let stroke = self.slip.turn();
        self.sliding.join(&stroke);
        self.of_loop.join(&stroke);
        if self.quarters % 4 == 1 {
            let GrossSliding {
                slid,
                work: [rubbed, _],
                ..
            } = std::mem::take(&mut self.of_loop);
            let before = self.reversal.filter(|_| rubbed > 0.0);
            if let Some(before) = before {
                self.loops.add(0.25 * (work - before) * slid / rubbed);
            }
            self.reversal = (self.quarters > 4).then_some(work);
        }
    }

    /// The cycles as CSV, a line each; `None` without any. `flows` is true where flows are measured.
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

    /// Slopes of the straight lines through the last half of the cycles, each with the half of its 95 % interval: third body per length (kg/m) and
    /// height of the wheel (m) over the number of the cycle; then the mean of the third body. `None` with fewer than eight cycles.
    pub fn trends(&self) -> Option<([[f64; 2]; 2], f64)> {
        let last = &self.all[self.all.len().div_ceil(2)..];
        let third = last.iter().map(|(_, values)| values[QUANTITIES.len() - 1]);
        let third: Vec<f64> = third.collect();
        let height = last.iter().scan(0.0, |y, (_, values)| {
            *y -= values[0];
            Some(*y)
        });
        let slopes = [slope(&third)?, slope(&height.collect::<Vec<f64>>())?];
        Some((slopes, third.iter().sum::<f64>() / third.len() as f64))
    }

    /// The results of the last cycle and of all together; empty without cycles.
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
            let values = || self.all.iter().map(|(_, values)| values[k]);
            let sum: f64 = values().sum();
            let all = match *name {
                // From the first cycle: a layer that is ground bears the wheel on few grains.
                "p0_1mm_pa" => (
                    "p0_1mm_motion_pa".into(),
                    values().next().unwrap_or_default(),
                ),
                "slip_amplitude_m" | "accommodated_by_body_m" => (name.to_string(), sum / count),
                _ if MEANS.contains(name) => (format!("all_cycles_{name}"), sum / count),
                _ => (format!("all_cycles_{name}"), sum),
            };
            if *name == "traction_ratio" {
                let old = ["cycle", "all_cycles"].map(|of| format!("{of}_friction_coefficient"));
                results.extend(old.into_iter().zip([last[k], sum / count]));
            }
            results.extend([(of_last, last[k]), all]);
        }
        let by_work = self.loops.value();
        results.extend(by_work.map(|slip| ("slip_by_work_m".into(), slip)));
        let of_way = self.sliding.results().into_iter();
        results.extend(of_way.filter_map(|(name, value)| Some((name.into(), value?))));
        if let (true, Some(([third, height], _))) = (flows, self.trends()) {
            let named = [
                ("third_body_trend_kg_per_m", third[0]),
                ("third_body_trend_interval_kg_per_m", third[1]),
                ("wheel_trend_m", height[0]),
                ("wheel_trend_interval_m", height[1]),
            ];
            results.extend(named.map(|(name, value)| (name.into(), value)));
        }
        results.retain(|(_, value)| value.is_finite());
        results
    }
}

/// Names of the quantities.
fn names(flows: bool) -> &'static [&'static str] {
    &QUANTITIES[..if flows { QUANTITIES.len() } else { OF_WHEEL }]
}

#[cfg(test)]
mod tests;
