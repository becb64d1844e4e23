//! The bounds of the checks of plausibility.

use kit::{Bounds, ConfigError};
use schemars::JsonSchema;
use serde::Deserialize;

/// `plausible`: bounds `[warn, suspect]` of each check, larger values being worse. The manual has the values of valid and of
/// wrong runs beside them (scenarios/README.md).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DemPlausibleConfig {
    /// Largest overlap of compliant contacts over the mean radius.
    pub overlap_rel: Bounds,
    /// Largest mean overlap of rigid contacts over the mean radius: their geometry is that of grains that do not overlap.
    pub overlap_rigid_rel: Bounds,
    /// Grains that left the layer, over all.
    pub ejected_rel: Bounds,
    /// Largest distance of the wheel's force from its load in the second half of the hold, over the load.
    pub wheel_force_rel: Bounds,
    /// Height that the wheel loses or gains in the second half of the hold, by its trend, over its approach (and 0.01 of the mean
    /// radius). A rail of 1e6 kg/m3 in `quick` is off by 0.5 %, one of 1e7 by 2.7 %.
    pub wheel_drift_rel: Bounds,
    /// Change of the wheel's height over the last period, where its displacement is 0, over the amplitude of its motion: 0.5 um of 50 um are
    /// a work of the load of 4.5 % of the friction loop of `wheel-rail-fe-small`.
    pub cycle_drift_rel: Bounds,
    /// Distance of the mean force on the glued disks from that on the wheel in the second half of the hold, weight and all
    /// fixed bodies being allowed for, over the load.
    pub boundary_force_rel: Bounds,
    /// Force that moves the mass added by `mass_scale`, over the force that goes through the grains, both summed over the last
    /// half of the steps or a little more, without a wheel's ramp.
    pub added_inertia_rel: Bounds,
    /// Energy of springs and bonds that detection changes between two steps, sizes summed, over what the grains have stored
    /// and dissipated. Pairs that pass each other by s turn their normal and open by s^2 / (2 (r_1 + r_2)), of first order in
    /// the step over a run; a gap or a normal that is wrong does more.
    pub detection_rel: Bounds,
    /// Energy that rigid contacts have made over what the grains have stored and dissipated, contact by contact: Newton's restitution with friction
    /// can make some (Kane and Levinson 1985), a true law none.
    pub impact_energy_rel: Bounds,
    /// Way of a grain in a step, over the smaller radius: past another disk that it presses on, or into a wall or a wheel; along the weight, for
    /// theta = 1.
    pub grain_travel_rel: Bounds,
    /// Most grains at once that overlap a wall of points from behind, over all.
    pub behind_wall_rel: Bounds,
    /// Half-width of 98 % of the wheel's force over that of a layer that ends there. Against the rail alone, two loads that
    /// rub with partial slip lost 6 % of their friction loop at 0.72 and 17 % at 0.83, and 1 to 4 % at 0.66.
    pub contact_width_rel: Bounds,
    /// One over the fewest contacts that carry 0.9 of the wheel's force, the mean over the second half of the hold or, if those are
    /// fewer, over the motion. It never exceeds 1: what few disks carry may be meant so.
    pub wheel_contact_share: Bounds,
    /// Largest residual of a contact solve. In `quick` the mean friction is off by 0.2 % at 1e-3, 1.8 % at 3e-3 and 4 % at 1e-2.
    pub contact_residual: Bounds,
    /// Step or window over the bound of the bonds, 1/(sqrt(3) omega), where some bond bore more than half its strength. Above it a bond
    /// may hold with more than its fracture energy against it.
    pub bond_step_rel: Bounds,
    /// Energy that decohesion took less than that of the surface which bonds gave up, over the latter, where that is a thousandth of what the
    /// grains were given.
    pub bond_energy_rel: Bounds,
    /// Energy that the scheme took over all that the grains were given, where drives, walls, weight or their flight at the start gave a tenth of
    /// that at least.
    pub numerical_rel: Bounds,
    /// Kinetic stress of the grains in the zone of a flow over the pressure of the wheel, mean over the run.
    pub flow_kinetic_rel: Bounds,
    /// Mass that found no place to be fed in, over the mass that was due.
    pub injection_rel: Bounds,
    /// Steps of a run alone that were accepted without having converged, over all.
    pub not_converged_rel: Bounds,
}

impl Default for DemPlausibleConfig {
    fn default() -> DemPlausibleConfig {
        let bounds = |warn, suspect| Bounds { warn, suspect };
        DemPlausibleConfig {
            overlap_rel: bounds(0.3, 1.0),
            overlap_rigid_rel: bounds(2e-3, 0.1),
            ejected_rel: bounds(0.0, 0.1),
            wheel_force_rel: bounds(0.05, 0.2),
            wheel_drift_rel: bounds(0.03, 0.3),
            cycle_drift_rel: bounds(0.01, 0.1),
            boundary_force_rel: bounds(0.02, 0.1),
            added_inertia_rel: bounds(0.1, 0.4),
            detection_rel: bounds(5e-3, 3e-2),
            impact_energy_rel: bounds(1e-4, 1e-3),
            grain_travel_rel: bounds(0.3, 1.0),
            behind_wall_rel: bounds(0.0, 0.1),
            contact_width_rel: bounds(0.71, 0.95),
            wheel_contact_share: bounds(0.2, 1.0),
            contact_residual: bounds(2e-3, 0.3),
            bond_step_rel: bounds(1.0, 4.0),
            bond_energy_rel: bounds(0.1, 0.5),
            numerical_rel: bounds(0.1, 0.5),
            flow_kinetic_rel: bounds(1e-3, 1e-2),
            injection_rel: bounds(0.02, 0.5),
            not_converged_rel: bounds(0.0, 0.01),
        }
    }
}

impl DemPlausibleConfig {
    /// Refuses bounds that are not in order.
    pub fn validate(&self) -> Result<(), ConfigError> {
        let all = [
            ("overlap_rel", self.overlap_rel),
            ("overlap_rigid_rel", self.overlap_rigid_rel),
            ("ejected_rel", self.ejected_rel),
            ("wheel_force_rel", self.wheel_force_rel),
            ("wheel_drift_rel", self.wheel_drift_rel),
            ("cycle_drift_rel", self.cycle_drift_rel),
            ("added_inertia_rel", self.added_inertia_rel),
            ("detection_rel", self.detection_rel),
            ("impact_energy_rel", self.impact_energy_rel),
            ("grain_travel_rel", self.grain_travel_rel),
            ("behind_wall_rel", self.behind_wall_rel),
            ("boundary_force_rel", self.boundary_force_rel),
            ("contact_width_rel", self.contact_width_rel),
            ("wheel_contact_share", self.wheel_contact_share),
            ("contact_residual", self.contact_residual),
            ("bond_step_rel", self.bond_step_rel),
            ("bond_energy_rel", self.bond_energy_rel),
            ("numerical_rel", self.numerical_rel),
            ("flow_kinetic_rel", self.flow_kinetic_rel),
            ("injection_rel", self.injection_rel),
            ("not_converged_rel", self.not_converged_rel),
        ];
        Bounds::check_all("plausible", all)
    }
}
