//! The numbers from the handshake that determine stability.

use nalgebra::{DMatrix, DVector};
use protocol::BoundaryInertia;

use super::prediction::{StabilityInputs, StabilityPrediction, explain};
use crate::clock::Clock;
use crate::coupling::Coupling;
use crate::error::Result;
use crate::group::{Group, Patch};
use crate::keys::{CouplingScheme, Dirichlet};
use crate::nodal_mass::{both_components, nodal_mass};
use crate::participants::Participants;
use crate::source::mass_only;

/// A compliance may be negative by this fraction of its largest value: rounding of columns that are not quite
/// symmetric.
const NEGATIVE: f64 = 1e-9;

/// Predicts the stability of the scheme on each interface of a group, by its index in the scenario. It requests the
/// columns once if the scheme needs them anyway; for other schemes it requests them if the continuum offers them.
pub fn foresee(
    coupling: &mut Coupling,
    participants: &mut dyn Participants,
) -> Result<Vec<(usize, StabilityPrediction)>> {
    let blocks = blocks(coupling, participants)?;
    let (group, scheme) = (coupling.group(), coupling.scheme());
    let foreseen = group.patches.iter().filter_map(|patch| {
        let block = blocks[patch.force_driven].as_ref()?;
        let inputs = inputs(group, scheme, patch, block, participants);
        Some(explain(&inputs, scheme).map(|prediction| (patch.index, prediction)))
    });
    foreseen.collect()
}

/// The inputs of one interface, `block` being its continuum's compliance (m/N) or impedance (kg/s).
fn inputs(
    group: &Group,
    scheme: &CouplingScheme,
    patch: &Patch,
    block: &DMatrix<f64>,
    participants: &dyn Participants,
) -> StabilityInputs {
    let side = &group.force_driven[patch.force_driven];
    let continuum = participants.description(side.peer);
    let motion_driven = participants.description(group.motion_driven[patch.motion_driven].peer);
    // A nonsensical value of a foreign solver counts as missing.
    let positive = |value: &f64| *value > 0.0 && value.is_finite();
    let limit = |limit: Option<f64>, name: &str| {
        let limit = limit.filter(positive);
        limit.map(|limit| (limit, name.to_string()))
    };
    let mut inertia = motion_driven.boundary_inertia;
    let (compliance, point_mass_kg) = match scheme.dirichlet() {
        Dirichlet::MotionDriven => {
            let own = group.mapping.block(&patch.points, &side.range);
            (largest_eigenvalue(&own.condense(block)), 0.0)
        }
        Dirichlet::ForceDriven => {
            let masses = &group.points.mass_kg[patch.points.clone()];
            let mean_kg = masses.iter().sum::<f64>() / masses.len() as f64;
            let mut most = 1.0;
            if let Some(inertia) = inertia.as_mut().filter(|inertia| inertia.may_part) {
                // Such points resist by their own mass alone.
                most = f64::INFINITY;
                inertia.mass_kg = 0.0;
                inertia.stiffness_n_per_m = None;
            }
            let weigh = |mass: &f64| (mass / mean_kg).min(most);
            let weights: Vec<f64> = group.points.mass_kg.iter().map(weigh).collect();
            (stiffest(group, patch, block, &weights), mean_kg)
        }
    };
    StabilityInputs {
        clock: Clock {
            step_s: group.clock.step_s / f64::from(side.steps),
            substeps: group.clock.substeps * side.steps,
        },
        step_limit: limit(continuum.step_limit_s, &continuum.step_limit_name),
        first_period_s: continuum.first_period_s.filter(positive),
        window_limit: limit(motion_driven.step_limit_s, &motion_driven.step_limit_name),
        accuracy_limits: motion_driven.accuracy_limits.clone(),
        compliance,
        definite: definite(block),
        boundary_inertia: inertia.filter(|inertia| sensible(inertia, point_mass_kg)),
        point_mass_kg,
    }
}

/// H D^-1 (m/N) of the stiffest motion of an interface against the points of its layer, `block` being the impedance D
/// of its continuum: the smallest eigenvalue of H D^-1 N^T w N. A point lighter than the mean resists in proportion, w
/// = m / mean, and so does a heavier one whose mass may part. Otherwise w is at most 1: the mass behind a heavier point
/// may be no larger than behind the others. Several interfaces of a continuum can add up to at most the sum of their
/// impedances.
fn stiffest(group: &Group, patch: &Patch, block: &DMatrix<f64>, weights: &[f64]) -> f64 {
    let side = &group.force_driven[patch.force_driven];
    let first = 2 * (patch.nodes.start - side.range.start);
    let size = 2 * patch.nodes.len();
    let own = block.view((first, first), (size, size));
    let resists = both_components(&nodal_mass(&group.mapping, weights, &patch.nodes));
    let Some(factor) = resists.cholesky() else {
        return 0.0;
    };
    let lower = factor.l();
    let half = lower.solve_lower_triangular(&own.into_owned());
    let whole = half.and_then(|half| lower.solve_lower_triangular(&half.transpose()));
    let patches = group.patches.iter();
    let together = patches.filter(|other| other.force_driven == patch.force_driven);
    let window_s = group.clock.window_s();
    whole.map_or(0.0, |whole| {
        window_s / (largest_eigenvalue(&whole) * together.count() as f64)
    })
}

/// C (m/N) of each continuum in a full window, or its impedance (kg/s) if it follows a velocity; `None` for a continuum
/// without columns and masses.
fn blocks(
    coupling: &mut Coupling,
    participants: &mut dyn Participants,
) -> Result<Vec<Option<DMatrix<f64>>>> {
    if let Some(columns) = coupling.columns(participants)? {
        return Ok(columns.into_iter().map(Some).collect());
    }
    let (group, dirichlet) = (coupling.group(), coupling.scheme().dirichlet());
    let window = group.clock.window(0, 0, group.clock.substeps);
    let mut blocks = Vec::new();
    for side in &group.force_driven {
        let (own, n) = (&side.window(&window), 2 * side.range.len());
        let mut masses = group.nodes.mass_kg[side.range.clone()].iter();
        let weighs = masses.all(|mass| *mass > 0.0);
        let columns = participants.description(side.peer).capabilities.columns;
        blocks.push(match dirichlet {
            Dirichlet::ForceDriven => Some(participants.impedance(side.peer, own, n)?),
            Dirichlet::MotionDriven if columns => Some(participants.compliance(side.peer, own, n)?),
            Dirichlet::MotionDriven => weighs.then(|| mass_only(group, side, &window)),
        });
    }
    Ok(blocks)
}

/// True if masses and springs are physically possible; the point has this mass (kg) of its own.
fn sensible(inertia: &BoundaryInertia, point_mass_kg: f64) -> bool {
    let masses = [inertia.glued_mass_kg + point_mass_kg, inertia.mass_kg];
    let resists = match inertia.stiffness_n_per_m {
        Some(stiffness) => stiffness > 0.0 && stiffness.is_finite() && inertia.mass_kg > 0.0,
        None => masses[0] + masses[1] > 0.0,
    };
    let known = masses.iter().all(|mass| *mass >= 0.0 && mass.is_finite());
    resists && known && (0.5..=1.0).contains(&inertia.theta)
}

/// By power iteration: the matrix is symmetric up to rounding.
fn largest_eigenvalue(matrix: &DMatrix<f64>) -> f64 {
    // All entries differ, so that no motion of a surface is orthogonal to this direction.
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

/// True if no eigenvalue of the symmetric part is negative beyond rounding.
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
        // A component that does not move is allowed.
        assert!(definite(&DMatrix::from_row_slice(
            2,
            2,
            &[1.0, 0.0, 0.0, 0.0]
        )));
    }
}
