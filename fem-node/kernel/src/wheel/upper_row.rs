//! The upper row of nodes, as the contact with the wheel sees it.

/// The upper row at the end of a step, before its contact forces are known; every field holds a row of nodes.
pub struct UpperRow<'a> {
    /// New displacements (m).
    pub u: &'a [f64],
    /// Velocities at the start of the step (m/s).
    pub v: &'a [f64],
    /// Accelerations at the start of the step (m/s2).
    pub a: &'a [f64],
    /// New internal forces (N).
    pub force: &'a [f64],
    /// Applied forces at the end of the step (N).
    pub load: &'a [f64],
    /// Inverse masses (1/kg).
    pub inverse_mass: &'a [f64],
}
