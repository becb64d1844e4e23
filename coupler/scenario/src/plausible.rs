//! The bounds of the checks of plausibility that the coupler makes.

kit::plausible_bounds! {
    /// `run.plausible`: bounds `[warn, suspect]` of each check, larger values being worse.
    Plausible {
        /// Largest distance of the force through a participant's interfaces from the load that it says it holds, over the load.
        force_balance_rel = [0.02, 0.1],
        /// Energy that a participant, or all of them, cannot account for, over the work done.
        energy_balance_rel = [0.01, 0.1],
        /// Energy that the interfaces lost or made, over the energy that went through them.
        interface_energy_rel = [0.02, 0.1],
        /// Difference between the work at its interfaces that a participant tells and the one that was exchanged, over the sum of
        /// the sizes of the latter.
        interface_work_rel = [1e-6, 1e-3],
        /// Largest gap between both sides of an interface, over the spacing of its nodes.
        gap_rel = [0.01, 1.0],
        /// Difference in shape (tilt and curvature) between the glued points and the surface of the other side, over the spacing
        /// of the points, less what their roughness may explain.
        surface_offset_rel = [0.01, 0.3],
        /// Mean distance of the glued points from the surface of the other side, over the length that is joined: each side may have
        /// an origin of its own, but not one in other units.
        surface_distance_rel = [10.0, 1e3],
        /// Windows that were accepted without having converged, over all.
        not_converged_rel = [0.0, 0.01],
    }
}
