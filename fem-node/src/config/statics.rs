//! How a static analysis follows its loads.

use protocol::ConfigError;
use serde::Deserialize;

use super::{optional, positive};

/// Increments of a static analysis and of a static start. Coulomb friction depends on the history of the load, so the
/// load grows from zero in equal steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StaticsConfig {
    /// Largest load increment (N); a 200th of the load when absent.
    pub increment_n: Option<f64>,
    /// Increments in a cycle of the sideways motion, at least 4; 240 when absent, which resolves the half micrometre
    /// in which the paper's contact starts to slip.
    pub increments_per_cycle: Option<u32>,
}

/// More increments than this are taken for a mistyped unit.
const INCREMENTS_MAX: f64 = 1e6;

impl StaticsConfig {
    /// Equal increments that bring this load (N).
    pub fn load_increments(&self, load: f64) -> usize {
        match self.increment_n {
            // Rounding must not turn 8000 / 100 into 81.
            Some(increment) => (load / increment - 1e-9).ceil().max(1.0) as usize,
            None => crate::statics::INCREMENTS,
        }
    }

    pub(super) fn check(&self, load: f64) -> Result<(), ConfigError> {
        optional(self.increment_n, |increment| {
            positive("statics.increment_n", increment, "N")
        })?;
        if self
            .increment_n
            .is_some_and(|increment| load / increment > INCREMENTS_MAX)
        {
            let problem =
                format!("would take more than {INCREMENTS_MAX:.0e} increments to {load:?} N");
            return Err(ConfigError::new("statics.increment_n", problem)
                .help("check the unit (N), or leave it out for a 200th of the load"));
        }
        match self.increments_per_cycle {
            Some(count) if count < 4 => Err(ConfigError::new(
                "statics.increments_per_cycle",
                format!("must be at least 4, got {count}"),
            )
            .help("fewer would miss the reversals; 240 resolve the stick-slip transition")),
            _ => Ok(()),
        }
    }
}
