//! The near and the far part of a compliance.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, SymmetricEigen};
use serde::{Deserialize, Serialize};

use super::modes::dot_within;
use crate::pack::vectorised;

/// Largest spectral radius of C_near^-1 C_far: a change of force of one window comes back halved in the next.
pub const RADIUS_MAX: f64 = 0.5;

/// Ratio of the distances that are tried.
const GROWTH: f64 = 1.25;

/// Directions from which a spectral radius is computed.
const DIRECTIONS: usize = 48;

/// Distance within which a compliance acts in the same window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NearChoice {
    /// The first distance from this one on (m) for which windows are stable.
    From(f64),
    /// This distance (m).
    Exactly(f64),
}

/// A compliance C = C_near + C_far (m/N), both symmetric and column after column.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct NearField {
    /// Distance within which a component belongs to C_near (m).
    pub reach: f64,
    /// Spectral radius of C_near^-1 C_far, infinite where C_near is not positive definite.
    pub radius: f64,
    /// C_near.
    pub near: Vec<f64>,
    /// The same, and C_far.
    parts: [SymmetricMatrix; 2],
}

/// A symmetric matrix that is zero far from its diagonal, or near to it.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct SymmetricMatrix {
    diagonal: Vec<f64>,
    /// Rows below the diagonal outside of which each column is zero.
    bands: Vec<[usize; 2]>,
    /// The numbers of these rows, column after column. To read the matrix costs more than to multiply by it: half of it is read.
    below: Vec<f64>,
}

impl SymmetricMatrix {
    fn new(matrix: &DMatrix<f64>) -> SymmetricMatrix {
        let band = |j: usize| {
            let mut rows = j + 1..matrix.nrows();
            let is_there = |i: &usize| matrix[(*i, j)] != 0.0;
            let first = rows.clone().find(is_there).unwrap_or(0);
            [first, rows.rfind(is_there).map_or(first, |last| last + 1)]
        };
        let bands: Vec<[usize; 2]> = (0..matrix.ncols()).map(band).collect();
        let rows = bands.iter().enumerate();
        let below = rows.flat_map(|(j, [first, end])| (*first..*end).map(move |i| matrix[(i, j)]));
        SymmetricMatrix {
            diagonal: matrix.diagonal().as_slice().to_vec(),
            below: below.collect(),
            bands,
        }
    }

    /// Adds its product with the forces to the displacements.
    fn add(&self, force: &[f64], displacement: &mut [f64]) {
        let mut rest = self.below.as_slice();
        vectorised!({
            for (j, [first, end]) in self.bands.iter().enumerate() {
                let (column, after) = rest.split_at(end - first);
                rest = after;
                let rows = displacement[*first..*end].iter_mut();
                rows.zip(column).for_each(|(u, c)| *u += force[j] * c);
                displacement[j] +=
                    self.diagonal[j] * force[j] + dot_within(column, &force[*first..*end]);
            }
        });
    }
}

impl NearField {
    /// Splits a compliance between components at these distances from each other (m).
    pub(crate) fn choose(
        compliance: &DMatrix<f64>,
        distance: impl Fn(usize, usize) -> f64,
        choice: NearChoice,
    ) -> NearField {
        let n = compliance.nrows();
        let distances = DMatrix::from_fn(n, n, distance);
        let mut reach = match choice {
            NearChoice::From(reach) | NearChoice::Exactly(reach) => reach,
        };
        loop {
            let field = NearField::split(compliance, &distances, reach);
            if field.is_stable() || matches!(choice, NearChoice::Exactly(_)) {
                return field;
            }
            reach *= GROWTH;
        }
    }

    /// True where windows are stable.
    pub fn is_stable(&self) -> bool {
        self.radius <= RADIUS_MAX
    }

    fn split(compliance: &DMatrix<f64>, distances: &DMatrix<f64>, reach: f64) -> NearField {
        let part = |wanted: bool| {
            let is_part = |distance: f64| (distance <= reach) == wanted;
            compliance.zip_map(distances, |c, at| if is_part(at) { c } else { 0.0 })
        };
        let [near, far] = [true, false].map(part);
        NearField {
            reach,
            radius: spectral_radius(&near, &far),
            parts: [&near, &far].map(SymmetricMatrix::new),
            near: near.as_slice().to_vec(),
        }
    }

    /// Adds C_near f to the displacements.
    pub(crate) fn add_near(&self, force: &[f64], displacement: &mut [f64]) {
        self.parts[0].add(force, displacement);
    }

    /// C_far f (m).
    pub(crate) fn far(&self, force: &[f64]) -> Vec<f64> {
        let mut moved = vec![0.0; force.len()];
        self.parts[1].add(force, &mut moved);
        moved
    }
}

/// The largest |eigenvalue| of near^-1 far, infinite where `near` is not positive definite on the components that move. It is the largest of the
/// symmetric L^-1 far L^-T with near = L L^T, computed by Lanczos iteration with all directions kept orthogonal.
fn spectral_radius(near: &DMatrix<f64>, far: &DMatrix<f64>) -> f64 {
    if far.iter().all(|c| *c == 0.0) {
        return 0.0;
    }
    let moving: Vec<usize> = (0..near.nrows())
        .filter(|i| near[(*i, *i)] != 0.0)
        .collect();
    let part = |of: &DMatrix<f64>| of.select_rows(&moving).select_columns(&moving);
    let (Some(factor), far) = (Cholesky::new(part(near)), part(far)) else {
        return f64::INFINITY;
    };
    let n = moving.len();
    let rough = DVector::from_fn(n, |i, _| {
        ((i + 1) as f64 * 0.618_033_988_749_894_9).fract() - 0.5
    });
    let mut directions = vec![rough.normalize()];
    let mut products = DMatrix::<f64>::zeros(DIRECTIONS, DIRECTIONS);
    let mut done = 0;
    while done < DIRECTIONS.min(n) && done < directions.len() {
        let mut image = product(&factor, &far, &directions[done]);
        let length = image.norm();
        for (i, direction) in directions.iter().chain(&directions).enumerate() {
            let along = direction.dot(&image);
            image.axpy(-along, direction, 1.0);
            products[(i % directions.len(), done)] += along;
        }
        done += 1;
        let rest = image.norm();
        if rest > 1e-10 * length {
            directions.push(image / rest);
        }
    }
    let reduced = DMatrix::from_fn(done, done, |i, j| products[(i.min(j), i.max(j))]);
    SymmetricEigen::new(reduced).eigenvalues.amax()
}

/// L^-1 far L^-T x.
fn product(factor: &Cholesky<f64, Dyn>, far: &DMatrix<f64>, x: &DVector<f64>) -> DVector<f64> {
    let lower = factor.l_dirty();
    let mut y = x.clone();
    lower.tr_solve_lower_triangular_mut(&mut y);
    let mut image = far * y;
    lower.solve_lower_triangular_mut(&mut image);
    image
}
