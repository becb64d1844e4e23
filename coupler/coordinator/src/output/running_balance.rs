//! Energy balances during a run: a later state may look better than the worst one.

use kit::Bounds;
use protocol::larger;
use serde::{Deserialize, Serialize};

use scheme::ledger::EnergySums;

/// Number of consecutive windows beyond the bound after which a balance counts as lost. The loss of a scheme in a
/// window is of first order in its length, so that a sound run may begin with an error of a few windows over the time
/// so far: scheme `velocity` in `quick` has 0.147 after twenty windows and 0.011 at the end.
const PATIENCE: u32 = 100;

/// The worst of one balance so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunningBalance {
    /// Largest energy error (J).
    defect_j: f64,
    /// Largest work, or stored and dissipated energy (J).
    scale_j: f64,
    /// Consecutive windows beyond the bound; the count ends at [`PATIENCE`].
    beyond: u32,
    /// Largest dissipated energy so far (J).
    dissipated_j: f64,
}

impl RunningBalance {
    /// Adds the energies of a ledger after a window. Returns the error once, when the balance becomes lost.
    pub fn add(&mut self, sums: &EnergySums, bounds: Bounds) -> Option<f64> {
        self.see(sums.defect_j().abs(), scale_j(sums), bounds.suspect)
    }

    /// Adds the dissipated energy of a ledger after a window, which must never decrease. Returns the relative decrease
    /// once, when it stays beyond the bound.
    pub fn add_loss(&mut self, sums: &EnergySums, bound: f64) -> Option<f64> {
        self.dissipated_j = larger(self.dissipated_j, sums.dissipated_j);
        self.see(self.dissipated_j - sums.dissipated_j, scale_j(sums), bound)
    }

    /// Adds an error and its scale (J) after a window. Returns their ratio once, when the balance becomes lost.
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

fn scale_j(sums: &EnergySums) -> f64 {
    larger(sums.worked_j(), sums.kept_size_j)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Windows after which an error `defect` (a function of the window) is reported, with its value; each window does 1
    /// J of work.
    fn reported(windows: u32, defect: impl Fn(u32) -> f64) -> Vec<(u32, f64)> {
        let mut balance = RunningBalance::default();
        let mut seen = |window| {
            let value = balance.see(defect(window), f64::from(window), 0.1);
            value.map(|value| (window, value))
        };
        (1..=windows).filter_map(&mut seen).collect()
    }

    #[test]
    fn a_lost_balance_is_reported_once_although_it_may_recover() {
        // 60 J of 50 J, recovered from window 60 on.
        let lost = reported(2000, |window| {
            if (50..60).contains(&window) {
                60.0
            } else {
                0.0
            }
        });
        assert_eq!(lost, [(149, 60.0 / 149.0)]);
    }

    #[test]
    fn an_error_at_the_start_is_not_reported() {
        // An error of two windows over the time so far.
        assert_eq!(reported(1000, |_| 2.0), []);
        assert_eq!(reported(1000, |window| 0.1 * f64::from(window)), []);
        assert_eq!(reported(1000, |window| 0.11 * f64::from(window)).len(), 1);
    }

    #[test]
    fn a_balance_that_is_lost_again_is_not_reported_again() {
        let lost = reported(3000, |window| match window {
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

    /// 0.9 J of 1 J are reported as dissipated, and return with the rest.
    #[test]
    fn decreasing_losses_are_reported_and_others_are_not() {
        let reports = |dissipated: fn(f64) -> f64| {
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
        assert_eq!(reports(|_| 0.0), 0);
        assert_eq!(reports(|stored| 0.05 * stored), 0);
        assert_eq!(reports(|stored| 0.9 * stored), 1);
    }

    /// 1 J of 1 J of work is missing; 20 J move to and fro.
    #[test]
    fn the_larger_of_work_and_stored_energy_is_the_scale_and_the_second_bound_decides() {
        let sums = EnergySums {
            work_j: 1.0,
            work_size_j: 1.0,
            kept_size_j: 20.0,
            ..EnergySums::default()
        };
        let found = |warn: f64, suspect: f64| {
            let mut balance = RunningBalance::default();
            let mut add = || balance.add(&sums, Bounds { warn, suspect });
            (0..2 * PATIENCE).find_map(|_| add())
        };
        assert_eq!(found(0.01, 0.1), None);
        assert_eq!(found(0.01, 0.04), Some(0.05));
    }

    #[test]
    fn nan_is_reported() {
        let found = reported(200, |window| if window == 7 { f64::NAN } else { 0.0 });
        assert_eq!(found.len(), 1);
        assert!(found[0].0 == 106 && found[0].1.is_nan(), "{found:?}");
    }
}
