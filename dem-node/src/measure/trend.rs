//! The straight line through values over time, and its interval of confidence.

use kit::student::student;
use serde::{Deserialize, Serialize};

/// Sums from which the line of least squares follows, y = a + b t.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Trend {
    count: f64,
    t: f64,
    y: f64,
    tt: f64,
    ty: f64,
    first: f64,
    last: f64,
}

impl Trend {
    /// Adds a value at a time; times rise.
    pub fn add(&mut self, t: f64, y: f64) {
        if self.count == 0.0 {
            self.first = t;
        }
        self.last = t;
        // Relative to the first time: squares of large times would cost digits.
        let t = t - self.first;
        self.count += 1.0;
        self.t += t;
        self.y += y;
        self.tt += t * t;
        self.ty += t * y;
    }

    /// Change of the line from the first to the last time; `None` for fewer than three values.
    pub fn change(&self) -> Option<f64> {
        let spread = self.count * self.tt - self.t * self.t;
        let slope = (self.count * self.ty - self.t * self.y) / spread;
        (self.count >= 3.0).then_some(slope * (self.last - self.first))
    }
}

/// Slope of the line through values one apart, and the half of its 95 % interval by Student's t; `None` for fewer than four. Correlated values say
/// less than independent ones: with r the correlation of neighbours about the line, n (1 - r)/(1 + r) of n values count (Santer et al. 2000, J.
/// Geophys. Res. 105, equation 6).
pub fn slope(values: &[f64]) -> Option<[f64; 2]> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let at = |k: usize| k as f64 - 0.5 * (n - 1.0);
    let sum = |of: &dyn Fn(usize) -> f64, last: usize| (0..last).map(of).sum::<f64>();
    let spread = sum(&|k| at(k).powi(2), values.len());
    let slope = sum(&|k| at(k) * (values[k] - mean), values.len()) / spread;
    let rest = |k: usize| values[k] - mean - slope * at(k);
    let squares = sum(&|k| rest(k).powi(2), values.len());
    let neighbours = sum(&|k| rest(k) * rest(k + 1), values.len().saturating_sub(1));
    let r = if squares > 0.0 {
        (neighbours / squares).clamp(0.0, 0.9)
    } else {
        0.0
    };
    let deviation = (squares / ((n - 2.0) * spread) * (1.0 + r) / (1.0 - r)).sqrt();
    (values.len() >= 4).then(|| [slope, student(values.len() - 2) * deviation])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 1, 3, 2, 4: a slope of 0.8, residuals -0.3, 0.9, -0.9, 0.3 that alternate, t = 4.303 of two degrees of freedom. 1, 2, 2, 1 about their mean:
    /// neighbours with -1/4 + 1/4 - 1/4 over 1, so that all count fully; 1, 1, 2, 2, 1, 1: residuals of -1/3 and 2/3 have (1 - 2 + 4 - 2 + 1)/12 =
    /// 1/6.
    #[test]
    fn a_slope_has_the_interval_of_its_residuals() {
        let [found, half] = slope(&[1.0, 3.0, 2.0, 4.0]).expect("four values");
        assert!((found - 0.8).abs() < 1e-12);
        assert!((half - 4.303 * (1.8f64 / 2.0 / 5.0).sqrt()).abs() < 1e-12);
        let [flat, half] = slope(&[1.0, 2.0, 2.0, 1.0]).expect("four values");
        assert!(flat.abs() < 1e-15 && (half - 4.303 * (1.0f64 / 2.0 / 5.0).sqrt()).abs() < 1e-12);
        let [flat, half] = slope(&[1.0, 1.0, 2.0, 2.0, 1.0, 1.0]).expect("six values");
        let independent = 2.776 * (4.0f64 / 3.0 / 4.0 / 17.5).sqrt();
        assert!(flat.abs() < 1e-15 && (half - independent * (7.0f64 / 5.0).sqrt()).abs() < 1e-12);
        assert_eq!(slope(&[0.0; 3]), None);
        assert_eq!(slope(&[2.0; 5]), Some([0.0; 2]));
    }

    #[test]
    fn a_line_is_found_below_an_oscillation() {
        let mut trend = Trend::default();
        for i in 0..=1000 {
            assert_eq!(trend.change().is_some(), i >= 3);
            let t = 7.0 + 1e-3 * f64::from(i);
            trend.add(t, 5.0 - 0.2 * (t - 7.0) + 0.05 * f64::from(i).sin());
        }
        let change = trend.change().expect("there are enough values");
        assert!((change + 0.2).abs() < 0.05, "{change}");
        let mut line = Trend::default();
        for t in [1.0, 2.0, 3.0] {
            line.add(t, 2.0 * t - 1.0);
        }
        assert!((line.change().expect("three") - 4.0).abs() < 1e-12);
    }
}
