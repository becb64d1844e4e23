//! Boundary conditions of named sets of nodes: a load, or the motion itself, or one of each.

use std::collections::BTreeMap;

use kit::ConfigError;
use kit::keys::refuse_if;
use kit::limits::{not_negative, positive};
use kit::number::PrescribedComponent;
use kit::table::{LoadTable, check_table};
use protocol::Cause;
use schemars::JsonSchema;
use serde::Deserialize;

/// Boundary condition of each named set.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct BoundaryConfig(pub BTreeMap<String, SetConfig>);

/// Boundary condition of one set: a load, a motion, or both, each in its own direction.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SetConfig {
    /// Components (tx, ty) of a traction on the reference edge (Pa), or `"free"` where there is none.
    pub traction_pa: Option<[PrescribedComponent; 2]>,
    /// Pressure on the reference edge, against its outward normal (Pa).
    pub pressure_pa: Option<f64>,
    /// Force of the whole set over time (s, N), spread evenly over its length: linear between the entries, constant beyond them.
    pub load_table: Option<LoadTable>,
    /// Direction of that force, of any length but 0; when absent the only one that a motion leaves free, towards +x or +y.
    pub load_direction: Option<[f64; 2]>,
    /// Components of the velocity (m/s), or `"free"` where the set may move.
    pub velocity_m_per_s: Option<[PrescribedComponent; 2]>,
    /// Components of the displacement at the end of the ramp (m), or `"free"`.
    pub displacement_m: Option<[PrescribedComponent; 2]>,
    /// Duration of a linear ramp from zero (s), of tractions, pressures and motions alike; at once when absent or 0, which a
    /// displacement cannot be.
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

/// Motion of a set, once read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SetMotion {
    Velocity([PrescribedComponent; 2]),
    Displacement([PrescribedComponent; 2]),
}

impl SetConfig {
    /// The load that is given.
    pub(crate) fn load(&self) -> Option<SetLoad<'_>> {
        let traction = self.traction_pa.map(SetLoad::Traction);
        let given = traction.or(self.pressure_pa.map(SetLoad::Pressure));
        let table = self.load_table.as_ref().zip(self.direction());
        given.or(table.map(|(table, direction)| SetLoad::Table(table, direction)))
    }

    /// The motion that is given.
    pub(crate) fn motion(&self) -> Option<SetMotion> {
        let velocity = self.velocity_m_per_s.map(SetMotion::Velocity);
        velocity.or(self.displacement_m.map(SetMotion::Displacement))
    }

    /// Unit vector along which the force of a table acts, where a key gives it.
    fn direction(&self) -> Option<[f64; 2]> {
        let given = self.load_direction.or_else(|| self.only_free())?;
        // The length of two large numbers overflows, that of their ratios does not.
        let larger = given[0].abs().max(given[1].abs());
        let [x, y] = given.map(|d| d / larger);
        Some([x, y].map(|d| d / x.hypot(y)))
    }

    /// The only direction that the motion leaves free.
    fn only_free(&self) -> Option<[f64; 2]> {
        match self.motion()?.components().map(|component| component.0) {
            [None, Some(_)] => Some([1.0, 0.0]),
            [Some(_), None] => Some([0.0, 1.0]),
            _ => None,
        }
    }

    fn check(&self, set: &str) -> Result<(), ConfigError> {
        self.check_count(set)?;
        self.check_table(set)?;
        self.check_directions(set)?;
        let load = self.load().map(SetLoad::numbers);
        for (name, numbers) in load
            .into_iter()
            .chain(self.motion().map(SetMotion::numbers))
        {
            if !numbers.iter().all(|number| number.is_finite()) {
                let key = format!("boundary.{set}.{name}");
                return Err(
                    ConfigError::new(&key, "must hold finite numbers").because(Cause::OutOfRange)
                );
            }
        }
        let ramp_key = format!("boundary.{set}.ramp_s");
        not_negative(&ramp_key, self.ramp_s, "s")?;
        let moved =
            |shift: [PrescribedComponent; 2]| shift.iter().any(|d| d.0.is_some_and(|d| d != 0.0));
        if self.displacement_m.is_some_and(moved) {
            positive(&ramp_key, self.ramp_s.unwrap_or(0.0), "s")?;
        }
        Ok(())
    }

    /// Refuses a set without a load or motion, and two of a kind.
    fn check_count(&self, set: &str) -> Result<(), ConfigError> {
        let loads = [
            self.traction_pa.is_some(),
            self.pressure_pa.is_some(),
            self.load_table.is_some(),
        ];
        let motions = [
            self.velocity_m_per_s.is_some(),
            self.displacement_m.is_some(),
        ];
        let count = |given: &[bool]| given.iter().filter(|given| **given).count();
        let (loads, motions) = (count(&loads), count(&motions));
        let problem =
            "must hold exactly one load or motion, or a load and a motion in different directions";
        let help = "give one of traction_pa, pressure_pa, load_table, velocity_m_per_s, displacement_m; or traction_pa = [\"free\", -1e6] beside velocity_m_per_s = [0.1, \"free\"]";
        let one_each = loads + motions > 0 && loads <= 1 && motions <= 1;
        refuse_if(!one_each, &format!("boundary.{set}"), problem, help)
    }

    /// Refuses a wrong table, one without a direction, and a ramp that nothing follows.
    fn check_table(&self, set: &str) -> Result<(), ConfigError> {
        let key = |name: &str| format!("boundary.{set}.{name}");
        self.check_direction(&key("load_direction"))?;
        let Some(table) = &self.load_table else {
            return Ok(());
        };
        check_table(&key("load_table"), table)?;
        if self.direction().is_none() {
            let problem = "has no direction: load_direction is missing, and no motion leaves exactly one free";
            return Err(ConfigError::new(&key("load_table"), problem)
                .because(Cause::MissingKey)
                .help("write load_direction = [0.0, -1.0] for a force downwards, or a motion with one direction \"free\""));
        }
        refuse_if(
            self.ramp_s.is_some() && self.motion().is_none(),
            &key("ramp_s"),
            "does not act on load_table, which already is the load over time",
            "remove it, and let the table begin with [0.0, 0.0]",
        )
    }

    /// Refuses a direction of nothing, and one that is none.
    fn check_direction(&self, key: &str) -> Result<(), ConfigError> {
        let Some(direction) = self.load_direction else {
            return Ok(());
        };
        refuse_if(
            self.load_table.is_none(),
            key,
            "is that of load_table, and there is none",
            "add load_table = [[t_s, n], ...], or remove the key",
        )?;
        if direction != [0.0; 2] && direction.iter().all(|d| d.is_finite()) {
            return Ok(());
        }
        let problem =
            format!("is {direction:?}, and must hold two finite numbers that are not both 0");
        Err(ConfigError::new(key, problem).help("write [0.0, -1.0] for a force downwards"))
    }

    /// Refuses a direction that has a load and a motion.
    fn check_directions(&self, set: &str) -> Result<(), ConfigError> {
        let key = format!("boundary.{set}");
        let (Some(load), Some(motion)) = (self.load(), self.motion()) else {
            return Ok(());
        };
        refuse_if(
            matches!(load, SetLoad::Pressure(_)),
            &key,
            "has a pressure beside a motion, and a pressure may act in both directions",
            "give the component that is not moved as traction_pa = [\"free\", -1e6]",
        )?;
        let both = |k: &usize| load.acts_along(*k) && motion.components()[*k].0.is_some();
        let Some(k) = [0, 1].into_iter().find(both) else {
            return Ok(());
        };
        let direction = ["x", "y"][k];
        refuse_if(
            true,
            &key,
            format!("has a load and a motion in {direction}, of which only one can be given"),
            "write \"free\" for one of them, or remove load_direction",
        )
    }
}

impl SetLoad<'_> {
    /// True where it is given along x (0) or y (1).
    fn acts_along(&self, k: usize) -> bool {
        match self {
            SetLoad::Traction(traction) => traction[k].0.is_some(),
            SetLoad::Pressure(_) => true,
            SetLoad::Table(_, direction) => direction[k] != 0.0,
        }
    }

    /// The key and its numbers.
    pub(crate) fn numbers(self) -> (&'static str, Vec<f64>) {
        match self {
            SetLoad::Traction(traction) => ("traction_pa", given(traction)),
            SetLoad::Pressure(pressure) => ("pressure_pa", vec![pressure]),
            SetLoad::Table(table, _) => ("load_table", table.iter().flatten().copied().collect()),
        }
    }
}

impl SetMotion {
    /// Its components, (m/s) or (m).
    pub(crate) fn components(self) -> [PrescribedComponent; 2] {
        match self {
            SetMotion::Velocity(components) | SetMotion::Displacement(components) => components,
        }
    }

    /// The key and its numbers.
    pub(crate) fn numbers(self) -> (&'static str, Vec<f64>) {
        let key = match self {
            SetMotion::Velocity(_) => "velocity_m_per_s",
            SetMotion::Displacement(_) => "displacement_m",
        };
        (key, given(self.components()))
    }
}

/// The components that are numbers.
fn given(components: [PrescribedComponent; 2]) -> Vec<f64> {
    components.into_iter().filter_map(|c| c.0).collect()
}

impl BoundaryConfig {
    pub(super) fn check(&self) -> Result<(), ConfigError> {
        self.0
            .iter()
            .try_for_each(|(set, config)| config.check(set))
    }

    /// The sets whose motion is prescribed.
    pub(crate) fn moved_sets(&self) -> impl Iterator<Item = &str> {
        let moved = self
            .0
            .iter()
            .filter(|(_, config)| config.motion().is_some());
        moved.map(|(set, _)| set.as_str())
    }
}
