//! The largest natural frequency, and with it the longest stable step.

use nalgebra::{DMatrix, SymmetricEigen};

use crate::element::body::Body;

/// Relative residual of the largest eigenvalue at which the iteration ends.
const TOLERANCE: f64 = 1e-6;

/// Largest Krylov space: 60 to 200 directions are usual.
const DIRECTIONS_MAX: usize = 640;

/// Largest natural frequency (1/s) of M^-1 K, from above within about 1e-6.
///
/// Power iteration with all its iterates kept, that is Lanczos' method on the symmetric M^-1/2 K M^-1/2
/// (Lanczos 1950; Parlett, The Symmetric Eigenvalue Problem, 1980, ch. 13). Plain power iteration would need
/// thousands of products here, because the top of the spectrum is dense. Without reorthogonalisation copies of
/// converged eigenvalues appear, which does not disturb the largest one. The residual is added to the result,
/// so that an iteration that ended early errs on the side of a shorter step.
pub fn omega_max(body: &Body) -> f64 {
    let mut space = Krylov::new(body);
    let mut checkpoint = 20;
    loop {
        let alive = space.extend(body);
        if !alive || space.alpha.len() == checkpoint {
            let (value, residual) = space.largest();
            if !alive || residual <= TOLERANCE * value || checkpoint >= DIRECTIONS_MAX {
                return (value + residual).sqrt();
            }
            checkpoint *= 2;
        }
    }
}

/// h < sqrt(2/b) / omega_max: spectral radius of the scheme for one mode, det = 1 + (1/2 - b) (omega h)^2 and
/// trace = 2 - (b + 1/2) (omega h)^2; the eigenvalue -1 is reached at 1 + trace + det = 4 - 2 b (omega h)^2 = 0. With a stiffness
/// damping beta (s) h < (sqrt(2/b + 4 xi^2) - 2 xi) / omega_max, xi = beta omega_max/2, derived in [`crate::integrate`].
pub fn step_limit(omega_max: f64, damping: f64, stiffness_damping: f64) -> f64 {
    let twice = stiffness_damping * omega_max;
    ((2.0 / damping + twice * twice).sqrt() - twice) / omega_max
}

/// Directions of the iteration and the tridiagonal matrix to which they reduce the operator.
#[derive(Default)]
struct Krylov {
    scale: Vec<f64>,
    previous: Vec<f64>,
    current: Vec<f64>,
    image: Vec<f64>,
    scaled: Vec<f64>,
    alpha: Vec<f64>,
    beta: Vec<f64>,
}

impl Krylov {
    fn new(body: &Body) -> Krylov {
        let scale: Vec<f64> = body.inverse_mass.iter().map(|w| w.sqrt()).collect();
        let mut current = start_vector(&scale);
        let norm = dot(&current, &current).sqrt();
        current.iter_mut().for_each(|q| *q /= norm);
        let zero = vec![0.0; scale.len()];
        Krylov {
            scale,
            previous: zero.clone(),
            current,
            image: zero.clone(),
            scaled: zero,
            ..Krylov::default()
        }
    }

    /// Adds a direction; false when the space is complete.
    fn extend(&mut self, body: &Body) -> bool {
        for ((z, s), q) in self.scaled.iter_mut().zip(&self.scale).zip(&self.current) {
            *z = s * q;
        }
        body.layout.repeat_period(&mut self.scaled);
        body.internal_force(&self.scaled, &mut self.image);
        for (y, s) in self.image.iter_mut().zip(&self.scale) {
            *y *= s;
        }
        let alpha = dot(&self.current, &self.image);
        let last = self.beta.last().copied().unwrap_or(0.0);
        let directions = self.current.iter().zip(&self.previous);
        for (y, (q, p)) in self.image.iter_mut().zip(directions) {
            *y -= alpha * q + last * p;
        }
        let beta = dot(&self.image, &self.image).sqrt();
        self.alpha.push(alpha);
        self.beta.push(beta);
        if beta <= 1e-13 * alpha.abs() {
            return false;
        }
        self.image.iter_mut().for_each(|y| *y /= beta);
        std::mem::swap(&mut self.previous, &mut self.current);
        std::mem::swap(&mut self.current, &mut self.image);
        true
    }

    /// Largest eigenvalue of the tridiagonal matrix, and a bound on its distance from the operator's.
    fn largest(&self) -> (f64, f64) {
        let n = self.alpha.len();
        let matrix = DMatrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
            0 => self.alpha[i],
            1 => self.beta[i.min(j)],
            _ => 0.0,
        });
        let eigen = SymmetricEigen::new(matrix);
        let top = eigen.eigenvalues.imax();
        let residual = self.beta[n - 1] * eigen.eigenvectors[(n - 1, top)].abs();
        (eigen.eigenvalues[top], residual)
    }
}

/// A rough vector, the same in every run: fractional parts of multiples of the golden ratio.
fn start_vector(scale: &[f64]) -> Vec<f64> {
    let rough = |k: usize| (k as f64 * 0.618_033_988_749_894_9).fract() - 0.5;
    let free = |s: &f64| if *s > 0.0 { 1.0 } else { 0.0 };
    let entries = scale.iter().enumerate();
    entries.map(|(k, s)| free(s) * rough(k + 1)).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
