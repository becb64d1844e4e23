//! The keys of `[participant.config]`, read and checked once.

mod boundary;
mod mesh;
mod statics;
mod wheel;

use std::fmt;

use protocol::ConfigError;
use serde::de::{self, Deserializer, Visitor};
use serde::{Deserialize, Serialize};

pub(crate) use boundary::SetLoad;
pub use boundary::{BoundaryConfig, Component, SetConfig};
pub use mesh::{GmshConfig, MeshSource};
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

/// Constitutive law.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MaterialKind {
    /// Linear elastic, isotropic.
    #[default]
    Elastic,
    /// Elastic up to von Mises' yield surface, which grows and moves linearly with the plastic strain; plane strain.
    J2,
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

/// Geometry: a block with a graded structured mesh, fine in the middle of its upper edge.
#[derive(Clone, Debug, PartialEq)]
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
    pub side_columns: usize,
    /// Graded rows below the fine zone.
    pub depth_rows: usize,
    /// Radius of the upper edge (m); flat when absent or 0.
    pub crown_radius_m: Option<f64>,
    /// The left and the right edge are one: a body that goes on for ever in x.
    pub periodic_x: bool,
}

/// Constitutive law with its numbers.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaterialConfig {
    /// Which law; when absent `j2` beside a `yield_pa`, `elastic` without.
    pub kind: Option<MaterialKind>,
    /// Young's modulus (Pa), > 0.
    pub young_pa: f64,
    /// Poisson's ratio, in (-1, 0.5).
    pub poisson: f64,
    /// Density (kg/m3), > 0.
    pub density_kg_per_m3: f64,
    /// Yield stress in uniaxial tension (Pa), > 0; `j2` only.
    pub yield_pa: Option<f64>,
    /// Growth H of the yield stress with the equivalent plastic strain (Pa), >= 0; none when absent.
    pub hardening_pa: Option<f64>,
    /// Growth of the back stress with the plastic strain in uniaxial tension (Pa), >= 0; none when absent.
    pub kinematic_hardening_pa: Option<f64>,
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
    /// Rayleigh's damping in proportion to the stiffness (s), >= 0, C = mass_damping_per_s M + stiffness_damping_s K: a mode
    /// omega gets the damping ratio (mass_damping_per_s/omega + stiffness_damping_s omega)/2. It shortens the stable step;
    /// none when absent.
    pub stiffness_damping_s: Option<f64>,
    /// Mass damping on body and wheel until the wheel starts to move sideways (1/s), so that it has stopped bouncing by
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

    /// Which laws, planes, elements and strains go together.
    fn check_law(&self) -> Result<(), ConfigError> {
        if self.material.law() == MaterialKind::J2 && self.plane == Plane::Stress {
            return Err(ConfigError::new("plane", "\"stress\" does not go with a j2 material")
                .help("take plane = \"strain\": the return to the yield surface keeps ezz = 0, not szz = 0"));
        }
        if self.kinematics == Kinematics::Corotational
            && self.element == ElementKind::Q4MeanDilatation
        {
            return Err(ConfigError::new(
                "kinematics",
                "\"corotational\" does not go with the element q4_bbar",
            )
            .help("take q4_1point or q4_2x2: the mean dilatation is that of small strain"));
        }
        if self.kinematics == Kinematics::Corotational && self.material.law() == MaterialKind::J2 {
            return Err(ConfigError::new(
                "kinematics",
                "\"corotational\" does not go with a j2 material",
            )
            .help("take kinematics = \"small\", or an elastic material: no exact answer backs the pair yet"));
        }
        let damped = self.time.stiffness_damping_s.is_some_and(|time| time > 0.0);
        let nonlinear =
            self.material.law() == MaterialKind::J2 || self.kinematics == Kinematics::Corotational;
        if damped && nonlinear {
            return Err(ConfigError::new(
                "time.stiffness_damping_s",
                "takes the stiffness of a linear elastic body in small strain",
            )
            .help("remove it, or the yield stress and kinematics = \"corotational\"; time.mass_damping_per_s goes with any law"));
        }
        match self.analysis == Analysis::Static || self.start == Start::Static {
            true => self.check_static(),
            false => Ok(()),
        }
    }

    /// An equilibrium is solved for a supported, linear body.
    fn check_static(&self) -> Result<(), ConfigError> {
        let refused = [
            ("material.yield_pa", self.material.law() == MaterialKind::J2),
            ("kinematics", self.kinematics == Kinematics::Corotational),
            ("base", self.base == Base::Free),
        ];
        match refused.into_iter().find(|(_, refused)| *refused) {
            None => Ok(()),
            Some((key, _)) => {
                let problem = "does not go with a static analysis or start, which solve for a supported, linear elastic body";
                Err(ConfigError::new(key, problem)
                    .help("take analysis = \"dynamic\" and start = \"ramp\", or remove the key"))
            }
        }
    }

    /// Without ends there is nothing to hold, load or couple there.
    fn check_period(&self) -> Result<(), ConfigError> {
        if !self.mesh.periodic_x() {
            return Ok(());
        }
        let ends = |name: &&String| ["left", "right"].contains(&name.as_str());
        if let Some(name) = self.boundary.0.keys().find(ends) {
            let key = format!("boundary.{name}");
            let problem =
                "is no edge of a body with mesh.periodic_x, whose left and right edge are one";
            return Err(ConfigError::new(&key, problem)
                .help("remove the set, or write mesh.periodic_x = false"));
        }
        match self.sides {
            Sides::Free => Ok(()),
            Sides::FixedX => Err(ConfigError::new(
                "sides",
                "\"fixed_x\" holds the ends of a body that has none: mesh.periodic_x makes its left and right edge one",
            )
            .help("remove `sides`, or write mesh.periodic_x = false")),
        }
    }

    /// A prescribed motion needs time, and leaves nothing for a contact to find.
    fn check_motion(&self) -> Result<(), ConfigError> {
        let Some(set) = self.boundary.driven().next() else {
            return Ok(());
        };
        let key = format!("boundary.{set}");
        if self.analysis == Analysis::Static || self.start == Start::Static {
            return Err(ConfigError::new(
                &key,
                "a prescribed motion does not go with a static analysis or start",
            )
            .help("give a traction, or take analysis = \"dynamic\" and start = \"ramp\""));
        }
        match self.wheel.is_some() && self.boundary.driven().any(|set| set == "top") {
            true => Err(
                ConfigError::new("boundary.top", "moves the edge that the wheel touches")
                    .help("remove the motion or the wheel"),
            ),
            false => Ok(()),
        }
    }

    /// A static start carries the full tractions; a ramp would take them away again.
    fn check_start(&self) -> Result<(), ConfigError> {
        let ramped = |set: &SetConfig| set.ramp_s.is_some_and(|ramp| ramp > 0.0);
        let mut sets = self.boundary.0.iter().filter(|(_, set)| ramped(set));
        match sets.next() {
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
        self.check_hardening()?;
        if self.poisson > -1.0 && self.poisson < 0.5 {
            return Ok(());
        }
        let problem = format!("must lie between -1 and 0.5, got {}", self.poisson);
        Err(ConfigError::new("material.poisson", problem)
            .help("an incompressible body (0.5) transmits pressure infinitely fast, no step could follow it; take 0.49 at most"))
    }
}

impl MaterialConfig {
    /// A linear elastic material: Young's modulus (Pa), Poisson's ratio, density (kg/m3).
    pub fn elastic(young_pa: f64, poisson: f64, density_kg_per_m3: f64) -> MaterialConfig {
        MaterialConfig {
            kind: None,
            young_pa,
            poisson,
            density_kg_per_m3,
            yield_pa: None,
            hardening_pa: None,
            kinematic_hardening_pa: None,
        }
    }

    /// The law that the keys ask for: scripts give `yield_pa` alone.
    pub fn law(&self) -> MaterialKind {
        match (self.kind, self.yield_pa) {
            (Some(kind), _) => kind,
            (None, Some(_)) => MaterialKind::J2,
            (None, None) => MaterialKind::Elastic,
        }
    }

    fn check_hardening(&self) -> Result<(), ConfigError> {
        let keys = [
            ("material.yield_pa", self.yield_pa),
            ("material.hardening_pa", self.hardening_pa),
            (
                "material.kinematic_hardening_pa",
                self.kinematic_hardening_pa,
            ),
        ];
        let given = keys.into_iter().find(|(_, value)| value.is_some());
        match (self.law(), given) {
            (MaterialKind::Elastic, Some((key, _))) => Err(ConfigError::new(
                key,
                "has no effect on an elastic material",
            )
            .help("give material.yield_pa and leave material.kind out, or remove the key")),
            (MaterialKind::Elastic, None) => Ok(()),
            (MaterialKind::J2, _) => {
                let yield_pa = self.yield_pa.ok_or_else(|| {
                    ConfigError::new(
                        "material.yield_pa",
                        "is required with material.kind = \"j2\"",
                    )
                    .help("give the yield stress in uniaxial tension (Pa)")
                })?;
                positive("material.yield_pa", yield_pa, "Pa")?;
                keys[1..].iter().try_for_each(|(key, value)| {
                    optional(*value, |value| not_negative(key, value, "Pa"))
                })
            }
        }
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
        optional(self.stiffness_damping_s, |time| {
            not_negative("time.stiffness_damping_s", time, "s")
        })?;
        optional(self.end_s, |end| positive("time.end_s", end, "s"))
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
