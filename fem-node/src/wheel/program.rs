//! What happens to the wheel over time.

use std::f64::consts::TAU;

use protocol::Phase;

use crate::config::WheelConfig;

/// The load ramps up, is held, and from t_s = ramp + hold on the wheel is moved sideways by
/// D(t) = A sin(2 pi f (t - t_s)), at once at its full speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Program {
    load: f64,
    amplitude: f64,
    frequency: f64,
    ramp: f64,
    hold: f64,
    cycles: f64,
}

impl Program {
    /// The program of a scenario.
    pub fn new(config: &WheelConfig) -> Program {
        Program {
            load: config.load_n,
            amplitude: config.amplitude_m,
            frequency: config.frequency_hz,
            ramp: config.ramp_s,
            hold: config.hold_s,
            cycles: config.cycles,
        }
    }

    /// Full load (N).
    pub fn load(&self) -> f64 {
        self.load
    }

    /// Load at a time (N), downwards.
    pub fn load_at(&self, t: f64) -> f64 {
        match t < self.ramp {
            true => self.load * t / self.ramp,
            false => self.load,
        }
    }

    /// Sideways displacement D at a time (m).
    pub fn drive_at(&self, t: f64) -> f64 {
        self.amplitude * self.angle_at(t).sin()
    }

    /// Sideways velocity at a time (m/s), that of the motion from t_s on.
    pub fn speed_at(&self, t: f64) -> f64 {
        match t < self.motion_start() {
            true => 0.0,
            false => TAU * self.frequency * self.amplitude * self.angle_at(t).cos(),
        }
    }

    fn angle_at(&self, t: f64) -> f64 {
        TAU * self.frequency * (t - self.motion_start()).max(0.0)
    }

    /// When the load is complete (s).
    pub fn ramp_end(&self) -> f64 {
        self.ramp
    }

    /// t_s (s).
    pub fn motion_start(&self) -> f64 {
        self.ramp + self.hold
    }

    /// End of the history (s).
    pub fn end(&self) -> f64 {
        match self.cycles > 0.0 {
            true => self.motion_start() + self.cycles / self.frequency,
            false => self.motion_start(),
        }
    }

    /// Periods since t_s; none before.
    pub fn periods_at(&self, t: f64) -> Option<f64> {
        (self.cycles > 0.0 && t >= self.motion_start())
            .then(|| self.frequency * (t - self.motion_start()))
    }

    /// One period (s).
    pub fn period(&self) -> f64 {
        1.0 / self.frequency
    }

    /// Start and end of the last full cycle (s).
    pub fn last_full_cycle(&self) -> Option<[f64; 2]> {
        let full = self.cycles.floor();
        let at = |cycle: f64| self.motion_start() + cycle / self.frequency;
        (full >= 1.0).then(|| [at(full - 1.0), at(full)])
    }

    /// The named parts of the history; those without duration are left out.
    pub fn phases(&self) -> Vec<Phase> {
        let limits = [0.0, self.ramp, self.motion_start(), self.end()];
        let parts = ["ramp", "hold", "cycling"].iter().zip(limits.windows(2));
        parts
            .filter(|(_, t)| t[1] > t[0])
            .map(|(name, t)| Phase {
                name: name.to_string(),
                t0_s: t[0],
                t1_s: t[1],
                sampled: *name == "hold",
                picture: *name != "ramp",
            })
            .collect()
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// 8 000 N in 0.5 ms, 0.4 ms of hold, then 2.25 cycles of 50 um at 300 Hz.
    pub(in crate::wheel) fn program() -> Program {
        Program {
            load: 8000.0,
            amplitude: 5e-5,
            frequency: 300.0,
            ramp: 5e-4,
            hold: 4e-4,
            cycles: 2.25,
        }
    }

    #[test]
    fn the_load_ramps_then_holds() {
        assert_eq!(program().load_at(2.5e-4), 4000.0);
        assert_eq!(program().load_at(1.0), 8000.0);
    }

    #[test]
    fn motion_starts_after_the_hold_at_full_speed() {
        let program = program();
        assert_eq!(program.drive_at(9e-4), 0.0);
        assert_eq!(program.speed_at(8.9e-4), 0.0);
        let full = TAU * 300.0 * 5e-5;
        assert!((program.speed_at(9.0e-4) / full - 1.0).abs() < 1e-12);
        let measured = program.drive_at(9e-4 + 1e-8) / 1e-8;
        assert!((measured - full).abs() < 1e-6, "{measured}");
    }

    #[test]
    fn the_last_full_cycle_is_the_second_of_two_and_a_quarter() {
        let [start, end] = program().last_full_cycle().expect("there are two");
        assert!((start - (9e-4 + 1.0 / 300.0)).abs() < 1e-12);
        assert!((end - (9e-4 + 2.0 / 300.0)).abs() < 1e-12);
    }

    #[test]
    fn parts_without_duration_are_no_phases() {
        let still = Program {
            ramp: 0.0,
            cycles: 0.0,
            ..program()
        };
        let names: Vec<String> = still.phases().into_iter().map(|p| p.name).collect();
        assert_eq!(names, ["hold"]);
    }
}
