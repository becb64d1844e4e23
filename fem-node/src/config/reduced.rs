//! A body as its lowest modes.

use std::borrow::Cow;

use kit::number::{number_or_word, number_or_word_schema};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Deserializer};

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

/// The distance as written.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum NearReach {
    /// The least one with stable windows.
    #[default]
    Auto,
    /// Given (m).
    Metres(f64),
}

impl JsonSchema for NearReach {
    fn schema_name() -> Cow<'static, str> {
        "NearReach".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        number_or_word_schema("auto")
    }
}

impl<'de> Deserialize<'de> for NearReach {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let reach = number_or_word(deserializer, "auto", "a length in metres or \"auto\"")?;
        Ok(reach.map_or(NearReach::Auto, NearReach::Metres))
    }
}
