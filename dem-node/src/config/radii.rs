//! Distributions of radii between two limits.

use kit::ConfigError;
use kit::keys::refuse_if;
use kit::limits::refuse_given;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Distribution of radii between two limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RadiusLaw {
    /// Equal surface in each class of radius, p ~ r^-2: LMGC90's `granulo_Uniform`, the paper's law.
    SurfaceUniform,
    /// Equal number in each class of radius.
    NumberUniform,
    /// Equal number in each class of the radius' logarithm.
    LogUniform,
    /// p ~ r^k, with k in the key `power`.
    Power,
}

/// The radii that a table of keys asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Radii {
    /// Distribution of the radii.
    pub law: RadiusLaw,
    /// Exponent k of [`RadiusLaw::Power`], and of no other law: beyond -20 to 20 all radii lie at one of the limits.
    pub power: Option<f64>,
    /// Smallest and largest radius (m).
    pub ends: [f64; 2],
}

impl Radii {
    /// Radii between a smallest and a largest one (m).
    pub(super) fn new(law: RadiusLaw, power: Option<f64>, smallest: f64, largest: f64) -> Radii {
        let ends = [smallest, largest];
        Radii { law, power, ends }
    }

    /// The radius (m) below which the part u of all radii lies, 0 <= u < 1, by inverting the cumulative distribution: for
    /// p ~ r^-2 that is (1/a - 1/r) / (1/a - 1/b), for p ~ r^k with m = k + 1 it is (r^m - a^m) / (b^m - a^m).
    pub fn at(&self, u: f64) -> f64 {
        let [a, b] = self.ends;
        match self.law {
            RadiusLaw::SurfaceUniform => 1.0 / (1.0 / a - u * (1.0 / a - 1.0 / b)),
            RadiusLaw::NumberUniform => a + u * (b - a),
            RadiusLaw::LogUniform => a * (b / a).powf(u),
            RadiusLaw::Power => self.at_of_power(u),
        }
    }

    /// The same for p ~ r^k, counted from the end that holds more of the radii: no power of b/a then overflows, and near k = -1 no digits cancel.
    fn at_of_power(&self, u: f64) -> f64 {
        let [a, b] = self.ends;
        let (m, log) = (self.exponent() + 1.0, (b / a).ln());
        let radius = if m == 0.0 {
            a * (u * log).exp()
        } else if m < 0.0 {
            a * ((u * (m * log).exp_m1()).ln_1p() / m).exp()
        } else {
            b * (((1.0 - u) * (-m * log).exp_m1()).ln_1p() / m).exp()
        };
        radius.clamp(a, b)
    }

    /// Mean radius (m).
    pub fn mean(&self) -> f64 {
        let [a, b] = self.ends;
        match self.law {
            _ if a == b => a,
            RadiusLaw::SurfaceUniform => a * b * (b / a).ln() / (b - a),
            RadiusLaw::NumberUniform => 0.5 * (a + b),
            RadiusLaw::LogUniform => (b - a) / (b / a).ln(),
            RadiusLaw::Power => self.moment(1.0),
        }
    }

    /// Mean square of the radius (m2): the mean area of a disk is pi times as large.
    pub fn mean_square(&self) -> f64 {
        let [a, b] = self.ends;
        if a == b {
            return a * a;
        }
        self.moment(2.0)
    }

    /// Mean of r^n, (b^(n+m) - a^(n+m)) / (n + m) over (b^m - a^m) / m.
    fn moment(&self, n: f64) -> f64 {
        let [a, b] = self.ends;
        let log = (b / a).ln();
        let integral = |m: f64| {
            if m == 0.0 {
                return log;
            }
            (m * log).exp_m1() / m
        };
        let m = self.exponent() + 1.0;
        a.powf(n) * integral(n + m) / integral(m)
    }

    /// k of p ~ r^k.
    fn exponent(&self) -> f64 {
        match self.law {
            RadiusLaw::SurfaceUniform => -2.0,
            RadiusLaw::NumberUniform => 0.0,
            RadiusLaw::LogUniform => -1.0,
            RadiusLaw::Power => self.power.unwrap_or_default(),
        }
    }

    /// Refuses limits in the wrong order in the table `key`, a power without its law, and that law without its power.
    pub(super) fn validate(&self, key: &str) -> Result<(), ConfigError> {
        let [least, most] = self.ends;
        refuse_if(
            least > most,
            &format!("{key}.radius_min_m"),
            format!("must be at most radius_max_m = {most:e}, got {least:e} (m)"),
            "lower radius_min_m, or raise radius_max_m",
        )?;
        let key = format!("{key}.power");
        if self.law != RadiusLaw::Power {
            return refuse_given(
                [(key.as_str(), self.power.is_some())],
                "belongs to law = \"power\", and the law is another one",
                "remove it, or write law = \"power\"",
            );
        }
        if self.power.is_some() {
            return Ok(());
        }
        let problem = "this key is required and missing: law = \"power\" is p ~ r^power";
        let help = "write power = -2 for equal surface in each class of radius";
        Err(ConfigError::new(&key, problem).help(help))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn power(k: f64) -> Radii {
        Radii {
            law: RadiusLaw::Power,
            power: Some(k),
            ends: [1.0, 2.0],
        }
    }

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-14, "{a} and {b}");
    }

    #[test]
    fn named_laws_are_powers() {
        let named = [
            (RadiusLaw::SurfaceUniform, -2.0),
            (RadiusLaw::LogUniform, -1.0),
            (RadiusLaw::NumberUniform, 0.0),
        ];
        for (law, k) in named {
            let named = Radii {
                law,
                power: None,
                ends: [1.0, 2.0],
            };
            for u in [0.0, 0.1, 0.5, 0.999] {
                close(named.at(u), power(k).at(u));
            }
            close(named.mean(), power(k).mean());
            close(named.mean_square(), power(k).mean_square());
        }
    }

    #[test]
    fn a_power_near_the_logarithm_has_all_its_digits() {
        for off in [1e-15, -1e-12, 1e-9] {
            for u in [0.0, 0.3, 0.9] {
                let distance = (power(-1.0 + off).at(u) - power(-1.0).at(u)).abs();
                assert!(distance < 1e-15 + off.abs(), "{distance}");
            }
        }
    }

    #[test]
    fn moments_of_a_cube_agree_with_a_hand_calculation() {
        // p = 4 r^3 / 15 on [1, 2]: means 4 (2^5 - 1) / 75 and 4 (2^6 - 1) / 90.
        close(power(3.0).mean(), 4.0 * 31.0 / 75.0);
        close(power(3.0).mean_square(), 4.0 * 63.0 / 90.0);
    }
}
