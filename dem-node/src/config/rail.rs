//! The keys of `sample` with kind = "rail" and their limits.

use std::f64::consts::PI;

use dem_kernel::bodies::geometry::drop_at;
use kit::ConfigError;
use kit::keys::refuse_if;
use kit::limits::{ROUNDING, at_least};
use protocol::Cause;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::radii::{Radii, RadiusLaw};

/// More grains than this are taken for a mistyped unit: they would relax for hours.
const GRAINS_MAX: f64 = 5e5;
/// Least width of a rail, and least height of its sides, in largest radii: a thinner rail consists of the grains along its faces.
const WIDTH: f64 = 20.0;
const HEIGHT: f64 = 8.0;

/// A portion of a rail that consists of grains: straight sides and base, a crown above. The top of the crown is at y = 0, over
/// x = 0.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct RailConfig {
    /// Width (m), half of it on either side of x = 0.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub width_m: f64,
    /// Height above the base (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub height_m: f64,
    /// The place where the rail is `height_m` high.
    pub height_at: HeightAt,
    /// Radius of the crown (m); 0 = flat.
    #[schemars(range(min = 0.0))]
    pub crown_radius_m: f64,
    /// Smallest radius of the grains (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius_min_m: f64,
    /// Largest radius of the grains (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius_max_m: f64,
    /// Distribution of the radii.
    pub law: RadiusLaw,
    /// Exponent k of law = "power", p ~ r^k; required there, refused with other laws.
    #[schemars(range(min = -20.0, max = 20.0))]
    pub power: Option<f64>,
    /// Seed of the packing; the run's seed when absent.
    pub seed: Option<u64>,
}

/// The words for `sample.height_at`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum HeightAt {
    /// The sides.
    Edge,
    /// The top of the crown.
    Crown,
}

impl RailConfig {
    /// The radii.
    pub fn radii(&self) -> Radii {
        Radii::new(self.law, self.power, self.radius_min_m, self.radius_max_m)
    }

    /// Height of the base (m), below the top of the crown.
    pub fn base(&self) -> f64 {
        match self.height_at {
            HeightAt::Edge => -self.height_m - self.sag(),
            HeightAt::Crown => -self.height_m,
        }
    }

    /// Area inside base, sides and crown (m2): a rectangle and a segment of a circle, R^2 asin(w/R) - w sqrt(R^2 - w^2).
    pub fn area(&self) -> f64 {
        let (w, crown) = (0.5 * self.width_m, self.crown_radius_m);
        let rectangle = self.width_m * (-self.base() - self.sag());
        if crown == 0.0 {
            return rectangle;
        }
        rectangle + crown * crown * (w / crown).asin() - w * (crown * crown - w * w).sqrt()
    }

    /// Drop of the crown at the sides (m).
    fn sag(&self) -> f64 {
        drop_at(0.5 * self.width_m, self.crown_radius_m)
    }

    pub(super) fn validate(&self) -> Result<(), ConfigError> {
        self.radii().validate("sample")?;
        let widest = self.radius_max_m;
        at_least("sample.width_m", self.width_m, WIDTH * widest, "m")?;
        let crown = Some(self.crown_radius_m).filter(|crown| *crown > 0.0);
        at_least("sample.crown_radius_m", crown, self.width_m, "m")?;
        let (sides, least) = (-self.base() - self.sag(), HEIGHT * widest);
        refuse_if(
            sides < least * (1.0 - ROUNDING),
            "sample.height_m",
            format!("the sides are {sides:e} m high, and grains of {widest:e} m need {least:e} m"),
            "make the rail higher or its crown flatter, or the grains smaller",
        )?;
        let grains = self.area() / (PI * self.radii().mean_square());
        refuse_if(
            grains.is_nan() || grains > GRAINS_MAX,
            "sample.radius_min_m",
            format!(
                "a rail of {:e} m2 needs about {grains:.1e} grains of {:e} to {widest:e} m, more than {GRAINS_MAX:.0e}",
                self.area(),
                self.radius_min_m
            ),
            "check the units (m): a smaller rail, or larger grains",
        )
        .map_err(|error| error.because(Cause::TooMany))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paper(height_at: HeightAt) -> RailConfig {
        RailConfig {
            width_m: 65e-3,
            height_m: 20e-3,
            height_at,
            crown_radius_m: 0.3,
            radius_min_m: 0.05e-3,
            radius_max_m: 0.1e-3,
            law: RadiusLaw::SurfaceUniform,
            power: None,
            seed: None,
        }
    }

    /// Renouf, Saulot and Berthier (2006), section 6: 65 mm by 20 mm under a crown of 300 mm, in either reading.
    #[test]
    fn the_areas_agree_with_both_readings_of_the_paper() {
        let mm2 = |at: HeightAt| (paper(at).area() * 1e7).round() / 10.0;
        assert_eq!(mm2(HeightAt::Edge), 1376.6);
        assert_eq!(mm2(HeightAt::Crown), 1261.8);
        let top = -paper(HeightAt::Edge).base();
        assert!((top - 21.766e-3).abs() < 1e-6, "{top}");
    }

    #[test]
    fn a_flat_rail_is_a_rectangle() {
        let flat = RailConfig {
            crown_radius_m: 0.0,
            ..paper(HeightAt::Crown)
        };
        assert_eq!(flat.area(), 65e-3 * 20e-3);
    }
}
