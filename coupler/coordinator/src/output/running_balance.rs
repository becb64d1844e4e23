//! Energy balances while a run goes: a state later on may look better than the worst did.

use kit::Bounds;
use protocol::larger;
use serde::{Deserialize, Serialize};

use scheme::ledger::EnergySums;

/// Windows in a row beyond the bound after which a balance counts as lost. What a scheme loses in a window is of first order in its length, so that
/// the beginning of a sound run may be off by a few windows over the time so far: scheme `velocity` in `quick` by 0.147 after twenty
/// windows and 0.011 at the end.
const PATIENCE: u32 = 100;

/// The worst of one balance so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunningBalance {
    /// Largest energy without account (J).
    defect_j: f64,
    /// The most that was worked, or stored and dissipated (J).
    scale_j: f64,
    /// Windows in a row that were beyond the bound; the count ends at [`PATIENCE`].
    beyond: u32,
    /// The most that was dissipated so far (J).
    dissipated_j: f64,
}

impl RunningBalance {
    /// Adds the energies of a ledger after a window; its value, once, when that makes the balance lost.
    pub fn add(&mut self, sums: &EnergySums, bounds: Bounds) -> Option<f64> {
        let scale_j = larger(sums.worked_j(), sums.kept_size_j);
        self.see(sums.defect_j().abs(), scale_j, bounds.suspect)
    }

    /// Adds what a ledger dissipates after a window: that never comes back. The part of the energies by which it fell, once, when that
    /// stays beyond the bound.
    pub fn add_loss(&mut self, sums: &EnergySums, bound: f64) -> Option<f64> {
        self.dissipated_j = larger(self.dissipated_j, sums.dissipated_j);
        let scale_j = larger(sums.worked_j(), sums.kept_size_j);
        self.see(self.dissipated_j - sums.dissipated_j, scale_j, bound)
    }

    /// Adds a defect and its scale (J) after a window; its value, once, when that makes the balance lost.
    pub fn see(&mut self, defect_j: f64, scale_j: f64, bound: f64) -> Option<f64> {
        self.defect_j = larger(self.defect_j, defect_j);
        self.scale_j = larger(self.scale_j, scale_j);
        if self.beyond >= PATIENCE {
            return None;
        }
        let within = self.defect_j <= bound * self.scale_j;
        self.beyond = if within { 0 } else { self.beyond + 1 };
        (self.beyond == PATIENCE).then(|| self.defect_j / self.scale_j)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Windows after which `defect` (a function of the window) of a work of 1 J a window is told, and its value.
    fn told(windows: u32, defect: impl Fn(u32) -> f64) -> Vec<(u32, f64)> {
        let mut balance = RunningBalance::default();
        let mut seen = |window| {
            let value = balance.see(defect(window), f64::from(window), 0.1);
            value.map(|value| (window, value))
        };
        (1..=windows).filter_map(&mut seen).collect()
    }

    #[test]
    fn a_balance_that_is_lost_is_told_once_though_it_may_come_back() {
        // 60 J of 50 J, made good from window 60 on.
        let lost = told(2000, |window| {
            if (50..60).contains(&window) {
                60.0
            } else {
                0.0
            }
        });
        assert_eq!(lost, [(149, 60.0 / 149.0)]);
    }

    #[test]
    fn a_start_that_is_off_is_no_alarm() {
        // Two windows over the time so far.
        assert_eq!(told(1000, |_| 2.0), []);
        assert_eq!(told(1000, |window| 0.1 * f64::from(window)), []);
        assert_eq!(told(1000, |window| 0.11 * f64::from(window)).len(), 1);
    }

    #[test]
    fn a_balance_that_is_lost_again_is_not_told_again() {
        let lost = told(3000, |window| match window {
            50 => 60.0,
            1000 => 2000.0,
            _ => 0.0,
        });
        assert_eq!(lost.len(), 1);
    }

    #[test]
    fn energy_that_went_through_still_counts() {
        let mut balance = RunningBalance::default();
        for (defect, scale) in [(1.0, 100.0), (1.0, 0.0)] {
            for _ in 0..2 * PATIENCE {
                assert_eq!(balance.see(defect, scale, 0.1), None);
            }
        }
    }

    /// 0.9 J of 1 J are told as lost, and come back with the rest.
    #[test]
    fn losses_that_fall_are_told_and_others_are_not() {
        let told = |dissipated: fn(f64) -> f64| {
            let mut loss = RunningBalance::default();
            let mut seen = |window: u32| {
                let stored = (0.01 * f64::from(window)).sin().abs();
                let sums = EnergySums {
                    kept_size_j: 1.0,
                    dissipated_j: dissipated(stored) + 1e-4 * f64::from(window),
                    ..EnergySums::default()
                };
                loss.add_loss(&sums, 0.1)
            };
            (0..500).filter_map(&mut seen).count()
        };
        assert_eq!(told(|_| 0.0), 0);
        assert_eq!(told(|stored| 0.05 * stored), 0);
        assert_eq!(told(|stored| 0.9 * stored), 1);
    }

    /// 1 J is missed of 1 J of work, which is a twentieth of what moves to and fro.
    #[test]
    fn the_larger_of_work_and_stored_energy_is_the_scale_and_the_second_bound_decides() {
        let sums = EnergySums {
            work_j: 1.0,
            work_size_j: 1.0,
            kept_size_j: 20.0,
            ..EnergySums::default()
        };
        let told = |warn: f64, suspect: f64| {
            let mut balance = RunningBalance::default();
            let mut add = || balance.add(&sums, Bounds { warn, suspect });
            (0..2 * PATIENCE).find_map(|_| add())
        };
        assert_eq!(told(0.01, 0.1), None);
        assert_eq!(told(0.01, 0.04), Some(0.05));
    }

    #[test]
    fn what_is_no_number_is_hopeless() {
        let told = told(200, |window| if window == 7 { f64::NAN } else { 0.0 });
        assert_eq!(told.len(), 1);
        assert!(told[0].0 == 106 && told[0].1.is_nan(), "{told:?}");
    }
}
