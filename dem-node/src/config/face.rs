//! The keys of the wheel's face and their limits.

use protocol::ConfigError;
use serde::Deserialize;

use super::law::{LawConfig, LawKind};
use super::limits::refuse_if;
use super::{SampleConfig, WheelConfig};

/// The words for `wheel.face`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaceKind {
    /// Smooth: flat, or round where `wheel.radius_m` is given.
    #[default]
    Flat,
    /// A row of touching disks of the sample's radii, as wide as the sample (Renouf, Saulot and Berthier 2006, section 6).
    Disks,
}

/// Refuses a rough face that the sample has no disks for, and bonds that nothing could carry.
pub(super) fn validate_face(
    wheel: &WheelConfig,
    sample: &SampleConfig,
    law: &LawConfig,
) -> Result<(), ConfigError> {
    let rough = wheel.face == FaceKind::Disks;
    refuse_if(
        rough && sample.row().is_none(),
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
        rough && wheel.radius_m > 0.0,
        "wheel.radius_m",
        format!(
            "face = \"disks\" lies on a line, got a radius of {} m",
            wheel.radius_m
        ),
        "write radius_m = 0, or face = \"flat\"",
    )?;
    refuse_if(
        wheel.bonded && !(rough && law.kind.plain() == LawKind::Cohesion),
        "wheel.bonded",
        "bonds join disks under a law of cohesion",
        "write bonded = false, or face = \"disks\" and law.kind = \"cohesion\"",
    )
}
