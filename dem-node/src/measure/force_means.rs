//! Mean forces of the grains on driven clusters and named walls.

use serde::{Deserialize, Serialize};

use super::trend::Trend;

kit::results! {
    /// # Forces and places of sets
    /// - `<set>_force_x_n`: Force along x on the driven wall or cluster, at the end or the mean
    ///   over the second half of the run.
    /// - `<set>_force_x_deviation_n`: Standard deviation of that force over the second half of the
    ///   run, step by step.
    /// - `<set>_force_x_change_n`: Change of the straight line through that force over this half: above the deviation the force is not steady.
    /// - `<set>_force_y_n`: Force along y on the driven wall or cluster, at the end or the mean
    ///   over the second half of the run.
    /// - `<set>_x_m`: Position along x of the driven cluster, at the end.
    /// - `<set>_y_m`: Position along y of the driven cluster, at the end.
}

/// Mean forces over the second half of a run. While its end is unknown, or its first half lasts, they are means over the last half to three quarters
/// of the steps so far.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct ForceMeans {
    /// Sums since the second half began, or since the number of steps was a power of two, and sums between this power and the one before (N).
    recent: Sums,
    before: Sums,
    steps: u64,
    halved: bool,
}

/// Summed forces on each body, and number of steps.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Sums {
    forces: Vec<[f64; 2]>,
    /// Sums of the squares along x (N2), and the line through these forces.
    along: Vec<(f64, Trend)>,
    steps: u64,
}

impl ForceMeans {
    /// Adds the forces of a step (N) that began at `start` of a run that ends at `end` (s).
    pub fn record(&mut self, forces: &[[f64; 2]], start: f64, end: Option<f64>) {
        if !self.halved && end.is_some_and(|end| start >= 0.5 * end) {
            *self = ForceMeans {
                halved: true,
                ..ForceMeans::default()
            };
        } else if !self.halved && self.steps.is_power_of_two() {
            self.before = std::mem::take(&mut self.recent);
        }
        self.steps += 1;
        let recent = &mut self.recent;
        recent.forces.resize(forces.len(), [0.0; 2]);
        recent.along.resize(forces.len(), Default::default());
        recent.steps += 1;
        for (sum, force) in recent.forces.iter_mut().zip(forces) {
            *sum = [sum[0] + force[0], sum[1] + force[1]];
        }
        for ((squares, trend), [x, _]) in recent.along.iter_mut().zip(forces) {
            *squares += x * x;
            trend.add(start, *x);
        }
    }

    /// Standard deviation of the force along x on each body over the second half of the run, and change of the straight line through it (N): a steady
    /// force changes by less than it scatters. Empty before the second half has begun.
    pub fn steadiness(&self) -> impl Iterator<Item = [f64; 2]> {
        let recent = &self.recent;
        let both = recent.forces.iter().zip(&recent.along);
        let known = both.filter(|_| self.halved);
        known.filter_map(|([sum, _], (squares, trend))| {
            let count = recent.steps as f64;
            let variance = (squares / count - (sum / count).powi(2)).max(0.0);
            Some([variance.sqrt(), trend.change()?])
        })
    }

    /// Mean force on each body (N); empty before the first step.
    pub fn forces(&self) -> impl Iterator<Item = [f64; 2]> {
        let steps = (self.recent.steps + self.before.steps) as f64;
        let recent = self.recent.forces.iter().enumerate();
        recent.map(move |(index, sum)| {
            let before = self.before.forces.get(index).copied().unwrap_or_default();
            [0, 1].map(|k| (sum[k] + before[k]) / steps)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps of one second whose force is the number of the step, counted from 0.
    fn mean_after(steps: u32, end: Option<f64>) -> Option<[f64; 2]> {
        let mut means = ForceMeans::default();
        for step in (0..steps).map(f64::from) {
            means.record(&[[step, -step]], step, end);
        }
        means.forces().next()
    }

    #[test]
    fn the_mean_covers_the_second_half_once_it_has_begun() {
        assert_eq!(mean_after(20, Some(20.0)), Some([14.5, -14.5]));
        assert_eq!(mean_after(11, Some(20.0)), Some([10.0, -10.0]));
    }

    /// Of twelve steps, the steps since the fourth, the power of two before the last one, are 4 to 11.
    #[test]
    fn without_an_end_the_mean_covers_the_later_steps() {
        assert_eq!(mean_after(12, None), Some([7.5, -7.5]));
        assert_eq!(mean_after(10, Some(40.0)), Some([6.5, -6.5]));
        assert_eq!(mean_after(1, None), Some([0.0, 0.0]));
        assert_eq!(mean_after(0, None), None);
    }

    /// 10 to 19 N in ten steps: a deviation of sqrt(8.25) N about a line that rises by 9 N.
    #[test]
    fn the_change_is_reported_next_to_the_scatter() {
        let mut means = ForceMeans::default();
        for step in (0..20).map(f64::from) {
            means.record(&[[step, -step]], step, Some(20.0));
        }
        let [deviation, change] = means.steadiness().next().expect("there is a force");
        assert!((deviation - 8.25f64.sqrt()).abs() < 1e-12 && (change - 9.0).abs() < 1e-12);
        assert_eq!(ForceMeans::default().steadiness().count(), 0);
    }
}
