//! The bounds of the checks of plausibility that the coupler makes.

use kit::{Bounds, ConfigError};
use schemars::JsonSchema;
use serde::Deserialize;

/// `run.plausible`: bounds `[warn, suspect]` of each check, larger values being worse.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Plausible {
    /// Largest distance of the force through a participant's interfaces from the load that it says it holds, over the load.
    pub force_balance_rel: Bounds,
    /// Energy that a participant, or all of them, cannot account for, over the work done.
    pub energy_balance_rel: Bounds,
    /// Energy that the interfaces lost or made, over the energy that went through them.
    pub interface_energy_rel: Bounds,
    /// Difference between the work at its interfaces that a participant tells and the one that was exchanged, over the sum of
    /// the sizes of the latter.
    pub interface_work_rel: Bounds,
    /// Largest gap between both sides of an interface, over the spacing of its nodes.
    pub gap_rel: Bounds,
    /// Difference in shape (tilt and curvature) between the glued points and the surface of the other side, over the spacing
    /// of the points, less what their roughness may explain.
    pub surface_offset_rel: Bounds,
    /// Mean distance of the glued points from the surface of the other side, over the length that is joined: each side may have
    /// an origin of its own, but not one in other units.
    pub surface_distance_rel: Bounds,
    /// Windows that were accepted without having converged, over all.
    pub not_converged_rel: Bounds,
}

impl Default for Plausible {
    fn default() -> Plausible {
        let bounds = |warn, suspect| Bounds { warn, suspect };
        Plausible {
            force_balance_rel: bounds(0.02, 0.1),
            energy_balance_rel: bounds(0.01, 0.1),
            interface_energy_rel: bounds(0.02, 0.1),
            interface_work_rel: bounds(1e-6, 1e-3),
            gap_rel: bounds(0.01, 1.0),
            surface_offset_rel: bounds(0.01, 0.3),
            surface_distance_rel: bounds(10.0, 1e3),
            not_converged_rel: bounds(0.0, 0.01),
        }
    }
}

impl Plausible {
    pub(super) fn check(&self) -> Result<(), ConfigError> {
        let all = [
            ("force_balance_rel", self.force_balance_rel),
            ("energy_balance_rel", self.energy_balance_rel),
            ("interface_energy_rel", self.interface_energy_rel),
            ("interface_work_rel", self.interface_work_rel),
            ("gap_rel", self.gap_rel),
            ("surface_offset_rel", self.surface_offset_rel),
            ("surface_distance_rel", self.surface_distance_rel),
            ("not_converged_rel", self.not_converged_rel),
        ];
        Bounds::check_all("run.plausible", all)
    }
}
