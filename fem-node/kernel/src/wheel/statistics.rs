//! Statistics over all steps: reports may be far apart.

use std::collections::BTreeMap;

use kit::bounds::wider;
use kit::cycle_drift::{CycleDrift, Mean};
use kit::traction::{GrossSliding, TractionRatio};
use kit::wheel::WheelProgram;
use protocol::larger;
use serde::{Deserialize, Serialize};

use super::node_contact::{NodeContact, count, force_on_wheel};
use super::rigid::Wheel;

kit::results! {
    /// # Friction and sliding
    /// - `sn_max_velocity_pct`: Share of sliding contact nodes while the wheel is fastest, the mean
    ///   over ±10 µs at each passage through the middle after the first reversal.
    /// - `sn_reversal_pct`: Mean share of sliding nodes from 30 to 300 µs after a reversal, the largest over the reversals.
    /// - `sn_reversal_max_pct`: The largest single share of sliding nodes from 10 to 30 µs after a reversal, a noisy figure.
    /// - `sn_sliding_mean_pct`: Mean share of sliding nodes while the whole contact slides.
    /// - `sn_sliding_min_pct`: The smallest share of sliding nodes while the whole contact slides.
    /// - `sn_sliding_max_pct`: The largest share of sliding nodes while the whole contact slides.
    /// - `sn_stick_slip_mean_pct`: Mean share of sliding nodes from the first total sliding to the
    ///   reversal: the stick-slip phase.
}

/// Half of the time over which Sn is averaged around D = 0 (s).
const AROUND_ZERO: f64 = 10e-6;

/// Span after a reversal in which the largest Sn of a single step is recorded (s): before it the old slip is still dying out. The last slip events
/// end within the span, which makes the maximum noisy.
const JUST_REVERSED: [f64; 2] = [10e-6, 30e-6];

/// Span after a reversal over which Sn is averaged (s): the old slip has died out, the new one has hardly begun.
const AFTER_REVERSAL: [f64; 2] = [30e-6, 300e-6];

/// Share of the full friction above which the whole wheel slides.
const SLIDING: f64 = 0.999;

/// Statistics over all steps so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CycleStatistics {
    held_force: Mean,
    held_range: Option<[f64; 2]>,
    /// Force on the wheel at the end of the last step before it starts to move, 0 without such a step (N).
    before_motion: Option<f64>,
    ratio: TractionRatio,
    sliding: GrossSliding,
    sn_zero: Mean,
    sn_after_reversal: WorstMean,
    sn_reversal_max: Option<f64>,
    sn_stick_slip: StickSlip,
    sn_sliding: Mean,
    sn_sliding_range: Option<[f64; 2]>,
    loop_area: f64,
    pub drift: CycleDrift,
}

/// Means over successive spans; the largest mean is kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct WorstMean {
    span: Mean,
    worst: Option<f64>,
}

impl WorstMean {
    fn add(&mut self, value: f64) {
        self.span.add(value);
    }

    /// Ends the current span, if there is one.
    fn close(&mut self) {
        if let Some(mean) = std::mem::take(&mut self.span).value() {
            self.worst = Some(self.worst.map_or(mean, |worst| larger(worst, mean)));
        }
    }
}

/// Sn from the first step in which all nodes slide to the reversal that ends the stroke.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct StickSlip {
    /// Reversals so far.
    reversals: u64,
    stroke: Mean,
    /// Mean over the strokes that have ended.
    all: Mean,
}

impl StickSlip {
    fn add(&mut self, reversals: u64, sn: f64) {
        if reversals > self.reversals {
            let stroke = std::mem::take(&mut self.stroke);
            self.all.sum += stroke.sum;
            self.all.count += stroke.count;
            self.reversals = reversals;
        }
        if sn == 100.0 || self.stroke.count > 0 {
            self.stroke.add(sn);
        }
    }
}

/// True around D = 0, which returns every half period. The start of the motion does not count: nothing has slid before.
fn near_zero(program: &WheelProgram, periods: f64) -> bool {
    let half = 2.0 * periods;
    let from_zero = (half - half.round()) * 0.5 * program.period();
    half.round() >= 1.0 && from_zero.abs() <= AROUND_ZERO
}

/// Number of reversals so far, which lie a quarter of a period after the zeros, and the time since the last (s).
fn reversals(program: &WheelProgram, periods: f64) -> (u64, f64) {
    let half = 2.0 * periods + 0.5;
    (half as u64, half.fract() * 0.5 * program.period())
}

/// True where the time since a reversal is within this span (s).
fn reversed_within((count, since): (u64, f64), [from, until]: [f64; 2]) -> bool {
    count > 0 && (from..=until).contains(&since)
}

impl CycleStatistics {
    /// Records the end of a step, and the work of the drive in it (J).
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
        if program.rolling.is_some() && t > program.motion_start() + 0.5 * wheel.step {
            self.before_motion.get_or_insert(0.0);
            return;
        }
        let Some(periods) = program.periods_at(t) else {
            if t + 1.5 * wheel.step >= program.motion_start() {
                self.before_motion = Some(fn_);
            }
            if t >= 0.5 * (program.ramp_s + program.motion_start()) {
                self.held_force.add(fn_);
                self.held_range = Some(wider(self.held_range, fn_));
            }
            return;
        };
        self.before_motion.get_or_insert(0.0);
        let sn = count(contacts).sliding_pct();
        if near_zero(program, periods) {
            self.sn_zero.add(sn);
        }
        self.record_reversal(reversals(program, periods), sn);
        self.ratio.record([ft, fn_], program.load_n);
        let way = (program.displacement_at(t) - program.displacement_at(t - wheel.step)).abs();
        self.sliding.way += way;
        if fn_ > 0.0 && ft.abs() >= SLIDING * wheel.numbers.friction * fn_ {
            self.sliding.slide(way, [ft, fn_]);
            self.sn_sliding.add(sn);
            self.sn_sliding_range = Some(wider(self.sn_sliding_range, sn));
        }
        if let Some([start, end]) = program.last_full_cycle() {
            let shared = t.min(end) - (t - wheel.step).max(start);
            self.loop_area += drive_work * shared.max(0.0) / wheel.step;
        }
    }

    /// Records the share of sliding nodes (%) after this number of reversals, the last of which is some time ago (s).
    fn record_reversal(&mut self, reversals: (u64, f64), sn: f64) {
        if reversed_within(reversals, JUST_REVERSED) {
            let largest = self.sn_reversal_max.map_or(sn, |before| larger(before, sn));
            self.sn_reversal_max = Some(largest);
        }
        if reversed_within(reversals, AFTER_REVERSAL) {
            self.sn_after_reversal.add(sn);
        } else {
            self.sn_after_reversal.close();
        }
        self.sn_stick_slip.add(reversals.0, sn);
    }

    /// Least and largest force on the wheel in the second half of the hold, or without a hold the last force before the motion (N).
    pub fn held_range(&self) -> Option<[f64; 2]> {
        self.held_range
            .or(self.before_motion.map(|force| [force; 2]))
    }

    /// Records the force on a wheel that begins in equilibrium (N).
    pub(super) fn begin_at_rest(&mut self, force: f64) {
        self.before_motion = Some(force);
    }

    /// Results by name, after this many steps.
    pub fn results(&self, wheel: &Wheel, step: u64) -> BTreeMap<String, f64> {
        let sliding = self.sn_sliding_range;
        let over = |[_, end]: &[f64; 2]| (step as f64 + 0.5) * wheel.step >= *end;
        let cycle = wheel.program.last_full_cycle().filter(over);
        let all = [
            ("load_n", Some(wheel.program.load_n)),
            ("wheel_force_n", self.held_force.value()),
            ("sn_max_velocity_pct", self.sn_zero.value()),
            ("sn_reversal_pct", self.sn_after_reversal.worst),
            ("sn_reversal_max_pct", self.sn_reversal_max),
            ("sn_stick_slip_mean_pct", self.sn_stick_slip.all.value()),
            ("sn_sliding_mean_pct", self.sn_sliding.value()),
            ("sn_sliding_min_pct", sliding.map(|[low, _]| low)),
            ("sn_sliding_max_pct", sliding.map(|[_, high]| high)),
            ("loop_area_j", cycle.map(|_| self.loop_area)),
        ];
        let all = all.into_iter().chain(self.ratio.results());
        let known = all
            .chain(self.sliding.results())
            .filter_map(|(name, value)| Some((name, value?)));
        known.map(|(name, value)| (name.into(), value)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::body::{Body, ElementKind};
    use crate::material::Elastic;
    use crate::mesh::Mesh;
    use crate::wheel::rigid::WheelNumbers;

    /// A wheel of 8 000 N, 0.5 ms of ramp and 0.4 ms of hold, then 2.25 cycles of 50 um at 300 Hz.
    fn program() -> WheelProgram {
        WheelProgram {
            load_n: 8000.0,
            load_table: None,
            ramp_s: 5e-4,
            hold_s: 4e-4,
            amplitude_m: 5e-5,
            frequency_hz: 300.0,
            cycles: 2.25,
            rolling: None,
        }
    }

    /// A wheel that is loaded and held for these times (s), with steps of a quarter of a second.
    fn wheel([ramp_s, hold_s]: [f64; 2]) -> Wheel {
        let mesh = Mesh::structured(10, 2, |i, j| [i as f64 - 5.0, -(j as f64)]);
        let elastic = Elastic::plane_strain(1.0, 0.3, 1.0);
        let body = Body::new(&mesh, ElementKind::Q4OnePoint, &elastic, 1.0);
        let program = WheelProgram {
            ramp_s,
            hold_s,
            ..program()
        };
        let numbers = WheelNumbers {
            mass: 1.0,
            radius: 0.0,
            friction: 0.3,
            friction_while_loading: true,
            start_damping: 0.0,
            thickness: 1.0,
        };
        Wheel::new(program, numbers, &mesh, &body, 0.25)
    }

    /// Range of the force after steps that end with these forces on the wheel (N).
    fn range_after(
        statistics: CycleStatistics,
        times: [f64; 2],
        forces: &[f64],
    ) -> Option<[f64; 2]> {
        let (mut statistics, wheel) = (statistics, wheel(times));
        for (index, force) in forces.iter().enumerate() {
            let contact = NodeContact {
                normal: [0.0, -force],
                ..NodeContact::default()
            };
            statistics.record(&wheel, &[contact], index as u64 + 1, 0.0);
        }
        statistics.held_range()
    }

    #[test]
    fn the_range_covers_the_second_half_of_the_hold() {
        // A ramp of 1 s and a hold until 3 s: steps 8 to 11 count.
        let mut forces = [1000.0; 12];
        (forces[6], forces[7], forces[9], forces[11]) = (0.0, 900.0, 1100.0, 0.0);
        let range = |steps| range_after(Default::default(), [1.0, 2.0], &forces[..steps]);
        assert_eq!(range(7), None);
        assert_eq!(range(12), Some([900.0, 1100.0]));
    }

    #[test]
    fn without_a_hold_it_is_the_force_before_the_motion() {
        let mut forces = [0.0; 14];
        forces[10] = 700.0;
        let range = |steps| range_after(Default::default(), [3.0, 0.0], &forces[..steps]);
        assert_eq!(range(10), None);
        assert_eq!(range(11), Some([700.0; 2]));
        assert_eq!(range(14), Some([700.0; 2]));
        let at_once = range_after(Default::default(), [0.0; 2], &[500.0]);
        assert_eq!(at_once, Some([0.0; 2]), "nothing was there before");
        let mut loaded = CycleStatistics::default();
        loaded.begin_at_rest(800.0);
        assert_eq!(range_after(loaded, [0.0; 2], &[500.0]), Some([800.0; 2]));
    }

    #[test]
    fn the_start_of_the_motion_does_not_count() {
        assert!(!near_zero(&program(), 0.0));
        assert_eq!(reversals(&program(), 0.0).0, 0);
    }

    #[test]
    fn zeros_follow_each_other_by_half_a_period() {
        for half in 1..5 {
            let zero = 0.5 * f64::from(half);
            let us = 1e-6 * 300.0;
            assert!(near_zero(&program(), zero + 9.9 * us));
            assert!(near_zero(&program(), zero - 9.9 * us));
            assert!(!near_zero(&program(), zero - 10.1 * us));
        }
    }

    #[test]
    fn reversals_lie_a_quarter_period_after_zeros() {
        for half in 0..4_u32 {
            let reversal = 0.25 + 0.5 * f64::from(half);
            let after = |us: f64| reversals(&program(), reversal + us * 1e-6 * 300.0);
            assert_eq!(after(-0.1).0, u64::from(half));
            assert_eq!(after(0.1).0, u64::from(half) + 1);
            let within = |span| move |us: f64| reversed_within(after(us), span);
            assert_eq!(
                [9.9, 10.1, 29.9, 30.1].map(within(JUST_REVERSED)),
                [false, true, true, false]
            );
            let settled = within(AFTER_REVERSAL);
            assert_eq!(
                [29.9, 30.1, 299.9, 300.1].map(settled),
                [false, true, true, false]
            );
        }
    }

    /// Statistics of shares of sliding nodes (%) sampled every 10 us, the first one 5 us after the first reversal.
    fn statistics_of(shares: &[f64]) -> CycleStatistics {
        let mut statistics = CycleStatistics::default();
        for (index, sn) in shares.iter().enumerate() {
            // The next reversal follows after 400 us.
            let (reversals, tick) = (1 + index as u64 / 40, index % 40);
            statistics.record_reversal((reversals, 10e-6 * (tick as f64 + 0.5)), *sn);
        }
        statistics
    }

    #[test]
    fn the_share_after_a_reversal_is_the_worst_of_the_means() {
        let mut shares = [0.0; 120];
        // Slip events before and after the span of the mean; within, 4 and then 2 samples out of 27.
        (shares[1], shares[35]) = (70.0, 90.0);
        shares[3..7].fill(67.5);
        shares[50..52].fill(81.0);
        let statistics = statistics_of(&shares);
        assert_eq!(statistics.sn_after_reversal.worst, Some(10.0));
        assert_eq!(
            statistics.sn_reversal_max,
            Some(70.0),
            "15 us after a reversal"
        );
        let second = statistics_of(&shares[40..]);
        assert_eq!(second.sn_after_reversal.worst, Some(6.0));
        assert_eq!(second.sn_reversal_max, Some(0.0));
        assert_eq!(
            statistics_of(&shares[..20]).sn_after_reversal.worst,
            None,
            "a mean not yet complete"
        );
    }

    #[test]
    fn stick_slip_lasts_from_the_first_full_slip_to_the_reversal() {
        let mut shares = [40.0; 100];
        // 100, 38 of 0 until the reversal, then a stroke without full slip, and one that no reversal has ended.
        shares[1] = 100.0;
        shares[2..40].fill(0.0);
        shares[90] = 100.0;
        let mean = statistics_of(&shares).sn_stick_slip.all.value();
        assert_eq!(mean, Some(100.0 / 39.0));
        assert_eq!(statistics_of(&shares[..40]).sn_stick_slip.all.value(), None);
    }
}
