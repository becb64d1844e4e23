//! The keys of `sample.surface` and their limits.

use kit::ConfigError;
use kit::keys::refuse_if;
use kit::limits::at_least;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const KEY: &str = "sample.surface";

/// Default distance between the points of a surface, in mean radii.
pub(crate) const SPACING: f64 = 2.0;
/// Fewest points along a correlation length: fewer cut the tops of the heights off.
const POINTS: f64 = 2.0;
/// More segments than this are taken for a mistyped unit.
const SEGMENTS_MAX: f64 = 1e5;

/// The bare surface of the body below, and of the body above with a lid, beside glued disks or in their place: a polyline on whose segments grains
/// lie. Its points belong to the sets `base` and `lid`.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SurfaceConfig {
    /// Half of the surface's width (m), to either side of the middle; the coupled body must have a surface there. When absent, nine mean radii beyond
    /// a layer; listed disks need the key.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub half_width_m: Option<f64>,
    /// Largest distance between its points (m); a mean diameter when absent. The body below takes up forces at these points only: a contact needs
    /// some five segments.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub spacing_m: Option<f64>,
    /// Coefficient of friction of grains on the surface; the same as on the glued row when absent.
    #[schemars(range(min = 0.0))]
    pub friction: Option<f64>,
    /// Radius of the crown that the surface follows (m), 0 = straight; straight when absent. Under listed disks only: a layer has its own key.
    #[schemars(range(min = 0.0))]
    pub crown_radius_m: Option<f64>,
    /// Points of the surface (m) by ascending x, in place of all its other keys but friction; the grains lie above. Made from the other keys when
    /// absent.
    pub points_m: Option<Vec<[f64; 2]>>,
    /// Random heights about the line of the surface; smooth when absent.
    pub roughness: Option<RoughnessConfig>,
}

/// A rough profile: heights of a Gaussian process.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct RoughnessConfig {
    /// Root mean square of the heights (m).
    #[schemars(range(min = 0.0))]
    pub rms_m: f64,
    /// Correlation length l of the heights (m), with the correlation exp(-(x/l)^2).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub correlation_m: f64,
    /// Seed of the heights; the run's seed when absent.
    pub seed: Option<u64>,
}

impl SurfaceConfig {
    /// Refuses a surface that does not reach beyond `within` (m), the half-width of the grains on it, or whose points, by default `spacing` apart
    /// (m), do not resolve its roughness. `layer` is true for a layer, which has a crown of its own.
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
            "belongs to a surface under listed disks: the surface of a layer follows sample.crown_radius_m",
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
