//! The straight line through values over time, and how well they say it.

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
    yy: f64,
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
        // From the first time on: squares of large times would cost digits.
        let t = t - self.first;
        self.count += 1.0;
        self.t += t;
        self.y += y;
        self.tt += t * t;
        self.ty += t * y;
        self.yy += y * y;
    }

    /// Slope of the line, and the half of its 95 % interval by Student's t, which takes the values about the line as independent; `None` of
    /// less than four values.
    pub fn slope(&self) -> Option<[f64; 2]> {
        let n = self.count;
        let [tt, ty, yy] = [
            (self.tt, self.t * self.t),
            (self.ty, self.t * self.y),
            (self.yy, self.y * self.y),
        ]
        .map(|(sum, product)| sum - product / n);
        let slope = ty / tt;
        let freedom = n - 2.0;
        let variance = (yy - slope * ty).max(0.0) / (freedom * tt);
        (n >= 4.0).then(|| [slope, student(freedom as usize) * variance.sqrt()])
    }

    /// Change of the line from the first to the last time; `None` of less than three values.
    pub fn change(&self) -> Option<f64> {
        let spread = self.count * self.tt - self.t * self.t;
        let slope = (self.count * self.ty - self.t * self.y) / spread;
        (self.count >= 3.0).then_some(slope * (self.last - self.first))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert_eq!(line.slope(), None);
    }

    /// 1, 3, 2, 4 at 0, 1, 2, 3: a slope of 0.8, residuals -0.3, 0.9, -0.9, 0.3, and t = 4.303 of two degrees of freedom.
    #[test]
    fn a_slope_has_the_interval_of_its_residuals() {
        let mut trend = Trend::default();
        for (t, y) in [(0.0, 1.0), (1.0, 3.0), (2.0, 2.0), (3.0, 4.0)] {
            trend.add(t, y);
        }
        let [slope, half] = trend.slope().expect("four values");
        assert!((slope - 0.8).abs() < 1e-12);
        assert!((half - 4.303 * (1.8f64 / 2.0 / 5.0).sqrt()).abs() < 1e-12);
    }
}
