//! The keys of `sample.clusters.drive`: a cluster that is moved, or pushed, along x and along y.

use kit::ConfigError;
use kit::keys::refuse_if;
use kit::number::PrescribedComponent;
use kit::table::{LoadTable, check_table};
use schemars::JsonSchema;
use serde::Deserialize;

/// Prescribed motion and loads of a cluster. Each direction has a velocity, or is `"free"` and has a force.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ClusterDriveConfig {
    /// Velocity along x and y (m/s); `"free"` where a force acts. Both are free when absent.
    pub velocity_m_per_s: Option<[PrescribedComponent; 2]>,
    /// Force along x and y (N); `"free"` where a velocity is prescribed or no force acts. No force acts when absent.
    pub force_n: Option<[PrescribedComponent; 2]>,
    /// Force over time (s, N) in the only free direction, in place of `force_n`: linear between the entries, constant beyond them. Not used when
    /// absent.
    pub load_table: Option<LoadTable>,
    /// Mass (kg), before `mass_scale`; the sum of the disks when absent.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub mass_kg: Option<f64>,
    /// Damping of the motion in free directions (N s/m): the force against it over its speed.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub damping_n_s_per_m: f64,
}

fn numbers(given: Option<[PrescribedComponent; 2]>) -> [Option<f64>; 2] {
    given.map_or([None; 2], |both| both.map(|component| component.0))
}

impl ClusterDriveConfig {
    /// Velocity along x and y where one is prescribed (m/s).
    pub fn velocity(&self) -> [Option<f64>; 2] {
        numbers(self.velocity_m_per_s)
    }

    /// Force over time along x and y (s, N); empty where none acts.
    pub fn forces(&self) -> [LoadTable; 2] {
        let constant = numbers(self.force_n);
        let velocity = self.velocity();
        [0, 1].map(|k| match (&self.load_table, constant[k]) {
            (Some(table), _) if velocity[k].is_none() => table.clone(),
            (_, Some(force)) => vec![[0.0, force]],
            _ => Vec::new(),
        })
    }

    pub(super) fn validate(&self, key: &str) -> Result<(), ConfigError> {
        let velocity = self.velocity();
        let force = numbers(self.force_n);
        for (k, name) in ["x", "y"].iter().enumerate() {
            refuse_if(
                velocity[k].is_some() && force[k].is_some(),
                &format!("{key}.force_n"),
                format!("both a velocity and a force are given along {name}"),
                "write \"free\" in the place of one of them",
            )?;
        }
        let free = velocity.iter().filter(|v| v.is_none()).count();
        refuse_if(
            free == 0 && (self.mass_kg.is_some() || self.damping_n_s_per_m > 0.0),
            key,
            "mass and damping act in free directions, and both velocities are prescribed",
            "remove them, or write \"free\" in velocity_m_per_s",
        )?;
        self.validate_load(key, free)
    }

    fn validate_load(&self, key: &str, free: usize) -> Result<(), ConfigError> {
        let Some(table) = &self.load_table else {
            return Ok(());
        };
        let key = format!("{key}.load_table");
        refuse_if(
            free != 1 || self.force_n.is_some(),
            &key,
            format!(
                "is the force in the only free direction, and {free} directions are free or force_n is given too"
            ),
            "prescribe the velocity of the other direction, and remove force_n",
        )?;
        check_table(&key, table)
    }
}
