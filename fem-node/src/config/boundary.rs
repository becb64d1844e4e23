//! Boundary conditions of named sets of nodes: a traction, or the motion itself, or one of each.

use std::collections::BTreeMap;

use protocol::ConfigError;
use serde::{Deserialize, Deserializer};

use super::number::{not_negative, number_or_word, positive};

/// Boundary condition of each named set.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(transparent)]
pub struct BoundaryConfig(pub BTreeMap<String, SetConfig>);

/// Boundary condition of one set: a load, a motion, or both, each in its own direction.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SetConfig {
    /// Components (tx, ty) of a traction on the reference edge (Pa), or `"free"` where there is none.
    pub traction_pa: Option<[Component; 2]>,
    /// Pressure on the reference edge, against its outward normal (Pa).
    pub pressure_pa: Option<f64>,
    /// Components of the velocity (m/s), or `"free"` where the set may move.
    pub velocity_m_per_s: Option<[Component; 2]>,
    /// Components of the displacement at the end of the ramp (m), or `"free"`.
    pub displacement_m: Option<[Component; 2]>,
    /// Duration of a linear ramp from zero (s), of loads and motions alike; at once when absent or 0, which a displacement
    /// cannot be.
    pub ramp_s: Option<f64>,
}

/// A component of a prescribed motion or traction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Component(
    /// The prescribed number; none where it is left to the equations of motion.
    pub Option<f64>,
);

/// Load of a set, once read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SetLoad {
    Traction([Component; 2]),
    Pressure(f64),
}

/// Motion of a set, once read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SetMotion {
    Velocity([Component; 2]),
    Displacement([Component; 2]),
}

impl SetConfig {
    /// The load that is given.
    pub(crate) fn load(&self) -> Option<SetLoad> {
        let traction = self.traction_pa.map(SetLoad::Traction);
        traction.or(self.pressure_pa.map(SetLoad::Pressure))
    }

    /// The motion that is given.
    pub(crate) fn motion(&self) -> Option<SetMotion> {
        let velocity = self.velocity_m_per_s.map(SetMotion::Velocity);
        velocity.or(self.displacement_m.map(SetMotion::Displacement))
    }

    fn check(&self, set: &str) -> Result<(), ConfigError> {
        self.check_choice(set)?;
        let load = self.load().map(SetLoad::numbers);
        for (name, numbers) in load
            .into_iter()
            .chain(self.motion().map(SetMotion::numbers))
        {
            if !numbers.iter().all(|number| number.is_finite()) {
                let key = format!("boundary.{set}.{name}");
                return Err(ConfigError::new(&key, "must hold finite numbers"));
            }
        }
        let ramp_key = format!("boundary.{set}.ramp_s");
        not_negative(&ramp_key, self.ramp_s, "s")?;
        let moved = |shift: [Component; 2]| shift.iter().any(|d| d.0.is_some_and(|d| d != 0.0));
        if self.displacement_m.is_some_and(moved) {
            positive(&ramp_key, self.ramp_s.unwrap_or(0.0), "s")?;
        }
        Ok(())
    }

    /// Refuses a set without a load or motion, two of a kind, and a direction that has both.
    fn check_choice(&self, set: &str) -> Result<(), ConfigError> {
        let refused = |problem: &str, help: &str| {
            Err(ConfigError::new(&format!("boundary.{set}"), problem).help(help))
        };
        let loads = [self.traction_pa.is_some(), self.pressure_pa.is_some()];
        let motions = [
            self.velocity_m_per_s.is_some(),
            self.displacement_m.is_some(),
        ];
        let count = |given: [bool; 2]| given.iter().filter(|given| **given).count();
        let [loads, motions] = [loads, motions].map(count);
        if loads + motions == 0 || loads > 1 || motions > 1 {
            return refused(
                "must hold exactly one load or motion, or a traction and a motion in different directions",
                "give one of traction_pa, pressure_pa, velocity_m_per_s, displacement_m; or traction_pa = [\"free\", -1e6] beside velocity_m_per_s = [0.1, \"free\"]",
            );
        }
        let Some(motion) = self.motion() else {
            return Ok(());
        };
        match self.load() {
            None => Ok(()),
            Some(SetLoad::Pressure(_)) => refused(
                "has a pressure beside a motion, and a pressure may act in both directions",
                "give the component that is not moved as traction_pa = [\"free\", -1e6]",
            ),
            Some(SetLoad::Traction(traction)) => {
                let both = |k: &usize| traction[*k].0.and(motion.components()[*k].0).is_some();
                let Some(k) = [0, 1].into_iter().find(both) else {
                    return Ok(());
                };
                let direction = ["x", "y"][k];
                refused(
                    &format!(
                        "has a traction and a motion in {direction}, of which only one can be given"
                    ),
                    "write \"free\" for one of them",
                )
            }
        }
    }
}

impl SetLoad {
    /// The key and its numbers.
    pub(crate) fn numbers(self) -> (&'static str, Vec<f64>) {
        match self {
            SetLoad::Traction(traction) => ("traction_pa", given(traction)),
            SetLoad::Pressure(pressure) => ("pressure_pa", vec![pressure]),
        }
    }
}

impl SetMotion {
    /// Its components, (m/s) or (m).
    pub(crate) fn components(self) -> [Component; 2] {
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
fn given(components: [Component; 2]) -> Vec<f64> {
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

impl<'de> Deserialize<'de> for Component {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        number_or_word(deserializer, "free", "a number or \"free\"").map(Component)
    }
}
