//! Anderson's extrapolation of the sweeps r' = T(r).
//!
//! While no contact changes between open, stick and slip, T is linear, and there is a combination of the last m sweeps whose increments T(r) - r
//! cancel as well as possible. With the differences dr_k, dg_k of neighbouring guesses and increments g_k
//!
//! ```text
//! gamma = arg min |D (g - sum gamma_k dg_k)|,     r' = r + g - sum gamma_k (dr_k + dg_k)
//! ```
//!
//! (Anderson, "Iterative procedures for nonlinear integral equations", J. ACM 12 (1965) 547-560; Walker and Ni, SIAM J. Numer.
//! Anal. 49 (2011) 1715-1735). This removes m modes of any eigenvalues: modes of 0.9998, along which plain sweeps creep, and modes beyond 1 of strong
//! friction, along which plain sweeps diverge.

use std::collections::VecDeque;

use nalgebra::{Cholesky, DMatrix, DVector};

/// Number m of stored sweeps. With 5 and with 20 about as many windows converge.
const DEPTH: usize = 10;

/// Growth of the increment which shows that the stored sweeps have other contact states.
const GROWTH: f64 = 2.0;

/// Part of its square that is added to each difference: with less, gamma is a rounding error.
const REGULARISATION: f64 = 1e-12;

/// The last sweeps.
#[derive(Clone, Debug, Default)]
pub(super) struct Extrapolation {
    /// Guess, increment and |D increment| of the last sweep.
    last: Option<[Vec<f64>; 2]>,
    /// The differences of the stored sweeps, the oldest first.
    differences: VecDeque<Difference>,
    /// The least |D g| of the stored sweeps.
    least: f64,
}

#[derive(Clone, Debug)]
struct Difference {
    guess: Vec<f64>,
    increment: Vec<f64>,
    /// D dg of the impulses.
    weighted: Vec<f64>,
}

impl Extrapolation {
    /// Forgets all sweeps.
    pub(super) fn forget(&mut self) {
        self.last = None;
        self.differences.clear();
    }

    /// The next guess, given that a sweep has led from `before` to `after`. The first numbers are the impulses, whose increments are weighted with
    /// `diagonal`; all others are linear in them.
    pub(super) fn next(&mut self, diagonal: &[f64], before: Vec<f64>, after: &[f64]) -> Vec<f64> {
        let minus =
            |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a - b).collect() };
        let weigh =
            |g: &[f64]| -> Vec<f64> { diagonal.iter().zip(g).map(|(d, g)| d * g).collect() };
        let increment = minus(after, &before);
        let weighted = weigh(&increment);
        let length = dot(&weighted, &weighted).sqrt();
        // False for NaN.
        let same_states = length <= GROWTH * self.least;
        if !same_states {
            self.forget();
            self.least = length;
        }
        self.least = self.least.min(length);
        if let Some([guess, old]) = self.last.take() {
            let change = minus(&increment, &old);
            self.differences.push_back(Difference {
                guess: minus(&before, &guess),
                weighted: weigh(&change),
                increment: change,
            });
            if self.differences.len() > DEPTH {
                self.differences.pop_front();
            }
        }
        let mut next = after.to_vec();
        match self.combination(&weighted) {
            Some(gamma) => {
                for (difference, gamma) in self.differences.iter().zip(&gamma) {
                    let both = difference.guess.iter().zip(&difference.increment);
                    for (next, (guess, increment)) in next.iter_mut().zip(both) {
                        *next -= gamma * (guess + increment);
                    }
                }
            }
            None => self.differences.clear(),
        }
        self.last = Some([before, increment]);
        next
    }

    /// gamma; `None` where the differences determine nothing.
    fn combination(&self, weighted: &[f64]) -> Option<Vec<f64>> {
        let columns: Vec<&[f64]> = self.differences.iter().map(|d| &d.weighted[..]).collect();
        let lengths: Vec<f64> = columns.iter().map(|dg| dot(dg, dg).sqrt()).collect();
        let counts = |length: &f64| *length != 0.0 && length.is_finite();
        if !lengths.iter().all(counts) {
            return None;
        }
        let m = columns.len();
        let gram = DMatrix::from_fn(m, m, |i, j| {
            let product = dot(columns[i], columns[j]) / (lengths[i] * lengths[j]);
            product + if i == j { REGULARISATION } else { 0.0 }
        });
        let right = DVector::from_fn(m, |i, _| dot(columns[i], weighted) / lengths[i]);
        let gamma = Cholesky::new(gram)?.solve(&right);
        let both = gamma.iter().zip(&lengths);
        Some(both.map(|(gamma, length)| gamma / length).collect())
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// r' = A r + b with the eigenvalues 0.9999, 1.01 and 0.2 +- 1.1 i: plain sweeps creep, diverge and circle.
    fn swept(r: &[f64]) -> Vec<f64> {
        vec![
            0.9999 * r[0] + 1e-4,
            1.01 * r[1] + 0.3 * r[0] - 0.5,
            0.2 * r[2] - 1.1 * r[3] + 1.0,
            1.1 * r[2] + 0.2 * r[3] + 0.1 * r[1],
        ]
    }

    #[test]
    fn modes_that_creep_diverge_and_circle_are_removed() {
        let mut extrapolation = Extrapolation::default();
        let mut r = vec![5.0, -3.0, 2.0, 7.0];
        for _ in 0..8 {
            let after = swept(&r);
            r = extrapolation.next(&[1.0, 2.0, 0.5, 1.0], r, &after);
        }
        // The fixed point: r0 = 1, r1 = 20.
        let defect = swept(&r)
            .iter()
            .zip(&r)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        assert!(defect < 1e-9, "{defect:e} at {r:?}");
        assert!(
            (r[0] - 1.0).abs() < 1e-6 && (r[1] - 20.0).abs() < 1e-6,
            "{r:?}"
        );
    }
}
