//! The rigid wheel on the upper edge and the contact with it.

use protocol::ConfigError;
use serde::Deserialize;

use super::{Analysis, Config, Start, not_negative, optional, positive};

/// A rigid wheel that is pressed on the upper edge and moved sideways.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WheelConfig {
    /// Vertical load (N).
    pub load_n: f64,
    /// Mass (kg), which resists vertical motion; the sideways motion is prescribed.
    pub mass_kg: f64,
    /// Radius of the face (m); 0 = flat.
    #[serde(default)]
    pub radius_m: f64,
    /// Amplitude A of the sideways motion D(t) = A sin(2 pi f (t - t_s)) (m).
    #[serde(default)]
    pub amplitude_m: f64,
    /// Frequency f of the sideways motion (1/s).
    #[serde(default)]
    pub frequency_hz: f64,
    /// Time in which the load grows linearly from 0 (s).
    pub ramp_s: f64,
    /// Time under the full load before the motion starts at t_s = ramp + hold (s).
    pub hold_s: f64,
    /// Periods of the sideways motion, not necessarily whole.
    #[serde(default)]
    pub cycles: f64,
}

/// What happens where wheel and body touch: unilateral contact with Coulomb friction, neither regularised.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactConfig {
    /// Coefficient of friction, at least 0.
    pub friction: f64,
    /// Whether friction acts while the load is applied, before t_s; it does when absent. Without it the hydrostatic
    /// pressure of the paper's rail is 784 MPa instead of 671.
    #[serde(default = "yes")]
    pub friction_while_loading: bool,
}

fn yes() -> bool {
    true
}

impl WheelConfig {
    fn check(&self) -> Result<(), ConfigError> {
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
        match self.cycles > 0.0 {
            true => positive("wheel.frequency_hz", self.frequency_hz, "1/s"),
            false => Ok(()),
        }
    }
}

impl ContactConfig {
    fn check(&self) -> Result<(), ConfigError> {
        if self.friction >= 0.0 && self.friction.is_finite() {
            return Ok(());
        }
        let problem = format!("must be finite and not negative, got {:?}", self.friction);
        Err(ConfigError::new("contact.friction", problem).help("write 0 for a smooth wheel"))
    }
}

/// Wheel, contact and the keys that make sense only with them.
pub(super) fn check(config: &Config) -> Result<(), ConfigError> {
    optional(config.time.start_mass_damping_per_s, |rate| {
        not_negative("time.start_mass_damping_per_s", rate, "1/s")
    })?;
    match (&config.wheel, &config.contact) {
        (None, None) => check_without(config),
        (Some(_), None) => Err(missing(
            "contact",
            "the wheel needs a coefficient of friction",
            "add contact = { friction = 0.3 }, or 0 for a smooth wheel",
        )),
        (None, Some(_)) => Err(missing(
            "wheel",
            "`contact` says how the body touches a wheel, and there is none",
            "add [participant.config.wheel], or remove `contact`",
        )),
        (Some(wheel), Some(contact)) => {
            wheel.check()?;
            contact.check()?;
            check_end(config)
        }
    }
}

fn check_without(config: &Config) -> Result<(), ConfigError> {
    if config.time.start_mass_damping_per_s.is_some() {
        return Err(missing(
            "time.start_mass_damping_per_s",
            "it acts until the wheel starts to move, and there is no wheel",
            "remove it, or write mass_damping_per_s for the whole run",
        ));
    }
    if config.start == Start::Static {
        return Err(missing(
            "start",
            "\"static\" starts from a body loaded by its wheel, and there is no wheel",
            "add [participant.config.wheel], or remove `start`",
        ));
    }
    Ok(())
}

fn check_end(config: &Config) -> Result<(), ConfigError> {
    if config.analysis == Analysis::Dynamic && config.time.end_s.is_some() {
        return Err(missing(
            "time.end_s",
            "the wheel's history already ends the run",
            "remove the key, or change wheel.hold_s or wheel.cycles",
        ));
    }
    Ok(())
}

fn missing(key: &str, problem: &str, help: &str) -> ConfigError {
    ConfigError::new(key, problem).help(help)
}
