//! What the handshake tells of the scheme's stability, before the first window.

use nalgebra::{DMatrix, DVector};
use protocol::BoundaryInertia;

use super::Coupling;
use super::source;
use crate::couple::conversation::Conversation;
use crate::couple::group::Patch;
use crate::couple::handshake::Greeted;
use crate::couple::nodal_mass::{both_components, nodal_mass};
use crate::couple::predict::{Choice, Facts, Prediction, explain};
use crate::error::Error;
use crate::scenario::{CompliancePrior, Dirichlet, Scheme};

/// A compliance may be this much negative over its largest value: what rounding leaves of columns that are not quite
/// symmetric.
const NEGATIVE: f64 = 1e-9;

impl Coupling {
    /// Foresees how the scheme will do on each interface of the group, by its index in the scenario. Columns that the
    /// scheme needs anyway are asked for here, once; one that does without them asks all the same, where the continuum
    /// has them.
    pub fn foresee(
        &mut self,
        conversation: &mut Conversation,
        greeted: &[Greeted],
    ) -> Result<Vec<(usize, Prediction)>, Error> {
        let blocks = self.blocks(conversation, greeted)?;
        let patches = self.group.patches.iter();
        Ok(patches
            .map(|patch| {
                let facts = self.facts(patch, &blocks[patch.continuum], greeted);
                (patch.index, explain(&facts, Choice::from(&self.rules)))
            })
            .collect())
    }

    /// What the handshake told of one interface, `block` being its continuum's compliance (m/N).
    fn facts(&self, patch: &Patch, block: &DMatrix<f64>, greeted: &[Greeted]) -> Facts {
        let group = &self.group;
        let (side, wall) = (&group.continua[patch.continuum], &group.walls[patch.wall]);
        let continuum = &greeted[side.peer].description;
        let wall = &greeted[wall.peer].description;
        // What a foreign solver says of itself may be nonsense; it is then as good as not said.
        let positive = |value: &f64| *value > 0.0 && value.is_finite();
        let limit = |limit: Option<f64>, name: &str| {
            let limit = limit.filter(positive);
            limit.map(|limit| (limit, name.to_string()))
        };
        let (compliance, point_mass_kg) = match self.rules.dirichlet {
            Dirichlet::Wall => {
                let own = group.mapping.block(&patch.points, &side.places);
                (largest_eigenvalue(&own.condense(block)), 0.0)
            }
            Dirichlet::Continuum => {
                let masses = &group.points.mass_kg[patch.points.clone()];
                let mean = masses.iter().sum::<f64>() / masses.len() as f64;
                let parts = wall
                    .boundary_inertia
                    .is_some_and(|boundary_inertia| boundary_inertia.may_part);
                let most = if parts { f64::INFINITY } else { 1.0 };
                (self.stiffest(patch, block, (mean, most)), mean)
            }
        };
        let with_points = |boundary_inertia: BoundaryInertia| match self.rules.dirichlet {
            Dirichlet::Wall => boundary_inertia,
            Dirichlet::Continuum => pushed(boundary_inertia, point_mass_kg),
        };
        Facts {
            step_s: group.clock.step_s / f64::from(side.steps),
            substeps: group.clock.substeps * side.steps,
            step_limit: limit(continuum.step_limit_s, &continuum.step_limit_name),
            first_period_s: continuum.first_period_s.filter(positive),
            window_limit: limit(wall.step_limit_s, &wall.step_limit_name),
            compliance,
            definite: definite(block),
            boundary_inertia: wall.boundary_inertia.map(with_points).filter(sensible),
        }
    }

    /// H D^-1 (m/N) of the stiffest motion of an interface against the points of its wall, `block` being the impedance D of
    /// its continuum: the smallest eigenvalue of H D^-1 N^T w N. A point that is lighter than the mean resists in
    /// proportion, w = m / mean, and so does a heavier one, but for at most `most`: behind it there may be no more than
    /// behind the others. Several interfaces of a continuum can add up to the sum of their impedances at most.
    fn stiffest(&self, patch: &Patch, block: &DMatrix<f64>, (mean_kg, most): (f64, f64)) -> f64 {
        let group = &self.group;
        let side = &group.continua[patch.continuum];
        let first = 2 * (patch.nodes.start - side.places.start);
        let size = 2 * patch.nodes.len();
        let own = block.view((first, first), (size, size));
        let weights: Vec<f64> = group
            .points
            .mass_kg
            .iter()
            .map(|m| (m / mean_kg).min(most))
            .collect();
        let resists = both_components(&nodal_mass(&group.mapping, &weights, &patch.nodes));
        let Some(factor) = resists.cholesky() else {
            return 0.0;
        };
        let lower = factor.l();
        let half = lower.solve_lower_triangular(&own.into_owned());
        let whole = half.and_then(|half| lower.solve_lower_triangular(&half.transpose()));
        let together = group
            .patches
            .iter()
            .filter(|other| other.continuum == patch.continuum);
        let window_s = group.clock.window_s();
        whole.map_or(0.0, |whole| {
            window_s / (largest_eigenvalue(&whole) * together.count() as f64)
        })
    }

    /// C (m/N) of each continuum in a full window, or where it follows a velocity its impedance (kg/s).
    fn blocks(
        &mut self,
        conversation: &mut Conversation,
        greeted: &[Greeted],
    ) -> Result<Vec<DMatrix<f64>>, Error> {
        let clock = self.group.clock;
        let window = clock.window(0, 0, clock.substeps);
        let dual_schur = matches!(
            self.rules.scheme,
            Scheme::DualSchur | Scheme::DualSchurSecant | Scheme::DualSchurCheap
        );
        if dual_schur && self.rules.compliance == CompliancePrior::Columns {
            self.compliance
                .prepare(conversation, &self.group, &window)?;
            let believed = self.compliance.blocks(window.substeps).iter();
            return Ok(believed
                .map(|block| block / self.compliance.factor())
                .collect());
        }
        let mut blocks = Vec::new();
        for side in &self.group.continua {
            let asked = greeted[side.peer].description.capabilities.columns;
            blocks.push(match (self.rules.dirichlet, asked) {
                (Dirichlet::Continuum, _) => {
                    source::impedance(conversation, side, window.substeps)?
                }
                (_, true) => source::columns(conversation, side, window.substeps)?,
                (_, false) => source::mass_only(&self.group, side, &window),
            });
        }
        Ok(blocks)
    }
}

/// What a point resists by that is pushed: its own mass and, unless it may lose touch with that, what stands behind it.
fn pushed(boundary_inertia: BoundaryInertia, point_mass_kg: f64) -> BoundaryInertia {
    let touched = BoundaryInertia {
        glued_mass_kg: boundary_inertia.glued_mass_kg + point_mass_kg,
        ..boundary_inertia
    };
    match boundary_inertia.may_part {
        false => touched,
        true => BoundaryInertia {
            mass_kg: 0.0,
            stiffness_n_per_m: None,
            ..touched
        },
    }
}

/// Whether masses and springs are such as there are.
fn sensible(boundary_inertia: &BoundaryInertia) -> bool {
    let masses = [boundary_inertia.glued_mass_kg, boundary_inertia.mass_kg];
    let resists = match boundary_inertia.stiffness_n_per_m {
        Some(stiffness) => {
            stiffness > 0.0 && stiffness.is_finite() && boundary_inertia.mass_kg > 0.0
        }
        None => masses[0] + masses[1] > 0.0,
    };
    let known = masses.iter().all(|mass| *mass >= 0.0 && mass.is_finite());
    resists && known && (0.5..=1.0).contains(&boundary_inertia.theta)
}

/// By power iteration: the matrix is symmetric but for rounding.
fn largest_eigenvalue(matrix: &DMatrix<f64>) -> f64 {
    // No direction of a surface is orthogonal to one in which all entries differ.
    let mut direction = DVector::from_fn(matrix.nrows(), |i, _| 1.0 + 0.1 * (i as f64).sin());
    let mut value = 0.0;
    for _ in 0..200 {
        let moved = matrix * &direction;
        let norm = moved.norm();
        if norm == 0.0 {
            return 0.0;
        }
        let done = (norm - value).abs() <= 1e-9 * norm;
        value = norm;
        direction = moved / norm;
        if done {
            break;
        }
    }
    value
}

/// Whether no eigenvalue of the symmetric part is below zero, but for rounding.
fn definite(matrix: &DMatrix<f64>) -> bool {
    let mut symmetric = 0.5 * (matrix + matrix.transpose());
    let shift = NEGATIVE * symmetric.amax();
    for i in 0..symmetric.nrows() {
        symmetric[(i, i)] += shift;
    }
    symmetric.cholesky().is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_softest_motion_and_its_sign() {
        let matrix = DMatrix::from_row_slice(2, 2, &[2.0, 1.0, 1.0, 2.0]);
        assert!((largest_eigenvalue(&matrix) - 3.0).abs() < 1e-6);
        assert!(definite(&matrix));
        let one_sided = DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 1.0]);
        assert!(!definite(&one_sided));
        // A component that does not move is no fault.
        assert!(definite(&DMatrix::from_row_slice(
            2,
            2,
            &[1.0, 0.0, 0.0, 0.0]
        )));
    }
}
