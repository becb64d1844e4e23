//! Windows in integer steps, so that no two sides ever disagree about time by rounding.

use protocol::Window;

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

    /// Window `index`, repeat `iteration`.
    pub fn window(&self, index: u64, iteration: u32) -> Window {
        let step = index * u64::from(self.substeps);
        Window {
            index,
            iteration,
            step,
            substeps: self.substeps,
            t0_s: step as f64 * self.step_s,
            t1_s: (step + u64::from(self.substeps)) as f64 * self.step_s,
        }
    }

    /// Windows until `end_s`, the last one included whole. The margin keeps an end time that is a multiple of the
    /// window up to rounding from costing one window more.
    pub fn windows_until(&self, end_s: f64) -> u64 {
        (end_s / self.window_s() - 1e-6).ceil().max(0.0) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_meet_without_a_gap_and_end_where_asked() {
        let clock = Clock {
            step_s: 1.7e-8,
            substeps: 7,
        };
        assert_eq!(clock.window(41, 0).t1_s, clock.window(42, 3).t0_s);
        assert_eq!(clock.windows_until(10.0 * clock.window_s()), 10);
        assert_eq!(clock.windows_until(10.5 * clock.window_s()), 11);
    }
}
