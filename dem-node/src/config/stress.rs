//! The keys of `stress`: stress in cells and in the whole sample.

use kit::ConfigError;
use kit::keys::refuse_if;
use kit::limits::{ROUNDING, at_least, validate_sides};
use protocol::Cause;
use schemars::JsonSchema;
use serde::Deserialize;

/// Least side of a cell in mean diameters of the grains: a smaller cell holds a few contacts, not a stress.
const CELL_DIAMETERS: f64 = 3.5;
/// Most cells, some 100 MB of CSV.
const CELLS_MAX: f64 = 1e6;

/// `stress`: the cells, and their region.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StressConfig {
    /// Side of the square cells (m), at least 3.5 mean diameters.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub cell_m: f64,
    /// Left and right side of the region (m); when absent, the sides of the grains that carry contact forces, or of the strip that repeats.
    pub x_m: Option<[f64; 2]>,
    /// Lower and upper side of the region (m); the sides of the grains that carry contact forces when absent.
    pub y_m: Option<[f64; 2]>,
    /// Moment of the stress (s), for scenes without a wheel that is held; when absent, the end of the wheel's hold, or else of the run.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub at_s: Option<f64>,
}

impl StressConfig {
    /// Numbers of columns and rows of whole cells that fit between these sides (m).
    pub fn grid(&self, sides: [[f64; 2]; 2]) -> [f64; 2] {
        sides.map(|[low, high]| ((high - low) / self.cell_m * (1.0 + ROUNDING)).floor())
    }

    /// Refuses cells that hold no stress; `mean` is the mean diameter of the grains (m), `held` is true where a wheel has a hold.
    pub(super) fn validate(&self, mean: f64, held: bool) -> Result<(), ConfigError> {
        refuse_if(
            held && self.at_s.is_some(),
            "stress.at_s",
            "contradicts wheel.hold_s, at whose end the stress is taken",
            "remove one of them",
        )?;
        at_least("stress.cell_m", self.cell_m, CELL_DIAMETERS * mean, "m").map_err(|error| {
            error.help(format!(
                "a cell narrower than {CELL_DIAMETERS} mean diameters of the grains shows single contacts, no stress"
            ))
        })?;
        for (key, sides) in [("stress.x_m", self.x_m), ("stress.y_m", self.y_m)] {
            let Some(sides) = sides else {
                continue;
            };
            validate_sides(key, sides)?;
            refuse_if(
                self.grid([sides; 2])[0] < 1.0,
                key,
                format!(
                    "no cell of {:e} m fits between {:e} m and {:e} m",
                    self.cell_m, sides[0], sides[1]
                ),
                "widen the region, or lower stress.cell_m",
            )?;
        }
        match (self.x_m, self.y_m) {
            (Some(x), Some(y)) => self.refuse_misfit("stress.cell_m", [x, y]),
            _ => Ok(()),
        }
    }

    /// Refuses a region between these sides (m) that holds no whole cell, or too many.
    pub fn refuse_misfit(&self, key: &str, sides: [[f64; 2]; 2]) -> Result<(), ConfigError> {
        let [columns, rows] = self.grid(sides);
        let [width, height] = sides.map(|[low, high]| high - low);
        refuse_if(
            columns < 1.0 || rows < 1.0,
            key,
            format!(
                "no cell of {:e} m fits into a region of {width:e} m x {height:e} m",
                self.cell_m
            ),
            "widen the region, or remove the table: grains in so thin a layer have no stress in cells",
        )?;
        refuse_if(
            columns * rows > CELLS_MAX,
            "stress.cell_m",
            format!(
                "makes {:.1e} cells of a region of {width:e} m x {height:e} m, more than {CELLS_MAX:.0e}",
                columns * rows
            ),
            "check the units (m): larger cells, or a smaller region",
        )
        .map_err(|error| error.because(Cause::TooMany))
    }
}
