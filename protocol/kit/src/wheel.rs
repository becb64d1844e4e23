//! Load and sideways motion of a rigid wheel over time, and the named parts of a history.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use protocol::Phase;

use crate::keys::{ConfigError, refuse_if};
use crate::limits::{positive, refuse_given};
use crate::rolling::Rolling;
use crate::table::{LoadTable, check_wheel_table, last_change, load_at};

crate::results! {
    /// # Load and approach
    /// - `load_n`: Load on the wheel that the scenario asks for.
    /// - `wheel_force_n`: Force on the wheel, mean over the last half of the hold: the load, if the
    ///   wheel came to rest.
    /// - `approach_m`: Way of the wheel towards the rail from its first position: on grains the mean over the last half of
    ///   the hold, on a body the value at the end of the hold.
    /// # Friction and sliding
    /// - `loop_area_j`: Work of the tangential force over the last full cycle: the area of the
    ///   friction loop.
    /// # Signals
    /// - `wheel_x_m`: Sideways displacement D of the wheel, towards +x; of a rolling wheel the abscissa of its
    ///   centre, inside a body that repeats.
    /// - `wheel_y_m`: Height of the lowest point of the wheel's face.
    /// - `wheel_vx_m_per_s`: Sideways velocity of the wheel.
    /// - `wheel_fn_n`: Force on the wheel along y, upwards: the load while it is at rest.
    /// - `wheel_ft_n`: Force on the wheel along x: against its motion, so negative while it moves
    ///   towards +x.
    /// # Signals of the ledger
    /// - `wheel_load_j`: Work of the wheel's load, since the start.
    /// - `wheel_drive_j`: Work of the drive that moves the wheel sideways, since the start.
    /// - `kinetic_j`: Change of the kinetic energy since the start: scaled masses of the grains and
    ///   the vertical motion of their wheel, or the body.
    /// - `wheel_kinetic_j`: Change of the kinetic energy of the wheel's vertical motion since the
    ///   start.
    /// - `friction_j`: Energy dissipated by slip since the start.
    /// - `impact_j`: Energy dissipated in impacts of rigid contacts since the start; of grains without springs and bonds also by the time scheme, with
    ///   `theta` = 1 even in free fall.
}

/// Name of the phase at whose end results are taken.
pub const HOLD: &str = "hold";

/// The load ramps up or follows its table, and is then held. From t_s = ramp + hold on the wheel moves sideways by
/// D(t) = A sin(2 pi f (t - t_s)), at full speed from the start.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WheelProgram {
    /// Load after the ramp (N), downwards.
    pub load_n: f64,
    /// Load over time (s, N) instead of the ramp.
    pub load_table: Option<LoadTable>,
    /// Time in which the load grows linearly from 0 (s).
    pub ramp_s: f64,
    /// Time under the full load before the sideways motion (s).
    pub hold_s: f64,
    /// Amplitude A (m).
    pub amplitude_m: f64,
    /// Frequency f (1/s).
    pub frequency_hz: f64,
    /// Periods of the sideways motion, not necessarily whole.
    pub cycles: f64,
    /// Rolling from t_s on, in place of the sideways motion.
    pub rolling: Option<Rolling>,
}

/// The type of a table `wheel`: the keys that every solver has, and its own keys.
#[macro_export]
macro_rules! wheel_keys {
    ($(#[$about:meta])* $name:ident { $($own:tt)* }) => {
        $(#[$about])*
        #[derive(Clone, Debug, PartialEq, serde::Deserialize, schemars::JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct $name {
            /// Vertical load (N).
            #[schemars(range(min = 0.0))]
            pub load_n: f64,
            /// Vertical load over time (s, N) instead of the linear ramp: linear between the entries, constant beyond them. At the end
            /// of the hold it must equal `load_n`, which results and checks of the hold refer to.
            pub load_table: Option<$crate::table::LoadTable>,
            /// Mass (kg), never scaled, which resists vertical motion; the sideways motion is prescribed.
            #[schemars(extend("exclusiveMinimum" = 0))]
            pub mass_kg: f64,
            /// Radius of the face (m), its lowest point over x = 0 at the start; 0 = flat.
            #[serde(default)]
            #[schemars(range(min = 0.0))]
            pub radius_m: f64,
            $($own)*
            /// Amplitude A of the sideways motion D(t) = A sin(2 pi f (t - t_s)) (m); the wheel does not move where cycles = 0.
            #[serde(default)]
            #[schemars(range(min = 0.0))]
            pub amplitude_m: f64,
            /// Frequency f of the sideways motion (1/s), above 0 where there are cycles.
            #[serde(default)]
            pub frequency_hz: f64,
            /// Time in which the load grows linearly from 0 (s).
            #[schemars(range(min = 0.0))]
            pub ramp_s: f64,
            /// Time under the full load before the motion starts at t_s = ramp + hold (s).
            #[schemars(range(min = 0.0))]
            pub hold_s: f64,
            /// Periods of the sideways motion, not necessarily whole.
            #[serde(default)]
            #[schemars(range(min = 0.0))]
            pub cycles: f64,
            /// Rolling along the rail from t_s on, in place of the sideways motion.
            pub rolling: Option<$crate::rolling::RollingConfig>,
        }

        impl $name {
            /// Its load and its motion over time, on a body that repeats after `period` (m), if it repeats.
            ///
            /// # Errors
            /// Names the key, the fault, and what to write instead.
            pub fn program(&self, period: Option<f64>) -> Result<$crate::wheel::WheelProgram, $crate::ConfigError> {
                let rolling = self.rolling.as_ref();
                let rolling = rolling.map(|rolling| rolling.rolling(self.radius_m, period)).transpose()?;
                let program = $crate::wheel::WheelProgram {
                    load_n: self.load_n,
                    load_table: self.load_table.clone(),
                    ramp_s: self.ramp_s,
                    hold_s: self.hold_s,
                    amplitude_m: self.amplitude_m,
                    frequency_hz: self.frequency_hz,
                    cycles: self.cycles,
                    rolling,
                };
                program.check()?;
                Ok(program)
            }
        }
    };
}

impl WheelProgram {
    /// Refuses a sideways motion without a frequency or beside a rolling one, and a wrong table of loads; see [`check_wheel_table`].
    ///
    /// # Errors
    /// Names the key, the fault, and what to write instead.
    pub fn check(&self) -> Result<(), ConfigError> {
        let sideways = [
            ("wheel.amplitude_m", self.amplitude_m > 0.0),
            ("wheel.cycles", self.cycles > 0.0),
            ("wheel.frequency_hz", self.frequency_hz > 0.0),
        ];
        refuse_given(
            sideways.map(|(key, given)| (key, given && self.rolling.is_some())),
            "moves the wheel sideways, and wheel.rolling rolls it",
            "remove one of them",
        )?;
        if self.cycles > 0.0 {
            positive("wheel.frequency_hz", self.frequency_hz, "1/s")?;
            refuse_if(
                !self.end().is_finite(),
                "wheel.frequency_hz",
                format!(
                    "{:e} cycles at {:e} 1/s never end",
                    self.cycles, self.frequency_hz
                ),
                "raise it, or lower wheel.cycles",
            )?;
        }
        let (held_at, mut table) = (self.motion_start(), self.load_table.iter());
        table.try_for_each(|table| check_wheel_table(table, held_at, self.load_n))
    }

    /// Load at a time (N), downwards.
    pub fn load_at(&self, t: f64) -> f64 {
        if let Some(table) = &self.load_table {
            load_at(table, t)
        } else if t < self.ramp_s {
            self.load_n * t / self.ramp_s
        } else {
            self.load_n
        }
    }

    /// Distance that it has rolled at a time (m).
    pub fn rolled_at(&self, t: f64) -> f64 {
        let rolling = self.rolling.as_ref();
        rolling.map_or(0.0, |rolling| rolling.rolled_after(t - self.motion_start()))
    }

    /// Speed of a wheel (m/s) that begins to roll in the step between two times (s).
    pub fn starts_in(&self, start: f64, end: f64) -> Option<f64> {
        let starts = self.rolled_at(start) == 0.0 && self.rolled_at(end) > 0.0;
        let rolling = self.rolling.as_ref().filter(|_| starts);
        rolling.map(|rolling| rolling.speed)
    }

    /// Sideways displacement D at a time, or the abscissa of the centre of a rolling wheel (m).
    pub fn displacement_at(&self, t: f64) -> f64 {
        if let Some(rolling) = &self.rolling {
            return rolling.centre(self.rolled_at(t));
        }
        self.amplitude_m * self.angle_at(t).sin()
    }

    /// Sideways velocity at a time (m/s): 0 before t_s and without cycles.
    pub fn speed_at(&self, t: f64) -> f64 {
        if t < self.motion_start() {
            return 0.0;
        }
        if let Some(rolling) = &self.rolling {
            return rolling.speed;
        }
        if self.cycles == 0.0 {
            return 0.0;
        }
        self.angular_frequency() * self.amplitude_m * self.angle_at(t).cos()
    }

    /// Highest speed at which the face moves past a body at rest, along it (m/s); 0 where a rolling wheel spins freely.
    pub fn top_speed(&self) -> f64 {
        if let Some(rolling) = &self.rolling {
            rolling.speed.abs() * rolling.largest_creepage()
        } else if self.cycles > 0.0 {
            self.angular_frequency() * self.amplitude_m
        } else {
            0.0
        }
    }

    /// 2 pi f of the sideways motion (1/s).
    pub fn angular_frequency(&self) -> f64 {
        TAU * self.frequency_hz
    }

    /// 2 pi f (t - t_s); 0 before t_s and without cycles.
    fn angle_at(&self, t: f64) -> f64 {
        if self.cycles == 0.0 {
            return 0.0;
        }
        self.angular_frequency() * (t - self.motion_start()).max(0.0)
    }

    /// t_s (s).
    pub fn motion_start(&self) -> f64 {
        self.ramp_s + self.hold_s
    }

    /// End of the hold (s), if there is a hold.
    pub fn hold_end(&self) -> Option<f64> {
        (self.hold_s > 0.0).then(|| self.motion_start())
    }

    /// End of the history (s).
    pub fn end(&self) -> f64 {
        if let Some(rolling) = &self.rolling {
            self.motion_start() + rolling.duration()
        } else if self.cycles > 0.0 {
            self.motion_start() + self.cycles / self.frequency_hz
        } else {
            self.motion_start()
        }
    }

    /// Periods since t_s; `None` before.
    pub fn periods_at(&self, t: f64) -> Option<f64> {
        (self.cycles > 0.0 && t >= self.motion_start())
            .then(|| self.frequency_hz * (t - self.motion_start()))
    }

    /// One period (s).
    pub fn period(&self) -> f64 {
        1.0 / self.frequency_hz
    }

    /// Start and end of the last full cycle (s).
    pub fn last_full_cycle(&self) -> Option<[f64; 2]> {
        let full = self.cycles.floor();
        let at = |cycle: f64| self.motion_start() + cycle / self.frequency_hz;
        (full >= 1.0).then(|| [at(full - 1.0), at(full)])
    }

    /// Times (s) at which the keys of its table `wheel` have taken effect.
    pub fn moments(&self) -> BTreeMap<String, f64> {
        moments([
            ("wheel.ramp_s", Some(self.ramp_s)),
            ("wheel.load_table", last_change(self.load_table.as_ref())),
            ("wheel.hold_s", self.hold_end()),
            ("wheel.cycles", (self.cycles > 0.0).then(|| self.end())),
            ("wheel.rolling", self.rolling.as_ref().map(|_| self.end())),
        ])
    }

    /// The named parts of the history.
    pub fn phases(&self) -> Vec<Phase> {
        let (ramp, moves) = (self.ramp_s, self.motion_start());
        let motion = if self.rolling.is_some() {
            "rolling"
        } else {
            "cycling"
        };
        let motion = (motion, moves, self.end());
        phases([("ramp", 0.0, ramp), (HOLD, ramp, moves), motion])
    }
}

/// True for the step, by its start and end (s), that ends nearest to a moment (s); for both steps if two are equally near.
pub fn ends_at(moment: f64, [start, end]: [f64; 2]) -> bool {
    let middle = 0.5 * (start + end);
    let next = 2.0 * end - middle;
    (middle..=next).contains(&moment)
}

/// The keys that take effect at a moment (s).
pub fn moments<const N: usize>(keys: [(&str, Option<f64>); N]) -> BTreeMap<String, f64> {
    let keys = keys.into_iter();
    keys.filter_map(|(key, time_s)| Some((key.into(), time_s?)))
        .collect()
}

/// Named parts of a history with their start and end (s), without parts of no duration.
pub fn phases<const N: usize>(parts: [(&str, f64, f64); N]) -> Vec<Phase> {
    let lasting = parts.into_iter().filter(|(_, t0_s, t1_s)| t1_s > t0_s);
    let phase = |(name, t0_s, t1_s): (&str, f64, f64)| Phase {
        name: name.into(),
        t0_s,
        t1_s,
        sampled: name == HOLD,
        picture: name != "ramp",
    };
    lasting.map(phase).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 8 000 N in 0.5 ms, 0.4 ms of hold, then 2.25 cycles of 50 um at 300 Hz.
    fn program() -> WheelProgram {
        WheelProgram {
            load_n: 8000.0,
            load_table: None,
            ramp_s: 5e-4,
            hold_s: 4e-4,
            amplitude_m: 5e-5,
            frequency_hz: 300.0,
            cycles: 2.25,
            rolling: None,
        }
    }

    #[test]
    fn the_load_ramps_then_holds() {
        assert_eq!(program().load_at(2.5e-4), 4000.0);
        assert_eq!(program().load_at(1.0), 8000.0);
    }

    #[test]
    fn a_table_is_the_load_in_place_of_the_ramp() {
        let table = vec![[0.0, 1000.0], [4e-4, 5000.0], [9e-4, 8000.0], [1.9e-3, 0.0]];
        let program = WheelProgram {
            load_table: Some(table),
            ..program()
        };
        for (time, load) in [
            (0.0, 1000.0),
            (2e-4, 3000.0),
            (9e-4, 8000.0),
            (1.4e-3, 4000.0),
        ] {
            assert!((program.load_at(time) - load).abs() < 1e-9, "{time}");
        }
    }

    #[test]
    fn motion_starts_after_the_hold_at_full_speed() {
        let program = program();
        assert_eq!(program.displacement_at(9e-4), 0.0);
        assert_eq!(program.speed_at(8.9e-4), 0.0);
        let full = program.top_speed();
        assert_eq!(full, TAU * 300.0 * 5e-5);
        assert!((program.speed_at(9.0e-4) / full - 1.0).abs() < 1e-12);
        let measured = program.displacement_at(9e-4 + 1e-8) / 1e-8;
        assert!((measured - full).abs() < 1e-6, "{measured}");
    }

    /// The last window of a run may reach beyond t_s.
    #[test]
    fn a_wheel_without_cycles_stays() {
        let program = WheelProgram {
            cycles: 0.0,
            ..program()
        };
        for t in [8e-4, 9.1e-4, 1.0] {
            assert_eq!([program.displacement_at(t), program.speed_at(t)], [0.0; 2]);
        }
    }

    #[test]
    fn cycles_that_never_end_are_refused() {
        let slow = WheelProgram {
            frequency_hz: 5e-324,
            ..program()
        };
        let error = slow.check().expect_err("its end is infinite");
        assert_eq!(error.key, "wheel.frequency_hz");
        assert!(program().check().is_ok());
    }

    #[test]
    fn the_last_full_cycle_is_the_second_of_two_and_a_quarter() {
        let [start, end] = program().last_full_cycle().expect("there are two");
        assert!((start - (9e-4 + 1.0 / 300.0)).abs() < 1e-12);
        assert!((end - (9e-4 + 2.0 / 300.0)).abs() < 1e-12);
    }

    /// A table's last change is the last change of its force, not its last entry.
    #[test]
    fn each_key_takes_effect_at_its_moment() {
        let moments = |program: WheelProgram| Vec::from_iter(program.moments());
        let key = |name: &str, time_s| (format!("wheel.{name}"), time_s);
        let end = 9e-4 + 2.25 / 300.0;
        let whole = [key("cycles", end), key("hold_s", 9e-4), key("ramp_s", 5e-4)];
        assert_eq!(moments(program()), whole);
        let by_table = WheelProgram {
            load_table: Some(vec![[0.0, 0.0], [4e-4, 8000.0], [1.0, 8000.0]]),
            hold_s: 0.0,
            cycles: 0.0,
            ..program()
        };
        assert_eq!(
            moments(by_table),
            [key("load_table", 4e-4), key("ramp_s", 5e-4)]
        );
    }

    #[test]
    fn parts_without_duration_are_no_phases() {
        let program = WheelProgram {
            ramp_s: 0.0,
            ..program()
        };
        let names: Vec<String> = program.phases().into_iter().map(|p| p.name).collect();
        assert_eq!(names, [HOLD, "cycling"]);
    }
}
