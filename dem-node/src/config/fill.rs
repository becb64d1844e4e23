//! The keys of `sample.fill` and `sample.rows`: disks by the rectangle and by the row.

use kit::ConfigError;
use kit::keys::refuse_if;
use kit::limits::{ROUNDING, validate_sides};
use protocol::Cause;
use schemars::JsonSchema;
use serde::Deserialize;

use super::radii::{Radii, RadiusLaw};

/// More disks than this are taken for a mistyped unit.
const DISKS_MAX: f64 = 5e5;

/// A rectangle of loose disks: one in the middle of each square of a grid that the widest disk just fits.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FillConfig {
    /// Left and right side (m).
    pub x_m: [f64; 2],
    /// Lower and upper side (m).
    pub y_m: [f64; 2],
    /// Smallest radius (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius_min_m: f64,
    /// Largest radius (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius_max_m: f64,
    /// Distribution of the radii.
    pub law: RadiusLaw,
    /// Exponent k of law = "power", p ~ r^k; required there, refused with other laws.
    #[schemars(range(min = -20.0, max = 20.0))]
    pub power: Option<f64>,
    /// Largest component of the disks' random velocities at the start (m/s), along x and along y.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub speed_m_per_s: f64,
    /// Seed of the radii and speeds; the run's seed when absent.
    pub seed: Option<u64>,
}

/// A row of disks at equal distances, as many as touching disks of the radius (radius_min_m + radius_max_m)/2: under a law whose mean radius is
/// smaller there are gaps between them.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RowConfig {
    /// Name of the rigid cluster that the disks belong to.
    pub cluster: String,
    /// Ends of the row (m).
    pub x_m: [f64; 2],
    /// Height of the centres (m).
    pub y_m: f64,
    /// Smallest radius (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius_min_m: f64,
    /// Largest radius (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius_max_m: f64,
    /// Distribution of the radii.
    pub law: RadiusLaw,
    /// Exponent k of law = "power", p ~ r^k; required there, refused with other laws.
    #[schemars(range(min = -20.0, max = 20.0))]
    pub power: Option<f64>,
    /// Seed of the radii; the run's seed when absent.
    pub seed: Option<u64>,
}

impl FillConfig {
    /// The radii.
    pub fn radii(&self) -> Radii {
        Radii::new(self.law, self.power, self.radius_min_m, self.radius_max_m)
    }

    /// Columns and rows of the grid.
    pub fn grid(&self) -> [f64; 2] {
        let [width, height] = [self.x_m, self.y_m].map(|[low, high]| high - low);
        let side = 2.0 * self.radius_max_m;
        // A rectangle made for a whole number of disks must not lose one to rounding.
        [width, height].map(|length| (length / side * (1.0 + ROUNDING)).floor())
    }

    pub(super) fn validate(&self, key: &str) -> Result<(), ConfigError> {
        validate_sides(&format!("{key}.x_m"), self.x_m)?;
        validate_sides(&format!("{key}.y_m"), self.y_m)?;
        self.radii().validate(key)?;
        let [columns, rows] = self.grid();
        validate_count(key, columns * rows)
    }
}

impl RowConfig {
    /// The radii.
    pub fn radii(&self) -> Radii {
        Radii::new(self.law, self.power, self.radius_min_m, self.radius_max_m)
    }

    /// Number of its disks.
    pub fn count(&self) -> f64 {
        let pitch = self.radius_min_m + self.radius_max_m;
        ((self.x_m[1] - self.x_m[0]) / pitch).round().max(1.0)
    }

    pub(super) fn validate(&self, key: &str) -> Result<(), ConfigError> {
        validate_sides(&format!("{key}.x_m"), self.x_m)?;
        self.radii().validate(key)?;
        validate_count(key, self.count())
    }
}

fn validate_count(key: &str, count: f64) -> Result<(), ConfigError> {
    refuse_if(
        count < 1.0,
        key,
        "has no room for a disk of radius_max_m",
        "give it larger sides, or smaller disks",
    )?;
    refuse_if(
        count > DISKS_MAX,
        key,
        format!("holds {count:.1e} disks, more than {DISKS_MAX:.0e}"),
        "check the units (m): smaller sides, or larger disks",
    )
    .map_err(|error| error.because(Cause::TooMany))
}
