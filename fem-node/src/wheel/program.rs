//! Load and sideways motion of the wheel over time.

use std::f64::consts::TAU;

use kit::table::load_at;

use crate::config::wheel::WheelConfig;

/// The load ramps up, or follows its table, is held, and from t_s = ramp + hold on the wheel is moved sideways by
/// D(t) = A sin(2 pi f (t - t_s)), at once at its full speed.
#[derive(Clone, Debug, PartialEq)]
pub struct Program(pub(crate) WheelConfig);

impl Program {
    /// Load at a time (N), downwards.
    pub fn load_at(&self, t: f64) -> f64 {
        if let Some(table) = &self.0.load_table {
            load_at(table, t)
        } else if t < self.0.ramp_s {
            self.0.load_n * t / self.0.ramp_s
        } else {
            self.0.load_n
        }
    }

    /// Sideways displacement D at a time (m).
    pub fn lateral_at(&self, t: f64) -> f64 {
        self.0.amplitude_m * self.angle_at(t).sin()
    }

    /// Sideways velocity at a time (m/s), that of the motion from t_s on.
    pub fn speed_at(&self, t: f64) -> f64 {
        if t < self.motion_start() {
            return 0.0;
        }
        TAU * self.0.frequency_hz * self.0.amplitude_m * self.angle_at(t).cos()
    }

    fn angle_at(&self, t: f64) -> f64 {
        TAU * self.0.frequency_hz * (t - self.motion_start()).max(0.0)
    }

    /// t_s (s).
    pub fn motion_start(&self) -> f64 {
        self.0.ramp_s + self.0.hold_s
    }

    /// End of the history (s).
    pub fn end(&self) -> f64 {
        if self.0.cycles > 0.0 {
            self.motion_start() + self.0.cycles / self.0.frequency_hz
        } else {
            self.motion_start()
        }
    }

    /// Periods since t_s; none before.
    pub fn periods_at(&self, t: f64) -> Option<f64> {
        (self.0.cycles > 0.0 && t >= self.motion_start())
            .then(|| self.0.frequency_hz * (t - self.motion_start()))
    }

    /// One period (s).
    pub fn period(&self) -> f64 {
        1.0 / self.0.frequency_hz
    }

    /// Start and end of the last full cycle (s).
    pub fn last_full_cycle(&self) -> Option<[f64; 2]> {
        let full = self.0.cycles.floor();
        let at = |cycle: f64| self.motion_start() + cycle / self.0.frequency_hz;
        (full >= 1.0).then(|| [at(full - 1.0), at(full)])
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// 8 000 N in 0.5 ms, 0.4 ms of hold, then 2.25 cycles of 50 um at 300 Hz.
    pub(in crate::wheel) fn program() -> Program {
        Program(WheelConfig {
            load_n: 8000.0,
            load_table: None,
            mass_kg: 1.0,
            radius_m: 0.0,
            amplitude_m: 5e-5,
            frequency_hz: 300.0,
            ramp_s: 5e-4,
            hold_s: 4e-4,
            cycles: 2.25,
        })
    }

    #[test]
    fn the_load_ramps_then_holds() {
        assert_eq!(program().load_at(2.5e-4), 4000.0);
        assert_eq!(program().load_at(1.0), 8000.0);
    }

    #[test]
    fn a_table_is_the_load_in_place_of_the_ramp() {
        let mut program = program();
        let table = vec![[0.0, 1000.0], [4e-4, 5000.0], [9e-4, 8000.0], [1.9e-3, 0.0]];
        program.0.load_table = Some(table);
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
        assert_eq!(program.lateral_at(9e-4), 0.0);
        assert_eq!(program.speed_at(8.9e-4), 0.0);
        let full = TAU * 300.0 * 5e-5;
        assert!((program.speed_at(9.0e-4) / full - 1.0).abs() < 1e-12);
        let measured = program.lateral_at(9e-4 + 1e-8) / 1e-8;
        assert!((measured - full).abs() < 1e-6, "{measured}");
    }

    #[test]
    fn the_last_full_cycle_is_the_second_of_two_and_a_quarter() {
        let [start, end] = program().last_full_cycle().expect("there are two");
        assert!((start - (9e-4 + 1.0 / 300.0)).abs() < 1e-12);
        assert!((end - (9e-4 + 2.0 / 300.0)).abs() < 1e-12);
    }
}
