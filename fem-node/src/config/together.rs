//! Which keys go together.

use protocol::ConfigError;

use super::{
    Analysis, Base, Config, ElementKind, Kinematics, MaterialKind, Plane, SetConfig, Sides, Start,
};

impl Config {
    /// Which laws, planes, elements and strains go together.
    pub(super) fn check_law(&self) -> Result<(), ConfigError> {
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
            None if self.analysis == Analysis::Static => {
                let cycles = self.wheel.map_or(0.0, |wheel| wheel.cycles);
                self.statics.check_cycles(cycles)
            }
            None => Ok(()),
            Some((key, _)) => {
                let problem = "does not go with a static analysis or start, which solve for a supported, linear elastic body";
                Err(ConfigError::new(key, problem)
                    .help("take analysis = \"dynamic\" and start = \"ramp\", or remove the key"))
            }
        }
    }

    /// Without ends there is nothing to hold, load or couple there.
    pub(super) fn check_period(&self) -> Result<(), ConfigError> {
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
    pub(super) fn check_motion(&self) -> Result<(), ConfigError> {
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
    pub(super) fn check_start(&self) -> Result<(), ConfigError> {
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
