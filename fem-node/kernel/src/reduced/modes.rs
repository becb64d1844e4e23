//! The lowest modes of a supported body, K phi = omega^2 M phi with phi^T M phi = 1.

use nalgebra::{DMatrix, SymmetricEigen};
use serde::{Deserialize, Serialize};

use crate::element::body::Body;
use crate::error::{KernelError, MODES_BYTES};
use crate::pack::vectorised;
use crate::statics::factor::Factor;

/// Directions that one product adds. A periodic body has its modes in pairs of one frequency, and a single direction finds one of each pair only.
const BLOCK: usize = 4;

/// Largest residual of a mode over its eigenvalue 1/omega^2. Its frequency is then exact to rounding.
const TOLERANCE: f64 = 1e-11;

/// Length of a direction after its projection, over its length before, below which the rest is rounding.
const DEPENDENT: f64 = 1e-10;

/// Rows of all directions that are orthogonalised together: they stay in the first cache.
const ROWS: usize = 256;

/// The modes that a reduced body keeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ModeChoice {
    /// The lowest ones, this many, or all that the body has.
    Count(usize),
    /// All up to this frequency (1/s).
    UpTo(f64),
}

/// Modes by ascending frequency.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Modes {
    /// omega (1/s).
    pub omega: Vec<f64>,
    /// phi (1/sqrt(kg)) of each mode, in the order of the equations of the factor.
    pub(crate) shapes: Vec<Vec<f64>>,
    /// The lowest frequency that is left out (1/s), absent where all modes are kept.
    pub neglected: Option<f64>,
}

impl Modes {
    /// phi of a component in each mode; 0 where it cannot move.
    pub(crate) fn amplitudes<'a>(
        &'a self,
        factor: &Factor,
        component: usize,
    ) -> impl Iterator<Item = f64> + 'a {
        let equation = factor.equation(component);
        let shapes = self.shapes.iter();
        shapes.map(move |shape| equation.map_or(0.0, |equation| shape[equation]))
    }

    /// The lowest modes by block Lanczos iteration on M^1/2 K^-1 M^1/2, whose largest eigenvalues are 1/omega^2 (Golub and Underwood 1977; Parlett,
    /// The Symmetric Eigenvalue Problem, 1980, ch. 13). Every direction is kept orthogonal to all others, so no mode appears twice, and the iteration
    /// ends at the latest when the directions span all components.
    pub(crate) fn lowest(
        body: &Body,
        factor: &Factor,
        choice: ModeChoice,
    ) -> Result<Modes, KernelError> {
        let size = factor.components().len();
        let first = match choice {
            ModeChoice::Count(count) => 2 * count.min(size) + 4 * BLOCK,
            ModeChoice::UpTo(_) => 16 * BLOCK,
        };
        refuse_above_memory(size, first)?;
        let mut space = Directions::new(body, factor);
        let mut judged_at = first;
        loop {
            let is_complete = !space.extend(factor);
            if is_complete || space.done >= judged_at {
                let ritz = space.ritz();
                if is_complete || ritz.suffices(choice) {
                    return Ok(space.modes(&ritz, choice, is_complete));
                }
                judged_at = space.done + (space.done / 4).max(2 * BLOCK);
                refuse_above_memory(size, judged_at)?;
            }
        }
    }
}

/// Refuses this many directions of this size where they would not fit into memory.
fn refuse_above_memory(equations: usize, directions: usize) -> Result<(), KernelError> {
    let most = (MODES_BYTES / 8.0 / equations.max(1) as f64) as usize;
    if directions.min(equations) <= most {
        return Ok(());
    }
    Err(KernelError::TooManyModes {
        equations,
        directions,
        most: most / 3,
    })
}

/// Orthonormal directions, and the matrix to which they reduce the operator.
struct Directions {
    /// M^1/2 of each equation (sqrt(kg)).
    root_mass: Vec<f64>,
    basis: Vec<Vec<f64>>,
    /// Directions whose images are known.
    done: usize,
    /// Products of each image with the directions known by then.
    products: Vec<Vec<f64>>,
    /// The images of the last block in the directions that they add.
    coupling: DMatrix<f64>,
}

/// Eigenvalues in descending order with their vectors and residuals.
struct Ritz {
    values: Vec<f64>,
    vectors: DMatrix<f64>,
    residuals: Vec<f64>,
}

impl Ritz {
    /// Number of the largest eigenvalues that are exact.
    fn exact(&self) -> usize {
        let pairs = self.values.iter().zip(&self.residuals);
        pairs
            .take_while(|(value, residual)| **residual <= TOLERANCE * **value)
            .count()
    }

    /// True where all wanted modes are exact, and the next one too.
    fn suffices(&self, choice: ModeChoice) -> bool {
        let exact = self.exact();
        match choice {
            ModeChoice::Count(count) => exact > count,
            ModeChoice::UpTo(omega) => {
                let last = exact.checked_sub(1).map(|last| self.values[last]);
                last.is_some_and(|value| value.powf(-0.5) > omega)
            }
        }
    }
}

impl Directions {
    fn new(body: &Body, factor: &Factor) -> Directions {
        let components = factor.components().iter();
        let root_mass: Vec<f64> = components.map(|c| body.mass[*c].sqrt()).collect();
        let size = root_mass.len();
        let rough = |j: usize, i: usize| {
            ((i + 1) as f64 * (j as f64 + 1.0).sqrt() * 0.618_033_988_749_894_9).fract() - 0.5
        };
        let mut start = (0..BLOCK.min(size))
            .map(|j| (0..size).map(|i| rough(j, i)).collect())
            .collect::<Vec<Vec<f64>>>();
        let lengths = start.iter().map(|q| norm(q)).collect::<Vec<f64>>();
        orthonormalise(&mut start, &lengths);
        Directions {
            root_mass,
            basis: start,
            done: 0,
            products: Vec::new(),
            coupling: DMatrix::zeros(0, 0),
        }
    }

    /// Adds a block of directions, the images of the last one; false where they span all.
    fn extend(&mut self, factor: &Factor) -> bool {
        let mut images: Vec<Vec<f64>> = self.basis[self.done..].to_vec();
        self.weigh(&mut images);
        factor.solve_columns(&mut images);
        self.weigh(&mut images);
        let lengths: Vec<f64> = images.iter().map(|image| norm(image)).collect();
        let mut products = self.project(&mut images);
        for (sum, more) in products.iter_mut().zip(self.project(&mut images)) {
            sum.iter_mut()
                .zip(more)
                .for_each(|(sum, more)| *sum += more);
        }
        self.done = self.basis.len();
        self.products.extend(products);
        self.coupling = orthonormalise(&mut images, &lengths);
        self.basis.extend(images);
        self.basis.len() > self.done
    }

    fn weigh(&self, columns: &mut [Vec<f64>]) {
        for column in columns {
            let values = column.iter_mut().zip(&self.root_mass);
            values.for_each(|(value, root)| *value *= root);
        }
    }

    /// Removes the parts along all directions; returns these parts, image by image.
    fn project(&self, images: &mut [Vec<f64>]) -> Vec<Vec<f64>> {
        let mut parts = vec![vec![0.0; self.basis.len()]; images.len()];
        let chunks = |size: usize| {
            (0..size)
                .step_by(ROWS)
                .map(move |a| a..(a + ROWS).min(size))
        };
        let size = self.root_mass.len();
        for rows in chunks(size) {
            for (image, parts) in images.iter().zip(&mut parts) {
                let image = &image[rows.clone()];
                let sums = parts.iter_mut().zip(&self.basis);
                sums.for_each(|(sum, q)| *sum += dot(&q[rows.clone()], image));
            }
        }
        for rows in chunks(size) {
            for (image, parts) in images.iter_mut().zip(&parts) {
                let image = &mut image[rows.clone()];
                let along = parts.iter().zip(&self.basis);
                along.for_each(|(part, q)| add(image, -part, &q[rows.clone()]));
            }
        }
        parts
    }

    /// Eigenvalues of the reduced operator.
    fn ritz(&self) -> Ritz {
        let n = self.done;
        let matrix = DMatrix::from_fn(n, n, |i, j| {
            let (first, later) = (i.min(j), i.max(j));
            self.products[later][first]
        });
        let eigen = SymmetricEigen::new(matrix);
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
        let last = n - self.coupling.ncols();
        let residual = |k: &usize| {
            let end = eigen.eigenvectors.column(*k);
            (&self.coupling * end.rows(last, n - last)).norm()
        };
        Ritz {
            values: order.iter().map(|k| eigen.eigenvalues[*k]).collect(),
            residuals: order.iter().map(residual).collect(),
            vectors: eigen.eigenvectors.select_columns(&order),
        }
    }

    fn modes(&self, ritz: &Ritz, choice: ModeChoice, is_complete: bool) -> Modes {
        let known = if is_complete { self.done } else { ritz.exact() };
        let omega: Vec<f64> = ritz.values[..known].iter().map(|v| v.powf(-0.5)).collect();
        let count = match choice {
            ModeChoice::Count(count) => count.min(known),
            ModeChoice::UpTo(limit) => omega.iter().take_while(|one| **one <= limit).count(),
        };
        let shape = |k: usize| {
            let mut shape = vec![0.0; self.root_mass.len()];
            let parts = ritz.vectors.column(k);
            let along = parts.iter().zip(&self.basis);
            along.for_each(|(part, q)| add(&mut shape, *part, q));
            let values = shape.iter_mut().zip(&self.root_mass);
            values.for_each(|(value, root)| *value /= root);
            shape
        };
        Modes {
            shapes: (0..count).map(shape).collect(),
            neglected: omega.get(count).copied(),
            omega: omega[..count].to_vec(),
        }
    }
}

/// Replaces images by orthonormal directions that span the same space. Images that depend on the others, compared with their former `lengths`, are left
/// out. Returns the images in the directions.
fn orthonormalise(images: &mut Vec<Vec<f64>>, lengths: &[f64]) -> DMatrix<f64> {
    let mut directions: Vec<Vec<f64>> = Vec::new();
    let mut parts = DMatrix::zeros(images.len(), images.len());
    for (j, (image, length)) in images.iter_mut().zip(lengths).enumerate() {
        for (i, direction) in directions.iter().chain(&directions).enumerate() {
            let part = dot(direction, image);
            add(image, -part, direction);
            parts[(i % directions.len(), j)] += part;
        }
        let rest = norm(image);
        if rest > DEPENDENT * length {
            image.iter_mut().for_each(|value| *value /= rest);
            parts[(directions.len(), j)] = rest;
            directions.push(std::mem::take(image));
        }
    }
    let count = directions.len();
    *images = directions;
    parts.rows(0, count).into_owned()
}

/// Lanes of a sum: one chain of additions would wait for each of them.
const LANES: usize = 8;

/// Sum of products, in an order that no processor changes.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    vectorised!(dot_within(a, b))
}

/// [`dot`] within a pass that is vectorised.
#[inline(always)]
pub(crate) fn dot_within(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    let (a, a_rest) = a.as_chunks::<LANES>();
    let (b, b_rest) = b.as_chunks::<LANES>();
    for (a, b) in a.iter().zip(b) {
        for k in 0..LANES {
            sums[k] += a[k] * b[k];
        }
    }
    for (k, (a, b)) in a_rest.iter().zip(b_rest).enumerate() {
        sums[k] += a * b;
    }
    sums.iter().sum()
}

/// y + factor x.
pub(crate) fn add(y: &mut [f64], factor: f64, x: &[f64]) {
    vectorised!({
        for (y, x) in y.iter_mut().zip(x) {
            *y += factor * x;
        }
    });
}

/// y + sum of factor_j x_j over the columns x_j, each of which holds the numbers of y from `first` on. One call for all columns: choosing the registers
/// takes longer than a short column.
pub(crate) fn add_columns(
    y: &mut [f64],
    (columns, length, first): (&[f64], usize, usize),
    factors: impl Iterator<Item = f64>,
) {
    let end = first + y.len();
    vectorised!({
        for (column, factor) in columns.chunks_exact(length.max(1)).zip(factors) {
            for (y, x) in y.iter_mut().zip(&column[first..end]) {
                *y += factor * x;
            }
        }
    });
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}
