//! What the coupler believes of the continuum's compliance, for each number of substeps, and what the wall knows of it.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use protocol::{Kind, Window};

use crate::couple::conversation::Conversation;
use crate::couple::handshake::Joined;
use crate::error::Error;
use crate::scenario::CompliancePrior;

/// C (m/N) of the exchanged nodes by substeps. A window of other length has another C.
#[derive(Clone, Debug)]
pub struct Compliance {
    prior: CompliancePrior,
    /// Factor on what the prior gives.
    factor: f64,
    by_substeps: BTreeMap<u32, DMatrix<f64>>,
    /// Substeps of the window that the wall was told of last; `None` once C has changed since.
    told: Option<u32>,
}

/// An update is taken only where the pair tells something: y.s must be a positive part of |y||s| (curvature), and the
/// part of y that C does not explain must be above rounding.
const CURVATURE: f64 = 1e-12;
const EXPLAINED: f64 = 1e-10;

impl Compliance {
    /// Starts without any matrix; each is made when its number of substeps first comes up.
    pub fn new(prior: CompliancePrior, factor: f64) -> Compliance {
        Compliance {
            prior,
            factor,
            by_substeps: BTreeMap::new(),
            told: None,
        }
    }

    /// C lambda (m) for windows of these substeps.
    pub fn times(&self, substeps: u32, lambda: &[f64]) -> DVector<f64> {
        &self.by_substeps[&substeps] * DVector::from_column_slice(lambda)
    }

    /// Sees that C for this window is known and that the wall stands on it.
    pub fn prepare(
        &mut self,
        conversation: &mut Conversation,
        joined: &Joined,
        window: &Window,
    ) -> Result<(), Error> {
        if !self.by_substeps.contains_key(&window.substeps) {
            let matrix = self.fresh(conversation, joined, window)?;
            self.by_substeps.insert(window.substeps, matrix);
        }
        if self.told != Some(window.substeps) {
            tell_wall(
                conversation,
                joined,
                window,
                Some(&self.by_substeps[&window.substeps]),
            )?;
            self.told = Some(window.substeps);
        }
        Ok(())
    }

    /// Symmetric rank-two update of C itself by the pair s (N), y (m) of one window, so that C s = y afterwards:
    /// C += y y^T / (y.s) - (C s)(C s)^T / (s.C s) (Broyden 1970, Fletcher 1970, Goldfarb 1970, Shanno 1970, here
    /// for the inverse of the stiffness). C stays positive definite as long as y.s > 0.
    pub fn update(&mut self, substeps: u32, s: &[f64], y: &[f64]) {
        let Some(matrix) = self.by_substeps.get_mut(&substeps) else {
            return;
        };
        let (s, y) = (DVector::from_column_slice(s), DVector::from_column_slice(y));
        let carried = &*matrix * &s;
        let (curvature, energy) = (y.dot(&s), s.dot(&carried));
        let unexplained = (&y - &carried).norm();
        let tells = curvature > CURVATURE * y.norm() * s.norm() && energy > 0.0;
        if !tells || unexplained <= EXPLAINED * y.norm() {
            return;
        }
        matrix.ger(1.0 / curvature, &y, &y, 1.0);
        matrix.ger(-1.0 / energy, &carried, &carried, 1.0);
        self.told = None;
    }

    fn fresh(
        &self,
        conversation: &mut Conversation,
        joined: &Joined,
        window: &Window,
    ) -> Result<DMatrix<f64>, Error> {
        let matrix = match self.prior {
            CompliancePrior::Columns => columns(conversation, joined, window.substeps)?,
            CompliancePrior::Mass => mass_only(joined, window),
        };
        Ok(matrix * self.factor)
    }
}

/// Exact columns, asked of the continuum.
fn columns(
    conversation: &mut Conversation,
    joined: &Joined,
    substeps: u32,
) -> Result<DMatrix<f64>, Error> {
    let size = 2 * joined.nodes.len();
    let opening = Window {
        substeps,
        ..Window::default()
    };
    let kinds = (Kind::Columns, Kind::Compliance);
    let numbers =
        conversation.ask_exactly(joined.continuum, kinds, &opening, Vec::new(), size * size)?;
    Ok(DMatrix::from_vec(size, size, numbers))
}

/// H^2 / (2 m sqrt(substeps)) on the diagonal: a free node that drags along what a wave reaches in the window.
fn mass_only(joined: &Joined, window: &Window) -> DMatrix<f64> {
    let window_s = joined.clock.step_s * f64::from(window.substeps);
    let scale = window_s * window_s / (2.0 * f64::from(window.substeps).sqrt());
    DMatrix::from_diagonal(&DVector::from_fn(2 * joined.nodes.len(), |i, _| {
        scale / joined.nodes.mass_kg[i / 2]
    }))
}

/// Tells the wall its window and W_g = N C N^T / H^2; without C it moves rigidly as it is told.
pub fn tell_wall(
    conversation: &mut Conversation,
    joined: &Joined,
    window: &Window,
    compliance: Option<&DMatrix<f64>>,
) -> Result<(), Error> {
    let window_s = joined.clock.step_s * f64::from(window.substeps);
    let size = 2 * joined.points.len();
    let wall = match compliance {
        Some(matrix) => joined.mapping.condense(matrix) / (window_s * window_s),
        None => DMatrix::zeros(size, size),
    };
    let mut payload = Vec::with_capacity(1 + wall.len());
    payload.push(window_s);
    payload.extend_from_slice(wall.as_slice());
    conversation
        .ask(joined.wall, Kind::Wall, Kind::Ready, window, payload)
        .map(|_| ())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_update_explains_the_pair_and_stays_symmetric_positive() {
        let mut compliance = Compliance::new(CompliancePrior::Mass, 1.0);
        compliance
            .by_substeps
            .insert(5, DMatrix::identity(4, 4) * 0.3);
        let truth = DMatrix::from_fn(4, 4, |i, j| if i == j { 2.0 } else { 0.5 });
        for s in [
            [1.0, 0.0, 0.0, 0.0],
            [0.3, -1.0, 0.2, 0.0],
            [0.1, 0.4, 0.9, -0.7],
        ] {
            let y = &truth * DVector::from_column_slice(&s);
            compliance.update(5, &s, y.as_slice());
            assert!((compliance.times(5, &s) - &y).amax() < 1e-12);
        }
        let matrix = &compliance.by_substeps[&5];
        assert!((matrix - matrix.transpose()).amax() < 1e-14);
        assert!(matrix.clone().symmetric_eigen().eigenvalues.min() > 0.0);
    }

    #[test]
    fn a_pair_without_positive_curvature_changes_nothing() {
        let mut compliance = Compliance::new(CompliancePrior::Mass, 1.0);
        compliance.by_substeps.insert(1, DMatrix::identity(2, 2));
        compliance.update(1, &[1.0, 0.0], &[-1.0, 0.0]);
        assert_eq!(compliance.by_substeps[&1], DMatrix::identity(2, 2));
    }
}
