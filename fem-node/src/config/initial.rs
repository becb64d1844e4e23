//! Initial velocities of named sets of nodes.

use std::collections::BTreeMap;

use kit::ConfigError;
use schemars::JsonSchema;
use serde::Deserialize;

use super::motion::check_finite;

/// The name of all nodes of the body, unless its mesh has a set of that name.
pub(crate) const BODY: &str = "body";

/// Initial state of each named set, or of `body`, which means all nodes; a set comes before `body`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct InitialConfig(pub BTreeMap<String, InitialSetConfig>);

/// Initial state of one set.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InitialSetConfig {
    /// Components (vx, vy) of the velocity at t = 0 (m/s). Components that a support holds or a motion prescribes keep
    /// theirs.
    pub velocity_m_per_s: [f64; 2],
}

impl InitialConfig {
    pub(super) fn check(&self) -> Result<(), ConfigError> {
        self.0.iter().try_for_each(|(name, set)| {
            let key = format!("initial.{name}.velocity_m_per_s");
            check_finite(&key, set.velocity_m_per_s)
        })
    }
}
