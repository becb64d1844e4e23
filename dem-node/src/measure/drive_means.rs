//! Mean forces of the grains on driven clusters.

use serde::{Deserialize, Serialize};

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
