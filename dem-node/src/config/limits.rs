//! What the keys may hold, and what they may not hold together.

mod law;

use protocol::ConfigError;

use super::{
    Config, DisksConfig, LawKind, LayerConfig, PenetrationKind, SampleConfig, SolverConfig,
    SolverKind, TimeConfig, WheelConfig,
};

/// More grains than this are taken for a mistyped unit: their bed would be pressed for hours.
const GRAINS_MAX: f64 = 5e5;

/// Largest diameters that the radius of a round wheel on a layer must have, or it falls between the grains.
const WHEEL_GRAINS: f64 = 2.0;

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
        crate::prescribed_opening::validate(self)?;
        self.validate_together()?;
        self.validate_with_clusters()?;
        self.validate_periodic()
    }

    fn validate_together(&self) -> Result<(), ConfigError> {
        // A compliant bond has a spring in place of friction; a rigid one slides beside its shear.
        if self.solver.kind == SolverKind::Pcg
            && self.law.kind.plain() == LawKind::Cohesion
            && self.law.contact_stiffness_pa.is_none()
            && self.law.friction != Some(0.0)
        {
            return Err(ConfigError::new(
                "solver.kind",
                "\"pcg\" needs a convex problem, and rigid bonds with friction beside their shear make none",
            )
            .help("write solver.kind = \"nsgs\", law.friction = 0, or give law.contact_stiffness_pa"));
        }
        let lid = matches!(&self.sample, SampleConfig::Layer(layer) if layer.lid);
        if lid && self.wheel.is_some() {
            return Err(ConfigError::new(
                "wheel",
                "a layer with a lid is held by the body above it, and there is a wheel",
            )
            .help("remove [participant.config.wheel], or sample.lid"));
        }
        if matches!(self.sample, SampleConfig::Layer(_)) && self.wheel.is_none() && !lid {
            return Err(ConfigError::new(
                "wheel",
                "a layer needs the wheel that holds it, and there is none",
            )
            .help("add [participant.config.wheel], or sample.lid = true"));
        }
        if let (SampleConfig::Layer(layer), Some(wheel)) = (&self.sample, &self.wheel)
            && wheel.radius_m > 0.0
        {
            let least = WHEEL_GRAINS * 2.0 * layer.radius_max_m;
            at_least("wheel.radius_m", wheel.radius_m, least, "m").map_err(|error| {
                error.help("a smaller one falls between the grains; write 0 for a flat face")
            })?;
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

impl Config {
    /// What rigid clusters do not go with.
    fn validate_with_clusters(&self) -> Result<(), ConfigError> {
        let clustered = match &self.sample {
            SampleConfig::Disks(disks) => disks.has_clusters(),
            SampleConfig::Layer(_) => false,
        };
        if !clustered {
            return Ok(());
        }
        let refused = [
            (
                self.solver.kind == SolverKind::Pcg,
                "solver.kind",
                "\"pcg\" solves contacts of single disks only, and sample.disks has clusters",
                "write solver.kind = \"nsgs\"",
            ),
            (
                self.law.kind.plain() == LawKind::Cohesion,
                "law.kind",
                "bonds of clusters are not supported, and sample.disks has clusters",
                "choose law.kind = \"coulomb\" or \"signorini\"",
            ),
            (
                matches!(
                    self.law.penetration,
                    Some(PenetrationKind::Split | PenetrationKind::Projection)
                ),
                "law.penetration",
                "moves single disks apart, and sample.disks has clusters",
                "write penetration = \"gap\" or \"iqs\"",
            ),
        ];
        match refused.into_iter().find(|(holds, ..)| *holds) {
            None => Ok(()),
            Some((_, key, why, help)) => Err(ConfigError::new(key, why).help(help)),
        }
    }
}

impl SolverConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        positive("solver.tolerance", self.tolerance, "")?;
        within("solver.tolerance", self.tolerance, 0.0, 0.1)?;
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
        // A layer thinner than a grain consists of glued ones only.
        at_least(
            "sample.thickness_m",
            self.thickness_m,
            2.0 * self.radius_min_m,
            "m",
        )?;
        self.refuse_a_desert()?;
        at_least("sample.crown_radius_m", self.crown_radius_m, 0.0, "m")?;
        if self.lid && self.crown_radius_m > 0.0 {
            return Err(ConfigError::new(
                "sample.crown_radius_m",
                format!(
                    "a layer with a lid lies between flat faces, got a crown of {} m",
                    self.crown_radius_m
                ),
            )
            .help("write crown_radius_m = 0, or remove sample.lid"));
        }
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

impl LayerConfig {
    /// About how many grains the bed needs: its area over that of a grain of the mean square radius when equal surfaces are
    /// wanted, pi r_min r_max.
    fn refuse_a_desert(&self) -> Result<(), ConfigError> {
        let depth = self.thickness_m + self.bed_extra_m;
        let area = std::f64::consts::PI * self.radius_min_m * self.radius_max_m;
        let grains = 2.0 * self.half_width_m * depth / area;
        if grains <= GRAINS_MAX {
            return Ok(());
        }
        let key = match self.thickness_m > self.half_width_m {
            true => "sample.thickness_m",
            false => "sample.radius_min_m",
        };
        let problem = format!(
            "a bed {:e} m wide and {depth:e} m deep needs about {grains:.1e} grains of {:e} to {:e} m, more than {GRAINS_MAX:.0e}",
            2.0 * self.half_width_m,
            self.radius_min_m,
            self.radius_max_m
        );
        Err(ConfigError::new(key, problem)
            .help("check the units (m): a thinner or narrower layer, or larger grains"))
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
            if disk.lid && !disk.glued {
                return Err(
                    ConfigError::new(&key("lid"), "only a glued disk belongs to the lid")
                        .help("add glued = true"),
                );
            }
        }
        for (i, wall) in self.walls.iter().enumerate() {
            wall.validate(&format!("sample.walls[{i}]"))?;
        }
        self.validate_clusters()
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
        at_least("wheel.radius_m", self.radius_m, 0.0, "m")?;
        finite("wheel.vy_m_per_s", self.vy_m_per_s)?;
        if self.cycles > 0.0 {
            positive("wheel.frequency_hz", self.frequency_hz, "1/s")?;
        }
        Ok(())
    }
}

pub(super) fn required(key: &str, value: Option<f64>, by: &str) -> Result<f64, ConfigError> {
    value.ok_or_else(|| ConfigError::new(key, format!("{by} need it and it is missing")))
}

pub(super) fn positive(key: &str, value: f64, unit: &str) -> Result<(), ConfigError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(ConfigError::new(
        key,
        format!("must be positive, got {value:e}{}", in_brackets(unit)),
    ))
}

pub(super) fn at_least(key: &str, value: f64, minimum: f64, unit: &str) -> Result<(), ConfigError> {
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

pub(super) fn within(key: &str, value: f64, low: f64, high: f64) -> Result<(), ConfigError> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(ConfigError::new(
        key,
        format!("must lie between {low} and {high}, got {value}"),
    ))
}

pub(super) fn finite(key: &str, value: f64) -> Result<(), ConfigError> {
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
