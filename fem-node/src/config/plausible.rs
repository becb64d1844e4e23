//! The bounds of the checks of plausibility.

use kit::{Bounds, ConfigError};
use schemars::JsonSchema;
use serde::Deserialize;

/// `plausible`: bounds `[warn, suspect]` of each check, larger values being worse.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FemPlausibleConfig {
    /// Largest distance of the wheel's force from its load in the second half of the hold, over the load.
    pub wheel_force_rel: Bounds,
    /// Distance of the outermost node in contact from the middle of the upper edge, over that of the edge's end, where wheel
    /// or edge is curved.
    pub contact_reach_rel: Bounds,
    /// One over the number of nodes in a curved contact: three nodes of 0.4 mm are off by 1 to 10 % in approach and peak pressure, five by
    /// 0.6 %.
    pub contact_resolution: Bounds,
    /// Largest strain of a centroid, under small-strain kinematics the largest displacement gradient, rotation included.
    pub strain: Bounds,
    /// Change of the wheel's height over the last period, where its displacement is 0, over the amplitude of its motion: 0.5 um of 50 um are
    /// a work of the load of 4.5 % of the friction loop of `wheel-rail-fe-small`.
    pub cycle_drift_rel: Bounds,
    /// Largest equivalent plastic strain over the elastic one Y/(3 mu) at first yield, where the element is not `q4_bbar`: in
    /// plastic flow, which keeps the volume, `q4_2x2` is too stiff and `q4_1point` hardly held against hourglass modes.
    pub plastic_element: Bounds,
    /// Strain energy by which the elements miss that of bending, over all strain energy, while the body is elastic: about the share by
    /// which displacements under a load are off.
    pub locking_rel: Bounds,
}

impl Default for FemPlausibleConfig {
    fn default() -> FemPlausibleConfig {
        let bounds = |warn, suspect| Bounds { warn, suspect };
        FemPlausibleConfig {
            wheel_force_rel: bounds(0.05, 0.2),
            contact_reach_rel: bounds(0.5, 0.9),
            contact_resolution: bounds(0.3, 0.8),
            strain: bounds(0.1, 0.3),
            cycle_drift_rel: bounds(0.01, 0.1),
            plastic_element: bounds(0.0, 1e300),
            locking_rel: bounds(0.05, 0.3),
        }
    }
}

impl FemPlausibleConfig {
    pub(super) fn check(&self) -> Result<(), ConfigError> {
        let all = [
            ("wheel_force_rel", self.wheel_force_rel),
            ("contact_reach_rel", self.contact_reach_rel),
            ("contact_resolution", self.contact_resolution),
            ("strain", self.strain),
            ("cycle_drift_rel", self.cycle_drift_rel),
            ("plastic_element", self.plastic_element),
            ("locking_rel", self.locking_rel),
        ];
        Bounds::check_all("plausible", all)
    }
}
