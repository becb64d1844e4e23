//! The rigid wheel above the grains: its load, its sideways motion and the phases of both.

use std::f64::consts::TAU;

use kit::table::load_at;
use protocol::Phase;

use crate::config::wheel::WheelConfig;

/// Load and motion of the wheel over time: the load ramps up, is held, and from t_s = ramp + hold on the wheel is moved
/// sideways by D(t) = A sin(2 pi f (t - t_s)), at once at its full speed.
impl WheelConfig {
    /// Load at a time (N), downwards.
    pub fn load_at(&self, t: f64) -> f64 {
        if let Some(table) = &self.load_table {
            return load_at(table, t);
        }
        if t >= self.ramp_s {
            return self.load_n;
        }
        self.load_n * t / self.ramp_s
    }

    /// Sideways displacement D(t) = A sin(2 pi f (t - t_s)) at a time (m).
    pub fn displacement_at(&self, t: f64) -> f64 {
        let since = t - self.motion_start();
        if since <= 0.0 {
            return 0.0;
        }
        self.amplitude_m * (TAU * self.frequency_hz * since).sin()
    }

    /// Highest sideways speed (m/s).
    pub fn top_speed(&self) -> f64 {
        if self.cycles > 0.0 {
            self.angular_frequency() * self.amplitude_m
        } else {
            0.0
        }
    }

    /// 2 pi f of the sideways motion (1/s).
    pub fn angular_frequency(&self) -> f64 {
        TAU * self.frequency_hz
    }

    /// t_s (s).
    pub fn motion_start(&self) -> f64 {
        self.ramp_s + self.hold_s
    }

    /// True for the step, by its start and end (s), after which the hold is over; of two that share the end evenly, for both.
    pub fn ends_hold(&self, [start, end]: [f64; 2]) -> bool {
        let middle = 0.5 * (start + end);
        let next = 2.0 * end - middle;
        self.hold_s > 0.0 && (middle..=next).contains(&self.motion_start())
    }

    /// Start and end of the last full cycle (s).
    pub fn last_full_cycle(&self) -> Option<(f64, f64)> {
        let full = self.cycles.floor();
        let at = |cycle: f64| self.motion_start() + cycle / self.frequency_hz;
        (full >= 1.0).then(|| (at(full - 1.0), at(full)))
    }

    /// The named parts of the history; those without duration are left out.
    pub fn phases(&self) -> Vec<Phase> {
        let limits = [0.0, self.ramp_s, self.motion_start(), self.end()];
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
mod tests {
    use super::*;
    use crate::config::wheel::FaceKind;

    fn program() -> WheelConfig {
        WheelConfig {
            load_n: 8000.0,
            load_table: None,
            mass_kg: 0.01,
            radius_m: 0.0,
            face: FaceKind::Flat,
            bonded: false,
            vy_m_per_s: 0.0,
            amplitude_m: 5e-5,
            frequency_hz: 300.0,
            ramp_s: 5e-4,
            hold_s: 4e-4,
            cycles: 2.25,
        }
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
        program.load_table = Some(table);
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
        let speed = program.displacement_at(9e-4 + 1e-8) / 1e-8;
        assert!((speed - TAU * 300.0 * 5e-5).abs() < 1e-6, "{speed}");
    }

    #[test]
    fn the_last_full_cycle_is_the_second_of_two_and_a_quarter() {
        let (start, end) = program().last_full_cycle().expect("there are two");
        assert!((start - (9e-4 + 1.0 / 300.0)).abs() < 1e-12);
        assert!((end - (9e-4 + 2.0 / 300.0)).abs() < 1e-12);
    }

    #[test]
    fn a_ramp_of_no_duration_is_no_phase() {
        let mut program = program();
        program.ramp_s = 0.0;
        let names: Vec<String> = program.phases().into_iter().map(|p| p.name).collect();
        assert_eq!(names, ["hold", "cycling"]);
    }
}
