//! Time and memory of a run, with the prediction from its first windows.

use serde::Serialize;

use crate::cost::prediction::{CostPrediction, Pace};
use scheme::ledger::ratio;

/// Parts of the wall-clock time of a run, and the error of its prediction.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Spent {
    /// Until the first window begins (s).
    setup_wall_s: f64,
    /// All windows (s).
    windows_wall_s: f64,
    /// Time from the end of the last window on (s).
    closing_wall_s: f64,
    /// Absent for a run that ended before a prediction.
    #[serde(skip_serializing_if = "Option::is_none")]
    prediction: Option<Outcome>,
    /// The prediction, also for a dry run.
    #[serde(skip)]
    pub told: Option<CostPrediction>,
    #[serde(skip)]
    memory_bytes: f64,
}

/// A prediction with its ratios to the actual values.
#[derive(Clone, Copy, Debug, Serialize)]
struct Outcome {
    #[serde(flatten)]
    prediction: CostPrediction,
    wall_over_actual: f64,
    memory_over_actual: f64,
}

impl Spent {
    /// The cost of a run whose windows are over.
    pub fn of(pace: &Pace) -> Option<Spent> {
        let [start, end] = pace.stretch_ns()?;
        Some(Spent {
            setup_wall_s: pace.setup_wall_s()?,
            windows_wall_s: 1e-9 * (end - start) as f64,
            closing_wall_s: 0.0,
            prediction: None,
            told: pace.prediction,
            memory_bytes: pace.memory_bytes as f64,
        })
    }

    /// Compares the prediction with the whole run of this number of windows.
    pub fn end(&mut self, wall_s: f64, windows: u64) {
        self.closing_wall_s = wall_s - self.setup_wall_s - self.windows_wall_s;
        let early = self.told.filter(|early| early.windows < windows);
        self.prediction = early.map(|prediction| Outcome {
            prediction,
            wall_over_actual: ratio(prediction.wall_s, wall_s),
            memory_over_actual: ratio(prediction.memory_bytes as f64, self.memory_bytes),
        });
    }
}
