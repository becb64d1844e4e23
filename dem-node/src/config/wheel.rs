//! The keys of `wheel` and their limits.

use kit::ConfigError;
use kit::keys::refuse_if;
use schemars::JsonSchema;
use serde::Deserialize;

use super::law::{LawConfig, LawKind};
use super::sample::SampleConfig;

kit::wheel_keys! {
    /// A rigid wheel that is pressed on the grains and moved sideways. It does not turn.
    DemWheelConfig {
        /// Face of the wheel: smooth, or a row of disks.
        #[serde(default)]
        pub face: FaceKind,
        /// True if the disks of the face are bonded to grains nearer than `law.alert_m`, as the grains are to each other.
        #[serde(default)]
        pub bonded: bool,
        /// Vertical velocity at the start (m/s), when the wheel touches the grains; negative downwards.
        #[serde(default)]
        pub vy_m_per_s: f64,
    }
}

/// The words for `wheel.face`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FaceKind {
    /// Smooth: flat, or round where `wheel.radius_m` is given.
    #[default]
    Flat,
    /// A row of touching disks of the sample's radii, as wide as the sample (Renouf, Saulot and Berthier 2006, section 6).
    Disks,
}

impl DemWheelConfig {
    /// Refuses a rough face without a law of radii in the sample, and bonds that no disk can have.
    pub(super) fn validate_on(
        &self,
        sample: &SampleConfig,
        law: &LawConfig,
    ) -> Result<(), ConfigError> {
        let rough = self.face == FaceKind::Disks;
        refuse_if(
            rough && sample.wheel_row().is_none(),
            "wheel.face",
            "\"disks\" takes the radii of the sample, and listed disks have no law of radii",
            "write face = \"flat\", or choose another sample.kind",
        )?;
        refuse_if(
            rough && sample.period_ends().is_some(),
            "wheel.face",
            "a row of disks ends beside the sample, and sample.periodic_x_m repeats it",
            "write face = \"flat\"",
        )?;
        refuse_if(
            rough && self.radius_m > 0.0,
            "wheel.radius_m",
            format!(
                "face = \"disks\" lies on a line, got a radius of {} m",
                self.radius_m
            ),
            "write radius_m = 0, or face = \"flat\"",
        )?;
        refuse_if(
            self.bonded && !(rough && law.kind.plain() == LawKind::Cohesion),
            "wheel.bonded",
            "bonds join disks under a law of cohesion",
            "write bonded = false, or face = \"disks\" and law.kind = \"cohesion\"",
        )
    }
}
