//! The keys of `wheel` and their limits.

use kit::ConfigError;
use kit::table::LoadTable;
use kit::wheel::WheelProgram;
use schemars::JsonSchema;
use serde::Deserialize;

use super::law::{LawConfig, LawKind};
use super::limits::{at_least, finite, positive};
use super::sample::SampleConfig;
use kit::keys::refuse_if;

/// A rigid wheel that is pressed on the grains and moved sideways. It does not turn.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DemWheelConfig {
    /// Vertical load (N).
    #[schemars(range(min = 0.0))]
    pub load_n: f64,
    /// Vertical load over time (s, N) instead of the linear ramp: linear between the entries, constant beyond them. At the end
    /// of the hold it must be `load_n`, which results and checks of the hold refer to.
    pub load_table: Option<LoadTable>,
    /// Mass (kg), never scaled.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub mass_kg: f64,
    /// Radius of the face (m), its lowest point over x = 0 at the start; 0 = flat.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub radius_m: f64,
    /// Smooth, or a row of disks.
    #[serde(default)]
    pub face: FaceKind,
    /// True if the disks of the face are bonded to the grains that they are near, as the grains are to each other.
    #[serde(default)]
    pub bonded: bool,
    /// Vertical velocity at the start, where it touches the grains (m/s): negative for a wheel that is dropped on them.
    #[serde(default)]
    pub vy_m_per_s: f64,
    /// Amplitude A of the sideways motion D(t) = A sin(2 pi f (t - t_s)) (m).
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub amplitude_m: f64,
    /// Frequency f of the sideways motion (1/s).
    #[serde(default)]
    pub frequency_hz: f64,
    /// Time in which the load grows linearly from 0 (s).
    #[schemars(range(min = 0.0))]
    pub ramp_s: f64,
    /// Time under the full load before the motion starts at t_s = ramp + hold (s).
    #[schemars(range(min = 0.0))]
    pub hold_s: f64,
    /// Periods of the sideways motion, not necessarily whole.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub cycles: f64,
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
    /// Its load and its motion over time.
    pub fn program(&self) -> WheelProgram {
        kit::wheel_program!(self)
    }

    pub(super) fn validate(&self) -> Result<(), ConfigError> {
        positive("wheel.mass_kg", self.mass_kg, "kg")?;
        at_least("wheel.load_n", self.load_n, 0.0, "N")?;
        at_least("wheel.ramp_s", self.ramp_s, 0.0, "s")?;
        at_least("wheel.hold_s", self.hold_s, 0.0, "s")?;
        at_least("wheel.amplitude_m", self.amplitude_m, 0.0, "m")?;
        at_least("wheel.cycles", self.cycles, 0.0, "")?;
        at_least("wheel.radius_m", self.radius_m, 0.0, "m")?;
        finite("wheel.vy_m_per_s", self.vy_m_per_s)?;
        if self.cycles > 0.0 {
            positive("wheel.frequency_hz", self.frequency_hz, "1/s")?;
        }
        self.program().check_table()
    }

    /// Refuses a rough face that the sample has no disks for, and bonds that nothing could carry.
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
