//! All keys of a participant.

use std::collections::BTreeMap;

use fem_kernel::element::body::ElementKind;
use fem_kernel::statics::history::StaticLoads;
use kit::table::last_change;
use kit::wheel::{WheelProgram, moments};
use schemars::JsonSchema;
use serde::Deserialize;

use super::boundary::BoundaryConfig;
use super::choice::{Analysis, Base, Kinematics, Plane, Sides, Start};
use super::heat::HeatConfig;
use super::initial::InitialConfig;
use super::material::{MaterialConfig, MaterialKind};
use super::mesh::MeshSource;
use super::motion::settled_at;
use super::probe::ProbeConfig;
use super::reduced::ReducedConfig;
use super::statics::StaticsConfig;
use super::time::FemTimeConfig;
use super::wheel::{ContactConfig, FemWheelConfig};

/// Keys of a body: geometry, material, time integration, loads and contact.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FemConfig {
    /// Kind of analysis: motion over time or equilibrium; motion when absent.
    #[serde(default)]
    pub analysis: Analysis,
    /// Loading of a body under a wheel at the start; a ramp when absent. A static analysis does not use it.
    #[serde(default)]
    pub start: Start,
    /// Finite element; when absent `q4_1point`, or `q4_bbar` for a plastic material.
    pub element: Option<ElementKind>,
    /// Measure of strain; small strain when absent.
    #[serde(default)]
    pub kinematics: Kinematics,
    /// Out-of-plane condition; plane strain when absent.
    #[serde(default)]
    pub plane: Plane,
    /// Support of the lower edge; clamped when absent.
    #[serde(default)]
    pub base: Base,
    /// Support of the lateral edges; none when absent.
    #[serde(default)]
    pub sides: Sides,
    /// Geometry and element sizes, or a Gmsh file.
    pub mesh: MeshSource,
    /// Constitutive law with its parameters, and density.
    pub material: MaterialConfig,
    /// Time step, damping and end of the run.
    pub time: FemTimeConfig,
    /// Loads and prescribed motions on named sets; none when absent.
    #[serde(default)]
    pub boundary: BoundaryConfig,
    /// Velocities of named sets at the start; 0 when absent.
    #[serde(default)]
    pub initial: InitialConfig,
    /// Points whose displacement and velocity are signals; none when absent.
    #[serde(default)]
    pub probes: Vec<ProbeConfig>,
    /// The rigid wheel on the upper edge; no wheel when absent.
    pub wheel: Option<FemWheelConfig>,
    /// Contact of the upper edge with the wheel: required with a wheel, refused without.
    pub contact: Option<ContactConfig>,
    /// Increments of a static analysis or a static start.
    #[serde(default)]
    pub statics: StaticsConfig,
    /// The body as its lowest modes, for coupled runs; all of its elements when absent.
    pub reduced: Option<ReducedConfig>,
    /// Temperatures of the body; none when absent.
    pub heat: Option<HeatConfig>,
    /// Seed for displacing each node of the mesh along y by up to 1e-12 of the mean element size: a difference from the run without it is noise. No
    /// node is displaced when absent.
    #[serde(default)]
    pub perturb_seed: Option<u64>,
    /// Bounds `[warn, suspect]` of the checks of plausibility; an absent check keeps its own.
    #[serde(default)]
    pub plausible: FemPlausible,
}

impl FemConfig {
    /// The given element; when absent the fast `q4_1point`, or `q4_bbar` for a plastic material, whose flow keeps the volume.
    pub fn element(&self) -> ElementKind {
        let plastic = self.material.law() == MaterialKind::J2;
        let own = if plastic {
            ElementKind::Q4MeanDilatation
        } else {
            ElementKind::Q4OnePoint
        };
        self.element.unwrap_or(own)
    }

    /// The loads of a wheel in equilibrium, where there is one.
    pub fn static_loads(&self) -> Option<StaticLoads> {
        let (wheel, contact) = self.wheel.as_ref().zip(self.contact.as_ref())?;
        let rolling = wheel.rolling.as_ref();
        Some(StaticLoads {
            load: wheel.load_n,
            radius: wheel.radius_m,
            friction: contact.friction,
            friction_while_loading: contact.friction_while_loading,
            increments: self.statics.load_increments(wheel.load_n),
            start: rolling.map_or(0.0, |rolling| rolling.start_m),
        })
    }

    /// Times (s) at which loads and motions over time, the wheel's included, have taken effect.
    pub(crate) fn moments(&self, wheel: Option<&WheelProgram>) -> BTreeMap<String, f64> {
        let mut all = wheel.map_or_else(BTreeMap::new, WheelProgram::moments);
        for (name, set) in &self.boundary.0 {
            let own = moments([
                ("load_table", last_change(set.load_table.as_ref())),
                ("motion_table", set.motion_table.as_ref().map(settled_at)),
                ("motion.start_s", set.motion.map(|motion| motion.start_s)),
                ("ramp_s", set.ramp_s),
            ])
            .into_iter();
            all.extend(own.map(|(key, time_s)| (format!("boundary.{name}.{key}"), time_s)));
        }
        all
    }
}

/// The table `plausible` of a continuum.
pub type FemPlausible = kit::Plausible<FemTable>;

/// Its name where checks are declared.
#[derive(Clone, Debug, PartialEq)]
pub struct FemTable;

impl kit::bounds::Table for FemTable {
    const NAME: &'static str = "fem";
}
