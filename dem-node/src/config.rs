//! The keys of `[participant.config]` and their limits.

use protocol::ConfigError;
use serde::Deserialize;

/// Everything that a scenario says about the third body. SI units, the unit in each key.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// What happens at a contact; the same for every contact, wheel, walls and glued disks included.
    pub law: LawConfig,
    /// How the contact problem of a step is solved.
    pub solver: SolverConfig,
    /// Step and scheme.
    pub time: TimeConfig,
    /// Density of the grains (kg/m3).
    pub density_kg_per_m3: f64,
    /// Factor on the inertia of the grains; loads, weights and the wheel's mass are never scaled.
    #[serde(default = "one")]
    pub mass_scale: f64,
    /// Acceleration of gravity (m/s2). The weight is that of the real mass.
    #[serde(default)]
    pub gravity_m_per_s2: [f64; 2],
    /// Where the grains come from.
    pub sample: SampleConfig,
    /// The rigid wheel above the grains.
    #[serde(default)]
    pub wheel: Option<WheelConfig>,
}

fn one() -> f64 {
    1.0
}

/// `law`: unilateral contact with optional friction and compliance.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LawConfig {
    /// Signorini or Coulomb.
    pub kind: LawKind,
    /// Coefficient of friction, at least 0; with `coulomb` only.
    pub friction: Option<f64>,
    /// Stiffness of each contact per thickness (Pa): kn = value x thickness. Rigid contacts when absent.
    pub contact_stiffness_pa: Option<f64>,
    /// kt / kn of compliant contacts with friction, above 0.
    pub tangential_stiffness_ratio: Option<f64>,
}

/// The words for `law.kind`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LawKind {
    /// Unilateral contact without friction.
    Signorini,
    /// Unilateral contact with Coulomb friction.
    Coulomb,
}

/// `solver`: how the contact problem is solved.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SolverConfig {
    /// The algorithm.
    pub kind: SolverKind,
    /// Bound on the true natural-map residual, relative.
    pub tolerance: f64,
    /// Iterations after which a window counts as not converged.
    pub max_iterations: usize,
    /// Iterations that are always done.
    pub min_iterations: usize,
}

/// The words for `solver.kind`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SolverKind {
    /// Block non-linear Gauss-Seidel.
    Nsgs,
}

/// `time`: step and scheme.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimeConfig {
    /// Step of a run alone (s); a coupled node steps by windows.
    pub step_s: Option<f64>,
    /// Weight of the end velocity, 0.5 to 1. A coupled node needs 1.
    #[serde(default = "one")]
    pub theta: f64,
    /// Mean stress that the scene expects (Pa); it sets the bound t_i = d sqrt(rho/P) on the step.
    pub pressure_pa: f64,
    /// Accepts a step above t_i.
    #[serde(default)]
    pub unsafe_step: bool,
    /// End of a run alone without wheel (s).
    pub end_s: Option<f64>,
}

/// `sample`: where the grains come from.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "snake_case", tag = "kind", deny_unknown_fields)]
pub enum SampleConfig {
    /// A pressed layer that follows the crown, glued to its base.
    Layer(LayerConfig),
    /// Disks and walls one by one.
    Disks(DisksConfig),
}

/// A pressed layer of constant thickness on a crowned line.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LayerConfig {
    /// Distance from the base line to the wheel's face (m).
    pub thickness_m: f64,
    /// The layer covers |x| up to this (m).
    pub half_width_m: f64,
    /// Radius of the crown of the base line (m); 0 = straight.
    pub crown_radius_m: f64,
    /// Smallest radius of the grains (m).
    pub radius_min_m: f64,
    /// Largest radius of the grains (m).
    pub radius_max_m: f64,
    /// Distribution of the radii.
    pub law: RadiusLaw,
    /// Seed of the packing; the run's seed when absent.
    pub seed: Option<u64>,
    /// What the bed has below the cut (m). Five mean diameters keep the floor's ordering out of the layer.
    #[serde(default = "bed_extra")]
    pub bed_extra_m: f64,
    /// Pressures under the flat plate, one after the other (Pa). The second, lower one leaves little
    /// elastic overlap to relax when the side walls go.
    #[serde(default = "press")]
    pub press_pa: Vec<f64>,
}

fn bed_extra() -> f64 {
    0.7e-3
}

fn press() -> Vec<f64> {
    vec![300e6, 50e6]
}

/// Distribution of radii between two limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RadiusLaw {
    /// Equal surface in each class of radius, p ~ r^-2: LMGC90's `granulo_Uniform`, the paper's law.
    SurfaceUniform,
    /// Equal number in each class of radius.
    NumberUniform,
    /// Equal number in each class of the radius' logarithm.
    LogUniform,
}

/// Disks and walls one by one.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DisksConfig {
    /// The disks; glued ones form the set `base`.
    pub disks: Vec<DiskConfig>,
    /// Fixed half-planes.
    #[serde(default)]
    pub walls: Vec<WallConfig>,
}

/// One disk.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DiskConfig {
    /// Centre (m).
    pub x_m: f64,
    /// Centre (m).
    pub y_m: f64,
    /// Radius (m).
    pub radius_m: f64,
    /// Velocity at the start (m/s).
    #[serde(default)]
    pub vx_m_per_s: f64,
    /// Velocity at the start (m/s).
    #[serde(default)]
    pub vy_m_per_s: f64,
    /// Spin at the start (rad/s), anticlockwise positive.
    #[serde(default)]
    pub spin_rad_per_s: f64,
    /// Whether it belongs to the glued row: massless, without spin.
    #[serde(default)]
    pub glued: bool,
}

/// A fixed half-plane: the grains stay on the side of the normal.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WallConfig {
    /// A point of the face (m).
    pub x_m: f64,
    /// A point of the face (m).
    pub y_m: f64,
    /// Direction of the normal.
    pub nx: f64,
    /// Direction of the normal.
    pub ny: f64,
}

/// A flat rigid wheel that is pressed on the grains and moved sideways.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WheelConfig {
    /// Vertical load (N).
    pub load_n: f64,
    /// Mass (kg), never scaled.
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

impl Config {
    /// Refuses values out of range, naming the key, the value and what to do.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.law.validate()?;
        self.solver.validate()?;
        self.time.validate()?;
        positive("density_kg_per_m3", self.density_kg_per_m3, "kg/m3")?;
        at_least("mass_scale", self.mass_scale, 1.0, "")?;
        for component in self.gravity_m_per_s2 {
            finite("gravity_m_per_s2", component)?;
        }
        match &self.sample {
            SampleConfig::Layer(layer) => layer.validate()?,
            SampleConfig::Disks(disks) => disks.validate()?,
        }
        if let Some(wheel) = &self.wheel {
            wheel.validate()?;
        }
        self.validate_together()
    }

    fn validate_together(&self) -> Result<(), ConfigError> {
        if matches!(self.sample, SampleConfig::Layer(_)) && self.wheel.is_none() {
            return Err(ConfigError::new(
                "wheel",
                "a layer needs the wheel that holds it, and there is none",
            )
            .help("add [participant.config.wheel]"));
        }
        if self.wheel.is_some() && self.time.end_s.is_some() {
            return Err(
                ConfigError::new("time.end_s", "the wheel's history already ends the run")
                    .help("remove the key, or change wheel.hold_s or wheel.cycles"),
            );
        }
        Ok(())
    }
}

impl LawConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        if let Some(stiffness) = self.contact_stiffness_pa {
            positive("law.contact_stiffness_pa", stiffness, "Pa")?;
        }
        match self.kind {
            LawKind::Signorini => self.validate_frictionless(),
            LawKind::Coulomb => self.validate_coulomb(),
        }
    }

    fn validate_frictionless(&self) -> Result<(), ConfigError> {
        let superfluous = [
            ("law.friction", self.friction),
            (
                "law.tangential_stiffness_ratio",
                self.tangential_stiffness_ratio,
            ),
        ];
        match superfluous.into_iter().find(|(_, value)| value.is_some()) {
            None => Ok(()),
            Some((key, _)) => Err(ConfigError::new(
                key,
                "law.kind = \"signorini\" has no tangential force, the key would have no effect",
            )
            .help("remove it, or choose law.kind = \"coulomb\"")),
        }
    }

    fn validate_coulomb(&self) -> Result<(), ConfigError> {
        let friction = required("law.friction", self.friction, "law.kind = \"coulomb\"")?;
        at_least("law.friction", friction, 0.0, "")?;
        let key = "law.tangential_stiffness_ratio";
        match (self.contact_stiffness_pa, self.tangential_stiffness_ratio) {
            (None, None) => Ok(()),
            (None, Some(_)) => Err(ConfigError::new(
                key,
                "rigid contacts have no stiffness, the key would have no effect",
            )
            .help("remove it, or give law.contact_stiffness_pa")),
            (Some(_), ratio) => {
                let why = "compliant contacts with friction";
                positive(key, required(key, ratio, why)?, "")
            }
        }
    }
}

impl SolverConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        within("solver.tolerance", self.tolerance, f64::MIN_POSITIVE, 0.1)?;
        if self.max_iterations == 0 || self.min_iterations > self.max_iterations {
            return Err(ConfigError::new(
                "solver.max_iterations",
                format!(
                    "must be at least 1 and at least solver.min_iterations = {}, got {}",
                    self.min_iterations, self.max_iterations
                ),
            ));
        }
        Ok(())
    }
}

impl TimeConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        within("time.theta", self.theta, 0.5, 1.0)?;
        positive("time.pressure_pa", self.pressure_pa, "Pa")?;
        for (key, value) in [("time.step_s", self.step_s), ("time.end_s", self.end_s)] {
            if let Some(value) = value {
                positive(key, value, "s")?;
            }
        }
        Ok(())
    }
}

impl LayerConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        positive("sample.thickness_m", self.thickness_m, "m")?;
        positive("sample.half_width_m", self.half_width_m, "m")?;
        positive("sample.radius_min_m", self.radius_min_m, "m")?;
        at_least(
            "sample.radius_max_m",
            self.radius_max_m,
            self.radius_min_m,
            "m",
        )?;
        at_least(
            "sample.bed_extra_m",
            self.bed_extra_m,
            4.0 * self.radius_max_m,
            "m",
        )?;
        at_least(
            "sample.half_width_m",
            self.half_width_m,
            10.0 * self.radius_max_m,
            "m",
        )?;
        at_least("sample.crown_radius_m", self.crown_radius_m, 0.0, "m")?;
        if self.crown_radius_m > 0.0 {
            at_least(
                "sample.crown_radius_m",
                self.crown_radius_m,
                2.0 * self.half_width_m,
                "m",
            )?;
        }
        if self.press_pa.is_empty() {
            return Err(ConfigError::new(
                "sample.press_pa",
                "needs at least one pressure",
            ));
        }
        self.press_pa
            .iter()
            .try_for_each(|pressure| positive("sample.press_pa", *pressure, "Pa"))
    }
}

impl DisksConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        if self.disks.iter().all(|disk| disk.glued) {
            return Err(ConfigError::new(
                "sample.disks",
                "needs at least one disk that is not glued",
            ));
        }
        for (i, disk) in self.disks.iter().enumerate() {
            let key = |name: &str| format!("sample.disks[{i}].{name}");
            positive(&key("radius_m"), disk.radius_m, "m")?;
            finite(&key("x_m"), disk.x_m)?;
            finite(&key("y_m"), disk.y_m)?;
        }
        for (i, wall) in self.walls.iter().enumerate() {
            positive(
                &format!("sample.walls[{i}].nx"),
                wall.nx.hypot(wall.ny),
                "length of (nx, ny)",
            )?;
        }
        Ok(())
    }
}

impl WheelConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        positive("wheel.mass_kg", self.mass_kg, "kg")?;
        at_least("wheel.load_n", self.load_n, 0.0, "N")?;
        at_least("wheel.ramp_s", self.ramp_s, 0.0, "s")?;
        at_least("wheel.hold_s", self.hold_s, 0.0, "s")?;
        at_least("wheel.amplitude_m", self.amplitude_m, 0.0, "m")?;
        at_least("wheel.cycles", self.cycles, 0.0, "")?;
        if self.radius_m != 0.0 {
            return Err(ConfigError::new(
                "wheel.radius_m",
                format!(
                    "only a flat wheel can roll on grains so far, got a radius of {} m",
                    self.radius_m
                ),
            )
            .help("write radius_m = 0"));
        }
        if self.cycles > 0.0 {
            positive("wheel.frequency_hz", self.frequency_hz, "1/s")?;
        }
        Ok(())
    }
}

fn required(key: &str, value: Option<f64>, by: &str) -> Result<f64, ConfigError> {
    value.ok_or_else(|| ConfigError::new(key, format!("{by} need it and it is missing")))
}

fn positive(key: &str, value: f64, unit: &str) -> Result<(), ConfigError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(ConfigError::new(
        key,
        format!("must be positive, got {value:e}{}", in_brackets(unit)),
    ))
}

fn at_least(key: &str, value: f64, minimum: f64, unit: &str) -> Result<(), ConfigError> {
    if value >= minimum && value.is_finite() {
        return Ok(());
    }
    Err(ConfigError::new(
        key,
        format!(
            "must be at least {minimum:e}, got {value:e}{}",
            in_brackets(unit)
        ),
    ))
}

fn within(key: &str, value: f64, low: f64, high: f64) -> Result<(), ConfigError> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(ConfigError::new(
        key,
        format!("must lie between {low} and {high}, got {value}"),
    ))
}

fn finite(key: &str, value: f64) -> Result<(), ConfigError> {
    if value.is_finite() {
        return Ok(());
    }
    Err(ConfigError::new(
        key,
        format!("must be a finite number, got {value}"),
    ))
}

fn in_brackets(unit: &str) -> String {
    match unit {
        "" => String::new(),
        unit => format!(" ({unit})"),
    }
}
