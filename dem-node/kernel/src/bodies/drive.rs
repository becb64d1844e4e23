//! Clusters that are moved or pushed along x and y: driven rough walls.
//!
//! A prescribed direction has a constant velocity under any contact forces. In a free direction m dv = h F + p - h c v_theta, p being the impulse of
//! the contacts and the weight and c the damping, which is implicit: v' = ((m - h c (1 - theta)) v + h F + p) / (m + h c theta).

use kit::table::{LoadTable, load_at};

/// Loads of a driven cluster.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drive {
    /// Name of the cluster.
    pub name: String,
    /// Force over time along x and y (s, N).
    pub forces: [LoadTable; 2],
    /// Force against the motion over its speed (N s/m).
    pub damping: f64,
}

/// The time at which the loads of a step are taken, and its length.
#[derive(Clone, Copy, Debug)]
pub struct StepTime {
    /// Time (s).
    pub time: f64,
    /// Length of the step (s).
    pub step: f64,
    /// Weight of the end velocity.
    pub theta: f64,
}

impl Drive {
    /// Impulse of the loads along x and y in a step (N s), without the damping.
    pub fn push(&self, at: &StepTime) -> [f64; 2] {
        [0, 1].map(|k| at.step * load_at(&self.forces[k], at.time))
    }

    /// h c, by which a velocity of 1 m/s loses momentum in a step (kg).
    pub fn drag(&self, at: &StepTime) -> f64 {
        at.step * self.damping
    }
}
