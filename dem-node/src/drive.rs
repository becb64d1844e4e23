//! Clusters that are moved or pushed along x and y: driven rough walls.
//!
//! A prescribed direction has a constant velocity whatever the contacts do. In a free one
//! m dv = h F + p - h c v_theta, p being the impulse of the contacts and the weight and c the damping, which is taken implicitly:
//! v' = ((m - h c (1 - theta)) v + h F + p) / (m + h c theta).

use kit::table::{LoadTable, load_at};
use serde::{Deserialize, Serialize};

/// Loads of a driven cluster.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drive {
    /// Name of the cluster.
    pub name: String,
    /// Force over time along x and y (s, N).
    pub forces: [LoadTable; 2],
    /// Force against the motion over its speed (N s/m).
    pub damping: f64,
}

/// The moment of a step at which loads are taken.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// Time (s).
    pub time: f64,
    /// Length of the step (s).
    pub step: f64,
    /// Weight of the end velocity.
    pub theta: f64,
}

impl Drive {
    /// Impulse of the loads along x and y in a step (N s), without the damping.
    pub fn push(&self, at: &Moment) -> [f64; 2] {
        [0, 1].map(|k| at.step * load_at(&self.forces[k], at.time))
    }

    /// h c, by which a velocity of 1 m/s loses momentum in a step (kg).
    pub fn drag(&self, at: &Moment) -> f64 {
        at.step * self.damping
    }
}

/// Mean forces of the grains on driven clusters over the second half of a run.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct DriveMeans {
    sums: Vec<[f64; 2]>,
    steps: u64,
}

impl DriveMeans {
    /// Adds the forces of a step (N) that began at `start` of a run that ends at `end` (s).
    pub fn record(&mut self, forces: &[[f64; 2]], start: f64, end: Option<f64>) {
        if forces.is_empty() || end.is_none_or(|end| start < 0.5 * end) {
            return;
        }
        self.sums.resize(forces.len(), [0.0; 2]);
        self.steps += 1;
        for (sum, force) in self.sums.iter_mut().zip(forces) {
            *sum = [sum[0] + force[0], sum[1] + force[1]];
        }
    }

    /// Mean force on each (N); none before the second half.
    pub fn forces(&self) -> impl Iterator<Item = [f64; 2]> {
        let steps = self.steps as f64;
        self.sums.iter().map(move |sum| sum.map(|s| s / steps))
    }
}
