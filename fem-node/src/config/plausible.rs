//! The bounds of the checks of plausibility.

kit::plausible_bounds! {
    /// `plausible`: bounds `[warn, suspect]` of each check, larger values being worse.
    FemPlausibleConfig {
        /// Largest distance of the wheel's force from its load in the second half of the hold, over the load.
        wheel_force_rel = [0.05, 0.2],
        /// Distance of the outermost node in contact from the middle of the upper edge, over that of the edge's end, where wheel
        /// or edge is curved.
        contact_reach_rel = [0.5, 0.9],
        /// One over the number of nodes in a curved contact: three nodes of 0.4 mm are off by 1 to 10 % in approach and peak pressure, five by
        /// 0.6 %.
        contact_resolution = [0.3, 0.8],
        /// Largest strain of a centroid, under small-strain kinematics the largest displacement gradient, rotation included.
        strain = [0.1, 0.3],
        /// Change of the wheel's height over the last period, where its displacement is 0, over the amplitude of its motion: 0.5 um of 50 um are
        /// a work of the load of 4.5 % of the friction loop of `wheel-rail-fe-small`.
        cycle_drift_rel = [0.01, 0.1],
        /// Largest equivalent plastic strain over the elastic one Y/(3 mu) at first yield, where the element is not `q4_bbar`: in
        /// plastic flow, which keeps the volume, `q4_2x2` is too stiff and `q4_1point` hardly held against hourglass modes.
        plastic_element = [0.0, 1e300],
        /// Strain energy by which the elements miss that of bending, over all strain energy, while the body is elastic: about the share by
        /// which displacements under a load are off.
        locking_rel = [0.05, 0.3],
    }
}
