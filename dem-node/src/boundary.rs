//! The compliant boundary: massless glued disks on a body that another solver moves, v_g = a_g + W_g p.

use crate::error::DemError;

/// The boundary of n glued disks during a step: their velocities are v_g = a_g + W_g p, with a_g without contact forces,
/// p the contact impulses on them and W_g the compliance of the body over a window (the dual Schur relation of
/// Gravouil and Combescure 2001, as the coupler announces it). Velocities and impulses are (2 n): x0, y0, x1, y1, ...
#[derive(Clone, Debug, Default)]
pub struct CompliantBoundary {
    /// W_g (1/kg), 2 n x 2 n, column-major; empty for a fixed boundary.
    compliance: Vec<f64>,
    /// a_g (m/s).
    free_velocity: Vec<f64>,
    /// v_g (m/s).
    pub velocity: Vec<f64>,
    /// Contact impulses on the glued disks, p (N s).
    pub impulse: Vec<f64>,
}

impl CompliantBoundary {
    /// A fixed boundary of so many glued disks.
    pub fn fixed(glued: usize) -> CompliantBoundary {
        CompliantBoundary {
            compliance: Vec::new(),
            free_velocity: vec![0.0; 2 * glued],
            velocity: vec![0.0; 2 * glued],
            impulse: vec![0.0; 2 * glued],
        }
    }

    /// Refuses a compliance that is no square over so many disks, or that moves a disk against its force.
    pub fn refuse_misfit(glued: usize, compliance: &[f64]) -> Result<(), DemError> {
        let components = 2 * glued;
        if compliance.len() != components * components {
            return Err(DemError::Request(format!(
                "the wall's compliance holds {} numbers, {glued} glued disks need {components} x {components}",
                compliance.len()
            )));
        }
        if let Some(i) = compliance.iter().position(|w| !w.is_finite()) {
            return Err(DemError::Request(format!(
                "the wall's compliance holds {} at component {i}, which is no number",
                compliance[i]
            )));
        }
        if let Some(i) = (0..components).find(|i| compliance[i * (components + 1)] < 0.0) {
            return Err(DemError::Request(format!(
                "the wall's compliance has {:e} on its diagonal at component {i}: a wall cannot move against its force",
                compliance[i * (components + 1)]
            )));
        }
        Ok(())
    }

    /// A boundary with this compliance (1/kg), 2 n x 2 n, column-major.
    pub fn compliant(glued: usize, compliance: Vec<f64>) -> CompliantBoundary {
        // Rigid motion costs nothing when the whole matrix is zero.
        let rigid = compliance.iter().all(|w| *w == 0.0);
        CompliantBoundary {
            compliance: if rigid { Vec::new() } else { compliance },
            ..CompliantBoundary::fixed(glued)
        }
    }

    /// True if it moves with the forces on it.
    pub fn is_compliant(&self) -> bool {
        !self.compliance.is_empty()
    }

    /// Starts a step: the boundary moves with a_g (2 n), no impulse acts on it.
    pub fn start(&mut self, free_velocity: &[f64]) {
        self.free_velocity.clear();
        self.free_velocity.extend_from_slice(free_velocity);
        self.velocity.clear();
        self.velocity.extend_from_slice(free_velocity);
        self.impulse.fill(0.0);
    }

    /// Adds an impulse (N s) on a glued disk; all glued disks follow with two columns of W_g.
    #[inline]
    pub fn apply(&mut self, disk: usize, impulse: [f64; 2]) {
        self.gather(disk, impulse);
        let components = self.velocity.len();
        if self.compliance.is_empty() {
            return;
        }
        let columns = &self.compliance[2 * disk * components..(2 * disk + 2) * components];
        add_columns(&mut self.velocity, columns, impulse);
    }

    /// Adds an impulse (N s) that the boundary follows at the next [`CompliantBoundary::evaluate`].
    #[inline]
    pub fn gather(&mut self, disk: usize, impulse: [f64; 2]) {
        self.impulse[2 * disk] += impulse[0];
        self.impulse[2 * disk + 1] += impulse[1];
    }

    /// W_g p of any impulses (2 n), without changing the boundary.
    pub fn times_compliance(&self, impulse: &[f64], velocity: &mut [f64]) {
        velocity.fill(0.0);
        if self.compliance.is_empty() {
            return;
        }
        let columns = self.compliance.chunks_exact(2 * velocity.len());
        for (pair, p) in columns.zip(impulse.chunks_exact(2)) {
            add_columns(velocity, pair, [p[0], p[1]]);
        }
    }

    /// Velocity of a glued disk (m/s).
    #[inline]
    pub fn velocity_of(&self, disk: usize) -> [f64; 2] {
        [self.velocity[2 * disk], self.velocity[2 * disk + 1]]
    }

    /// The block of W_g at a glued disk, 2 x 2, row by row (1/kg). A measured one is not quite symmetric.
    pub fn block(&self, disk: usize) -> [[f64; 2]; 2] {
        if self.compliance.is_empty() {
            return [[0.0; 2]; 2];
        }
        let components = self.velocity.len();
        let at = |row: usize, column: usize| self.compliance[column * components + row];
        let (x, y) = (2 * disk, 2 * disk + 1);
        [[at(x, x), at(x, y)], [at(y, x), at(y, y)]]
    }

    /// Evaluates v_g = a_g + W_g p anew, without the rounding of the many small changes (Gravouil and Combescure 2001).
    pub fn evaluate(&mut self) {
        let impulse = self.impulse.clone();
        self.velocity.copy_from_slice(&self.free_velocity);
        self.impulse.fill(0.0);
        for (disk, p) in impulse.chunks_exact(2).enumerate() {
            self.apply(disk, [p[0], p[1]]);
        }
    }
}

/// Adds two neighbouring columns times the components of an impulse.
#[inline]
fn add_columns(velocity: &mut [f64], columns: &[f64], [p_x, p_y]: [f64; 2]) {
    if p_x == 0.0 && p_y == 0.0 {
        return;
    }
    let (x_column, y_column) = columns.split_at(velocity.len());
    for ((v, x), y) in velocity.iter_mut().zip(x_column).zip(y_column) {
        *v += x * p_x + y * p_y;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impulses_move_every_glued_disk_by_their_columns() {
        let compliance: Vec<f64> = (0..16).map(f64::from).collect();
        let mut boundary = CompliantBoundary::compliant(2, compliance);
        boundary.start(&[1.0, 0.0, 0.0, 0.0]);
        boundary.apply(1, [1.0, -1.0]);
        // columns 2 = (8..12) and 3 = (12..16): their difference is -4 everywhere
        assert_eq!(boundary.velocity, [-3.0, -4.0, -4.0, -4.0]);
        boundary.evaluate();
        assert_eq!(boundary.velocity, [-3.0, -4.0, -4.0, -4.0]);
        assert_eq!(boundary.block(1), [[10.0, 14.0], [11.0, 15.0]]);
    }

    #[test]
    fn a_matrix_of_another_size_is_refused() {
        let error =
            CompliantBoundary::refuse_misfit(2, &[0.0; 4]).expect_err("2 disks need 16 numbers");
        assert!(error.to_string().contains("4 x 4"), "{error}");
    }
}
