//! A body as its lowest modes.

use std::borrow::Cow;

use kit::ConfigError;
use kit::keys::refuse_if;
use kit::number::{number_or_word, number_or_word_schema};
use protocol::Cause;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Deserializer};

use super::boundary::SetConfig;
use super::choice::{Analysis, Base, Kinematics};
use super::keys::FemConfig;
use super::material::MaterialKind;

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
    #[schemars(range(min = 0.0))]
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

impl FemConfig {
    /// Refuses a reduced body that is not a supported linear one in motion, loaded by forces only.
    pub(super) fn check_reduced(&self) -> Result<(), ConfigError> {
        let Some(reduced) = &self.reduced else {
            return Ok(());
        };
        let help = "give modes = 50, or omega_max_per_s";
        let count =
            usize::from(reduced.modes.is_some()) + usize::from(reduced.omega_max_per_s.is_some());
        refuse_if(count > 1, "reduced", "has two numbers of modes", help)?;
        let missing = |error: ConfigError| error.because(Cause::MissingKey);
        refuse_if(count == 0, "reduced", "has no number of modes", help).map_err(missing)?;
        let is_plastic = self.material.law() == MaterialKind::J2;
        let is_damped = self.time.stiffness_damping_s.is_some_and(|time| time > 0.0);
        let refused = [
            (
                self.analysis == Analysis::Static,
                "analysis",
                "needs no modes",
            ),
            (
                self.wheel.is_some(),
                "wheel",
                "touches nodes that change from step to step",
            ),
            (
                is_plastic,
                "material.yield_pa",
                "has no modes once it flows",
            ),
            (
                self.kinematics == Kinematics::Corotational,
                "kinematics",
                "has no modes where it turns",
            ),
            (
                self.base == Base::Free,
                "base",
                "moves as a whole, which is no mode",
            ),
            (
                is_damped,
                "time.stiffness_damping_s",
                "is not carried by the modes",
            ),
        ];
        for (holds, key, why) in refused {
            let why = format!("does not go with `reduced`: such a body {why}");
            refuse_if(holds, key, why, "remove `reduced`, or change the key")?;
        }
        if let Some(set) = self.initial.0.keys().next() {
            let why = "does not go with `reduced`, whose bodies start at rest";
            refuse_if(
                true,
                &format!("initial.{set}"),
                why,
                "remove `reduced` or the velocity",
            )?;
        }
        let mut sets = self.boundary.0.iter();
        let is_moved = |set: &SetConfig| set.prescribed().is_some();
        sets.try_for_each(|(name, set)| {
            let why = "moves nodes, but the modes of `reduced` belong to nodes that forces move";
            let help = "remove `reduced`, or give the set a load";
            refuse_if(is_moved(set), &format!("boundary.{name}"), why, help)
        })
    }
}
