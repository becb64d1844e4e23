//! The keys of `[participant.config]`, read and checked once.

mod statics;
mod wheel;

use std::fmt;

use protocol::ConfigError;
use serde::de::{self, Deserializer, Visitor};
use serde::{Deserialize, Serialize};

pub use statics::StaticsConfig;
pub use wheel::{ContactConfig, WheelConfig};

/// What the scenario says about the body.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// Motion in time or equilibrium; motion when absent.
    #[serde(default)]
    pub analysis: Analysis,
    /// How a body under a wheel comes under its load.
    #[serde(default)]
    pub start: Start,
    /// Element; `q4_1point` when absent, the fast one.
    #[serde(default)]
    pub element: ElementKind,
    /// Out-of-plane condition; plane strain when absent.
    #[serde(default)]
    pub plane: Plane,
    /// Support of the lower edge.
    #[serde(default)]
    pub base: Base,
    /// Support of the lateral edges.
    #[serde(default)]
    pub sides: Sides,
    /// Geometry and sizes.
    pub mesh: MeshConfig,
    /// Constitutive law and density.
    pub material: MaterialConfig,
    /// Time integration.
    pub time: TimeConfig,
    /// Tractions on the edges.
    #[serde(default)]
    pub boundary: BoundaryConfig,
    /// The rigid wheel on the upper edge.
    pub wheel: Option<WheelConfig>,
    /// Contact of the upper edge with the wheel.
    pub contact: Option<ContactConfig>,
    /// How a static analysis or a static start follows its loads.
    #[serde(default)]
    pub statics: StaticsConfig,
}

/// What is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Analysis {
    /// Explicit dynamics.
    #[default]
    Dynamic,
    /// Equilibrium under the full load.
    Static,
}

/// How a body under a wheel comes under its load.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Start {
    /// The wheel's load grows in time, `wheel.ramp_s` long.
    #[default]
    Ramp,
    /// The motion starts from the equilibrium under the full load, in place of the ramp; what `wheel.hold_s` says
    /// remains.
    Static,
}

/// Finite element.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ElementKind {
    /// Bilinear quadrilateral, one point, hourglass stiffness of Flanagan and Belytschko.
    #[default]
    #[serde(rename = "q4_1point")]
    Q4OnePoint,
    /// Bilinear quadrilateral, 2 x 2 points.
    #[serde(rename = "q4_2x2")]
    Q4Full,
    /// Bilinear quadrilateral, 2 x 2 points for the change of shape, one mean value for the change of volume; it
    /// does not lock when nearly incompressible.
    #[serde(rename = "q4_bbar")]
    Q4MeanDilatation,
}

/// Out-of-plane condition.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Plane {
    /// ezz = 0.
    #[default]
    Strain,
    /// szz = 0.
    Stress,
}

/// Support of the lower edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Base {
    /// Both components fixed.
    #[default]
    Clamped,
    /// y fixed, x free, except in the middle node where nothing else holds the body.
    Roller,
}

/// Support of the lateral edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sides {
    /// No support.
    #[default]
    Free,
    /// x fixed, y free: a laterally confined strip.
    FixedX,
}

/// Constitutive law.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MaterialKind {
    /// Linear elastic, isotropic, small strain.
    #[default]
    Elastic,
}

/// Geometry: a block with a graded structured mesh, fine in the middle of its upper edge.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeshConfig {
    /// Width (m).
    pub width_m: f64,
    /// Height at the crown (m).
    pub height_m: f64,
    /// Element size in the fine zone (m).
    pub size_m: f64,
    /// Width of the fine zone, centred (m); the whole width when absent.
    pub fine_width_m: Option<f64>,
    /// Depth of the fine zone (m); the whole height when absent.
    pub fine_depth_m: Option<f64>,
    /// Graded columns on each side of the fine zone.
    #[serde(default)]
    pub side_columns: usize,
    /// Graded rows below the fine zone.
    #[serde(default)]
    pub depth_rows: usize,
    /// Radius of the upper edge (m); flat when absent or 0.
    pub crown_radius_m: Option<f64>,
}

/// Constitutive law with its numbers.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaterialConfig {
    /// Which law.
    #[serde(default)]
    pub kind: MaterialKind,
    /// Young's modulus (Pa), > 0.
    pub young_pa: f64,
    /// Poisson's ratio, in (-1, 0.5).
    pub poisson: f64,
    /// Density (kg/m3), > 0.
    pub density_kg_per_m3: f64,
}

/// Time integration.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimeConfig {
    /// Step (s), or `"auto"`: `safety` times the stability limit.
    pub step_s: StepChoice,
    /// Damping parameter b of the scheme, 0.5 (none) to 1.
    pub damping: f64,
    /// Share of the stability limit that `"auto"` takes, in (0, 1]; 0.9 when absent, the usual margin for
    /// what a linear bound cannot see.
    pub safety: Option<f64>,
    /// Damping force per mass and velocity (1/s), >= 0; none when absent.
    pub mass_damping_per_s: Option<f64>,
    /// The same on body and wheel until the wheel starts to move sideways (1/s), so that it has stopped bouncing by
    /// then; none when absent.
    pub start_mass_damping_per_s: Option<f64>,
    /// Accept a step above the stability limit, to show what happens then.
    #[serde(default)]
    pub unsafe_step: bool,
    /// End of the run (s); needed where no interface dictates it.
    pub end_s: Option<f64>,
}

/// The step as written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepChoice {
    /// A share of the stability limit.
    Auto,
    /// Given (s).
    Seconds(f64),
}

/// Tractions on the edges, constant along each.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoundaryConfig {
    /// Upper edge.
    pub top: Option<TractionConfig>,
    /// Left edge.
    pub left: Option<TractionConfig>,
    /// Right edge.
    pub right: Option<TractionConfig>,
}

/// A traction, held after a linear ramp.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TractionConfig {
    /// Components (tx, ty) on the reference edge (Pa).
    pub traction_pa: [f64; 2],
    /// Duration of the ramp from zero (s); applied at once when absent or 0.
    pub ramp_s: Option<f64>,
}

impl Config {
    /// Checks every number that can be judged alone; mesh and step are judged where they are built.
    pub fn check(&self) -> Result<(), ConfigError> {
        self.mesh.check()?;
        self.material.check()?;
        self.time.check()?;
        self.boundary.check()?;
        wheel::check(self)?;
        self.statics
            .check(self.wheel.map_or(0.0, |wheel| wheel.load_n))?;
        self.check_start()
    }

    /// A static start carries the full tractions; a ramp would take them away again.
    fn check_start(&self) -> Result<(), ConfigError> {
        let ramped = |traction: &TractionConfig| traction.ramp_s.is_some_and(|ramp| ramp > 0.0);
        let mut edges = self
            .boundary
            .edges()
            .filter(|(_, traction)| ramped(traction));
        match edges.next() {
            Some((name, _)) if self.start == Start::Static => {
                let key = format!("boundary.{name}.ramp_s");
                let problem = "a static start already carries the full traction";
                Err(ConfigError::new(&key, problem)
                    .help("remove the ramp, or write start = \"ramp\""))
            }
            _ => Ok(()),
        }
    }
}

impl MeshConfig {
    fn check(&self) -> Result<(), ConfigError> {
        positive("mesh.width_m", self.width_m, "m")?;
        positive("mesh.height_m", self.height_m, "m")?;
        positive("mesh.size_m", self.size_m, "m")?;
        optional(self.fine_width_m, |w| positive("mesh.fine_width_m", w, "m"))?;
        optional(self.fine_depth_m, |d| positive("mesh.fine_depth_m", d, "m"))?;
        optional(self.crown_radius_m, |r| {
            not_negative("mesh.crown_radius_m", r, "m")
        })
    }
}

impl MaterialConfig {
    fn check(&self) -> Result<(), ConfigError> {
        positive("material.young_pa", self.young_pa, "Pa")?;
        positive(
            "material.density_kg_per_m3",
            self.density_kg_per_m3,
            "kg/m3",
        )?;
        if self.poisson > -1.0 && self.poisson < 0.5 {
            return Ok(());
        }
        let problem = format!("must lie between -1 and 0.5, got {}", self.poisson);
        Err(ConfigError::new("material.poisson", problem)
            .help("an incompressible body (0.5) transmits pressure infinitely fast, no step could follow it; take 0.49 at most"))
    }
}

impl TimeConfig {
    fn check(&self) -> Result<(), ConfigError> {
        if let StepChoice::Seconds(step) = self.step_s {
            positive("time.step_s", step, "s")?;
        }
        if !(0.5..=1.0).contains(&self.damping) {
            let problem = format!("must lie between 0.5 and 1, got {}", self.damping);
            return Err(ConfigError::new("time.damping", problem)
                .help("0.5 adds no damping, 0.75 is the usual choice, below 0.5 the scheme is unstable at any step"));
        }
        optional(self.safety, check_safety)?;
        optional(self.mass_damping_per_s, |rate| {
            not_negative("time.mass_damping_per_s", rate, "1/s")
        })?;
        optional(self.end_s, |end| positive("time.end_s", end, "s"))
    }
}

impl BoundaryConfig {
    /// The loaded edges by name.
    pub fn edges(&self) -> impl Iterator<Item = (&'static str, &TractionConfig)> {
        [
            ("top", &self.top),
            ("left", &self.left),
            ("right", &self.right),
        ]
        .into_iter()
        .filter_map(|(name, traction)| traction.as_ref().map(|traction| (name, traction)))
    }

    fn check(&self) -> Result<(), ConfigError> {
        for (name, traction) in self.edges() {
            if !traction.traction_pa.iter().all(|t| t.is_finite()) {
                let key = format!("boundary.{name}.traction_pa");
                return Err(ConfigError::new(&key, "must be two finite numbers (Pa)"));
            }
            optional(traction.ramp_s, |ramp| {
                not_negative(&format!("boundary.{name}.ramp_s"), ramp, "s")
            })?;
        }
        Ok(())
    }
}

impl<'de> Deserialize<'de> for StepChoice {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(StepVisitor)
    }
}

/// By hand, because serde's message for an untagged enum does not say what would be right.
struct StepVisitor;

impl Visitor<'_> for StepVisitor {
    type Value = StepChoice;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a step in seconds or \"auto\"")
    }

    fn visit_f64<E: de::Error>(self, value: f64) -> Result<StepChoice, E> {
        Ok(StepChoice::Seconds(value))
    }

    fn visit_i64<E: de::Error>(self, value: i64) -> Result<StepChoice, E> {
        Ok(StepChoice::Seconds(value as f64))
    }

    fn visit_u64<E: de::Error>(self, value: u64) -> Result<StepChoice, E> {
        Ok(StepChoice::Seconds(value as f64))
    }

    fn visit_str<E: de::Error>(self, value: &str) -> Result<StepChoice, E> {
        match value {
            "auto" => Ok(StepChoice::Auto),
            other => Err(E::invalid_value(de::Unexpected::Str(other), &self)),
        }
    }
}

/// Refuses what is not a positive finite number.
pub(crate) fn positive(key: &str, value: f64, unit: &str) -> Result<(), ConfigError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    let problem = format!("must be positive and finite, got {value:?} ({unit})");
    Err(ConfigError::new(key, problem).help(format!("write a number above 0, in {unit}")))
}

fn not_negative(key: &str, value: f64, unit: &str) -> Result<(), ConfigError> {
    if value >= 0.0 && value.is_finite() {
        return Ok(());
    }
    let problem = format!("must be finite and not negative, got {value:?} ({unit})");
    Err(ConfigError::new(key, problem).help("leave the key out to have none"))
}

fn check_safety(safety: f64) -> Result<(), ConfigError> {
    if safety > 0.0 && safety <= 1.0 {
        return Ok(());
    }
    let problem = format!("must lie above 0 and not above 1, got {safety}");
    Err(ConfigError::new("time.safety", problem)
        .help("it is the share of the stability limit that `step_s = \"auto\"` takes"))
}

fn optional(
    value: Option<f64>,
    check: impl Fn(f64) -> Result<(), ConfigError>,
) -> Result<(), ConfigError> {
    value.map_or(Ok(()), check)
}
