//! The bounds of the checks of plausibility.

kit::plausible_bounds! {
    /// `plausible`: bounds `[warn, suspect]` of each check, larger values being worse. The manual has the values of valid and of
    /// wrong runs beside them (scenarios/README.md).
    DemPlausibleConfig {
        /// Largest overlap of compliant contacts over the mean radius.
        overlap_rel = [0.3, 1.0],
        /// Largest mean overlap of rigid contacts over the mean radius: their geometry is that of grains that do not overlap.
        overlap_rigid_rel = [2e-3, 0.1],
        /// Grains that left the layer, over all.
        ejected_rel = [0.0, 0.1],
        /// Grains whose centre ends behind the face of a body that carries them by more than 0.3 of their radius, over all.
        inside_rel = [0.0, 0.0],
        /// Largest distance of the wheel's force from its load in the second half of the hold, over the load.
        wheel_force_rel = [0.05, 0.2],
        /// Height that the wheel loses or gains in the second half of the hold, by its trend, over its approach (and 0.01 of the mean
        /// radius). A rail of 1e6 kg/m3 in `quick` is off by 0.5 %, one of 1e7 by 2.7 %.
        wheel_drift_rel = [0.03, 0.3],
        /// Change of the wheel's height over the last period, where its displacement is 0, over the amplitude of its motion: 0.5 um of 50 um are
        /// a work of the load of 4.5 % of the friction loop of `wheel-rail-fe-small`.
        cycle_drift_rel = [0.01, 0.1],
        /// Distance of the mean force on the glued disks from that on the wheel in the second half of the hold, weight and all
        /// fixed bodies being allowed for, over the load.
        boundary_force_rel = [0.02, 0.1],
        /// Force that moves the mass added by `mass_scale`, over the force that goes through the grains, both summed over the last
        /// half of the steps or a little more, without a wheel's ramp.
        added_inertia_rel = [0.1, 0.4],
        /// Energy of springs and bonds that detection changes between two steps otherwise than the velocities foretell, sizes summed, over what
        /// the grains have stored and dissipated: a gap or a normal that is wrong, or a way past each other that is long beside the radii.
        detection_rel = [5e-3, 3e-2],
        /// Energy that rigid contacts have made over what the grains have stored and dissipated, contact by contact: Newton's restitution with friction
        /// can make some (Kane and Levinson 1985), a true law none.
        impact_energy_rel = [1e-4, 1e-3],
        /// Way of a grain in a step, over the smaller radius: past another disk that it presses on, or into a wall or a wheel; along the weight, for
        /// theta = 1.
        grain_travel_rel = [0.3, 1.0],
        /// Most grains at once that overlap a wall of points from behind, over all.
        behind_wall_rel = [0.0, 0.1],
        /// Half-width of 98 % of the wheel's force over that of a layer that ends there. Against the rail alone, two loads that
        /// rub with partial slip lost 6 % of their friction loop at 0.72 and 17 % at 0.83, and 1 to 4 % at 0.66.
        contact_width_rel = [0.71, 0.95],
        /// One over the fewest contacts that carry 0.9 of the wheel's force, the mean over the second half of the hold or, if those are
        /// fewer, over the motion. It never exceeds 1: what few disks carry may be meant so.
        wheel_contact_share = [0.2, 1.0],
        /// Largest residual of a contact solve. In `quick` the mean friction is off by 0.2 % at 1e-3, 1.8 % at 3e-3 and 4 % at 1e-2.
        contact_residual = [2e-3, 0.3],
        /// Step or window over the bound of the bonds, 1/(sqrt(3) omega), where some bond bore more than half its strength. Above it a bond
        /// may hold with more than its fracture energy against it.
        bond_step_rel = [1.0, 4.0],
        /// Energy that decohesion took less than that of the surface which bonds gave up, over the latter, where that is a thousandth of what the
        /// grains were given.
        bond_energy_rel = [0.1, 0.5],
        /// Energy that the scheme took, as contacts turn too, over all that the grains were given, where drives, walls, weight or their flight at
        /// the start gave a tenth of that at least; elsewhere what contacts lost as they turned, over what the grains stored and lost.
        numerical_rel = [0.1, 0.5],
        /// Kinetic stress of the grains in the zone of a flow over the pressure of the wheel, mean over the run.
        flow_kinetic_rel = [1e-3, 1e-2],
        /// Change that a cycle of the wheel makes of a fed flow, over the last half of at least eight cycles and beyond the 95 % interval of its trend:
        /// of the third body per length, over its mean, or of the wheel's height, over the mean diameter.
        not_steady_rel = [0.01, 0.5],
        /// Mass that found no place to be fed in, over the mass that was due.
        injection_rel = [0.02, 0.5],
        /// Work of friction on bare surfaces that took nothing off, since as much was gone as may go, over all of it.
        detachment_rel = [0.01, 0.5],
        /// Steps of a run alone that were accepted without having converged, over all.
        not_converged_rel = [0.0, 0.01],
    }
}
