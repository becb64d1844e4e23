//! Boundary conditions of named sets of nodes: a traction, or the motion itself.

use std::collections::BTreeMap;

use protocol::ConfigError;
use serde::{Deserialize, Deserializer};

use super::number::{not_negative, number_or_word, positive};

/// Boundary condition of each named set.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(transparent)]
pub struct BoundaryConfig(pub BTreeMap<String, SetConfig>);

/// Boundary condition of one set; exactly one of its keys but `ramp_s`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SetConfig {
    /// Components (tx, ty) of a traction on the reference edge (Pa).
    pub traction_pa: Option<[f64; 2]>,
    /// Pressure on the reference edge, against its outward normal (Pa).
    pub pressure_pa: Option<f64>,
    /// Components of the velocity (m/s), or `"free"` where the set may move.
    pub velocity_m_per_s: Option<[Component; 2]>,
    /// Components of the displacement at the end of the ramp (m), or `"free"`.
    pub displacement_m: Option<[Component; 2]>,
    /// Duration of a linear ramp from zero (s); at once when absent or 0, which a displacement cannot be.
    pub ramp_s: Option<f64>,
}

/// A component of a prescribed motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Component(
    /// The prescribed number; none where it is left to the equations of motion.
    pub Option<f64>,
);

/// Load or motion of a set, once read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SetLoad {
    Traction([f64; 2]),
    Pressure(f64),
    Velocity([Component; 2]),
    Displacement([Component; 2]),
}

impl SetConfig {
    /// The one load or motion that is given.
    pub(crate) fn load(&self) -> Option<SetLoad> {
        let all = [
            self.traction_pa.map(SetLoad::Traction),
            self.pressure_pa.map(SetLoad::Pressure),
            self.velocity_m_per_s.map(SetLoad::Velocity),
            self.displacement_m.map(SetLoad::Displacement),
        ];
        let mut given = all.into_iter().flatten();
        let first = given.next();
        first.filter(|_| given.next().is_none())
    }

    fn check(&self, set: &str) -> Result<(), ConfigError> {
        let Some(load) = self.load() else {
            let key = format!("boundary.{set}");
            return Err(
                ConfigError::new(&key, "must hold exactly one load or motion")
                    .help("give one of traction_pa, pressure_pa, velocity_m_per_s, displacement_m"),
            );
        };
        let (name, numbers) = load.numbers();
        if !numbers.iter().all(|number| number.is_finite()) {
            let key = format!("boundary.{set}.{name}");
            return Err(ConfigError::new(&key, "must hold finite numbers"));
        }
        let ramp_key = format!("boundary.{set}.ramp_s");
        not_negative(&ramp_key, self.ramp_s, "s")?;
        if matches!(load, SetLoad::Displacement(_)) && numbers.iter().any(|d| *d != 0.0) {
            positive(&ramp_key, self.ramp_s.unwrap_or(0.0), "s")?;
        }
        Ok(())
    }
}

impl SetLoad {
    /// The key and its numbers.
    pub(crate) fn numbers(self) -> (&'static str, Vec<f64>) {
        let given = |components: [Component; 2]| components.into_iter().filter_map(|c| c.0);
        match self {
            SetLoad::Traction(traction) => ("traction_pa", traction.to_vec()),
            SetLoad::Pressure(pressure) => ("pressure_pa", vec![pressure]),
            SetLoad::Velocity(velocity) => ("velocity_m_per_s", given(velocity).collect()),
            SetLoad::Displacement(shift) => ("displacement_m", given(shift).collect()),
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
        let motion = |config: &SetConfig| {
            config.velocity_m_per_s.is_some() || config.displacement_m.is_some()
        };
        let moved = self.0.iter().filter(move |(_, config)| motion(config));
        moved.map(|(set, _)| set.as_str())
    }
}

impl<'de> Deserialize<'de> for Component {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        number_or_word(deserializer, "free", "a number or \"free\"").map(Component)
    }
}
