//! Loads of the tests: small, known, and the same in every launch.

use std::f64::consts::PI;

use super::tested::{Part, TestedParticipant};
use crate::random::Random;

/// Motion of a window under a load, over the distance between the points: small enough for every law to be linear.
const MOTION: f64 = 1e-6;

/// Motion of a boundary in a window, over the size of its points: enough to close the contacts of a layer at rest.
const APPROACH: f64 = 1e-4;

/// Loads on all exchanged components: forces (N), or velocities of a boundary (m/s).
#[derive(Clone, Debug)]
pub struct TrialLoads {
    scale: f64,
    /// Mean of the loads.
    mean: [f64; 2],
    /// Size of the random part.
    chance: f64,
    points: usize,
}

impl TrialLoads {
    /// Forces under which points at this spacing (m) move by a millionth of it in a window; `softest_m_per_n` is the motion of the softest
    /// point.
    pub fn forces(points: usize, spacing_m: f64, softest_m_per_n: f64) -> TrialLoads {
        TrialLoads {
            scale: MOTION * spacing_m / softest_m_per_n,
            mean: [0.0; 2],
            chance: 1.0,
            points,
        }
    }

    /// Velocities that press points of this size (m) into a layer, in the direction `into`.
    pub fn velocities(points: usize, size_m: f64, into: [f64; 2], window_s: f64) -> TrialLoads {
        TrialLoads {
            scale: APPROACH * size_m / window_s,
            mean: into,
            chance: 0.1,
            points,
        }
    }

    /// No load at all.
    pub fn none(&self) -> Vec<f64> {
        vec![0.0; 2 * self.points]
    }

    /// The load of a window; another `draw` gives another load for the same window.
    pub fn of_window(&self, index: u64, draw: u64) -> Vec<f64> {
        let mut random = Random::new(index.wrapping_mul(1_000_003).wrapping_add(draw));
        let mut drawn = |mean| mean + self.chance * (2.0 * random.share() - 1.0);
        let means = self.mean.iter().cycle().take(2 * self.points);
        means.map(|mean| self.scale * drawn(mean)).collect()
    }

    /// Forces that grow from zero and return to it within `windows`; velocities that come and go.
    pub fn slow(&self, index: u64, windows: u64, part: Part) -> Vec<f64> {
        let at = (index as f64 + 0.5) / windows as f64;
        let factor = match part {
            Part::MotionDriven => 0.1 * (2.0 * PI * at).sin(),
            _ => (PI * at).sin().powi(2),
        };
        let whole = self.of_window(0, 0);
        whole.iter().map(|load| factor * load).collect()
    }
}

/// The direction into the layer: against the outward normal of its first set.
pub fn into(tested: &TestedParticipant) -> Option<[f64; 2]> {
    let outward = tested.description.outward.get(tested.sets.first()?)?;
    Some(outward.map(|component| -component))
}
