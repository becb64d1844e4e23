//! Keys that must go together.

use fem_kernel::element::body::ElementKind;
use kit::ConfigError;
use kit::keys::refuse_if;
use protocol::Cause;

use super::boundary::SetConfig;
use super::choice::{Analysis, Base, ContactEdge, Kinematics, Plane, Sides, Start};
use super::heat::HeatSources;
use super::keys::FemConfig;
use super::material::MaterialKind;
use super::probe;

impl FemConfig {
    /// Refuses keys that do not go together; mesh and step are judged where they are built.
    pub fn check(&self) -> Result<(), ConfigError> {
        self.material.check()?;
        self.boundary.check()?;
        probe::check(&self.probes)?;
        self.plausible.check("plausible")?;
        self.check_wheel()?;
        self.statics
            .check(self.wheel.as_ref().map_or(0.0, |wheel| wheel.load_n))?;
        self.check_law()?;
        self.check_period()?;
        self.check_boundary()?;
        self.check_initial()?;
        self.check_reduced()?;
        self.check_heat()
    }

    /// True where an equilibrium is solved for.
    fn solves_equilibrium(&self) -> bool {
        self.analysis == Analysis::Static || self.start == Start::Static
    }

    /// Keys that have no effect on this kind of analysis. Scenes share a body with its wheel, steps and start between a dynamic and a static run, and
    /// these keys do not count.
    pub(crate) fn unused_keys(&self) -> Vec<&'static str> {
        let (time, statics) = (&self.time, &self.statics);
        let is_static = self.analysis == Analysis::Static;
        let wheel = self.wheel.as_ref();
        let cycles = wheel.is_some_and(|wheel| wheel.cycles > 0.0);
        let rolling = wheel.and_then(|wheel| wheel.rolling.as_ref());
        let rolls = rolling.is_some();
        let ramps = |set: &SetConfig| set.ramp_s.is_some() && set.load().is_some();
        let ramps = self.boundary.0.values().any(ramps);
        let bare_static = is_static && wheel.is_none();
        let heat = self.heat.as_ref();
        let elastic = self.material.law() == MaterialKind::Elastic;
        let sources = heat.map_or_else(HeatSources::default, |heat| heat.sources);
        let keys = [
            ("time.end_s", is_static && time.end_s.is_some()),
            ("time.safety", is_static && time.safety.is_some()),
            ("time.unsafe_step", is_static && time.unsafe_step),
            (
                "time.mass_damping_per_s",
                is_static && time.mass_damping_per_s.is_some(),
            ),
            (
                "time.stiffness_damping_s",
                is_static && time.stiffness_damping_s.is_some(),
            ),
            ("boundary.<set>.ramp_s", is_static && ramps),
            (
                "heat.every_steps",
                is_static && heat.is_some_and(|heat| heat.every_steps.is_some()),
            ),
            (
                "heat.sources.friction",
                wheel.is_none() && sources.friction.is_some(),
            ),
            ("heat.sources.plastic", elastic && sources.plastic.is_some()),
            (
                "statics.increment_n",
                (!self.solves_equilibrium() || bare_static) && statics.increment_n.is_some(),
            ),
            (
                "statics.increments_per_cycle",
                !(is_static && cycles) && statics.increments_per_cycle.is_some(),
            ),
            (
                "statics.rolling_increment_m",
                !(is_static && rolls) && statics.rolling_increment_m.is_some(),
            ),
        ];
        let unused = keys.into_iter().filter(|(_, unused)| *unused);
        unused.map(|(key, _)| key).collect()
    }

    /// Wheel, contact and the keys that make sense only with them.
    fn check_wheel(&self) -> Result<(), ConfigError> {
        let start_damping = self.time.start_mass_damping_per_s;
        let (wheel, contact) = (self.wheel.is_some(), self.contact.is_some());
        refuse_if(
            !wheel && !contact && start_damping.is_some(),
            "time.start_mass_damping_per_s",
            "acts until the wheel starts to move, but the body has no wheel",
            "remove it, or write mass_damping_per_s for the whole run",
        )?;
        refuse_if(
            !wheel && !contact && self.start == Start::Static,
            "start",
            "\"static\" starts from a body loaded by its wheel, but the body has no wheel",
            "add [participant.config.wheel], or remove `start`",
        )?;
        refuse_if(
            wheel && !contact,
            "contact",
            "the wheel needs a coefficient of friction",
            "add contact = { friction = 0.3 }, or 0 for a smooth wheel",
        )?;
        refuse_if(
            contact && !wheel,
            "wheel",
            "is required with `contact`, which describes the contact with the wheel",
            "add [participant.config.wheel], or remove `contact`",
        )?;
        let Some(wheel) = &self.wheel else {
            return Ok(());
        };
        refuse_if(
            wheel.load_table.is_some() && self.solves_equilibrium(),
            "wheel.load_table",
            "is a load over time, but a static analysis or start reaches wheel.load_n by increments, without time",
            "remove the table, or take analysis = \"dynamic\" and start = \"ramp\"",
        )?;
        refuse_if(
            self.analysis == Analysis::Dynamic && self.time.end_s.is_some(),
            "time.end_s",
            "the wheel's history already ends the run",
            "remove the key, or change wheel.hold_s or wheel.cycles",
        )
    }

    /// Law, plane, element and measure of strain.
    fn check_law(&self) -> Result<(), ConfigError> {
        let plastic = self.material.law() == MaterialKind::J2;
        let corotational = self.kinematics == Kinematics::Corotational;
        refuse_if(
            plastic && self.plane == Plane::Stress,
            "plane",
            "\"stress\" does not go with a j2 material",
            "take plane = \"strain\": the return to the yield surface keeps ezz = 0, not szz = 0",
        )?;
        refuse_if(
            corotational && self.element() == ElementKind::Q4MeanDilatation,
            "kinematics",
            "\"corotational\" does not go with the element q4_bbar",
            "take q4_1point or q4_2x2: the mean dilatation holds for small strain only",
        )?;
        refuse_if(
            corotational && plastic,
            "kinematics",
            "\"corotational\" does not go with a j2 material",
            "take kinematics = \"small\", or an elastic material: no exact solution verifies the pair yet",
        )?;
        let damped = self.time.stiffness_damping_s.is_some_and(|time| time > 0.0);
        refuse_if(
            damped && (plastic || corotational),
            "time.stiffness_damping_s",
            "needs the stiffness of a linear elastic body in small strain",
            "remove it, or the yield stress and kinematics = \"corotational\"; time.mass_damping_per_s goes with any law",
        )?;
        if !self.solves_equilibrium() {
            return Ok(());
        }
        for (refused, key) in [
            (plastic, "material.yield_pa"),
            (corotational, "kinematics"),
            (self.base == Base::Free, "base"),
        ] {
            refuse_if(
                refused,
                key,
                "does not go with a static analysis or start, which solve for a supported, linear elastic body",
                "take analysis = \"dynamic\" and start = \"ramp\", or remove the key",
            )?;
        }
        if self.analysis == Analysis::Static {
            let cycles = self.wheel.as_ref().map_or(0.0, |wheel| wheel.cycles);
            self.statics.check_cycles(cycles)?;
        }
        Ok(())
    }

    /// A periodic body has no ends to hold, load or couple.
    fn check_period(&self) -> Result<(), ConfigError> {
        if !self.mesh.periodic_x() {
            return Ok(());
        }
        let ends = |name: &&String| ["left", "right"].contains(&name.as_str());
        let end = self.boundary.0.keys().find(ends);
        refuse_if(
            end.is_some(),
            &format!("boundary.{}", end.map_or("", |name| name)),
            "is not an edge of a body with mesh.periodic_x, whose left and right edge are one",
            "remove the set, or write mesh.periodic_x = false",
        )?;
        refuse_if(
            self.sides == Sides::FixedX,
            "sides",
            "\"fixed_x\" holds the ends of a body, but mesh.periodic_x makes its left and right edge one",
            "remove `sides`, or write mesh.periodic_x = false",
        )
    }

    /// Checks sets with a prescribed motion, a load over time or a ramp: motions and loads over time need time, a contact cannot move an edge with a
    /// prescribed motion, and a ramp would take away the full tractions of a static start.
    fn check_boundary(&self) -> Result<(), ConfigError> {
        self.refuse_set(
            |set| self.solves_equilibrium() && set.prescribed().is_some(),
            "",
            "a prescribed motion does not go with a static analysis or start",
            "give a traction, or take analysis = \"dynamic\" and start = \"ramp\"",
        )?;
        refuse_if(
            self.wheel.is_some() && self.boundary.moved_sets().any(|set| set == "top"),
            "boundary.top",
            "moves the edge that the wheel touches",
            "remove the motion or the wheel",
        )?;
        self.refuse_set(
            |set| self.solves_equilibrium() && set.load_table.is_some(),
            ".load_table",
            "is a load over time, and a static analysis or start solves at a fixed load, without time",
            "give its force over the length of the set and run.thickness_m as traction_pa, or take analysis = \"dynamic\" and start = \"ramp\"",
        )?;
        self.refuse_set(
            |set| self.start == Start::Static && set.ramp_s.is_some_and(|ramp| ramp > 0.0),
            ".ramp_s",
            "a static start already carries the full traction",
            "remove the ramp, or write start = \"ramp\"",
        )
    }

    /// An initial velocity needs a body that moves and has no wheel.
    fn check_initial(&self) -> Result<(), ConfigError> {
        let Some(set) = self.initial.0.keys().next() else {
            return Ok(());
        };
        let key = format!("initial.{set}");
        refuse_if(
            self.solves_equilibrium(),
            &key,
            "a velocity does not go with a static analysis or start",
            "take analysis = \"dynamic\" and start = \"ramp\", or remove the key",
        )?;
        refuse_if(
            self.wheel.is_some(),
            &key,
            "does not go with a wheel, which touches the body at rest when the run starts",
            "remove the key or the wheel",
        )
    }

    /// Refuses a reduced body that is not a supported linear one in motion, loaded by forces only.
    fn check_reduced(&self) -> Result<(), ConfigError> {
        let Some(reduced) = &self.reduced else {
            return Ok(());
        };
        let help = "give modes = 50, or omega_max_per_s";
        let count =
            usize::from(reduced.modes.is_some()) + usize::from(reduced.omega_max_per_s.is_some());
        refuse_if(count > 1, "reduced", "has two numbers of modes", help)?;
        let missing = |error: ConfigError| error.because(Cause::MissingKey);
        refuse_if(count == 0, "reduced", "has no number of modes", help).map_err(missing)?;
        let is_plastic = self.material.law() == MaterialKind::J2;
        let is_damped = self.time.stiffness_damping_s.is_some_and(|time| time > 0.0);
        let set = self.initial.0.keys().next();
        let initial = format!("initial.{}", set.map_or("", |set| set));
        let turns = self.kinematics == Kinematics::Corotational;
        for (holds, key) in [
            (self.analysis == Analysis::Static, "analysis"),
            (self.wheel.is_some(), "wheel"),
            (is_plastic, "material.yield_pa"),
            (turns, "kinematics"),
            (self.base == Base::Free, "base"),
            (is_damped, "time.stiffness_damping_s"),
            (set.is_some(), &initial),
        ] {
            refuse_if(
                holds,
                key,
                "does not go with `reduced`: its modes describe a supported, linear elastic body in small strain that starts at rest, without a wheel of its own and without stiffness damping",
                "change the key, or remove `reduced`",
            )?;
        }
        self.refuse_set(
            |set| set.prescribed().is_some(),
            "",
            "moves nodes, but the modes of `reduced` belong to nodes that forces move",
            "remove `reduced`, or give the set a load",
        )
    }

    /// Refuses bodies whose heat has no mesh, no time or no way.
    fn check_heat(&self) -> Result<(), ConfigError> {
        let Some(heat) = &self.heat else {
            return Ok(());
        };
        let edge = self.mesh.contact_edge();
        let wheel = self.wheel.as_ref();
        let moves = wheel.is_some_and(|wheel| wheel.rolling.is_some() || wheel.cycles > 0.0);
        let (shared, half_space) = (heat.wheel_share != 0.0, heat.wheel_half_space.is_some());
        let ends = ["left", "right"].map(|end| heat.edges.contains_key(end));
        let refusals = [
            (
                edge.is_none(),
                "heat",
                "needs a structured mesh: its layers lie at the contact edge",
                "give mesh.width_m and the other sizes, or remove `heat`",
            ),
            (
                edge == Some(ContactEdge::Bottom) && self.wheel.is_some(),
                "heat",
                "has its layers at the contact edge, and the wheel acts on the upper edge",
                "take mesh.contact_edge = \"top\", or remove `heat`",
            ),
            (
                self.analysis == Analysis::Static && !moves,
                "heat",
                "takes the time of a static analysis from its moving wheel, which is missing",
                "give wheel.rolling or wheel.cycles, or take analysis = \"dynamic\"",
            ),
            (
                wheel.is_none() && (shared || half_space),
                if shared {
                    "heat.wheel_share"
                } else {
                    "heat.wheel_half_space"
                },
                "has no effect without a wheel of the body's own",
                "remove it",
            ),
            (
                shared && half_space,
                "heat.wheel_share",
                "is given, and follows from heat.wheel_half_space",
                "remove one of the two",
            ),
            (
                half_space
                    && heat
                        .edges
                        .get("top")
                        .is_some_and(|edge| edge.held_k.is_some()),
                "heat.edges.top.held_k",
                "holds the edge at a temperature, and heat.wheel_half_space exchanges heat with it",
                "remove one of the two",
            ),
            (
                heat.alpha_per_k.is_some()
                    && (self.reduced.is_some()
                        || self.analysis == Analysis::Static
                        || self.kinematics == Kinematics::Corotational),
                "heat.alpha_per_k",
                "expands bodies in motion and in small strain, not with `reduced`, analysis = \"static\" or kinematics = \"corotational\"",
                "remove the key, or the other one",
            ),
            (
                self.material.law() == MaterialKind::Elastic && heat.softening.is_some(),
                "heat.softening.yield_stress",
                "has no effect on an elastic material",
                "give material.yield_pa, or remove the key",
            ),
            (
                self.mesh.periodic_x() && ends.contains(&true),
                "heat.edges",
                "names an end of a body that repeats along x and has none",
                "remove left and right",
            ),
        ];
        refusals
            .into_iter()
            .try_for_each(|(holds, key, why, help)| refuse_if(holds, key, why, help))?;
        heat.check_tables()?;
        heat.conditions().map(|_| ())
    }

    /// Refuses the first set of the boundary that is `wrong`, at one of its keys.
    fn refuse_set(
        &self,
        wrong: impl Fn(&SetConfig) -> bool,
        key: &str,
        why: &str,
        help: &str,
    ) -> Result<(), ConfigError> {
        let mut sets = self.boundary.0.iter();
        sets.try_for_each(|(name, set)| {
            refuse_if(wrong(set), &format!("boundary.{name}{key}"), why, help)
        })
    }
}
