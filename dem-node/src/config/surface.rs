//! The keys of `sample.surface` and their limits.

use kit::ConfigError;
use kit::keys::refuse_if;
use kit::limits::at_least;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const KEY: &str = "sample.surface";

/// Mean radii between the points of a surface by default.
pub(crate) const SPACING: f64 = 2.0;
/// Fewest points of a corrugation along its correlation length: fewer cut its tops off.
const POINTS: f64 = 2.0;
/// Most segments that are taken for meant.
const SEGMENTS_MAX: f64 = 1e5;

/// The bare surface of the body below (and above, under a lid), beside glued disks or in their place: a polyline on whose segments grains
/// lie. Its points belong to the sets `base` and `lid`.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SurfaceConfig {
    /// The surface covers this much to either side of the middle (m), where the coupled body must have its own; nine mean radii beyond a
    /// layer when absent.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub half_width_m: Option<f64>,
    /// Largest distance of its points (m); a mean diameter when absent. The body below feels what lies between two points at these: a contact
    /// needs some five segments.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub spacing_m: Option<f64>,
    /// Coefficient of friction of grains on it; that of the grains on the glued row when absent.
    #[schemars(range(min = 0.0))]
    pub friction: Option<f64>,
    /// Radius of the crown that it follows (m), 0 = straight; for listed disks, as a layer has its own.
    #[schemars(range(min = 0.0))]
    pub crown_radius_m: Option<f64>,
    /// Its points (m) in place of the keys before but friction, by ascending x: the grains are on the left of their direction.
    pub points_m: Option<Vec<[f64; 2]>>,
    /// Heights about that line.
    pub roughness: Option<RoughnessConfig>,
}

/// A rough profile: heights of a Gaussian process.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct RoughnessConfig {
    /// Root of the mean square of the heights (m).
    #[schemars(range(min = 0.0))]
    pub rms_m: f64,
    /// Length l over which they are correlated, as exp(-(x/l)^2) (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub correlation_m: f64,
    /// Seed of the heights; the run's when absent.
    pub seed: Option<u64>,
}

impl SurfaceConfig {
    /// Refuses a surface that does not reach beyond `within` (m), the half-width of what lies on it, or whose points, by default `spacing`
    /// apart (m), do not resolve its roughness. `layer` is true where a layer has the crown.
    pub(super) fn validate(
        &self,
        within: f64,
        spacing: f64,
        layer: bool,
    ) -> Result<(), ConfigError> {
        let key = |name: &str| format!("{KEY}.{name}");
        at_least(&key("half_width_m"), self.half_width_m, within, "m")?;
        refuse_if(
            layer && self.crown_radius_m.is_some(),
            &key("crown_radius_m"),
            "belongs to a surface under listed disks: that of a layer follows sample.crown_radius_m",
            "remove it",
        )?;
        let reach = self.half_width_m.unwrap_or(within);
        let crown = self.crown_radius_m.filter(|crown| *crown > 0.0);
        at_least(&key("crown_radius_m"), crown, reach, "m")?;
        let spacing = self.spacing_m.unwrap_or(spacing);
        refuse_if(
            2.0 * reach > SEGMENTS_MAX * spacing,
            &key("spacing_m"),
            format!(
                "a surface of {:e} m in segments of {spacing:e} m has more than {SEGMENTS_MAX:.0e} of them",
                2.0 * reach
            ),
            "check the units (m)",
        )?;
        if let Some(points) = &self.points_m {
            self.validate_points(points)?;
        }
        let Some(rough) = self.roughness else {
            return Ok(());
        };
        let least = POINTS * spacing;
        at_least(&key("roughness.correlation_m"), rough.correlation_m, least, "m").map_err(|error| {
            error.help("a correlation length needs two points at least: lower sample.surface.spacing_m, or raise it")
        })
    }

    fn validate_points(&self, points: &[[f64; 2]]) -> Result<(), ConfigError> {
        let key = format!("{KEY}.points_m");
        let others = [self.half_width_m, self.spacing_m, self.crown_radius_m];
        refuse_if(
            others.iter().any(Option::is_some) || self.roughness.is_some(),
            &key,
            "says where the surface is, and so do half_width_m, spacing_m, crown_radius_m and roughness",
            "keep one of them",
        )?;
        let rises = points.windows(2).all(|pair| pair[0][0] < pair[1][0]);
        refuse_if(
            points.len() < 2 || !rises,
            &key,
            "needs at least two points, by ascending x",
            "list them from left to right, each x once",
        )
    }
}
