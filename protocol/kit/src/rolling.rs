//! A wheel that rolls along the rail after its hold: creepage or creep force over the distance that it rolls.
//!
//! The centre moves at V, and the wheel turns at omega, so that its lowest point has the velocity zeta V in the frame of the rail:
//!
//! ```text
//! zeta = (V - omega R)/V                                    creepage: positive brakes, negative drives
//! n:  V sin(theta)      t:  V cos(theta) - omega R          velocity of the face at the angle theta from the lowest point
//! ```
//!
//! A positive creep force T drags the rail along in the direction in which the wheel rolls (Carter 1926; Johnson 1985, ch. 8).

use schemars::JsonSchema;
use serde::Deserialize;

use crate::keys::{ConfigError, refuse_if};
use crate::limits::positive;
use crate::table::{LoadTable, check_table, integral_to, load_at};

/// Rolling after the hold, from t_s on: one of four quantities is given, the creepage or the force; the other one is a result.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RollingConfig {
    /// Speed V of the wheel's centre (m/s), negative towards -x. A static analysis needs only its sign.
    pub speed_m_per_s: f64,
    /// Creepage zeta = (V - omega R)/V: 0 turns at V/R, positive brakes, 1 slides without turning.
    #[schemars(range(min = -1.0, max = 1.0))]
    pub creepage: Option<f64>,
    /// Creepage over the rolled distance (m, 1), linear between the entries and constant beyond them.
    pub creepage_table: Option<LoadTable>,
    /// Tangential force T of the wheel on the rail (N), summed along the face; positive brakes.
    pub force_n: Option<f64>,
    /// Braking torque T R on the wheel (N m); negative drives.
    pub torque_nm: Option<f64>,
    /// Distance to roll (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub distance_m: Option<f64>,
    /// Passages over a body that repeats along x, in place of `distance_m`, not necessarily whole.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub passes: Option<f64>,
    /// Abscissa over which the wheel is loaded and begins to roll (m).
    #[serde(default)]
    pub start_m: f64,
    /// Rolled distance over which the creepage or the force grows linearly from 0 (m). With 0, creepage acts at once; a static analysis applies a
    /// force before the wheel rolls.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub ramp_m: f64,
    /// Moment of inertia of the wheel about its axis (kg m2): with a force or torque over time the wheel spins freely under it. A static
    /// analysis does not use it.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub spin_inertia_kg_m2: Option<f64>,
}

/// A distance along x, or the one to the nearest image in a body that repeats (m).
pub fn nearest_image(apart: f64, period: Option<f64>) -> f64 {
    period.map_or(apart, |period| apart - period * (apart / period).round())
}

/// The quantity that is given, over the rolled distance (m).
#[derive(Clone, Debug, PartialEq)]
pub enum Drive {
    /// Creepage.
    Creepage(LoadTable),
    /// Tangential force on the rail in the direction of rolling (N).
    Force(LoadTable),
}

/// The rolling of a wheel.
#[derive(Clone, Debug, PartialEq)]
pub struct Rolling {
    /// Speed of the centre (m/s), with its sign.
    pub speed: f64,
    /// Abscissa of the centre at the start (m).
    pub start: f64,
    /// Distance to roll (m), > 0.
    pub distance: f64,
    /// Distance over which the body repeats (m).
    pub period: Option<f64>,
    /// Creepage or force.
    pub drive: Drive,
    /// Moment of inertia (kg m2) of a wheel that spins freely.
    pub inertia: Option<f64>,
}

impl RollingConfig {
    /// The rolling of a wheel of this radius (m) over a body that repeats after `period` (m), if it repeats.
    ///
    /// # Errors
    /// A key of `wheel.rolling` that is missing, given twice, or beyond its range.
    pub fn rolling(&self, radius: f64, period: Option<f64>) -> Result<Rolling, ConfigError> {
        let key = |name: &str| format!("wheel.rolling.{name}");
        refuse_if(
            radius == 0.0,
            "wheel.radius_m",
            "is 0, a flat face, which cannot roll",
            "give the radius of the wheel",
        )?;
        refuse_if(
            self.speed_m_per_s == 0.0 || !self.speed_m_per_s.is_finite(),
            &key("speed_m_per_s"),
            format!("is {:?}, and the wheel does not roll", self.speed_m_per_s),
            "give the speed of the wheel's centre, negative towards -x",
        )?;
        let given = crate::named!(self, is_some; creepage, creepage_table, force_n, torque_nm);
        let given = Vec::from_iter(given.iter().filter(|(_, some)| *some));
        refuse_if(
            given.len() != 1,
            &key(given.get(1).map_or("creepage", |(name, _)| name)),
            "must be the only one of creepage, creepage_table, force_n and torque_nm: one is given, the others are results",
            "give one of them",
        )?;
        let distance = self.distance(period)?;
        let grown = |value: f64| match self.ramp_m {
            0.0 => vec![[0.0, value]],
            ramp => vec![[0.0, 0.0], [ramp, value]],
        };
        refuse_if(
            self.creepage_table.is_some() && self.ramp_m > 0.0,
            &key("ramp_m"),
            "does not go with creepage_table, which gives the creepage over the distance",
            "remove one of them",
        )?;
        refuse_if(
            self.ramp_m > distance,
            &key("ramp_m"),
            format!(
                "{:e} m is longer than the {distance:e} m to roll",
                self.ramp_m
            ),
            "shorten it, or roll further",
        )?;
        if let Some(table) = &self.creepage_table {
            check_table(&key("creepage_table"), table)?;
            let beyond = table.iter().find(|[_, creepage]| creepage.abs() > 1.0);
            refuse_if(
                beyond.is_some() || table[0][0] < 0.0,
                &key("creepage_table"),
                "must hold distances from 0 on, and creepages from -1 to 1",
                "write [[distance_m, creepage], ...]",
            )?;
        }
        let force = self
            .force_n
            .or(self.torque_nm.map(|torque| torque / radius));
        let drive = match (&self.creepage_table, self.creepage, force) {
            (Some(table), ..) => Drive::Creepage(table.clone()),
            (_, Some(creepage), _) => Drive::Creepage(grown(creepage)),
            (.., force) => Drive::Force(grown(force.unwrap_or_default())),
        };
        Ok(Rolling {
            speed: self.speed_m_per_s,
            start: self.start_m,
            distance,
            period,
            drive,
            inertia: self.spin_inertia_kg_m2,
        })
    }

    fn distance(&self, period: Option<f64>) -> Result<f64, ConfigError> {
        let key = "wheel.rolling.distance_m";
        match (self.distance_m, self.passes, period) {
            (Some(distance), None, _) => positive(key, distance, "m").map(|()| distance),
            (None, Some(passes), Some(period)) => Ok(passes * period),
            (None, Some(_), None) => Err(ConfigError::new(
                "wheel.rolling.passes",
                "counts passages over a body that repeats, and this one does not",
            )
            .help("give distance_m, or make the body periodic along x")),
            _ => Err(ConfigError::new(
                key,
                "must be given, or passes over a body that repeats, and not both",
            )
            .help("give one of them")),
        }
    }
}

impl Rolling {
    /// +1 where it rolls towards +x, -1 towards -x.
    pub fn direction(&self) -> f64 {
        1.0_f64.copysign(self.speed)
    }

    /// Distance that the centre has covered at a time after its start (m). A last window that ends later goes on.
    pub fn rolled_after(&self, time: f64) -> f64 {
        (self.speed.abs() * time).max(0.0)
    }

    /// Abscissa of the centre after this distance (m).
    pub fn centre(&self, rolled: f64) -> f64 {
        self.start + self.direction() * rolled
    }

    /// Length of a passage (m): the period of a body that repeats, or the whole distance.
    pub fn passage(&self) -> f64 {
        self.period.unwrap_or(self.distance)
    }

    /// Distance from which results count (m): the last passage, or the last half where there is but one.
    pub fn judged_from(&self) -> f64 {
        let last = self.distance - self.passage();
        if last > 0.0 {
            last
        } else {
            0.5 * self.distance
        }
    }

    /// Refuses a way that leaves what it rolls on, from `ends[0]` to `ends[1]` (m), and a force that friction cannot hold: `limit` (N). In time a force
    /// needs the inertia of the spin.
    ///
    /// # Errors
    /// Names the key, the fault, and what to write instead.
    pub fn check_on(&self, ends: [f64; 2], limit: f64, in_time: bool) -> Result<(), ConfigError> {
        let [left, right] = ends;
        for (key, x) in [
            ("start_m", self.start),
            ("distance_m", self.centre(self.distance)),
        ] {
            refuse_if(
                self.period.is_none() && !(left < x && x < right),
                &format!("wheel.rolling.{key}"),
                format!(
                    "brings the centre of the wheel to x = {x:e} m, beyond what it rolls on, which reaches from {left:e} to {right:e} m"
                ),
                "roll a shorter way, or make the body or the sample wider",
            )?;
        }
        let given = matches!(self.drive, Drive::Force(_));
        let forces = [0.0, self.distance].map(|rolled| self.force(rolled).unwrap_or(0.0).abs());
        let largest = forces[0].max(forces[1]);
        refuse_if(
            given && largest > 0.0 && largest >= limit,
            "wheel.rolling.force_n",
            format!(
                "or torque_nm over the radius is {largest:e} N, and friction holds less than {limit:e} N"
            ),
            "lower it, or give the creepage",
        )?;
        let inertia = "wheel.rolling.spin_inertia_kg_m2";
        refuse_if(
            in_time && given && self.inertia.is_none(),
            inertia,
            "is missing: under a force or torque the wheel spins freely",
            "give the moment of inertia, or the creepage",
        )?;
        refuse_if(
            !given && self.inertia.is_some(),
            inertia,
            "has no effect where the creepage is given, which prescribes the spin",
            "remove it, or give a force or torque",
        )
    }

    /// Duration (s).
    pub fn duration(&self) -> f64 {
        self.distance / self.speed.abs()
    }

    /// Distance of an abscissa from another one (m), over the nearest image of a body that repeats.
    pub fn apart(&self, x: f64, from: f64) -> f64 {
        nearest_image(x - from, self.period)
    }

    /// R phi, the length of the face that has rolled off after this distance (m), where the creepage is given: the integral of 1 - zeta.
    pub fn turned(&self, rolled: f64) -> Option<f64> {
        match &self.drive {
            Drive::Creepage(table) => Some(rolled - integral_to(table, rolled)),
            Drive::Force(_) => None,
        }
    }

    /// Largest creepage that is given; 0 where it is a result.
    pub fn largest_creepage(&self) -> f64 {
        let given = match &self.drive {
            Drive::Creepage(table) => &table[..],
            Drive::Force(_) => &[],
        };
        given.iter().fold(0.0, |most, [_, one]| most.max(one.abs()))
    }

    /// Force on the rail in the direction of rolling (N) after this distance, where it is given.
    pub fn force(&self, rolled: f64) -> Option<f64> {
        match &self.drive {
            Drive::Creepage(_) => None,
            Drive::Force(table) => Some(load_at(table, rolled)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn config() -> RollingConfig {
        RollingConfig {
            speed_m_per_s: 20.0,
            creepage: Some(0.01),
            creepage_table: None,
            force_n: None,
            torque_nm: None,
            distance_m: Some(0.04),
            passes: None,
            start_m: -0.02,
            ramp_m: 0.02,
            spin_inertia_kg_m2: None,
        }
    }

    /// 1 % of creepage reached over half of the way: 0.04 - 0.01 (0.01 + 0.02) of face rolls off.
    #[test]
    fn the_face_that_rolls_off_is_the_integral_of_one_less_the_creepage() {
        let rolling = config().rolling(0.5, None).expect("valid");
        assert_eq!(rolling.centre(rolling.rolled_after(1e-3)), 0.0);
        assert_eq!(rolling.rolled_after(-1.0), 0.0);
        assert!((rolling.turned(0.04).expect("given") - (0.04 - 3e-4)).abs() < 1e-15);
        let back = RollingConfig {
            speed_m_per_s: -20.0,
            ..config()
        };
        let back = back.rolling(0.5, None).expect("valid");
        assert_eq!(back.centre(0.04), -0.06);
        assert_eq!(back.turned(0.04), rolling.turned(0.04));
    }

    #[test]
    fn a_torque_is_a_force_at_the_radius() {
        let torque = RollingConfig {
            creepage: None,
            torque_nm: Some(50.0),
            ramp_m: 0.0,
            ..config()
        };
        let rolling = torque.rolling(0.5, None).expect("valid");
        assert_eq!(
            [rolling.force(0.0), rolling.turned(0.0)],
            [Some(100.0), None]
        );
    }

    #[test]
    fn what_cannot_roll_is_refused_by_its_key() {
        let refused = |change: fn(&mut RollingConfig), radius: f64| {
            let mut wrong = config();
            change(&mut wrong);
            wrong.rolling(radius, None).expect_err("refused").key
        };
        let key = |name: &str| format!("wheel.rolling.{name}");
        assert_eq!(refused(|_| (), 0.0), "wheel.radius_m");
        assert_eq!(
            refused(|c| c.speed_m_per_s = 0.0, 0.5),
            key("speed_m_per_s")
        );
        assert_eq!(refused(|c| c.force_n = Some(1.0), 0.5), key("force_n"));
        assert_eq!(refused(|c| c.creepage = None, 0.5), key("creepage"));
        assert_eq!(refused(|c| c.distance_m = None, 0.5), key("distance_m"));
        assert_eq!(refused(|c| c.ramp_m = 1.0, 0.5), key("ramp_m"));
        let passes = |c: &mut RollingConfig| (c.passes, c.distance_m) = (Some(2.0), None);
        assert_eq!(refused(passes, 0.5), key("passes"));
        let mut periodic = config();
        passes(&mut periodic);
        let rolling = periodic.rolling(0.5, Some(0.1)).expect("valid");
        assert_eq!(rolling.distance, 0.2);
        assert!((rolling.apart(0.09, -0.01)).abs() < 1e-16);
    }
}
