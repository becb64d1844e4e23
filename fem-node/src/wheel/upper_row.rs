//! The upper row of nodes, as the contact with the wheel sees it.

/// The upper row at the end of a step, before its contact forces are known; every field holds a row of nodes.
pub(crate) struct UpperRow<'a> {
    /// New displacements (m).
    pub(crate) u: &'a [f64],
    /// Velocities at the start of the step (m/s).
    pub(crate) v: &'a [f64],
    /// Accelerations at the start of the step (m/s2).
    pub(crate) a: &'a [f64],
    /// New internal forces (N).
    pub(crate) force: &'a [f64],
    /// Applied forces at the end of the step (N).
    pub(crate) load: &'a [f64],
    /// Inverse masses (1/kg).
    pub(crate) inverse_mass: &'a [f64],
}
