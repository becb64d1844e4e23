//! The remaining time of a run.

use crate::cost::prediction::Mark;

/// Number of marks that are kept; beyond it every other mark is dropped.
const MARKS: usize = 256;

/// Marks of a run. The rest is assumed to run like the second half of the time so far: the phases of a load differ, and
/// the latest is nearest to the rest.
#[derive(Clone, Debug, Default)]
pub struct Remaining {
    marks: Vec<Mark>,
}

impl Remaining {
    /// Begins at this simulated time (s).
    pub fn from(t_s: f64) -> Remaining {
        Remaining {
            marks: vec![Mark { t_s, wall_s: 0.0 }],
        }
    }

    /// The run has reached a simulated time after this wall-clock time (s).
    pub fn add(&mut self, t_s: f64, wall_s: f64) {
        if self.marks.len() >= MARKS {
            let mut index = 0;
            self.marks.retain(|_| {
                index += 1;
                index % 2 == 1
            });
        }
        self.marks.push(Mark { t_s, wall_s });
    }

    /// Remaining wall-clock time (s) until this simulated time (s); `None` before there are two marks.
    pub fn until(&self, end_s: f64) -> Option<f64> {
        let last = *self.marks.last()?;
        let is_early = |mark: &Mark| mark.wall_s < 0.5 * last.wall_s;
        let half = self.marks.partition_point(is_early);
        let from = self.marks[half.min(self.marks.len().saturating_sub(2))];
        let left_s = from.rate(last) * (end_s - last.t_s);
        left_s.is_finite().then(|| left_s.max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rest_runs_like_the_second_half() {
        let mut remaining = Remaining::from(0.0);
        assert_eq!(remaining.until(10.0), None);
        // Two simulated seconds in 1 s, then one in 2 s.
        remaining.add(2.0, 1.0);
        assert_eq!(remaining.until(10.0), Some(4.0));
        remaining.add(3.0, 3.0);
        remaining.add(4.0, 5.0);
        assert_eq!(remaining.until(10.0), Some(12.0));
        assert_eq!(remaining.until(4.0), Some(0.0));
    }

    #[test]
    fn a_long_run_keeps_few_marks_and_its_rate() {
        let mut remaining = Remaining::from(0.0);
        for second in 1..100_000 {
            remaining.add(f64::from(second), 3.0 * f64::from(second));
        }
        assert!(remaining.marks.len() <= MARKS);
        let left_s = remaining.until(100_000.0).expect("it is on its way");
        assert!((left_s - 3.0).abs() < 1e-9, "{left_s}");
    }
}
