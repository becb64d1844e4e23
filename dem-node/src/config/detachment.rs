//! The keys of `detachment`: steel that comes off bare surfaces as grains.

use kit::ConfigError;
use kit::keys::refuse_if;
use schemars::JsonSchema;
use serde::Deserialize;

use super::injection::InjectionConfig;
use super::law::LawConfig;
use super::sample::SampleConfig;

/// `detachment`: a segment of a bare surface loses a layer, which becomes grains, each time that friction has done enough work on it.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DetachmentConfig {
    /// Work of friction over the area of a segment after which a layer comes off (J/m2).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub energy_j_per_m2: f64,
    /// Depth of a layer (m), at most a third of the shortest segment.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub depth_m: f64,
    /// Time in which a grain grows to its size (s); a hundred inertial times t_i when absent.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub growth_s: Option<f64>,
}

impl DetachmentConfig {
    /// Refuses scenes without bare surfaces, and scenes in which no grain can grow.
    pub(super) fn validate(
        &self,
        law: &LawConfig,
        sample: &SampleConfig,
        injection: Option<&InjectionConfig>,
        gravity: [f64; 2],
    ) -> Result<(), ConfigError> {
        let refusals = [
            (
                injection.is_some(),
                "feeds the grains in store, and so does injection",
            ),
            (
                sample.surface().is_none(),
                "is for bare surfaces, and the sample has none",
            ),
            (
                law.contact_stiffness_pa.is_none(),
                "lets grains grow, which push by the springs of their contacts, and law.contact_stiffness_pa is missing",
            ),
            (
                gravity != [0.0; 2],
                "keeps grains in store, which nothing would hold against gravity_m_per_s2",
            ),
        ];
        let help = "remove the table, or the key that contradicts it";
        let mut refusals = refusals.into_iter();
        refusals.try_for_each(|(refused, why)| refuse_if(refused, "detachment", why, help))
    }
}
