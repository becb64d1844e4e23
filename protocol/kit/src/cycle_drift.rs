//! Drift of a wheel from one cycle of its sideways motion to the next; means.

use protocol::{Finding, larger};
use serde::{Deserialize, Serialize};

use crate::wheel::WheelProgram;
use crate::{Bounds, judge};

crate::findings! {
    /// From one cycle to the next the wheel moves up or down under its held load.
    ///
    /// - Why: the layer or body below it yields or oscillates, as thick or loose layers do. Friction
    ///   and loops do not describe a steady motion.
    /// - Do: take more `wheel.cycles`, make `wheel.hold_s` longer, or the layer thinner or bonded.
    /// - Judged: Change of the wheel's height over the last period, at displacement 0, over the
    ///   amplitude of its motion: at 0.5 um of 50 um the load does a work of 4.5 % of the friction
    ///   loop of `wheel-rail-fe-small`.
    /// - Valid: 2e-4 (`wheel-rail-coupled`).
    /// - Wrong: 0.025, 0.06 (its layer 1.0, 1.5 mm thick: friction at D = 0 exceeds the rail's by
    ///   7 % or more).
    CYCLE_DRIFT = "cycle_drift": cycle_drift_rel in dem fem = [0.01, 0.1];
}

/// Fraction of half a period by which a step may miss the end of the half: times are sums of steps.
const ROUNDING: f64 = 1e-3;

/// Heights of a wheel each time that its displacement returns to 0, twice per period. Under a held load a steady motion has the same
/// height there in each cycle, for any course in between.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CycleDrift {
    /// Zeros so far.
    count: u64,
    /// The last four heights (m), the latest at the end.
    heights: [f64; 4],
}

impl CycleDrift {
    /// Records the height (m) at the end of a step, t (s).
    pub fn record(&mut self, program: &WheelProgram, t: f64, height: f64) {
        let periods = program.periods_at(t).unwrap_or(0.0);
        let count = (2.0 * periods + ROUNDING) as u64;
        if count > self.count {
            self.count = count;
            self.heights.rotate_left(1);
            self.heights[3] = height;
        }
    }

    /// Judges the larger change of height over the last period, from zero to zero, over the amplitude. It needs three zeros, and does not
    /// judge if the height has a reason to change: without a load, under a table, without an amplitude.
    pub fn judge(&self, program: &WheelProgram, bounds: Bounds) -> Option<Finding> {
        let held = program.load_n > 0.0 && program.load_table.is_none();
        let [a, b, c, d] = self.heights;
        let before = if self.count > 3 { (c - a).abs() } else { 0.0 };
        let drift = larger(before, (d - b).abs());
        let found = judge!(bounds, CYCLE_DRIFT, drift / program.amplitude_m;
            "from one cycle to the next the wheel moved up or down by {drift:.2e} m at displacement 0: the layer or body below it yields or oscillates, and friction loops do not describe a steady motion; take more wheel.cycles, make wheel.hold_s longer, or the layer thinner, bonded or damped");
        found.filter(|_| held && program.amplitude_m > 0.0 && self.count >= 3)
    }
}

/// A mean that is filled value by value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Mean {
    /// Sum of the values.
    pub sum: f64,
    /// Number of values.
    pub count: u64,
}

impl Mean {
    /// Adds a value.
    pub fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1;
    }

    /// The mean; `None` without values.
    pub fn value(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The drift of a wheel that sinks by 1 um per cycle, and rises and sinks by 20 um within each, after `cycles` cycles of 50 um.
    fn drift(cycles: f64, change: impl Fn(&mut WheelProgram)) -> Option<f64> {
        let mut program = WheelProgram {
            load_n: 8000.0,
            hold_s: 1e-3,
            amplitude_m: 5e-5,
            frequency_hz: 300.0,
            cycles,
            ..WheelProgram::default()
        };
        change(&mut program);
        let mut drift = CycleDrift::default();
        for step in 0..=(program.end() / 1e-6).round() as u64 {
            let t = step as f64 * 1e-6;
            let periods = program.periods_at(t).unwrap_or(0.0);
            let height = 2e-5 * (4.0 * std::f64::consts::PI * periods).sin() - 1e-6 * periods;
            drift.record(&program, t, height);
        }
        let bounds = Bounds::from([1e-9, 1.0]);
        drift.judge(&program, bounds).map(|found| found.value)
    }

    #[test]
    fn drift_between_cycles_is_measured_and_motion_within_a_cycle_is_not() {
        for cycles in [1.5, 2.0, 3.25] {
            let found = drift(cycles, |_| {}).expect("three zeros");
            assert!((found / 0.02 - 1.0).abs() < 0.05, "{cycles}: {found}");
        }
    }

    #[test]
    fn a_cycle_without_another_to_compare_and_a_load_that_changes_are_not_judged() {
        assert_eq!(drift(1.25, |_| {}), None);
        assert_eq!(drift(2.0, |program| program.load_n = 0.0), None);
        assert_eq!(drift(2.0, |program| program.amplitude_m = 0.0), None);
        let table = vec![[0.0, 1.0], [1.0, 2.0]];
        assert_eq!(
            drift(2.0, |program| program.load_table = Some(table.clone())),
            None
        );
    }
}
