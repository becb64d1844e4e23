//! Boundary conditions of named sets of nodes: a load, a motion, or one of each.

use std::collections::BTreeMap;

use kit::ConfigError;
use kit::keys::refuse_if;
use kit::limits::{positive, required};
use kit::number::PrescribedComponent;
use kit::table::{LoadTable, check_table};
use protocol::Cause;
use schemars::JsonSchema;
use serde::Deserialize;

use super::motion::{MotionTable, ReciprocatingConfig, SetMotion, check_direction, unit};

/// Boundary condition of each named set.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct BoundaryConfig(pub BTreeMap<String, SetConfig>);

/// Boundary condition of one set: a load, a motion, or both, each in its own direction.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SetConfig {
    /// Components (tx, ty) of a traction on the reference edge (Pa), `"free"` for a component without load. No traction when absent.
    pub traction_pa: Option<[PrescribedComponent; 2]>,
    /// Pressure on the reference edge (Pa), against its outward normal; none when absent.
    pub pressure_pa: Option<f64>,
    /// Force of the whole set over time, in entries (s, N), spread evenly over its length: linear between the entries, constant beyond them. No force
    /// when absent.
    pub load_table: Option<LoadTable>,
    /// Direction of the force in `load_table`, of any length but 0; when absent, the only direction that a motion leaves free, towards +x or +y.
    pub load_direction: Option<[f64; 2]>,
    /// Components of the set's velocity (m/s), `"free"` where it may move. No prescribed velocity when absent.
    pub velocity_m_per_s: Option<[PrescribedComponent; 2]>,
    /// Components of the set's displacement at the end of the ramp (m), `"free"` where it may move. No prescribed displacement when absent.
    pub displacement_m: Option<[PrescribedComponent; 2]>,
    /// Displacement of the set over time, in entries (s, m, m): linear between the entries, constant beyond them, and 0 at t = 0; `"free"` in all
    /// entries where the set may move. No prescribed motion when absent.
    pub motion_table: Option<MotionTable>,
    /// Sinusoidal motion to and fro along one direction; none when absent.
    pub motion: Option<ReciprocatingConfig>,
    /// Duration (s) of a linear ramp from zero, for a traction, pressure, velocity or displacement. Without a ramp, absent or 0, the value applies at
    /// once; a displacement other than 0 needs a ramp, and loads and motions over time take none.
    #[schemars(range(min = 0.0))]
    pub ramp_s: Option<f64>,
}

/// Load of a set, once read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SetLoad<'a> {
    Traction([PrescribedComponent; 2]),
    Pressure(f64),
    /// Force over time (s, N) and the unit vector along which it acts.
    Table(&'a LoadTable, [f64; 2]),
}

impl SetConfig {
    /// The given load.
    pub(crate) fn load(&self) -> Option<SetLoad<'_>> {
        let traction = self.traction_pa.map(SetLoad::Traction);
        let given = traction.or(self.pressure_pa.map(SetLoad::Pressure));
        let table = self.load_table.as_ref().zip(self.direction());
        given.or(table.map(|(table, direction)| SetLoad::Table(table, direction)))
    }

    /// The given motion.
    pub(crate) fn prescribed(&self) -> Option<SetMotion<'_>> {
        let velocity = self.velocity_m_per_s.map(SetMotion::Velocity);
        let rate = velocity.or(self.displacement_m.map(SetMotion::Displacement));
        let table = self.motion_table.as_ref().map(SetMotion::Table);
        let to_and_fro = self.motion.as_ref().map(SetMotion::Reciprocating);
        rate.or(table).or(to_and_fro)
    }

    /// Unit vector along which the force of a table acts, where a key gives it.
    fn direction(&self) -> Option<[f64; 2]> {
        let given = self.load_direction.or_else(|| self.only_free())?;
        Some(unit(given))
    }

    /// The only direction that the motion leaves free.
    fn only_free(&self) -> Option<[f64; 2]> {
        match self.prescribed()?.components().map(|component| component.0) {
            [None, Some(_)] => Some([1.0, 0.0]),
            [Some(_), None] => Some([0.0, 1.0]),
            _ => None,
        }
    }

    fn check(&self, set: &str) -> Result<(), ConfigError> {
        self.check_count(set)?;
        let motion = self.prescribed();
        motion.map_or(Ok(()), |motion| motion.check(set))?;
        self.check_table(set)?;
        self.check_directions(set)?;
        self.check_ramp(&format!("boundary.{set}.ramp_s"))
    }

    /// Refuses a ramp without effect, and a displacement without a ramp.
    fn check_ramp(&self, key: &str) -> Result<(), ConfigError> {
        let rate = self.velocity_m_per_s.or(self.displacement_m);
        let follows = rate.or(self.traction_pa).is_some() || self.pressure_pa.is_some();
        refuse_if(
            self.ramp_s.is_some() && !follows,
            key,
            "has no effect on load_table, motion_table and motion, which already vary over time",
            "remove it, and let a table begin with [0.0, 0.0], or set motion.start_s",
        )?;
        let moved =
            |shift: [PrescribedComponent; 2]| shift.iter().any(|d| d.0.is_some_and(|d| d != 0.0));
        let loaded = self.traction_pa.is_some() || self.pressure_pa.is_some();
        refuse_if(
            self.ramp_s.is_some() && !loaded && !rate.is_some_and(moved),
            key,
            "has no effect on a set that is held at rest",
            "remove it",
        )?;
        if self.displacement_m.is_some_and(moved) {
            let ramp = required(key, self.ramp_s, "displacements other than 0")
                .map_err(|error| error.help("add ramp_s = 1e-4, the time (s) of the motion"))?;
            positive(key, ramp, "s")?;
        }
        Ok(())
    }

    /// Refuses a set without a load or motion, and two of a kind.
    fn check_count(&self, set: &str) -> Result<(), ConfigError> {
        let loads = kit::named!(self, is_some; traction_pa, pressure_pa, load_table);
        let motions =
            kit::named!(self, is_some; velocity_m_per_s, displacement_m, motion_table, motion);
        let count = |given: &[(&str, bool)]| given.iter().filter(|(_, given)| *given).count();
        let (loads, motions) = (count(&loads), count(&motions));
        let problem =
            "must hold exactly one load or motion, or a load and a motion in different directions";
        let help = "give one of traction_pa, pressure_pa, load_table, velocity_m_per_s, displacement_m, motion_table, motion; or traction_pa = [\"free\", -1e6] with velocity_m_per_s = [0.1, \"free\"]";
        let one_each = loads + motions > 0 && loads <= 1 && motions <= 1;
        refuse_if(!one_each, &format!("boundary.{set}"), problem, help)
    }

    /// Refuses a wrong table of loads, one without a direction, and a direction without a table.
    fn check_table(&self, set: &str) -> Result<(), ConfigError> {
        let key = |name: &str| format!("boundary.{set}.{name}");
        if let Some(direction) = self.load_direction {
            refuse_if(
                self.load_table.is_none(),
                &key("load_direction"),
                "is the direction of load_table, which is absent",
                "add load_table = [[t_s, n], ...], or remove the key",
            )?;
            check_direction(&key("load_direction"), direction)?;
        }
        let Some(table) = &self.load_table else {
            return Ok(());
        };
        check_table(&key("load_table"), table)?;
        if self.direction().is_some() {
            return Ok(());
        }
        let problem =
            "has no direction: load_direction is missing, and no motion leaves exactly one free";
        Err(ConfigError::new(&key("load_table"), problem)
            .because(Cause::MissingKey)
            .help("write load_direction = [0.0, -1.0] for a force downwards, or a motion with one direction \"free\""))
    }

    /// Refuses a direction that has a load and a motion.
    fn check_directions(&self, set: &str) -> Result<(), ConfigError> {
        let key = format!("boundary.{set}");
        let (Some(load), Some(motion)) = (self.load(), self.prescribed()) else {
            return Ok(());
        };
        refuse_if(
            matches!(load, SetLoad::Pressure(_)),
            &key,
            "has a pressure and a motion, and a pressure may act in both directions",
            "give the component that is not moved as traction_pa = [\"free\", -1e6]",
        )?;
        for (k, direction) in ["x", "y"].into_iter().enumerate() {
            refuse_if(
                load.acts_along(k) && motion.components()[k].0.is_some(),
                &key,
                format!(
                    "has a load and a motion in {direction}, but only one of them is allowed there"
                ),
                "write \"free\" for one of them, or remove load_direction",
            )?;
        }
        Ok(())
    }
}

impl SetLoad<'_> {
    /// The key that gives it.
    pub(crate) fn key(&self) -> &'static str {
        match self {
            SetLoad::Traction(_) => "traction_pa",
            SetLoad::Pressure(_) => "pressure_pa",
            SetLoad::Table(..) => "load_table",
        }
    }

    /// True where it is given along x (0) or y (1).
    fn acts_along(&self, k: usize) -> bool {
        match self {
            SetLoad::Traction(traction) => traction[k].0.is_some(),
            SetLoad::Pressure(_) => true,
            SetLoad::Table(_, direction) => direction[k] != 0.0,
        }
    }
}

impl BoundaryConfig {
    pub(super) fn check(&self) -> Result<(), ConfigError> {
        self.0
            .iter()
            .try_for_each(|(set, config)| config.check(set))
    }

    /// The sets whose motion is prescribed.
    pub(crate) fn moved_sets(&self) -> impl Iterator<Item = &str> {
        let sets = self.0.iter();
        let moved = sets.filter(|(_, config)| config.prescribed().is_some());
        moved.map(|(set, _)| set.as_str())
    }
}
