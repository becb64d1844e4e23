//! The rigid wheel on the upper edge and the contact with it.

use kit::ConfigError;
use kit::table::LoadTable;
use kit::wheel::WheelProgram;
use protocol::Cause;
use schemars::JsonSchema;
use serde::Deserialize;

use super::number::{not_negative, positive};

/// A rigid wheel that is pressed on the upper edge and moved sideways.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FemWheelConfig {
    /// Vertical load (N).
    #[schemars(range(min = 0.0))]
    pub load_n: f64,
    /// Vertical load over time (s, N) instead of the linear ramp: linear between the entries, constant beyond them. At
    /// the end of the hold it must be `load_n`, which results and checks of the hold refer to.
    pub load_table: Option<LoadTable>,
    /// Mass (kg), which resists vertical motion; the sideways motion is prescribed.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub mass_kg: f64,
    /// Radius of the face (m); 0 = flat.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub radius_m: f64,
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

/// Contact of wheel and body: unilateral, with Coulomb friction, neither regularised.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactConfig {
    /// Coefficient of friction, at least 0.
    #[schemars(range(min = 0.0))]
    pub friction: f64,
    /// True where friction acts while the load is applied, before t_s; true when absent. Without it the hydrostatic
    /// pressure of the paper's rail is 784 MPa instead of 671.
    #[serde(default = "yes")]
    pub friction_while_loading: bool,
}

fn yes() -> bool {
    true
}

impl FemWheelConfig {
    /// Its load and its motion over time.
    pub(crate) fn program(&self) -> WheelProgram {
        kit::wheel_program!(self)
    }

    pub(super) fn check(&self) -> Result<(), ConfigError> {
        positive("wheel.mass_kg", self.mass_kg, "kg")?;
        for (key, value, unit) in [
            ("wheel.load_n", self.load_n, "N"),
            ("wheel.radius_m", self.radius_m, "m"),
            ("wheel.amplitude_m", self.amplitude_m, "m"),
            ("wheel.ramp_s", self.ramp_s, "s"),
            ("wheel.hold_s", self.hold_s, "s"),
            ("wheel.cycles", self.cycles, "periods"),
        ] {
            not_negative(key, value, unit)?;
        }
        if self.cycles > 0.0 {
            positive("wheel.frequency_hz", self.frequency_hz, "1/s")?;
        }
        self.program().check_table()
    }
}

impl ContactConfig {
    pub(super) fn check(&self) -> Result<(), ConfigError> {
        if self.friction >= 0.0 && self.friction.is_finite() {
            return Ok(());
        }
        let problem = format!("must be finite and not negative, got {:?}", self.friction);
        Err(ConfigError::new("contact.friction", problem)
            .because(Cause::OutOfRange)
            .help("write 0 for a smooth wheel"))
    }
}
