//! All keys of a participant.

use serde::Deserialize;

use super::boundary::BoundaryConfig;
use super::choice::{Analysis, Base, ElementKind, Kinematics, Plane, Sides, Start};
use super::material::MaterialConfig;
use super::mesh::MeshSource;
use super::plausible::PlausibleConfig;
use super::statics::StaticsConfig;
use super::time::TimeConfig;
use super::wheel::{ContactConfig, WheelConfig};

/// Keys of a body: geometry, material, time integration, loads and contact.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// Motion in time or equilibrium; motion when absent.
    #[serde(default)]
    pub analysis: Analysis,
    /// Way in which a body under a wheel comes under its load.
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
    /// Increments of a static analysis or a static start.
    #[serde(default)]
    pub statics: StaticsConfig,
    /// Bounds of the checks of plausibility.
    #[serde(default)]
    pub plausible: PlausibleConfig,
}
