//! Prediction of the error of a scene from the errors of other scenes.

use kit::student::student;
use nalgebra::{DMatrix, DVector};

/// A prediction of an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorPrediction {
    /// Median.
    pub expected: f64,
    /// Value that 39 of 40 scenes stay below.
    pub bound: f64,
}

/// Smallest number of degrees of freedom: with fewer, a bound is many times the error.
const LEAST_FREEDOM: usize = 3;

/// Smallest number of scenes for a prediction that depends on this many numbers of a scene.
pub fn least_scenes(numbers: usize) -> usize {
    numbers + 1 + LEAST_FREEDOM
}

/// Predicts the error at `at` (p numbers of a scene, for example logarithms of its loads) from the errors of n scenes at `positions`
/// (n x p): ln e = b0 + b.x + scatter by least squares, and the one-sided prediction interval of a further scene,
/// ln e < b0 + b.x + t_(0.975, n - p - 1) s sqrt(1 + h), h = x^T (X^T X)^-1 x (Montgomery, Peck and Vining, Introduction to
/// Linear Regression Analysis, 2012, equation 3.54). Numbers that are equal in all scenes explain nothing and are left out.
///
/// Returns `None` with fewer than [`least_scenes`], or if an error is not positive.
pub fn predict(positions: &[Vec<f64>], errors: &[f64], at: &[f64]) -> Option<ErrorPrediction> {
    let varied = |k: &usize| {
        let mut all = positions.iter();
        all.any(|position| position[*k] != positions[0][*k])
    };
    let varied: Vec<usize> = (0..at.len()).filter(varied).collect();
    let (n, p) = (positions.len(), 1 + varied.len());
    let positive = |error: &f64| *error > 0.0 && error.is_finite();
    if n < least_scenes(varied.len()) || !errors.iter().all(positive) {
        return None;
    }
    let freedom = n - p;
    let row = |of: &[f64]| -> Vec<f64> {
        let numbers = varied.iter().map(|k| of[*k]);
        std::iter::once(1.0).chain(numbers).collect()
    };
    let rows = positions.iter();
    let rows: Vec<f64> = rows.flat_map(|position| row(position)).collect();
    let x = DMatrix::from_row_slice(n, p, &rows);
    let y = DVector::from_iterator(n, errors.iter().map(|error| error.ln()));
    let inverse = (x.transpose() * &x).try_inverse()?;
    let b = &inverse * x.transpose() * &y;
    let scatter = ((&y - &x * &b).norm_squared() / freedom as f64).sqrt();
    let at = DVector::from_vec(row(at));
    let h = (at.transpose() * &inverse * &at)[(0, 0)];
    let middle = b.dot(&at);
    let t = student(freedom);
    Some(ErrorPrediction {
        expected: middle.exp(),
        bound: (middle + t * scatter * (1.0 + h).sqrt()).exp(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ln e = 0, 1, 2, 3 about a mean of 1.5 with s = sqrt(5/3), so that the bound is 3.182 s sqrt(1 + 1/4) above the mean.
    #[test]
    fn a_mean_has_the_interval_of_the_textbook() {
        let errors: Vec<f64> = (0..4).map(|k| f64::from(k).exp()).collect();
        let found = predict(&vec![vec![]; 4], &errors, &[]).expect("four will do");
        assert!((found.expected.ln() - 1.5).abs() < 1e-12);
        let above = 3.182 * (5.0f64 / 3.0).sqrt() * 1.25f64.sqrt();
        assert!((found.bound.ln() - 1.5 - above).abs() < 1e-12);
        assert_eq!(predict(&vec![vec![]; 3], &errors[..3], &[]), None);
    }

    /// Errors proportional to the load have no scatter about that law.
    #[test]
    fn a_law_of_the_load_is_followed() {
        let loads = [1.0, 1.0, 2.0, 2.0, 4.0, 4.0f64];
        let positions: Vec<Vec<f64>> = loads.iter().map(|load| vec![load.ln(), 7.0]).collect();
        let errors: Vec<f64> = loads.iter().map(|load| 0.01 * load).collect();
        let found = predict(&positions, &errors, &[3f64.ln(), 7.0]).expect("six will do");
        assert!((found.expected - 0.03).abs() < 1e-12, "{found:?}");
        assert!((found.bound - 0.03).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn an_error_of_zero_has_no_logarithm() {
        assert_eq!(
            predict(&vec![vec![]; 5], &[1.0, 1.0, 1.0, 0.0, 1.0], &[]),
            None
        );
    }

    /// If errors scatter by a known law, 39 of 40 stay below the bound: 2 000 trials of seven errors and an eighth.
    #[test]
    fn thirty_nine_of_forty_stay_below_the_bound() {
        let mut random = lab::random::Random::new(1);
        // Irwin-Hall of twelve: normal to 1e-3 of its density.
        let mut normal = || (0..12).map(|_| random.share()).sum::<f64>() - 6.0;
        let mut below = 0;
        for _ in 0..2000 {
            let errors: Vec<f64> = (0..8).map(|_| (0.5 * normal()).exp()).collect();
            let found = predict(&vec![vec![]; 7], &errors[..7], &[]).expect("seven will do");
            below += usize::from(errors[7] < found.bound);
        }
        // 1 950 expected with a deviation of 7.
        assert!((1929..=1971).contains(&below), "{below}");
    }
}
