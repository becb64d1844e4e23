//! Initial velocities of named sets of nodes.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

/// The name of all nodes of the body, unless its mesh has a set of that name.
pub(crate) const BODY: &str = "body";

/// Initial state of each named set, or of `body`, which means all nodes; a named set takes precedence over `body`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct InitialConfig(pub BTreeMap<String, InitialSetConfig>);

/// Initial state of one set.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InitialSetConfig {
    /// Components (vx, vy) of the velocity at t = 0 (m/s). Components that a support holds or a motion prescribes keep their own velocity.
    pub velocity_m_per_s: [f64; 2],
}
