//! Load increments of a static analysis.

use kit::ConfigError;
use kit::keys::refuse_if;
use kit::limits::ROUNDING;
use kit::rolling::Rolling;
use protocol::Cause;
use schemars::JsonSchema;
use serde::Deserialize;

/// Increments of a static analysis and of a static start. Coulomb friction depends on the history of the load, so the
/// load grows from zero in equal steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StaticsConfig {
    /// Largest load increment (N); a 200th of the load when absent.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub increment_n: Option<f64>,
    /// Increments in a cycle of the sideways motion, at least 4; 240 when absent, which resolve the half micrometre over which the contact of Renouf,
    /// Saulot and Berthier (2006) starts to slip.
    #[schemars(range(min = 4))]
    pub increments_per_cycle: Option<u32>,
    /// Distance that the wheel rolls in an increment (m), at most the distance of the nodes that it rolls over; this distance when absent.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub rolling_increment_m: Option<f64>,
}

/// Load increments by default. Under 8 000 N on the paper's rail the peak pressures stay within 0.05 % and the centroid pressures within 0.02 % from
/// 100 increments on; 5 are 1 % off.
pub const INCREMENTS: usize = 200;

/// Increments in a cycle of the sideways motion by default.
const PER_CYCLE: u32 = 240;

/// More increments than this are taken for a mistyped unit.
const INCREMENTS_MAX: f64 = 1e6;

impl StaticsConfig {
    /// Number of equal increments up to this load (N).
    pub fn load_increments(&self, load: f64) -> usize {
        match self.increment_n {
            // Rounding must not turn 8000 / 100 into 81.
            Some(increment) => (load / increment - 1e-9).ceil().max(1.0) as usize,
            None => INCREMENTS,
        }
    }

    /// Increments of this many cycles of the sideways motion.
    pub fn cycle_increments(&self, cycles: f64) -> f64 {
        (cycles * f64::from(self.per_cycle())).round()
    }

    /// Increments in a cycle of the sideways motion.
    pub fn per_cycle(&self) -> u32 {
        self.increments_per_cycle.unwrap_or(PER_CYCLE)
    }

    /// Increments of a wheel that rolls over nodes at this least distance (m).
    pub(crate) fn rolling_increments(
        &self,
        rolling: &Rolling,
        spacing: f64,
    ) -> Result<u64, ConfigError> {
        let key = "statics.rolling_increment_m";
        let increment = self.rolling_increment_m.unwrap_or(spacing);
        refuse_if(
            increment > (1.0 + ROUNDING) * spacing,
            key,
            format!(
                "{increment:e} m is more than the {spacing:e} m between the nodes that the wheel rolls over"
            ),
            "lower it, or leave it out",
        )?;
        let count = (rolling.distance / increment - ROUNDING).ceil().max(1.0);
        let too_many = || {
            let problem = format!(
                "{:e} m of rolling are {count:.1e} increments, more than {INCREMENTS_MAX:.0e}",
                rolling.distance
            );
            ConfigError::new("wheel.rolling.distance_m", problem).because(Cause::TooMany)
        };
        (count <= INCREMENTS_MAX)
            .then_some(count as u64)
            .ok_or_else(too_many)
    }

    /// Refuses a sideways motion of more increments than a user can wait for.
    pub(super) fn check_cycles(&self, cycles: f64) -> Result<(), ConfigError> {
        let increments = self.cycle_increments(cycles);
        if increments <= INCREMENTS_MAX {
            return Ok(());
        }
        let per_cycle = self.per_cycle();
        let key = if f64::from(per_cycle) > INCREMENTS_MAX / 100.0 {
            "statics.increments_per_cycle"
        } else {
            "wheel.cycles"
        };
        let problem = format!(
            "{cycles:?} cycles of {per_cycle} increments are {increments:.1e}, more than {INCREMENTS_MAX:.0e}"
        );
        Err(ConfigError::new(key, problem)
            .because(Cause::TooMany)
            .help("two cycles of 240 increments reach the steady loop"))
    }

    pub(super) fn check(&self, load: f64) -> Result<(), ConfigError> {
        let too_small = |increment| load / increment > INCREMENTS_MAX;
        if self.increment_n.is_some_and(too_small) {
            let problem =
                format!("would take more than {INCREMENTS_MAX:.0e} increments to {load:?} N");
            return Err(ConfigError::new("statics.increment_n", problem)
                .because(Cause::TooMany)
                .help("check the unit (N), or leave it out for a 200th of the load"));
        }
        Ok(())
    }
}
