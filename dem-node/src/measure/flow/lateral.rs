//! Third body that leaves the zone sideways, out of the plane: a sink that a plane model lacks.

use dem_kernel::bodies::Bodies;
use dem_kernel::random::RandomNumbers;
use dem_kernel::step::state::GrainState;

use super::{Flow, FlowScene};
use crate::measure::loads::shown;

kit::results! {
    /// # Flows of third body
    /// - `q_lateral_kg`: Ql: mass that left the zone sideways, out of the plane (`flow.lateral`).
    /// # Signals of the ledger
    /// - `lateral_j`: Energy of the grains that left the plane since the start.
}

/// Separates these random numbers from others.
const STREAM: u64 = 0x4c61_7465;

impl Flow {
    /// Takes third body out of the zone sideways, at the rate of its mass over `flow.lateral.time_s`, after a step of the length `step` (s). Grains
    /// are drawn at random, one when half a mean grain is due, so that the mass that has left is right within half a grain. Returns the numbers of
    /// the grains.
    pub fn leave_sideways(
        &mut self,
        scene: &FlowScene,
        (bodies, state): (&Bodies, &GrainState),
        step: f64,
    ) -> Vec<usize> {
        let mut leaving = Vec::new();
        let Some(lateral) = scene.config.lateral else {
            return leaving;
        };
        self.lateral_due += self.held * step / lateral.time_s;
        let mean = scene.masses.iter().sum::<f64>() / scene.masses.len() as f64;
        while self.lateral_due >= 0.5 * mean {
            let grains = state
                .grains(bodies)
                .filter(|grain| !leaving.contains(grain));
            let loose = grains.filter(|i| self.grains[*i].inside && self.grains[*i].is_third());
            let loose: Vec<usize> = loose.collect();
            let mut random = RandomNumbers::new(scene.seed ^ STREAM ^ (self.lateral_grains << 32));
            let drawn = (random.unit() * loose.len() as f64) as usize;
            let Some(grain) = loose.get(drawn).copied() else {
                break;
            };
            let ([x, _], mass) = (shown(bodies, state.centres[grain]), scene.masses[grain]);
            self.lateral_due -= mass;
            self.lateral_grains += 1;
            self.ledger.lateral += mass;
            self.held -= mass;
            if self.middle.is_some_and(|middle| middle.holds(x)) {
                self.in_middle -= mass;
            }
            leaving.push(grain);
        }
        leaving
    }
}
