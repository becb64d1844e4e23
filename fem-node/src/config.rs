//! The keys of `[participant.config]`, read and checked once.

mod boundary;
mod material;
mod mesh;
mod statics;
mod time;
mod together;
mod wheel;

use protocol::ConfigError;
use serde::{Deserialize, Serialize};

pub(crate) use boundary::SetLoad;
pub use boundary::{BoundaryConfig, Component, SetConfig};
pub use material::{MaterialConfig, MaterialKind};
pub use mesh::{GmshConfig, MeshConfig, MeshSource};
pub use statics::StaticsConfig;
pub use time::{StepChoice, TimeConfig};
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
    /// Small strain when absent.
    #[serde(default)]
    pub kinematics: Kinematics,
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
    pub mesh: MeshSource,
    /// Constitutive law and density.
    pub material: MaterialConfig,
    /// Time integration.
    pub time: TimeConfig,
    /// Loads and prescribed motions on named sets.
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
    /// No support.
    Free,
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

/// What is taken for the strain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kinematics {
    /// The symmetric part of the displacement gradient; rotations must stay small.
    #[default]
    Small,
    /// The stretch without the rotation: rotations may be large, the stretch must stay small.
    Corotational,
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
        self.check_law()?;
        self.check_period()?;
        self.check_motion()?;
        self.check_start()
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

fn optional(
    value: Option<f64>,
    check: impl Fn(f64) -> Result<(), ConfigError>,
) -> Result<(), ConfigError> {
    value.map_or(Ok(()), check)
}
