//! The keys of `profile`: means over slices of the sample and intervals of time.

use kit::ConfigError;
use kit::keys::refuse_if;
use protocol::Cause;
use schemars::JsonSchema;
use serde::Deserialize;

/// Most slices of all intervals together, some 200 MB of CSV.
const SLICES_MAX: f64 = 1e6;

/// `profile`: the slices and intervals.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProfileConfig {
    /// Direction in which the slices are stacked.
    pub axis: ProfileAxis,
    /// Number of slices of equal thickness, from the lowest edge of the grains to the highest at the start of an interval.
    #[schemars(range(min = 1, max = 1000))]
    pub bins: u32,
    /// Start of the first interval (s).
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub start_s: f64,
    /// Length of an interval (s).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub every_s: f64,
}

/// The words for `profile.axis`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ProfileAxis {
    /// Sideways.
    X,
    /// Upwards.
    Y,
}

impl ProfileAxis {
    /// Index of the coordinate.
    pub fn index(self) -> usize {
        self as usize
    }
}

impl ProfileConfig {
    /// Refuses more slices by the end of the run (s) than a file should hold.
    pub(super) fn validate(&self, end: Option<f64>) -> Result<(), ConfigError> {
        let lasts = (end.unwrap_or(0.0) - self.start_s).max(0.0);
        let slices = f64::from(self.bins) * (lasts / self.every_s).ceil();
        refuse_if(
            slices > SLICES_MAX,
            "profile.every_s",
            format!("makes {slices:.1e} slices by the end of the run, more than {SLICES_MAX:.0e}"),
            "make it longer, or profile.bins fewer",
        )
        .map_err(|error| error.because(Cause::TooMany))
    }
}
