//! Prescribed motions of named sets over time.
//!
//! A moved component has the displacement D of its motion at the end of every step, u' = D(t + h), regardless of rounding at its start: the step has
//! the velocity (D(t + h) - u)/h and no acceleration.

use fem_kernel::element::layout::Layout;
use kit::table::{LoadTable, load_at, slope_at};
use kit::wheel::WheelProgram;

use crate::config::motion::{SetMotion, by_direction, settled_at};

/// Components whose motion is prescribed.
#[derive(Clone, Debug, PartialEq)]
pub struct PrescribedMotion {
    /// The moved set.
    pub set: String,
    /// Component, and its velocity after the ramp (m/s), its displacement at the end of the ramp (m), or its share of a displacement over time.
    pub components: Vec<(usize, f64)>,
    pub(crate) history: MotionHistory,
}

/// A motion over time, divided by the number of its component.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum MotionHistory {
    Velocity(Ramp),
    Displacement(Ramp),
    /// Displacements along x and y, and the time from which they are constant (s).
    Table([LoadTable; 2], f64),
    /// The motion of a wheel without a load.
    Reciprocating(WheelProgram),
}

impl MotionHistory {
    pub(crate) fn new(motion: SetMotion, ramp: Ramp) -> MotionHistory {
        match motion {
            SetMotion::Velocity(_) => MotionHistory::Velocity(ramp),
            SetMotion::Displacement(_) => MotionHistory::Displacement(ramp),
            SetMotion::Table(table) => MotionHistory::Table(by_direction(table), settled_at(table)),
            SetMotion::Reciprocating(motion) => MotionHistory::Reciprocating(WheelProgram {
                hold_s: motion.start_s,
                amplitude_m: motion.amplitude_m,
                frequency_hz: motion.frequency_hz,
                // Until the end of the run.
                cycles: f64::INFINITY,
                ..WheelProgram::default()
            }),
        }
    }

    /// Displacement along x and y at time t, divided by the number of the component (m).
    pub(crate) fn displacement(&self, t: f64) -> [f64; 2] {
        match self {
            MotionHistory::Velocity(ramp) => [ramp.elapsed(t); 2],
            MotionHistory::Displacement(ramp) => [ramp.share(t); 2],
            MotionHistory::Table(along, _) => [0, 1].map(|k| load_at(&along[k], t)),
            MotionHistory::Reciprocating(program) => [program.displacement_at(t); 2],
        }
    }

    /// Velocity along x and y from time t on, divided by the number of the component (m/s).
    pub(crate) fn velocity(&self, t: f64) -> [f64; 2] {
        match self {
            MotionHistory::Velocity(ramp) => [ramp.share(t); 2],
            MotionHistory::Displacement(ramp) if t < ramp.duration => [1.0 / ramp.duration; 2],
            MotionHistory::Displacement(_) => [0.0; 2],
            MotionHistory::Table(along, _) => [0, 1].map(|k| slope_at(&along[k], t)),
            MotionHistory::Reciprocating(program) => [program.speed_at(t); 2],
        }
    }

    /// Time (s) at which its ramp or its table ends.
    pub(crate) fn settled_at(&self) -> f64 {
        match self {
            MotionHistory::Velocity(ramp) | MotionHistory::Displacement(ramp) => ramp.duration,
            MotionHistory::Table(_, settled) => *settled,
            MotionHistory::Reciprocating(_) => 0.0,
        }
    }

    /// Time (s) at which the motion to and fro starts.
    pub(crate) fn cycles_from(&self) -> Option<f64> {
        match self {
            MotionHistory::Reciprocating(program) => Some(program.motion_start()),
            _ => None,
        }
    }
}

impl PrescribedMotion {
    /// Components of the force on the body (N), by the names of their signals.
    pub(crate) fn reactions(&self, force: [f64; 2]) -> impl Iterator<Item = (String, f64)> {
        let named = ["x", "y"].into_iter().zip(force);
        named.map(|(direction, force)| (format!("{}_reaction_{direction}_n", self.set), force))
    }

    /// Displacements at time t along the directions that are not free (m), by the names of their signals.
    pub(crate) fn displacements(&self, layout: Layout, t: f64) -> Vec<(String, f64)> {
        if let MotionHistory::Velocity(_) | MotionHistory::Displacement(_) = self.history {
            return Vec::new();
        }
        let displacement = self.history.displacement(t);
        let along = |(k, direction): (usize, &str)| {
            let mut components = self.components.iter();
            let (_, share) = components.find(|(index, _)| layout.direction(*index) == k)?;
            let name = format!("{}_displacement_{direction}_m", self.set);
            Some((name, displacement[k] * share))
        };
        let directions = ["x", "y"].into_iter().enumerate();
        directions.filter_map(along).collect()
    }
}

/// A linear rise from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ramp {
    /// Duration (s).
    pub(crate) duration: f64,
}

impl Ramp {
    /// Share at time t (s).
    pub(crate) fn share(self, t: f64) -> f64 {
        if self.duration > 0.0 {
            (t / self.duration).clamp(0.0, 1.0)
        } else {
            1.0
        }
    }

    /// The integral of [`Ramp::share`] from 0 to t (s).
    fn elapsed(self, t: f64) -> f64 {
        if t < self.duration {
            0.5 * t * t / self.duration
        } else {
            t - 0.5 * self.duration
        }
    }
}
