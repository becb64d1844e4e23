//! The keys of `detachment`: steel that comes off bare surfaces as grains.

use kit::ConfigError;
use kit::keys::refuse_if;
use schemars::JsonSchema;
use serde::Deserialize;

use super::injection::InjectionConfig;
use super::law::LawConfig;
use super::sample::SampleConfig;

/// `detachment`: where friction on a segment of a bare surface has done so much work, so deep a layer of it goes, and comes as grains.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DetachmentConfig {
    /// Work of friction over the area of a segment after which it gives a layer (J/m2).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub energy_j_per_m2: f64,
    /// Depth of a layer (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub depth_m: f64,
    /// Time in which a grain grows to its size (s); a hundred inertial times when absent.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub growth_s: Option<f64>,
}

impl DetachmentConfig {
    /// Refuses scenes without bare surfaces or into which nothing can grow.
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
                "and injection both feed the grains in store",
            ),
            (
                sample.surface().is_none(),
                "is of bare surfaces, and the sample has none",
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
        let help = "remove the table, or what it does not go with";
        let mut refusals = refusals.into_iter();
        refusals.try_for_each(|(refused, why)| refuse_if(refused, "detachment", why, help))
    }
}
