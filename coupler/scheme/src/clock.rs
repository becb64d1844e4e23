//! Windows in integer steps, so that rounding never makes two sides disagree about time.

use protocol::Window;

use crate::error::{Result, SchemeError, Unfit};

/// More steps than this count as a mistyped unit: at 0.1 us of wall-clock time a step they take 28 hours.
const STEPS_MAX: f64 = 1e12;

/// The clock of an interface: windows of `substeps` explicit steps of `step_s`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Explicit step (s).
    pub step_s: f64,
    /// Explicit steps in a window.
    pub substeps: u32,
}

impl Clock {
    /// Length of a window (s).
    pub fn window_s(&self) -> f64 {
        self.step_s * f64::from(self.substeps)
    }

    /// The first run of window `index`, `substeps` long, from explicit step `step` on.
    pub fn window(&self, index: u64, step: u64, substeps: u32) -> Window {
        Window {
            index,
            iteration: 0,
            step,
            substeps,
            t0_s: step as f64 * self.step_s,
            t1_s: (step + u64::from(substeps)) as f64 * self.step_s,
        }
    }

    /// Explicit steps until `end_s`; the last one is a whole step. The margin avoids an extra step when the end time is
    /// a multiple of the step up to rounding.
    pub fn steps_until(&self, end_s: f64) -> Result<u64> {
        let steps = (end_s / self.step_s - 1e-6).ceil();
        if steps <= STEPS_MAX {
            return Ok(steps.max(0.0) as u64);
        }
        Err(SchemeError::from(Unfit::TooManySteps {
            steps,
            step_s: self.step_s,
            end_s,
            most: STEPS_MAX,
        }))
    }

    /// Substeps of a full window, or the steps left before `end`.
    pub fn substeps_before(&self, step: u64, end: u64) -> u32 {
        u32::try_from(end - step).map_or(self.substeps, |left| left.min(self.substeps))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_meet_without_a_gap_and_end_at_the_requested_step() {
        let clock = Clock {
            step_s: 1.7e-8,
            substeps: 7,
        };
        assert_eq!(clock.window(5, 35, 7).t1_s, clock.window(6, 42, 7).t0_s);
        let steps = |end: f64| clock.steps_until(end * clock.step_s).expect("few");
        assert_eq!([steps(0.0), steps(70.0), steps(70.5)], [0, 70, 71]);
        assert_eq!(clock.substeps_before(0, 71), 7);
        assert_eq!(clock.substeps_before(70, 71), 1);
    }

    #[test]
    fn an_endless_run_is_refused_with_the_keys_that_set_its_length() {
        let clock = Clock {
            step_s: 1e-8,
            substeps: 1,
        };
        assert_eq!(clock.steps_until(1e4).expect("28 hours"), 1_000_000_000_000);
        for end_s in [1.1e4, 1e30, f64::INFINITY, f64::NAN] {
            let message = clock.steps_until(end_s).expect_err("too long").to_string();
            assert!(message.contains("wheel.ramp_s"), "{message}");
        }
    }
}
