//! Sources of the compliance of a force-driven participant.

use nalgebra::{DMatrix, DVector};
use protocol::Window;

use super::group::{Group, Side};
use super::nodal_mass::{both_components, nodal_mass};
use super::participants::Participants;
use crate::error::{Result, Unfit};
use crate::keys::{CompliancePrior, CouplingScheme, Dirichlet};

/// Source of a matrix that is still unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ComplianceSource {
    /// The participant's own columns: the motion under a constant force.
    Columns,
    /// Surface masses alone.
    Mass,
    /// H D^-1 with the participant's own impedance D: the change of H v for a change of the force at the end of a
    /// window in which the velocity is linear in time.
    Impedance,
    /// H^2 M_n^-1 with the masses of the points on the nodes, for the components that can move: a line of nodes with
    /// only these masses.
    Points,
    /// No matrix: the motion of the boundary is prescribed.
    Rigid,
}

impl ComplianceSource {
    /// The source of the compliance that a scheme uses.
    pub fn of(scheme: &CouplingScheme) -> ComplianceSource {
        match (scheme, scheme.dirichlet()) {
            (CouplingScheme::DualSchur { compliance, .. }, _) => match compliance {
                CompliancePrior::Columns => ComplianceSource::Columns,
                CompliancePrior::Mass => ComplianceSource::Mass,
            },
            (CouplingScheme::Velocity { .. }, _) => ComplianceSource::Impedance,
            (_, Dirichlet::MotionDriven) => ComplianceSource::Rigid,
            (_, Dirichlet::ForceDriven) => ComplianceSource::Points,
        }
    }

    /// The matrix (m/N), n x n, of one force-driven participant for windows of this length.
    pub fn matrix(
        self,
        participants: &mut dyn Participants,
        group: &Group,
        side: &Side,
        window: &Window,
    ) -> Result<DMatrix<f64>> {
        let first = &side.window(&group.clock.window(0, 0, window.substeps));
        let (steps, n) = (first.substeps, 2 * side.range.len());
        match self {
            ComplianceSource::Columns => participants.compliance(side.peer, first, n),
            ComplianceSource::Mass => Ok(mass_only(group, side, window)),
            ComplianceSource::Impedance => {
                let resists = participants.impedance(side.peer, first, n)?;
                let yields = inverse_of_what_moves(&resists).ok_or_else(|| {
                    let name = participants.name(side.peer);
                    Unfit::NoInverse(format!("participant `{name}`: its impedance over {steps} steps has no inverse, although every explicit body below its stability limit has one; lower its time.step_s, or take scheme = \"dual-schur\""))
                })?;
                Ok(yields * group.window_s(window))
            }
            ComplianceSource::Points => {
                let resists = participants.impedance(side.peer, first, n)?;
                points_only(group, side, window, &resists)
            }
            ComplianceSource::Rigid => Ok(DMatrix::zeros(n, n)),
        }
    }
}

/// The inverse of a symmetric matrix on the components that move, with zeros for the others, whose columns are zero.
/// `None` unless the matrix is positive definite there.
fn inverse_of_what_moves(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let moving = (0..matrix.nrows()).filter(|i| matrix[(*i, *i)] != 0.0);
    let moving: Vec<usize> = moving.collect();
    let own = matrix.select_rows(&moving).select_columns(&moving);
    let symmetric = 0.5 * (&own + own.transpose());
    let inverse = symmetric.cholesky()?.inverse();
    let mut whole = DMatrix::zeros(matrix.nrows(), matrix.ncols());
    for (i, row) in moving.iter().enumerate() {
        for (j, column) in moving.iter().enumerate() {
            whole[(*row, *column)] = inverse[(i, j)];
        }
    }
    Some(whole)
}

/// H^2 / (2 m sqrt(substeps)) (m/N) on the diagonal: a free node with the mass that a wave reaches in the window.
pub fn mass_only(group: &Group, side: &Side, window: &Window) -> DMatrix<f64> {
    let window_s = group.window_s(window);
    let own_steps = f64::from(window.substeps * side.steps);
    let scale = window_s * window_s / (2.0 * own_steps.sqrt());
    let mass = &group.nodes.mass_kg[side.range.clone()];
    let diagonal = DVector::from_fn(2 * mass.len(), |i, _| scale / mass[i / 2]);
    DMatrix::from_diagonal(&diagonal)
}

/// H^2 M_n^-1 on the components with an impedance; zero for the others.
fn points_only(
    group: &Group,
    side: &Side,
    window: &Window,
    impedance: &DMatrix<f64>,
) -> Result<DMatrix<f64>> {
    let masses = nodal_mass(&group.mapping, &group.points.mass_kg, &side.range);
    let mut resists = both_components(&masses);
    for i in (0..resists.nrows()).filter(|i| impedance[(*i, *i)] == 0.0) {
        resists.row_mut(i).fill(0.0);
        resists.column_mut(i).fill(0.0);
    }
    let problem = "the masses of the glued points on the surface nodes have no inverse";
    let yields = inverse_of_what_moves(&resists);
    let yields = yields.ok_or_else(|| Unfit::NoInverse(problem.into()))?;
    Ok(yields * group.window_s(window).powi(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn held_components_have_zero_compliance_and_the_rest_is_inverted() {
        let resists = DMatrix::from_row_slice(3, 3, &[2.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 2.0]);
        let yields = inverse_of_what_moves(&resists).expect("it is definite");
        let exact = [2.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 2.0].map(|part| part / 3.0);
        assert!((yields - DMatrix::from_row_slice(3, 3, &exact)).amax() < 1e-15);
        let indefinite = DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 1.0]);
        assert!(inverse_of_what_moves(&indefinite).is_none());
    }
}
