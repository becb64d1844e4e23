//! Statistics over all steps: reports may be far apart.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::node_contact::{NodeContact, count, force_on_wheel};
use super::program::Program;
use super::rigid::Wheel;
use crate::pack::larger;

/// Signals of the wheel by name. `wheel_fn_n` and `wheel_ft_n` are the force of the body on the wheel, upwards and
/// towards +x; `wheel_y_m` is the lowest point of the face, `sn_pct` the share of sliding nodes among those in contact.
pub(crate) const SIGNALS: [&str; 7] = [
    "wheel_x_m",
    "wheel_y_m",
    "wheel_vx_m_per_s",
    "wheel_fn_n",
    "wheel_ft_n",
    "sn_pct",
    "contact_nodes",
];

/// Half of the time over which Sn is averaged around D = 0 (s).
const AROUND_ZERO: f64 = 10e-6;

/// Span after a reversal over which Sn is averaged (s): before, the old slip is still dying out.
const AFTER_REVERSAL: [f64; 2] = [10e-6, 30e-6];

/// Share of the full friction from which on the whole wheel slides.
const SLIDING: f64 = 0.999;

/// A mean that is filled value by value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Mean {
    sum: f64,
    count: u64,
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1;
    }

    fn value(self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }
}

/// Smallest and largest of some values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Range {
    low: f64,
    high: f64,
}

impl Range {
    fn of(value: f64, before: Option<Range>) -> Range {
        Range {
            low: before.map_or(value, |before| -larger(-before.low, -value)),
            high: before.map_or(value, |before| larger(before.high, value)),
        }
    }
}

/// Statistics over all steps so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct CycleStatistics {
    held_force: Mean,
    held_range: Option<Range>,
    /// Force on the wheel at the end of the last step before it starts to move, 0 where there is none (N).
    before_motion: Option<f64>,
    friction: Mean,
    sn_zero: Mean,
    sn_reversal: Mean,
    sn_reversal_range: Option<Range>,
    sn_sliding: Mean,
    sn_sliding_range: Option<Range>,
    loop_area: f64,
}

/// Part of a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
enum CyclePart {
    NearZero,
    AfterReversal,
    Elsewhere,
}

/// D = 0 at every half period; the reversals lie a quarter of a period behind. The start of the motion is no
/// such zero: nothing has slid before.
fn cycle_part(program: &Program, periods: f64) -> CyclePart {
    let half = 2.0 * periods;
    let from_zero = (half - half.round()) * 0.5 * program.period();
    if half.round() >= 1.0 && from_zero.abs() <= AROUND_ZERO {
        return CyclePart::NearZero;
    }
    let since_reversal = (half - 0.5).rem_euclid(1.0) * 0.5 * program.period();
    let [from, until] = AFTER_REVERSAL;
    if half >= 0.5 && (from..=until).contains(&since_reversal) {
        CyclePart::AfterReversal
    } else {
        CyclePart::Elsewhere
    }
}

impl CycleStatistics {
    /// Takes note of the end of a step, and of the work that the drive did in it (J).
    pub(super) fn record(
        &mut self,
        wheel: &Wheel,
        contacts: &[NodeContact],
        step: u64,
        drive_work: f64,
    ) {
        let program = &wheel.program;
        let t = step as f64 * wheel.step;
        let [ft, fn_] = force_on_wheel(contacts);
        let Some(periods) = program.periods_at(t) else {
            if t + 1.5 * wheel.step >= program.motion_start() {
                self.before_motion = Some(fn_);
            }
            if t >= 0.5 * (program.0.ramp_s + program.motion_start()) {
                self.held_force.add(fn_);
                self.held_range = Some(Range::of(fn_, self.held_range));
            }
            return;
        };
        self.before_motion.get_or_insert(0.0);
        let sn = count(contacts).sliding_pct();
        match cycle_part(program, periods) {
            CyclePart::NearZero => self.sn_zero.add(sn),
            CyclePart::AfterReversal => {
                self.sn_reversal.add(sn);
                self.sn_reversal_range = Some(Range::of(sn, self.sn_reversal_range));
            }
            CyclePart::Elsewhere => {}
        }
        if fn_ > 0.0 {
            self.friction.add(ft.abs() / fn_);
            if ft.abs() >= SLIDING * wheel.contact.friction * fn_ {
                self.sn_sliding.add(sn);
                self.sn_sliding_range = Some(Range::of(sn, self.sn_sliding_range));
            }
        }
        if let Some([start, end]) = program.last_full_cycle() {
            let shared = t.min(end) - (t - wheel.step).max(start);
            self.loop_area += drive_work * shared.max(0.0) / wheel.step;
        }
    }

    /// Least and largest force on the wheel in the second half of the hold, or the last one before the motion where there
    /// is no hold (N).
    pub(crate) fn held_range(&self) -> Option<[f64; 2]> {
        let range = self.held_range.map(|range| [range.low, range.high]);
        range.or(self.before_motion.map(|force| [force; 2]))
    }

    /// Takes note of a wheel that begins in equilibrium under this force (N).
    pub(super) fn begin_at_rest(&mut self, force: f64) {
        self.before_motion = Some(force);
    }

    /// Results by name.
    pub(crate) fn results(&self, wheel: &Wheel) -> BTreeMap<String, f64> {
        let sliding = self.sn_sliding_range;
        let cycle = wheel.program.last_full_cycle();
        let all = [
            ("load_n", Some(wheel.program.0.load_n)),
            ("wheel_force_n", self.held_force.value()),
            ("friction_coefficient", self.friction.value()),
            ("sn_max_velocity_pct", self.sn_zero.value()),
            ("sn_reversal_pct", self.sn_reversal_range.map(|sn| sn.high)),
            ("sn_reversal_mean_pct", self.sn_reversal.value()),
            ("sn_sliding_mean_pct", self.sn_sliding.value()),
            ("sn_sliding_min_pct", sliding.map(|sn| sn.low)),
            ("sn_sliding_max_pct", sliding.map(|sn| sn.high)),
            ("loop_area_j", cycle.map(|_| self.loop_area)),
        ];
        let known = all
            .into_iter()
            .filter_map(|(name, value)| Some((name, value?)));
        known.map(|(name, value)| (name.into(), value)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wheel::program::tests::program;

    #[test]
    fn the_start_of_the_motion_is_not_looked_at() {
        assert_eq!(cycle_part(&program(), 0.0), CyclePart::Elsewhere);
    }

    #[test]
    fn zeros_follow_each_other_by_half_a_period() {
        for half in 1..5 {
            let zero = 0.5 * f64::from(half);
            let us = 1e-6 * 300.0;
            assert_eq!(cycle_part(&program(), zero + 9.9 * us), CyclePart::NearZero);
            assert_eq!(cycle_part(&program(), zero - 9.9 * us), CyclePart::NearZero);
            assert_eq!(
                cycle_part(&program(), zero - 10.1 * us),
                CyclePart::Elsewhere
            );
        }
    }

    #[test]
    fn reversals_lie_a_quarter_period_after_zeros() {
        for half in 0..4 {
            let reversal = 0.25 + 0.5 * f64::from(half);
            let us = 1e-6 * 300.0;
            assert_eq!(
                cycle_part(&program(), reversal + 9.9 * us),
                CyclePart::Elsewhere
            );
            assert_eq!(
                cycle_part(&program(), reversal + 10.1 * us),
                CyclePart::AfterReversal
            );
            assert_eq!(
                cycle_part(&program(), reversal + 29.9 * us),
                CyclePart::AfterReversal
            );
            assert_eq!(
                cycle_part(&program(), reversal + 30.1 * us),
                CyclePart::Elsewhere
            );
        }
    }
}
