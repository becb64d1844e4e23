//! Where the compliance of a continuum comes from.

use nalgebra::{DMatrix, DVector};
use protocol::{Kind, Window};

use crate::couple::conversation::Conversation;
use crate::couple::group::{Group, Side};
use crate::couple::nodal_mass::{both_components, nodal_mass};
use crate::error::Error;

/// Where a matrix comes from that is not known yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// The continuum's own columns: what a constant force moves.
    Columns,
    /// Surface masses alone.
    Mass,
    /// H D^-1 with the continuum's own impedance D: what a change of the force at the end of a window adds to H v there,
    /// when the velocity goes in a straight line.
    Impedance,
    /// H^2 M_n^-1 with the masses of the points on the nodes, for what can move of the continuum: a line of nodes that moves
    /// by them alone.
    Points,
}

impl Source {
    /// The matrix (m/N) of one continuum for windows of this length.
    pub(super) fn matrix(
        self,
        conversation: &mut Conversation,
        group: &Group,
        side: &Side,
        window: &Window,
    ) -> Result<DMatrix<f64>, Error> {
        match self {
            Source::Columns => columns(conversation, side, window.substeps),
            Source::Mass => Ok(mass_only(group, side, window)),
            Source::Impedance => {
                let resists = impedance(conversation, side, window.substeps)?;
                let yields = inverse_of_what_moves(&resists).ok_or_else(|| {
                    let name = conversation.peers[side.peer].name();
                    Error::Refused(format!("participant `{name}`: its impedance over {} steps has no inverse, as that of every explicit body below its stability limit has; lower its time.step_s, or take scheme = \"dual-schur\"", window.substeps * side.steps))
                })?;
                Ok(yields * group.window_s(window))
            }
            Source::Points => {
                let resists = impedance(conversation, side, window.substeps)?;
                points_only(group, side, window, &resists)
            }
        }
    }
}

/// Exact columns, asked of the continuum.
pub fn columns(
    conversation: &mut Conversation,
    side: &Side,
    substeps: u32,
) -> Result<DMatrix<f64>, Error> {
    asked(
        conversation,
        side,
        (Kind::Columns, Kind::Compliance),
        substeps,
    )
}

/// D (kg/s), asked of the continuum.
pub fn impedance(
    conversation: &mut Conversation,
    side: &Side,
    substeps: u32,
) -> Result<DMatrix<f64>, Error> {
    asked(
        conversation,
        side,
        (Kind::ImpedanceColumns, Kind::Impedance),
        substeps,
    )
}

fn asked(
    conversation: &mut Conversation,
    side: &Side,
    kinds: (Kind, Kind),
    substeps: u32,
) -> Result<DMatrix<f64>, Error> {
    let size = 2 * side.places.len();
    let opening = Window {
        substeps: substeps * side.steps,
        ..Window::default()
    };
    let numbers = conversation.ask_exactly(side.peer, kinds, &opening, Vec::new(), size * size)?;
    Ok(DMatrix::from_vec(size, size, numbers))
}

/// The inverse of a symmetric matrix on the components that move; zero for the others, which have zeros in their columns.
/// `None` unless it is positive definite there.
fn inverse_of_what_moves(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let moving: Vec<usize> = (0..matrix.nrows())
        .filter(|i| matrix[(*i, *i)] != 0.0)
        .collect();
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

/// H^2 / (2 m sqrt(substeps)) on the diagonal: a free node that drags along what a wave reaches in the window.
pub fn mass_only(group: &Group, side: &Side, window: &Window) -> DMatrix<f64> {
    let window_s = group.window_s(window);
    let own_steps = f64::from(window.substeps * side.steps);
    let scale = window_s * window_s / (2.0 * own_steps.sqrt());
    let mass = &group.nodes.mass_kg[side.places.clone()];
    DMatrix::from_diagonal(&DVector::from_fn(2 * mass.len(), |i, _| {
        scale / mass[i / 2]
    }))
}

/// H^2 M_n^-1 on the components that have an impedance; zero for the others.
fn points_only(
    group: &Group,
    side: &Side,
    window: &Window,
    impedance: &DMatrix<f64>,
) -> Result<DMatrix<f64>, Error> {
    let masses = nodal_mass(&group.mapping, &group.points.mass_kg, &side.places);
    let mut resists = both_components(&masses);
    for i in (0..resists.nrows()).filter(|i| impedance[(*i, *i)] == 0.0) {
        resists.row_mut(i).fill(0.0);
        resists.column_mut(i).fill(0.0);
    }
    let yields = inverse_of_what_moves(&resists).ok_or_else(|| {
        Error::Refused("the masses of the glued points on the surface nodes have no inverse".into())
    })?;
    Ok(yields * group.window_s(window).powi(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_move_yields_nothing_and_the_rest_as_its_inverse() {
        let resists = DMatrix::from_row_slice(3, 3, &[2.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 2.0]);
        let yields = inverse_of_what_moves(&resists).expect("it is definite");
        let exact = [2.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 2.0].map(|part| part / 3.0);
        assert!((yields - DMatrix::from_row_slice(3, 3, &exact)).amax() < 1e-15);
        let indefinite = DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 1.0]);
        assert!(inverse_of_what_moves(&indefinite).is_none());
    }
}
