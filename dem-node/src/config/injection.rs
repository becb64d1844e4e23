//! The keys of `injection`: grains that are fed into the scene from outside.

use kit::ConfigError;
use kit::keys::refuse_if;
use protocol::Cause;
use schemars::JsonSchema;
use serde::Deserialize;

use super::flow::FlowConfig;
use super::law::LawConfig;

/// Most grains of a feed.
const MOST: f64 = 1e6;

/// `injection`: the source flow Qe of the tribological circuit. Grains of the sample's radii are fed in at a point, one after the other.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InjectionConfig {
    /// Position of the feed along x (m): each grain begins in the widest gap around this point.
    pub x_m: f64,
    /// Height of the feed (m).
    pub y_m: f64,
    /// Unscaled mass that is fed in per second (kg/s).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub rate_kg_per_s: f64,
    /// Start of the feed (s).
    #[schemars(range(min = 0.0))]
    pub start_s: f64,
    /// End of the feed (s), after its start.
    pub end_s: f64,
    /// Time in which a grain grows to its size (s); when absent, the time in which a mean grain is fed in, so that grains grow one by one.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub growth_s: Option<f64>,
}

impl InjectionConfig {
    /// Refuses an end before the start, and scenes in which no grain can grow.
    pub(super) fn validate(
        &self,
        law: &LawConfig,
        flow: Option<&FlowConfig>,
        gravity: [f64; 2],
    ) -> Result<(), ConfigError> {
        refuse_if(
            self.end_s <= self.start_s,
            "injection.end_s",
            format!(
                "must come after injection.start_s = {:e}, got {:e} (s)",
                self.start_s, self.end_s
            ),
            "remove the table for a scene that nothing is fed into",
        )?;
        refuse_if(
            flow.is_none(),
            "injection",
            "is one of the flows of third body, and these are not measured",
            "add [participant.config.flow], or remove the table",
        )?;
        refuse_if(
            law.contact_stiffness_pa.is_none(),
            "injection",
            "lets grains grow, which push by the springs of their contacts, and law.contact_stiffness_pa is missing",
            "give it, or remove the table",
        )?;
        refuse_if(
            gravity != [0.0; 2],
            "injection",
            "keeps grains in store, which nothing would hold against gravity_m_per_s2",
            "remove one of them",
        )
    }

    /// Refuses a feed of too many grains, of this mean mass (kg).
    pub(super) fn refuse_too_many(&self, mass: f64) -> Result<(), ConfigError> {
        let grains = self.rate_kg_per_s * (self.end_s - self.start_s) / mass;
        refuse_if(
            grains > MOST,
            "injection.rate_kg_per_s",
            format!(
                "feeds in {grains:.1e} grains until injection.end_s, more than the limit of {MOST:e}"
            ),
            "lower it, or let end_s be the end of the run",
        )
        .map_err(|error| error.because(Cause::TooMany))
    }
}
