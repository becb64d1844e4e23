//! The keys of `[participant.config]` and their limits.
//!
//! In reading order:
//! - [`law`]: the keys `law` and `law.pairs`;
//! - [`solver`]: the key `solver`;
//! - [`radii`], [`fill`], [`drive`], [`disks`], [`mod@file`], [`layer`], [`rail`], [`sample`]: the key `sample` and its three kinds;
//! - [`wheel`]: the key `wheel`;
//! - [`heat`]: the key `heat`;
//! - [`flow`], [`injection`], [`detachment`], [`profile`], [`stress`]: what is fed, measured and checked.

pub mod detachment;
pub mod disks;
pub mod drive;
pub mod file;
pub mod fill;
pub mod flow;
pub mod heat;
pub mod injection;
pub mod law;
pub mod layer;
pub mod profile;
pub mod radii;
pub mod rail;
pub mod sample;
pub mod solver;
pub mod stress;
pub mod surface;
pub mod wheel;

use std::collections::BTreeMap;
use std::f64::consts::PI;

use kit::keys::refuse_if;
use kit::limits::{at_least, refuse_given};
use kit::{ConfigError, Plausible};
use schemars::JsonSchema;
use serde::Deserialize;

use dem_kernel::bodies::pairs::{GRAINS, ROWS, WHEEL};
use detachment::DetachmentConfig;
use flow::FlowConfig;
use heat::HeatConfig;
use injection::InjectionConfig;
use kit::table::last_change;
use kit::wheel::{WheelProgram, moments};
use law::{LawConfig, LawKind};
use layer::PERIOD;
use profile::ProfileConfig;
use sample::SampleConfig;
use solver::{Algorithm, SolverConfig};
use stress::StressConfig;
use wheel::{DemWheelConfig, FaceKind};

/// Least radius of a round wheel on a layer, in diameters of the largest grain: a smaller wheel falls between the grains.
const WHEEL_GRAINS: f64 = 2.0;

/// Everything that a scenario says about the third body. SI units, the unit in each key.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DemConfig {
    /// The law of all contacts, also with the wheel, walls and glued disks; `law.pairs` lists exceptions.
    pub law: LawConfig,
    /// The solver of the contact problem of a step, and its stopping criteria.
    pub solver: SolverConfig,
    /// Time step, its bounds, and the weight of the time integration.
    pub time: DemTimeConfig,
    /// Density of the grains (kg/m3).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub density_kg_per_m3: f64,
    /// Factor on the inertia of the grains, at least 1, which allows longer steps; loads, weights and the wheel's mass are never scaled.
    #[serde(default = "kit::number::one::<f64>")]
    #[schemars(range(min = 1.0))]
    pub mass_scale: f64,
    /// Acceleration of gravity along x and y (m/s2); it acts on the unscaled masses.
    #[serde(default)]
    pub gravity_m_per_s2: [f64; 2],
    /// The source of the grains.
    pub sample: SampleConfig,
    /// The rigid wheel above the grains; no wheel when absent.
    pub wheel: Option<DemWheelConfig>,
    /// Prescribed motion that opens or closes the only contact of a pair of disks; none when absent.
    pub drive: Option<DriveConfig>,
    /// Means over slices of the sample and intervals of time; none when absent.
    pub profile: Option<ProfileConfig>,
    /// Stress in cells and in the whole sample; none when absent.
    pub stress: Option<StressConfig>,
    /// Flows of third body through the contact; not measured when absent.
    pub flow: Option<FlowConfig>,
    /// Grains that are fed in from outside; none when absent.
    pub injection: Option<InjectionConfig>,
    /// Steel that comes off bare surfaces as grains; none when absent.
    pub detachment: Option<DetachmentConfig>,
    /// Temperatures of the grains; they have none when absent.
    pub heat: Option<HeatConfig>,
    /// Seed of random displacements of the free grains, each by up to 1e-12 of its radius: a result that then differs from the run without them
    /// differs by noise. Nothing is displaced when absent.
    pub perturb_seed: Option<u64>,
    /// Bounds `[warn, suspect]` of the checks of plausibility; an absent check keeps its own.
    #[serde(default)]
    pub plausible: DemPlausible,
}

/// The table `plausible` of a participant of grains.
pub type DemPlausible = Plausible<DemTable>;

/// The name of this table where checks are declared.
#[derive(Clone, Debug, PartialEq)]
pub struct DemTable;

impl kit::bounds::Table for DemTable {
    const NAME: &'static str = "dem";
}

/// `time`: time step, its bounds, and the weight of the time integration.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DemTimeConfig {
    /// Step of a run alone (s), which must have one. A coupled run steps by its windows and refuses the key.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub step_s: Option<f64>,
    /// Weight of the velocity at the end of a step in the motion over the step, 0.5 to 1. A coupled run needs 1.
    #[serde(default = "kit::number::one::<f64>")]
    #[schemars(range(min = 0.5, max = 1.0))]
    pub theta: f64,
    /// Expected mean stress P of the scene (Pa). It sets the bound t_i = d sqrt(rho/P) on the step, d being the mean diameter and rho the scaled
    /// density. `detachment.growth_s` defaults to 100 t_i.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub pressure_pa: f64,
    /// True accepts a step above t_i, or with fewer than 20 steps in a period of the wheel; both are refused otherwise.
    #[serde(default)]
    pub unsafe_step: bool,
    /// End of the body's history (s), where neither `wheel` nor `drive` ends it; when absent, `run.end_s` or another participant ends the run.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub end_s: Option<f64>,
}

/// Prescribed motion of the only grain along the line from the only glued disk, over 30 openings sqrt(w/Cn) in
/// 100 000 steps; the step follows.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DriveConfig {
    /// Opening velocity (m/s); a negative one closes the contact.
    pub velocity_m_per_s: f64,
}

impl DemConfig {
    /// The configuration with its layer widened for the wheel's load (see [`layer::LayerConfig::half_width_load_n`]).
    ///
    /// # Errors
    /// There is no load for this rule.
    pub fn resolved(&self) -> Result<DemConfig, ConfigError> {
        let mut resolved = self.clone();
        let SampleConfig::Layer(layer) = &self.sample else {
            return Ok(resolved);
        };
        let key = "sample.half_width_load_n";
        let load = self.wheel.as_ref().map_or(0.0, |wheel| wheel.load_n);
        refuse_if(
            layer.half_width_load_n.is_some() && (load <= 0.0 || layer.periodic_x_m.is_some()),
            key,
            "makes the half-width follow the load of a wheel, and there is no such wheel, or the layer repeats",
            "remove it: half_width_m alone says how wide the layer is",
        )?;
        resolved.sample = SampleConfig::Layer(layer.under(load));
        Ok(resolved)
    }

    /// Load and motion of the wheel, where there is one, of a configuration that [`DemConfig::validate`] accepts.
    pub(crate) fn program(&self) -> Option<WheelProgram> {
        self.wheel.as_ref()?.program(self.repeats_after()).ok()
    }

    /// Distance along x after which the grains repeat (m), if they do.
    fn repeats_after(&self) -> Option<f64> {
        let [from, to] = self.sample.period_ends()?;
        Some(to - from)
    }

    /// Times (s) from which keys have had an effect: the history of the wheel, loads over time, the first fed grain, the wear time, before which no
    /// grain is worn, and the moment of the stress.
    pub fn moments(&self, first_fed_s: Option<f64>) -> BTreeMap<String, f64> {
        let flow = self.flow.filter(|_| self.sample.period().is_none());
        let mut all = moments([
            ("injection.start_s", first_fed_s),
            ("flow.wear_s", flow.map(|flow| flow.wear_s)),
            ("stress.at_s", self.stress.and_then(|stress| stress.at_s)),
        ]);
        all.extend(self.program().iter().flat_map(WheelProgram::moments));
        if let SampleConfig::Disks(disks) = &self.sample {
            for (i, cluster) in disks.clusters.iter().enumerate() {
                let mut drives = cluster.drive.iter();
                let last_s = drives.find_map(|drive| last_change(drive.load_table.as_ref()));
                let key = format!("sample.clusters[{i}].drive.load_table");
                all.extend(moments([(&*key, last_s)]));
            }
        }
        all
    }

    /// Unscaled mass of a disk (kg) of this radius and thickness (m).
    pub fn real_mass(&self, radius: f64, thickness: f64) -> f64 {
        self.density_kg_per_m3 * PI * radius * radius * thickness
    }

    /// Refuses keys that contradict each other, with the key, the value and a remedy. [`kit::read_config`] has refused values out of range.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.law.validate()?;
        self.solver.validate()?;
        self.plausible.check("plausible")?;
        self.sample.validate()?;
        if let Some(wheel) = &self.wheel {
            let program = wheel.program(self.repeats_after())?;
            if let Some(rolling) = &program.rolling {
                let half_width = self.sample.ends().map_or(f64::INFINITY, |[half, _]| half);
                let ends = [-half_width, half_width].map(|x| self.sample.middle() + x);
                // A pair may give the wheel a friction of its own.
                let friction = self.law.friction.filter(|_| self.law.pairs.is_empty());
                let limit = friction.map_or(f64::INFINITY, |friction| friction * wheel.load_n);
                rolling.check_on(ends, limit, true)?;
            }
            wheel.validate_on(&self.sample, &self.law)?;
        }
        if let Some(profile) = &self.profile {
            let wheel = self.program().map(|program| program.end());
            profile.validate(wheel.or(self.time.end_s))?;
        }
        if let Some(stress) = &self.stress {
            let held = self.wheel.as_ref().is_some_and(|wheel| wheel.hold_s > 0.0);
            stress.validate(2.0 * self.sample.radii().0, held)?;
        }
        if let Some(flow) = &self.flow {
            let gravity = self.gravity_m_per_s2;
            flow.validate(&self.law, &self.sample, self.wheel.as_ref(), gravity)?;
        }
        if let Some(injection) = &self.injection {
            injection.validate(&self.law, self.flow.as_ref(), self.gravity_m_per_s2)?;
        }
        if let Some(detachment) = &self.detachment {
            let (injection, gravity) = (self.injection.as_ref(), self.gravity_m_per_s2);
            detachment.validate(&self.law, &self.sample, injection, gravity)?;
        }
        if let Some(heat) = &self.heat {
            let lateral = self.flow.is_some_and(|flow| flow.lateral.is_some());
            let fed = self.injection.is_some() || self.detachment.is_some();
            heat.validate(fed || lateral, &self.groups())?;
            if let Some(softening) = &heat.softening {
                let surface = self.sample.surface().and_then(|keys| keys.friction);
                softening.validate(&self.law, surface)?;
            }
            if let SampleConfig::Disks(sample) = &self.sample {
                refuse_if(
                    sample.grains() == 0,
                    "heat",
                    "needs a grain with a temperature of its own, and all disks are glued or in clusters",
                    "free one of them, or remove `heat`",
                )?;
            }
        }
        self.validate_drive()?;
        self.validate_together()?;
        self.validate_pairs()?;
        self.validate_periodic()
    }

    /// Refuses a feed of more grains than a scene of this thickness (m) can hold.
    pub fn validate_feed(&self, thickness: f64) -> Result<(), ConfigError> {
        let (radius, _) = self.sample.radii();
        match &self.injection {
            None => Ok(()),
            Some(injection) => injection.refuse_too_many(self.real_mass(radius, thickness)),
        }
    }

    /// Names of the bodies of the scene, grains first.
    fn groups(&self) -> Vec<&str> {
        let mut groups = vec![GRAINS];
        groups.extend(self.wheel.as_ref().map(|_| WHEEL));
        match &self.sample {
            SampleConfig::Disks(sample) => groups.extend(sample.groups()),
            SampleConfig::Layer(layer) => groups.extend(&ROWS[..1 + usize::from(layer.lid)]),
            SampleConfig::Rail(_) => groups.extend(&ROWS[..1]),
        }
        groups
    }

    /// Refuses pairs that the scene does not have.
    fn validate_pairs(&self) -> Result<(), ConfigError> {
        if let SampleConfig::Disks(sample) = &self.sample {
            sample.validate_names()?;
        }
        self.law.validate_pairs(&self.groups())?;
        self.refuse_idle_pairs()
    }

    /// Refuses pairs whose keys can have no effect.
    fn refuse_idle_pairs(&self) -> Result<(), ConfigError> {
        let mut fixed = vec![WHEEL, ROWS[0], ROWS[1]];
        let mut glued = true;
        let mut grains = usize::MAX;
        match &self.sample {
            SampleConfig::Disks(sample) => {
                if self.injection.is_none() && self.detachment.is_none() {
                    grains = sample.grains();
                }
                fixed.extend(sample.walls.iter().filter_map(|wall| wall.name.as_deref()));
                glued = sample.disks.iter().any(|disk| disk.glued && !disk.lid);
            }
            SampleConfig::Layer(layer) => glued = layer.glued,
            SampleConfig::Rail(_) => {}
        }
        // A smooth wheel lies on glued disks where no grains are left between them.
        let wheel = self.wheel.as_ref();
        let smooth = wheel.is_some_and(|wheel| wheel.face == FaceKind::Flat);
        let lies_on_rows = |a: &str, b: &str| smooth && a == WHEEL && ROWS.contains(&b);
        let own = self.sample.surface().and_then(|keys| keys.friction);
        let bare = !glued && own.is_some();
        for (i, pair) in self.law.pairs.iter().enumerate() {
            let key = format!("law.pairs[{i}]");
            let is_fixed = |name: &String| fixed.contains(&name.as_str());
            let [a, b] = &pair.between;
            let refusals = [
                (
                    pair.has_no_law(),
                    "",
                    "has nothing of its own, so that the entry has no effect",
                    "give it friction, rolling, adhesion, healing, restitution, damping or a stiffness, or remove it",
                ),
                (
                    is_fixed(a) && is_fixed(b) && !lies_on_rows(a, b) && !lies_on_rows(b, a),
                    ".between",
                    "never touch each other: only grains and clusters have contacts, and a smooth wheel on glued disks; the entry has no effect",
                    "pair one of them with `grains` or a cluster, or remove the entry",
                ),
                (
                    pair.between.iter().filter(|name| **name == GRAINS).count() > grains,
                    ".between",
                    "has no contact: too few disks are grains, which belong to no cluster and are not glued; the entry has no effect",
                    "name clusters, walls or rows, or remove the entry",
                ),
                (
                    a == b && a != GRAINS && !is_fixed(a),
                    ".between",
                    "are one rigid body without contacts within, and the entry has no effect",
                    "pair the cluster with `grains` or another body, or remove the entry",
                ),
                (
                    bare && pair.friction.is_some()
                        && pair.between.iter().any(|name| name == ROWS[0]),
                    ".friction",
                    "has no effect: nothing is glued to the surface, and sample.surface.friction is its friction",
                    "remove one of the two",
                ),
            ];
            refusals
                .into_iter()
                .try_for_each(|(holds, end, why, help)| {
                    refuse_if(holds, &format!("{key}{end}"), why, help)
                })?;
        }
        Ok(())
    }

    fn validate_together(&self) -> Result<(), ConfigError> {
        self.validate_pcg()?;
        self.validate_wheel_on_sample()?;
        refuse_if(
            self.sample.has_clusters() && self.law.penetration().repairs(),
            "law.penetration",
            "moves single disks apart, and sample.disks has clusters",
            "write penetration = \"gap\" or \"iqs\"",
        )?;
        refuse_if(
            self.wheel.is_some() && self.time.end_s.is_some(),
            "time.end_s",
            "the wheel's history already ends the run",
            "remove the key, or change wheel.hold_s or wheel.cycles",
        )
    }

    /// Refuses the conjugate gradient where the problem is not convex, or has couples or several laws.
    fn validate_pcg(&self) -> Result<(), ConfigError> {
        if self.solver.algorithm != Algorithm::Pcg {
            return Ok(());
        }
        let (law, pairs) = (&self.law, &self.law.pairs);
        let own = self.sample.surface().and_then(|keys| keys.friction);
        let warm = self.heat.as_ref().and_then(|heat| heat.softening.as_ref());
        let nsgs = "write solver.kind = \"nsgs\"";
        let refusals = [
            // A compliant bond has a spring in place of friction; a rigid bond has friction in addition to its shear.
            (
                law.kind.plain() == LawKind::Cohesion
                    && law.contact_stiffness_pa.is_none()
                    && law.friction != Some(0.0),
                "\"pcg\" needs a convex problem, and rigid bonds with shear and friction make none",
                "write solver.kind = \"nsgs\", law.friction = 0, or give law.contact_stiffness_pa",
            ),
            (
                law.healing.is_some() || pairs.iter().any(|pair| pair.healing.is_some()),
                "\"pcg\" needs a convex problem, and law.healing adds friction to the shear of bonds",
                nsgs,
            ),
            (
                law.rolling.is_some() || pairs.iter().any(|pair| pair.rolling.is_some()),
                "\"pcg\" solves no couples, and law.rolling adds them",
                nsgs,
            ),
            (
                own.is_some()
                    || !pairs.is_empty()
                    || warm.is_some_and(|warm| !warm.friction.is_empty()),
                "\"pcg\" solves contacts of one law, and law.pairs, sample.surface.friction or heat.softening.friction has others",
                nsgs,
            ),
        ];
        refusals
            .into_iter()
            .try_for_each(|(holds, why, help)| refuse_if(holds, "solver.kind", why, help))
    }

    /// Refuses layers and rails that nothing holds, and wheels that fall between the grains.
    fn validate_wheel_on_sample(&self) -> Result<(), ConfigError> {
        let (lid, largest) = match &self.sample {
            SampleConfig::Disks(_) => return Ok(()),
            SampleConfig::Rail(rail) => {
                refuse_if(
                    self.wheel.is_none(),
                    "wheel",
                    "a rail needs a wheel that loads it",
                    "add [participant.config.wheel]",
                )?;
                (false, rail.radius_max_m)
            }
            SampleConfig::Layer(layer) => (layer.lid, layer.radius_max_m),
        };
        refuse_if(
            lid && self.wheel.is_some(),
            "wheel",
            "a layer with a lid is held by the body above it, and there is a wheel",
            "remove [participant.config.wheel], or sample.lid",
        )?;
        refuse_if(
            self.wheel.is_none() && !lid,
            "wheel",
            "a layer needs a wheel that holds it",
            "add [participant.config.wheel], or sample.lid = true",
        )?;
        let radius = self.wheel.as_ref().map(|wheel| wheel.radius_m);
        let (round, least) = (radius.filter(|r| *r > 0.0), WHEEL_GRAINS * 2.0 * largest);
        let help = "a smaller one falls between the grains; write 0 for a flat face";
        at_least("wheel.radius_m", round, least, "m").map_err(|error| error.help(help))
    }

    /// Refuses keys that contradict a strip that repeats.
    fn validate_periodic(&self) -> Result<(), ConfigError> {
        let Some(ends) = self.sample.period_ends() else {
            return Ok(());
        };
        self.sample.validate_strip(ends)?;
        let radius = self.wheel.as_ref().map_or(0.0, |wheel| wheel.radius_m);
        refuse_if(
            0.0 < radius && radius < ends[1] - ends[0],
            "wheel.radius_m",
            "is less than sample.periodic_x_m: the wheel would meet its own image",
            "raise the radius, write 0 for a flat face, or shorten the strip",
        )?;
        match self.drive {
            None => Ok(()),
            Some(_) => Err(ConfigError::new(
                PERIOD,
                "a driven pair does not repeat along x",
            )),
        }
    }

    /// Refuses scenes that a drive cannot move.
    fn validate_drive(&self) -> Result<(), ConfigError> {
        let Some(drive) = &self.drive else {
            return Ok(());
        };
        if drive.velocity_m_per_s == 0.0 {
            return Err(ConfigError::new("drive.velocity_m_per_s", "must not be 0")
                .help("a positive velocity opens the contact, a negative one closes it"));
        }
        let pair = match &self.sample {
            SampleConfig::Disks(sample) => {
                sample.disks.len() == 2 && sample.disks.iter().filter(|d| d.glued).count() == 1
            }
            SampleConfig::Layer(_) | SampleConfig::Rail(_) => false,
        };
        refuse_if(
            !pair || self.wheel.is_some(),
            "drive",
            "moves one grain from one glued disk, and the sample is not such a pair",
            "list two disks in sample.disks, one with glued = true, and no wheel",
        )?;
        if let SampleConfig::Disks(sample) = &self.sample {
            for (i, disk) in sample.disks.iter().enumerate() {
                disk.refuse_velocity(
                    !disk.glued,
                    &format!("sample.disks[{i}]"),
                    "has no effect: `drive` moves this disk",
                    "remove it; drive.velocity_m_per_s gives the velocity",
                )?;
            }
            let centres = [&sample.disks[0], &sample.disks[1]].map(|disk| [disk.x_m, disk.y_m]);
            refuse_if(
                centres[0] == centres[1],
                "sample.disks[1]",
                "has its centre where sample.disks[0] has it, and `drive` moves one along the line from the other",
                "move one of them",
            )?;
        }
        if self.law.contact_stiffness_pa.is_none() {
            return Err(ConfigError::new(
                "law.contact_stiffness_pa",
                "is missing: nothing could stop the prescribed motion of a rigid pair",
            ));
        }
        refuse_given(
            [
                ("time.step_s", self.time.step_s.is_some()),
                ("time.end_s", self.time.end_s.is_some()),
            ],
            "follows from drive.velocity_m_per_s: the pair moves by 30 delta_0 in 100 000 steps",
            "remove the key",
        )
    }
}
