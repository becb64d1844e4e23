//! Traction of a wheel over its sideways motion: |F_T|/F_N, sticking included, and the friction during gross sliding.

use protocol::larger;
use serde::{Deserialize, Serialize};

use crate::cycle_drift::Mean;

crate::results! {
    /// # Friction and sliding
    /// - `traction_ratio_mean`: Mean |F_T|/F_N of the wheel over its motion. It includes sticking, so it
    ///   is not a coefficient of friction. Of a rolling wheel T/N, positive where it brakes, over the last
    ///   of several passages or the last half of the distance.
    /// - `traction_ratio_peak`: The largest |F_T|/F_N of the wheel during its motion, while it bears at
    ///   least half of its load; of a rolling wheel the largest |T|/N over the same way.
    /// - `gross_sliding_share`: Share of the wheel's path over which the contact slides as a whole.
    /// - `gross_sliding_friction`: Mean |F_T| over mean F_N of the wheel on the path over which the
    ///   contact slides as a whole; absent if it never does.
    /// - `friction_coefficient`: Old name of `traction_ratio_mean`, which the next release drops.
}

/// Smallest share of its load that a wheel bears where its peak counts: a bouncing wheel can have any ratio.
const BORNE: f64 = 0.5;

/// |F_T|/F_N of a wheel, step by step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TractionRatio {
    mean: Mean,
    peak: Option<f64>,
}

impl TractionRatio {
    /// Records the force on the wheel (N), along x and y, under this load (N).
    pub fn record(&mut self, [tangential, normal]: [f64; 2], load: f64) {
        if normal <= 0.0 {
            return;
        }
        let ratio = tangential.abs() / normal;
        self.mean.add(ratio);
        if normal >= BORNE * load {
            self.peak = Some(self.peak.map_or(ratio, |peak| larger(peak, ratio)));
        }
    }

    /// Its results under their names.
    pub fn results(&self) -> [(&'static str, Option<f64>); 3] {
        let mean = self.mean.value();
        [
            ("traction_ratio_mean", mean),
            ("traction_ratio_peak", self.peak),
            ("friction_coefficient", mean),
        ]
    }
}

/// Sums over the path of a wheel, and over the part on which the contact slides as a whole.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GrossSliding {
    /// Path of the wheel (m).
    pub way: f64,
    /// Path on which the contact slides as a whole (m).
    pub slid: f64,
    /// Work of |F_T| and integral of F_N over the sliding path (J).
    pub work: [f64; 2],
}

impl GrossSliding {
    /// Records a part of the path (m) on which the contact slides, under this force on the wheel (N).
    pub fn slide(&mut self, way: f64, [tangential, normal]: [f64; 2]) {
        self.slid += way;
        self.work[0] += tangential.abs() * way;
        self.work[1] += normal * way;
    }

    /// Adds the sums over another part of the path.
    pub fn join(&mut self, other: &GrossSliding) {
        crate::add_fields!(self, other; way, slid);
        self.work = [0, 1].map(|k| self.work[k] + other.work[k]);
    }

    /// Its results under their names; `None` for a wheel that has not moved.
    pub fn results(&self) -> [(&'static str, Option<f64>); 2] {
        let [work, pressed] = self.work;
        [
            (
                "gross_sliding_share",
                (self.way > 0.0).then(|| self.slid / self.way),
            ),
            (
                "gross_sliding_friction",
                (pressed > 0.0).then(|| work / pressed),
            ),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ratios of 0.1, 0.4 and, bouncing at a tenth of the load, 3: the mean has all, the peak the first two.
    #[test]
    fn a_wheel_that_bounces_has_no_peak() {
        let mut ratio = TractionRatio::default();
        for force in [[-10.0, 100.0], [40.0, 100.0], [30.0, 10.0], [5.0, -1.0]] {
            ratio.record(force, 100.0);
        }
        let [mean, peak, old] = ratio.results().map(|(_, value)| value.unwrap_or_default());
        assert!((mean - 3.5 / 3.0).abs() < 1e-15 && old == mean);
        assert_eq!(peak, 0.4);
        assert_eq!(TractionRatio::default().results()[1].1, None);
    }

    /// 3 m of 4 m under 20 N, and half of them under 30 N, each pressed by 100 N.
    #[test]
    fn friction_is_the_mean_over_the_sliding_path() {
        let mut sliding = GrossSliding {
            way: 4.0,
            ..GrossSliding::default()
        };
        assert_eq!(sliding.results().map(|(_, value)| value), [Some(0.0), None]);
        sliding.slide(1.5, [-20.0, 100.0]);
        sliding.slide(1.5, [30.0, 100.0]);
        assert_eq!(
            sliding.results().map(|(_, value)| value),
            [Some(0.75), Some(0.25)]
        );
    }
}
