//! A body as its lowest modes.

use schemars::JsonSchema;
use serde::Deserialize;

/// A linear body as its lowest modes and its static flexibility, for a surface that grains load. Give `modes` or `omega_max_per_s`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReducedConfig {
    /// Number of the lowest modes, or all modes of a body that has fewer.
    #[schemars(range(min = 1))]
    pub modes: Option<u32>,
    /// Largest natural frequency of the modes (1/s).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub omega_max_per_s: Option<f64>,
    /// Distance on the surface (m) within which forces move points in the same window; points further away follow one window later. The least distance
    /// with stable windows when `"auto"` or absent.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub near_m: NearReach,
}

kit::number_or_word! {
    /// The distance as written: given (m), or the least one with stable windows.
    NearReach, "auto", "a length in metres or \"auto\""
}
