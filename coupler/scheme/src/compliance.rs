//! The coupler's compliance C of the force-driven participants, one matrix for each number of substeps, and the
//! boundary compliance that the motion-driven ones get from it: W_g = N C N^T / H^2.

use std::collections::BTreeMap;
use std::mem;
use std::ops::Range;

use nalgebra::{DMatrix, DVector, DVectorView};
use protocol::Window;
use serde::{Deserialize, Serialize};

use super::group::{Group, Patch, Side, components};
use super::participants::Participants;
use super::source::ComplianceSource;
use crate::error::Result;

/// C (m/N) of the exchanged nodes, one matrix for each number of substeps: block-diagonal, with one block for each
/// force-driven participant.
#[derive(Clone, Debug)]
pub struct Compliance {
    source: ComplianceSource,
    /// Factor on the source's matrix.
    factor: f64,
    /// The part that windows change.
    pub state: ComplianceState,
}

/// C of one participant (m/N), and for each column the rows outside of which it is zero.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Block {
    matrix: DMatrix<f64>,
    bands: Vec<Range<usize>>,
}

impl Block {
    fn new(matrix: DMatrix<f64>) -> Block {
        let band = |column: DVectorView<f64>| {
            let first = column.iter().position(|c| *c != 0.0).unwrap_or(0);
            let end = column.iter().rposition(|c| *c != 0.0);
            first..end.map_or(first, |last| last + 1)
        };
        let bands = matrix.column_iter().map(band).collect();
        Block { matrix, bands }
    }

    /// Adds the motion of the components `rows` (m) under forces (N) on the components from `first` on.
    fn add_motion(&self, rows: &Range<usize>, motion: &mut [f64], first: usize, forces: &[f64]) {
        for (j, force) in (first..).zip(forces) {
            let band = &self.bands[j];
            let (start, end) = (band.start.max(rows.start), band.end.min(rows.end));
            if start < end {
                let column = &self.matrix.as_slice()[j * self.matrix.nrows()..][start..end];
                let moved = &mut motion[start - rows.start..end - rows.start];
                for (u, c) in moved.iter_mut().zip(column) {
                    *u += force * c;
                }
            }
        }
    }
}

/// The part of a compliance that a checkpoint stores.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ComplianceState {
    by_substeps: BTreeMap<u32, Vec<Block>>,
    /// Substeps of the window that the boundaries were last set for; `None` if C has changed since.
    told: Option<u32>,
}

impl ComplianceState {
    /// True if its blocks fit the force-driven participants of this group.
    pub fn is_of(&self, group: &Group) -> bool {
        let sizes = || group.force_driven.iter().map(|side| 2 * side.range.len());
        let mut all = self.by_substeps.values();
        all.all(|blocks| {
            let shapes = blocks.iter().map(|block| block.matrix.shape());
            shapes.eq(sizes().map(|n| (n, n)))
        })
    }
}

/// An update needs a pair with information: y.s must be a positive fraction of |y||s| (curvature), and the part of y
/// that C does not explain must exceed rounding.
const CURVATURE: f64 = 1e-12;
const EXPLAINED: f64 = 1e-10;

impl Compliance {
    /// Starts without a matrix; the first window with a new number of substeps makes its own.
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
            let part = &lambda[start..start + block.matrix.nrows()];
            product.extend((&block.matrix * DVector::from_column_slice(part)).iter());
            start += part.len();
        }
        product
    }

    /// C_ii lambda_i (m) for windows of these substeps: the motion of each motion-driven participant's nodes under its
    /// own forces (N). No two of them share a node, so that one vector holds the parts of all.
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
                let own = rows.start - first..rows.end - first;
                let (pushed, forces) = (columns.start - first, &lambda[columns]);
                blocks[moved.force_driven].add_motion(&own, &mut motion[rows], pushed, forces);
            }
        }
        motion
    }

    /// The components that a force moves in windows of these substeps.
    pub fn moves(&self, substeps: u32) -> Vec<bool> {
        let blocks = self.state.by_substeps[&substeps].iter();
        let matrices = blocks.map(|block| &block.matrix);
        let moves = matrices.flat_map(|c| (0..c.nrows()).map(move |i| c[(i, i)] != 0.0));
        moves.collect()
    }

    /// C (m/N) of each continuum in a full window; `None` unless C is made of the continua's own columns.
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
        let columns = blocks.map(|block| &block.matrix / self.factor);
        Ok(Some(columns.collect()))
    }

    /// Makes C for this window and sets the boundaries for it, unless both are ready.
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
                blocks.push(Block::new(matrix * self.factor));
            }
            self.state.by_substeps.insert(window.substeps, blocks);
        }
        if self.state.told != Some(window.substeps) {
            self.set_boundaries(participants, group, window)?;
            self.state.told = Some(window.substeps);
        }
        Ok(())
    }

    /// Sends the last boundaries to the motion-driven participants again.
    pub fn repeat_boundaries(
        &self,
        participants: &mut dyn Participants,
        group: &Group,
    ) -> Result<()> {
        let substeps = self.state.told;
        let window = substeps.map(|substeps| group.clock.window(0, 0, substeps));
        window.map_or(Ok(()), |window| {
            self.set_boundaries(participants, group, &window)
        })
    }

    /// Sends each motion-driven participant its window and W_g = sum over the continua of N C N^T / H^2 (1/kg), N being
    /// its own rows; W_g is zero for a rigid boundary.
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

    /// Updates each block with its part of the pair s (N), y (m) of one window.
    pub fn update(&mut self, substeps: u32, s: &[f64], y: &[f64]) {
        let Some(blocks) = self.state.by_substeps.get_mut(&substeps) else {
            return;
        };
        let mut start = 0;
        for block in blocks {
            let part = start..start + block.matrix.nrows();
            start = part.end;
            if update(&mut block.matrix, &s[part.clone()], &y[part]) {
                *block = Block::new(mem::take(&mut block.matrix));
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
    let informative = curvature > CURVATURE * y.norm() * s.norm() && energy > 0.0;
    if !informative || unexplained <= EXPLAINED * y.norm() {
        return false;
    }
    matrix.ger(1.0 / curvature, &y, &y, 1.0);
    matrix.ger(-1.0 / energy, &carried, &carried, 1.0);
    true
}

/// N C N^T of one motion-driven participant (m/N), 2 points x 2 points. It leaves out the action of other participants'
/// points on the same continuum: that part converges over the repeats.
fn condensed(group: &Group, side: &Side, blocks: &[Block]) -> DMatrix<f64> {
    let continua = group.force_driven.iter().zip(blocks);
    let parts = continua.map(|(continuum, block)| {
        let own = group.mapping.block(&side.range, &continuum.range);
        own.condense(&block.matrix)
    });
    let whole = parts.reduce(|whole, part| whole + part);
    whole.expect("a group has a continuum")
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
            .insert(5, vec![Block::new(DMatrix::identity(4, 4) * 0.3)]);
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
        let matrix = &compliance.state.by_substeps[&5][0].matrix;
        assert!((matrix - matrix.transpose()).amax() < 1e-14);
        assert!(matrix.clone().symmetric_eigen().eigenvalues.min() > 0.0);
    }

    #[test]
    fn a_pair_without_positive_curvature_changes_nothing() {
        let mut compliance = Compliance::new(ComplianceSource::Mass, 1.0);
        let identity = vec![Block::new(DMatrix::identity(2, 2))];
        compliance.state.by_substeps.insert(1, identity.clone());
        compliance.update(1, &[1.0, 0.0], &[-1.0, 0.0]);
        assert_eq!(compliance.state.by_substeps[&1], identity);
    }
}
