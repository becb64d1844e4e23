//! The compliance of the force-driven participants as the coupler knows it, for each number of substeps, and the boundary of
//! the motion-driven ones that it makes: W_g = N C N^T / H^2.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use protocol::Window;
use serde::{Deserialize, Serialize};

use super::group::{Group, Patch, Side, components};
use super::participants::Participants;
use super::source::ComplianceSource;
use crate::error::Result;

/// C (m/N) of the exchanged nodes by substeps: block-diagonal, one block a force-driven participant. A window of other length
/// has another C.
#[derive(Clone, Debug)]
pub struct Compliance {
    source: ComplianceSource,
    /// Factor on what the source gives.
    factor: f64,
    /// The part of it that windows change.
    pub state: ComplianceState,
}

/// The part of it that a checkpoint holds.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ComplianceState {
    by_substeps: BTreeMap<u32, Vec<DMatrix<f64>>>,
    /// Substeps of the window that the boundaries were made for last; `None` once C has changed since.
    told: Option<u32>,
}

impl ComplianceState {
    /// True if all its blocks are those of the force-driven participants of this group.
    pub fn is_of(&self, group: &Group) -> bool {
        let sizes = || group.force_driven.iter().map(|side| 2 * side.range.len());
        let mut all = self.by_substeps.values();
        all.all(|blocks| {
            blocks
                .iter()
                .map(DMatrix::shape)
                .eq(sizes().map(|n| (n, n)))
        })
    }
}

/// An update is taken only where the pair tells something: y.s must be a positive part of |y||s| (curvature), and the
/// part of y that C does not explain must be above rounding.
const CURVATURE: f64 = 1e-12;
const EXPLAINED: f64 = 1e-10;

impl Compliance {
    /// Starts without any matrix; each is made when its number of substeps first comes up.
    pub fn new(source: ComplianceSource, factor: f64) -> Compliance {
        Compliance {
            source,
            factor,
            state: ComplianceState::default(),
        }
    }

    /// C lambda (m) for windows of these substeps.
    pub fn times(&self, substeps: u32, lambda: &[f64]) -> Vec<f64> {
        let mut start = 0;
        let mut product = Vec::with_capacity(lambda.len());
        for block in &self.state.by_substeps[&substeps] {
            let part = &lambda[start..start + block.nrows()];
            product.extend((block * DVector::from_column_slice(part)).iter());
            start += block.nrows();
        }
        product
    }

    /// C_ii lambda_i (m) for windows of these substeps: at the nodes of each motion-driven participant the motion by its own forces (N).
    /// Each stands on nodes of its own, so that the parts of all are one vector.
    pub fn own(&self, group: &Group, substeps: u32, lambda: &[f64]) -> Vec<f64> {
        let blocks = &self.state.by_substeps[&substeps];
        let mut motion = vec![0.0; lambda.len()];
        for moved in &group.patches {
            let of_both = |patch: &&Patch| {
                patch.force_driven == moved.force_driven
                    && patch.motion_driven == moved.motion_driven
            };
            for pushed in group.patches.iter().filter(of_both) {
                let first = 2 * group.force_driven[moved.force_driven].range.start;
                let [rows, columns] = [moved, pushed].map(|patch| components(&patch.nodes));
                let start = (rows.start - first, columns.start - first);
                let part = blocks[moved.force_driven].view(start, (rows.len(), columns.len()));
                let part = part * DVector::from_column_slice(&lambda[columns]);
                let sums = motion[rows].iter_mut().zip(&part);
                sums.for_each(|(sum, part)| *sum += part);
            }
        }
        motion
    }

    /// The components that a force moves in windows of these substeps.
    pub fn moves(&self, substeps: u32) -> Vec<bool> {
        let blocks = self.state.by_substeps[&substeps].iter();
        let blocks = blocks.flat_map(|block| (0..block.nrows()).map(|i| block[(i, i)] != 0.0));
        blocks.collect()
    }

    /// C (m/N) of each continuum in a full window, where it is made of their own columns.
    pub fn columns(
        &mut self,
        participants: &mut dyn Participants,
        group: &Group,
    ) -> Result<Option<Vec<DMatrix<f64>>>> {
        if self.source != ComplianceSource::Columns {
            return Ok(None);
        }
        let window = group.clock.window(0, 0, group.clock.substeps);
        self.prepare(participants, group, &window)?;
        let blocks = self.state.by_substeps[&window.substeps].iter();
        Ok(Some(blocks.map(|block| block / self.factor).collect()))
    }

    /// Sees that C for this window is known and that the boundaries are made for it.
    pub fn prepare(
        &mut self,
        participants: &mut dyn Participants,
        group: &Group,
        window: &Window,
    ) -> Result<()> {
        let known = self.source == ComplianceSource::Rigid
            || self.state.by_substeps.contains_key(&window.substeps);
        if !known {
            let mut blocks = Vec::new();
            for side in &group.force_driven {
                let matrix = self.source.matrix(participants, group, side, window)?;
                blocks.push(matrix * self.factor);
            }
            self.state.by_substeps.insert(window.substeps, blocks);
        }
        if self.state.told != Some(window.substeps) {
            self.set_boundaries(participants, group, window)?;
            self.state.told = Some(window.substeps);
        }
        Ok(())
    }

    /// Tells the motion-driven participants once more what they were told last.
    pub fn repeat_boundaries(
        &self,
        participants: &mut dyn Participants,
        group: &Group,
    ) -> Result<()> {
        let told = self.state.told.map(|told| group.clock.window(0, 0, told));
        told.map_or(Ok(()), |window| {
            self.set_boundaries(participants, group, &window)
        })
    }

    /// Tells each motion-driven participant its window and W_g = sum over the continua of N C N^T / H^2 (1/kg), N being its
    /// own rows; a rigid boundary has none.
    fn set_boundaries(
        &self,
        participants: &mut dyn Participants,
        group: &Group,
        window: &Window,
    ) -> Result<()> {
        let window_s = group.window_s(window);
        for side in &group.motion_driven {
            let matrix = match self.state.by_substeps.get(&window.substeps) {
                Some(blocks) => condensed(group, side, blocks) / (window_s * window_s),
                None => DMatrix::zeros(2 * side.range.len(), 2 * side.range.len()),
            };
            participants.set_boundary(side.peer, window, window_s, &matrix)?;
        }
        Ok(())
    }

    /// Updates each block by its part of the pair s (N), y (m) of one window.
    pub fn update(&mut self, substeps: u32, s: &[f64], y: &[f64]) {
        let Some(blocks) = self.state.by_substeps.get_mut(&substeps) else {
            return;
        };
        let mut start = 0;
        for block in blocks {
            let part = start..start + block.nrows();
            start = part.end;
            if update(block, &s[part.clone()], &y[part]) {
                self.state.told = None;
            }
        }
    }
}

/// Symmetric rank-two update of C itself by the pair s (N), y (m) of one window, so that C s = y afterwards:
/// C += y y^T / (y.s) - (C s)(C s)^T / (s.C s) (Broyden 1970, Fletcher 1970, Goldfarb 1970, Shanno 1970, here
/// for the inverse of the stiffness). C stays positive definite as long as y.s > 0. Returns whether C changed.
fn update(matrix: &mut DMatrix<f64>, s: &[f64], y: &[f64]) -> bool {
    let (s, y) = (DVector::from_column_slice(s), DVector::from_column_slice(y));
    let carried = &*matrix * &s;
    let (curvature, energy) = (y.dot(&s), s.dot(&carried));
    let unexplained = (&y - &carried).norm();
    let tells = curvature > CURVATURE * y.norm() * s.norm() && energy > 0.0;
    if !tells || unexplained <= EXPLAINED * y.norm() {
        return false;
    }
    matrix.ger(1.0 / curvature, &y, &y, 1.0);
    matrix.ger(-1.0 / energy, &carried, &carried, 1.0);
    true
}

/// N C N^T of one motion-driven participant (m/N), 2 points x 2 points. The action of the points of another one on the same
/// continuum is not in it: that part converges in the repeats.
fn condensed(group: &Group, side: &Side, blocks: &[DMatrix<f64>]) -> DMatrix<f64> {
    let continua = group.force_driven.iter().zip(blocks);
    let parts = continua.map(|(continuum, block)| {
        let own = group.mapping.block(&side.range, &continuum.range);
        own.condense(block)
    });
    parts
        .reduce(|whole, part| whole + part)
        .expect("a group has a continuum")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_update_explains_the_pair_and_stays_symmetric_positive() {
        let mut compliance = Compliance::new(ComplianceSource::Mass, 1.0);
        compliance
            .state
            .by_substeps
            .insert(5, vec![DMatrix::identity(4, 4) * 0.3]);
        let truth = DMatrix::from_fn(4, 4, |i, j| if i == j { 2.0 } else { 0.5 });
        for s in [
            [1.0, 0.0, 0.0, 0.0],
            [0.3, -1.0, 0.2, 0.0],
            [0.1, 0.4, 0.9, -0.7],
        ] {
            let y = &truth * DVector::from_column_slice(&s);
            compliance.update(5, &s, y.as_slice());
            let carried = DVector::from_vec(compliance.times(5, &s));
            assert!((carried - &y).amax() < 1e-12);
        }
        let matrix = &compliance.state.by_substeps[&5][0];
        assert!((matrix - matrix.transpose()).amax() < 1e-14);
        assert!(matrix.clone().symmetric_eigen().eigenvalues.min() > 0.0);
    }

    #[test]
    fn a_pair_without_positive_curvature_changes_nothing() {
        let mut compliance = Compliance::new(ComplianceSource::Mass, 1.0);
        let identity = vec![DMatrix::identity(2, 2)];
        compliance.state.by_substeps.insert(1, identity.clone());
        compliance.update(1, &[1.0, 0.0], &[-1.0, 0.0]);
        assert_eq!(compliance.state.by_substeps[&1], identity);
    }
}
