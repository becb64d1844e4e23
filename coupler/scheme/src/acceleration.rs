//! Acceleration of fixed-point iterations: constant relaxation, Aitken, interface quasi-Newton (IQN-ILS).

use nalgebra::{DMatrix, DVector};

use crate::keys::Acceleration;

/// Columns whose part orthogonal to the others is below this fraction of their length add no information and make the
/// least-squares problem ill-posed.
const DEPENDENT: f64 = 1e-8;

/// Bound on the relaxation, of either sign: Aitken's quotient can take any value when two residuals are nearly equal.
const RELAXATION_MAX: f64 = 1.5;

/// The history of one window's iteration x -> x~(x).
#[derive(Clone, Debug)]
pub struct Accelerator {
    kind: Acceleration,
    relaxation: f64,
    residuals: Vec<DVector<f64>>,
    answers: Vec<DVector<f64>>,
}

impl Accelerator {
    /// With an empty history; `relaxation` is the constant factor or the first one.
    pub fn new(kind: Acceleration, relaxation: f64) -> Accelerator {
        Accelerator {
            kind,
            relaxation,
            residuals: Vec::new(),
            answers: Vec::new(),
        }
    }

    /// The next x after the answer x~ to x.
    pub fn next(&mut self, x: &[f64], answer: &[f64]) -> Vec<f64> {
        let x = DVector::from_column_slice(x);
        let answer = DVector::from_column_slice(answer);
        let residual = &answer - &x;
        let next = match self.kind {
            Acceleration::Constant => None,
            Acceleration::Aitken => {
                self.aitken(&residual);
                None
            }
            Acceleration::IqnIls => self.quasi_newton(&residual, &answer),
        };
        let next = next.unwrap_or_else(|| &x + &residual * self.relaxation);
        self.residuals.push(residual);
        self.answers.push(answer);
        next.as_slice().to_vec()
    }

    /// omega <- -omega r_old.(r - r_old) / |r - r_old|^2 (Irons and Tuck 1969).
    fn aitken(&mut self, residual: &DVector<f64>) {
        let Some(old) = self.residuals.last() else {
            return;
        };
        let change = residual - old;
        let square = change.norm_squared();
        if square > 0.0 {
            let factor = -self.relaxation * old.dot(&change) / square;
            self.relaxation = factor.clamp(-RELAXATION_MAX, RELAXATION_MAX);
        }
    }

    /// Interface quasi-Newton with an inverse Jacobian from least squares (Degroote, Bathe and Vierendeels 2009): with
    /// V, W the differences of residuals and answers to the latest ones, x = x~ + W c where c minimises |V c + r|.
    fn quasi_newton(&self, residual: &DVector<f64>, answer: &DVector<f64>) -> Option<DVector<f64>> {
        let mut basis: Vec<DVector<f64>> = Vec::new();
        let (mut v, mut w) = (Vec::new(), Vec::new());
        // Latest first, so that old dependent columns drop out.
        for (old_residual, old_answer) in self.residuals.iter().zip(&self.answers).rev() {
            let column = old_residual - residual;
            let mut rest = column.clone();
            for direction in &basis {
                rest -= direction * direction.dot(&rest);
            }
            if rest.norm() > DEPENDENT * column.norm() && rest.norm() > 0.0 {
                basis.push(rest.normalize());
                v.push(column);
                w.push(old_answer - answer);
            }
        }
        if v.is_empty() {
            return None;
        }
        let v = DMatrix::from_columns(&v);
        let w = DMatrix::from_columns(&w);
        let qr = v.qr();
        let right = -(qr.q().transpose() * residual);
        let c = qr.r().solve_upper_triangular(&right)?;
        Some(answer + w * c)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x~ = A x + b with eigenvalues -3 and 0.5: plain iteration diverges.
    fn iterate(kind: Acceleration, relaxation: f64, repeats: usize) -> f64 {
        let a = DMatrix::from_row_slice(2, 2, &[-2.0, 1.0, 1.5, -0.5]);
        let b = DVector::from_column_slice(&[1.0, 2.0]);
        let exact = (DMatrix::identity(2, 2) - &a)
            .lu()
            .solve(&b)
            .expect("regular");
        let mut accelerator = Accelerator::new(kind, relaxation);
        let mut x = vec![0.0, 0.0];
        for _ in 0..repeats {
            let answer = &a * DVector::from_column_slice(&x) + &b;
            x = accelerator.next(&x, answer.as_slice());
        }
        (DVector::from_column_slice(&x) - exact).norm()
    }

    #[test]
    fn quasi_newton_solves_a_linear_problem_of_two_unknowns_in_four_answers() {
        assert!(iterate(Acceleration::IqnIls, 0.5, 4) < 1e-10);
    }

    #[test]
    fn relaxation_converges_where_the_plain_iteration_does_not() {
        assert!(iterate(Acceleration::Constant, 1.0, 60) > 1e3);
        assert!(iterate(Acceleration::Constant, 0.4, 200) < 1e-10);
        assert!(iterate(Acceleration::Aitken, 0.4, 200) < 1e-10);
    }
}
