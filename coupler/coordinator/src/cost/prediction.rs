//! Time and memory of a whole run, predicted from its first windows.

use std::time::{Duration, Instant};

use protocol::busy::monotonic_ns;
use serde::Serialize;

use super::memory::peak_bytes;

/// Time of the observed first windows: longer than the fluctuations of a machine, and short compared with a run that is
/// worth a prediction.
const LOOK: Duration = Duration::from_secs(1);

/// Number of windows to observe if they take longer, and the time limit for this.
const LOOK_WINDOWS: usize = 4;
const LOOK_LONGEST: Duration = Duration::from_secs(10);

/// Fewest windows for a prediction: with many grains the first window starts cold.
const LEAST_WINDOWS: usize = 2;

/// Number of parts of these windows that are compared.
const QUARTERS: usize = 4;

/// Cost of a whole run, from its set-up and its first windows. The rates are measured in this run on this machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct CostPrediction {
    /// Wall-clock time (s).
    pub wall_s: f64,
    /// Time if the rest runs like the fastest quarter of the observed windows (s).
    pub wall_low_s: f64,
    /// Time if the rest runs like the slowest quarter of the observed windows (s).
    pub wall_high_s: f64,
    /// Observed windows.
    pub windows: u64,
    /// Windows of the whole run, if the rest has the same length.
    pub windows_of_run: f64,
    /// Wall-clock time of the observed windows (s).
    pub windows_wall_s: f64,
    /// Largest memory of all processes together (bytes).
    pub memory_bytes: u64,
}

/// A moment between two windows.
#[derive(Clone, Copy, Debug, Default)]
pub struct Mark {
    /// Simulated time (s).
    pub t_s: f64,
    /// Wall-clock time since the first window began (s).
    pub wall_s: f64,
}

impl Mark {
    /// Wall-clock time (s) for one simulated second, from here to a later mark.
    pub fn rate(self, later: Mark) -> f64 {
        (later.wall_s - self.wall_s) / (later.t_s - self.t_s)
    }
}

/// The pace of a run, until its cost can be predicted.
#[derive(Default)]
pub struct Pace {
    pids: Vec<u32>,
    begun: Option<Begun>,
    marks: Vec<Mark>,
    /// The prediction, as soon as windows have been observed for a second.
    pub prediction: Option<CostPrediction>,
    /// End of the last window (ns of the monotonic clock).
    ended_ns: Option<u64>,
    /// Largest memory (bytes) of all processes together at that time.
    pub memory_bytes: u64,
}

/// The beginning of the first window.
struct Begun {
    at_ns: u64,
    setup_wall_s: f64,
    end_s: f64,
}

impl Pace {
    /// A run of these processes.
    pub fn new(pids: Vec<u32>) -> Pace {
        Pace {
            pids,
            ..Pace::default()
        }
    }

    /// The windows begin now, at the simulated time `t_s`, in a run that started at `start` and ends at `end_s`.
    pub fn begin(&mut self, start: Instant, t_s: f64, end_s: f64) {
        self.begun = Some(Begun {
            at_ns: monotonic_ns(),
            setup_wall_s: start.elapsed().as_secs_f64(),
            end_s,
        });
        self.marks = vec![Mark { t_s, wall_s: 0.0 }];
    }

    /// A window has ended and all groups have reached `t_s`; predicts the cost after enough windows.
    pub fn see(&mut self, t_s: f64) {
        let Some(begun) = self.begun.as_ref().filter(|_| self.prediction.is_none()) else {
            return;
        };
        let passed = Duration::from_nanos(monotonic_ns() - begun.at_ns);
        let wall_s = passed.as_secs_f64();
        self.marks.push(Mark { t_s, wall_s });
        let windows = self.marks.len() - 1;
        let few = windows < LEAST_WINDOWS || (windows < LOOK_WINDOWS && passed < LOOK_LONGEST);
        if (passed < LOOK || few) && t_s < begun.end_s * (1.0 - 1e-9) {
            return;
        }
        let mut prediction = predict(&self.marks, begun.end_s);
        prediction.wall_s += begun.setup_wall_s;
        prediction.wall_low_s += begun.setup_wall_s;
        prediction.wall_high_s += begun.setup_wall_s;
        prediction.memory_bytes = peak_bytes(&self.pids);
        self.prediction = Some(prediction);
        self.marks = Vec::new();
    }

    /// The last window has ended.
    pub fn end(&mut self) {
        self.ended_ns = Some(monotonic_ns());
        self.memory_bytes = peak_bytes(&self.pids);
    }

    /// Start and end of all windows together (ns of the monotonic clock), once they are over.
    pub fn stretch_ns(&self) -> Option<[u64; 2]> {
        Some([self.begun.as_ref()?.at_ns, self.ended_ns?])
    }

    /// Wall-clock time of the set-up (s), once it is over.
    pub fn setup_wall_s(&self) -> Option<f64> {
        self.begun.as_ref().map(|begun| begun.setup_wall_s)
    }
}

/// Time of all windows until `end_s`. The rest is assumed to run like the second half of the observed windows: the
/// first windows include work that is done once, and later ones are nearer to the rest in the load history.
fn predict(marks: &[Mark], end_s: f64) -> CostPrediction {
    let (first, last) = (marks[0], marks[marks.len() - 1]);
    let at = |part: usize| {
        let wall_s = last.wall_s * part as f64 / QUARTERS as f64;
        marks[marks.partition_point(|mark| mark.wall_s < wall_s)]
    };
    let rate = |from: Mark, to: Mark| Some(from.rate(to)).filter(|rate| rate.is_finite());
    let mean = rate(first, last).unwrap_or(0.0);
    let quarters = (0..QUARTERS).filter_map(|part| rate(at(part), at(part + 1)));
    let quarters: Vec<f64> = quarters.collect();
    let left_s = (end_s - last.t_s).max(0.0);
    let whole = |rate: f64| last.wall_s + rate * left_s;
    CostPrediction {
        wall_s: whole(rate(at(QUARTERS / 2), last).unwrap_or(mean)),
        wall_low_s: whole(quarters.iter().copied().fold(mean, f64::min)),
        wall_high_s: whole(quarters.iter().copied().fold(mean, f64::max)),
        windows: marks.len() as u64 - 1,
        windows_of_run: (marks.len() - 1) as f64 * (1.0 + left_s / (last.t_s - first.t_s)),
        windows_wall_s: last.wall_s,
        memory_bytes: 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Marks after windows of one simulated second with these wall-clock times.
    fn after(walls_s: impl IntoIterator<Item = f64>) -> Vec<Mark> {
        let mut marks = vec![Mark::default()];
        for wall_s in walls_s {
            let last = marks[marks.len() - 1];
            marks.push(Mark {
                t_s: last.t_s + 1.0,
                wall_s: last.wall_s + wall_s,
            });
        }
        marks
    }

    #[test]
    fn equal_windows_are_extrapolated() {
        let prediction = predict(&after([0.25; 8]), 100.0);
        let walls_s = [
            prediction.wall_s,
            prediction.wall_low_s,
            prediction.wall_high_s,
        ];
        assert_eq!(walls_s, [25.0; 3]);
        assert_eq!((prediction.windows, prediction.windows_wall_s), (8, 2.0));
    }

    #[test]
    fn a_slow_start_counts_once_and_widens_the_range() {
        // 1 s for the first window, 1 s for four and 2 s for eight.
        let prediction = predict(&after([[1.0].as_slice(), &[0.25; 12]].concat()), 113.0);
        assert_eq!(prediction.wall_s, 4.0 + 25.0);
        assert_eq!(prediction.wall_low_s, 4.0 + 25.0);
        assert_eq!(prediction.wall_high_s, 4.0 + 100.0);
    }

    #[test]
    fn a_single_window_and_a_whole_run_can_be_extrapolated() {
        assert_eq!(predict(&after([3.0]), 4.0).wall_s, 12.0);
        assert_eq!(predict(&after([3.0, 1.0]), 2.0).wall_s, 4.0);
    }
}
