//! The keys of `flow`: the flows of third body through the contact of a wheel, a lid or a strip that repeats.

use kit::ConfigError;
use kit::keys::refuse_if;
use kit::limits::{at_least, refuse_given};
use schemars::JsonSchema;
use serde::Deserialize;

use super::law::{LawConfig, LawKind};
use super::sample::SampleConfig;
use super::wheel::DemWheelConfig;

/// `flow`: the contact zone, and the time after which a grain that left it is worn. Below a lid the zone is the lid, in a strip that repeats it is
/// the strip: `wear_s` and `lateral` are the only keys there.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FlowConfig {
    /// Part of the wheel's normal force that the contact zone carries; half of the rest is dropped at either end, so that a few grains that touch far
    /// outside do not widen the zone.
    #[serde(default = "zone_share")]
    #[schemars(range(min = 0.5, max = 1.0))]
    pub zone_share: f64,
    /// Width added to the zone at either end, in mean diameters: grains this near are still dragged along.
    #[serde(default = "margin")]
    #[schemars(range(min = 0.0))]
    pub margin_diameters: f64,
    /// Distance by which an end of the zone must be off before it moves, in mean diameters: loads that pass from grain to grain make no flow.
    #[serde(default = "hysteresis")]
    #[schemars(range(min = 0.0))]
    pub hysteresis_diameters: f64,
    /// Time over which the wheel's force is averaged for the zone (s); `wear_s` when absent, 0 for the force of each step.
    #[schemars(range(min = 0.0))]
    pub zone_mean_s: Option<f64>,
    /// Time T_w that a grain must stay outside of the zone to count as worn (s): at least a cycle of the wheel, which may carry it back.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub wear_s: f64,
    /// Third body that leaves the zone sideways, out of the plane; none does when absent.
    pub lateral: Option<LateralConfig>,
}

/// `flow.lateral`: third body leaves the zone at the rate M / `time_s`, M being its mass in the zone; the run's seed draws the grains.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LateralConfig {
    /// Mean time that a grain stays in the zone before it leaves it sideways (s).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub time_s: f64,
}

fn zone_share() -> f64 {
    0.99
}

fn margin() -> f64 {
    5.0
}

fn hysteresis() -> f64 {
    1.0
}

impl FlowConfig {
    /// Time over which the wheel's force is averaged for the zone (s).
    pub fn mean_s(&self) -> f64 {
        self.zone_mean_s.unwrap_or(self.wear_s)
    }

    /// Refuses scenes without first bodies or contact zone.
    pub(super) fn validate(
        &self,
        law: &LawConfig,
        sample: &SampleConfig,
        wheel: Option<&DemWheelConfig>,
        gravity: [f64; 2],
    ) -> Result<(), ConfigError> {
        refuse_if(
            self.lateral.is_some() && (gravity != [0.0; 2] || sample.has_clusters()),
            "flow.lateral",
            "takes single grains out of the plane: nothing would hold them there against gravity_m_per_s2, and a rigid cluster goes as a whole",
            "remove the table, or gravity_m_per_s2 and sample.disks.cluster",
        )?;
        refuse_if(
            law.kind.plain() != LawKind::Cohesion,
            "flow",
            "knows the grains of the first bodies by their bonds, and this law has no bonds",
            "write law.kind = \"cohesion\", or remove the table",
        )?;
        let strip = sample.period().is_some();
        refuse_if(
            wheel.is_none() && !sample.has_lid() && !strip,
            "flow",
            "needs a wheel, a lid or a strip that repeats, and the scene has no such thing",
            "add [participant.config.wheel], sample.lid or sample.periodic_x_m, or remove the table",
        )?;
        let Some(wheel) = wheel.filter(|_| !strip) else {
            let given = [
                ("flow.zone_share", self.zone_share != zone_share()),
                ("flow.margin_diameters", self.margin_diameters != margin()),
                (
                    "flow.hysteresis_diameters",
                    self.hysteresis_diameters != hysteresis(),
                ),
                ("flow.zone_mean_s", self.zone_mean_s.is_some()),
            ];
            let what = "finds the zone below a wheel; here the zone is the whole lid or strip";
            return refuse_given(given, what, "remove the key");
        };
        let moves = wheel.cycles > 0.0;
        let cycle = if moves { 1.0 / wheel.frequency_hz } else { 0.0 };
        let help = "the wheel may carry a grain back within a cycle, 1 / wheel.frequency_hz";
        at_least("flow.wear_s", self.wear_s, cycle, "s").map_err(|error| error.help(help))
    }
}
