//! A row of the table of faults: many trials of one fault.

use std::collections::BTreeMap;

use serde::Serialize;

use scenario::error::Error;

/// A trial whose outcome was right.
#[derive(Clone, Debug, Default)]
pub struct FaultOutcome {
    /// Its end in a word or two.
    pub word: &'static str,
    /// Time from the fault until all processes of the run had ended, if the fault ended the run (s).
    pub detection_s: Option<f64>,
    /// Windows that had to be repeated.
    pub windows_lost: Option<u64>,
}

impl FaultOutcome {
    /// An end with nothing to find and no lost window.
    pub fn of(word: &'static str) -> FaultOutcome {
        FaultOutcome {
            word,
            ..FaultOutcome::default()
        }
    }

    /// An end this long (s) after the fault, with this many lost windows.
    pub fn after(detection_s: f64, word: &'static str, windows_lost: Option<u64>) -> FaultOutcome {
        FaultOutcome {
            word,
            detection_s: Some(detection_s),
            windows_lost,
        }
    }
}

/// A wrong outcome, or the reason why there is no outcome.
#[derive(Debug)]
pub enum Wrong {
    /// It does not follow the rule of its row.
    Outcome(String),
    /// The campaign itself cannot go on.
    Campaign(Error),
}

impl From<Error> for Wrong {
    fn from(error: Error) -> Wrong {
        Wrong::Campaign(error)
    }
}

impl From<String> for Wrong {
    fn from(why: String) -> Wrong {
        Wrong::Outcome(why)
    }
}

/// The result of a trial.
pub type FaultResult = Result<FaultOutcome, Wrong>;

/// One line of the table.
#[derive(Clone, Debug, Default, Serialize)]
pub struct FaultRow {
    /// The fault.
    pub name: String,
    /// Seed of its instants.
    pub seed: u64,
    /// Trials, or schedules.
    pub trials: u64,
    /// Trials that ended right.
    pub right: u64,
    /// Outcomes of the right trials, with their counts.
    pub outcomes: BTreeMap<String, u64>,
    /// Median of the times until the end (s).
    pub detection_p50_s: Option<f64>,
    /// 99th percentile of these times (s).
    pub detection_p99_s: Option<f64>,
    /// Bound of the 99th percentile (s).
    pub detection_bound_s: Option<f64>,
    /// Mean number of windows that had to be repeated.
    pub windows_lost_mean: Option<f64>,
    /// Largest number of these windows.
    pub windows_lost_max: Option<u64>,
    /// Processes and files in shared memory that were left.
    pub leftovers: u64,
    /// Schedules per minute, for the row of simulated runs.
    pub per_minute: Option<f64>,
    /// Descriptions of the first few wrong trials.
    pub wrong: Vec<String>,
    /// True if all trials ended right and in time, and nothing was left.
    pub holds: bool,
    #[serde(skip)]
    detections_s: Vec<f64>,
    #[serde(skip)]
    windows_lost: Vec<u64>,
}

/// Wrong trials that a row lists.
const LISTED: usize = 5;

impl FaultRow {
    /// A row without trials; a fault must be found within `bound_s`, if there is something to find.
    pub fn new(name: &str, seed: u64, bound_s: Option<f64>) -> FaultRow {
        FaultRow {
            name: name.into(),
            seed,
            detection_bound_s: bound_s,
            ..FaultRow::default()
        }
    }

    /// Counts trials with this outcome.
    pub fn ended(&mut self, word: &str, count: u64) {
        if count > 0 {
            self.trials += count;
            self.right += count;
            *self.outcomes.entry(word.into()).or_default() += count;
        }
    }

    /// Counts a trial that did not end right.
    pub fn failed(&mut self, why: String) {
        self.trials += 1;
        if self.wrong.len() < LISTED {
            self.wrong.push(why);
        }
    }

    /// Counts a trial; an error of the campaign is returned.
    pub fn add(&mut self, index: usize, tried: FaultResult, leftovers: u64) -> Result<(), Error> {
        self.leftovers += leftovers;
        match tried {
            Ok(outcome) => {
                self.ended(outcome.word, 1);
                self.detections_s.extend(outcome.detection_s);
                self.windows_lost.extend(outcome.windows_lost);
            }
            Err(Wrong::Outcome(why)) => self.failed(format!("trial {index}: {why}")),
            Err(Wrong::Campaign(error)) => return Err(error),
        }
        Ok(())
    }

    /// The row with its statistics and its verdict.
    pub fn judged(mut self) -> FaultRow {
        self.detections_s.sort_by(f64::total_cmp);
        self.detection_p50_s = percentile(&self.detections_s, 0.5);
        self.detection_p99_s = percentile(&self.detections_s, 0.99);
        let lost = &self.windows_lost;
        self.windows_lost_max = lost.iter().copied().max();
        let mean = |_| lost.iter().sum::<u64>() as f64 / lost.len() as f64;
        self.windows_lost_mean = self.windows_lost_max.map(mean);
        let late = self.detection_p99_s.zip(self.detection_bound_s);
        let in_time = late.is_none_or(|(found_s, bound_s)| found_s <= bound_s);
        self.holds = self.trials > 0 && self.right == self.trials && self.leftovers == 0 && in_time;
        self
    }
}

/// The smallest value that this share of the sorted values does not exceed.
fn percentile(sorted: &[f64], share: f64) -> Option<f64> {
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(tried: impl IntoIterator<Item = (FaultResult, u64)>) -> FaultRow {
        let mut row = FaultRow::new("fault", 1, Some(1.0));
        for (index, (tried, leftovers)) in tried.into_iter().enumerate() {
            row.add(index, tried, leftovers)
                .expect("the campaign goes on");
        }
        row.judged()
    }

    fn found(detection_s: f64, windows_lost: u64) -> FaultResult {
        Ok(FaultOutcome {
            word: "lost",
            detection_s: Some(detection_s),
            windows_lost: Some(windows_lost),
        })
    }

    #[test]
    fn a_row_holds_if_all_is_right_in_time_and_nothing_left() {
        let good = row([(found(0.1, 3), 0), (found(0.9, 6), 0), (found(0.2, 0), 0)]);
        assert!(good.holds, "{good:?}");
        assert_eq!((good.trials, good.right), (3, 3));
        assert_eq!(good.detection_p50_s, Some(0.2));
        assert_eq!(good.detection_p99_s, Some(0.9));
        assert_eq!(good.windows_lost_mean, Some(3.0));
        assert_eq!(good.windows_lost_max, Some(6));
        assert!(!row([(found(0.1, 0), 0), (found(1.1, 0), 0)]).holds);
        assert!(!row([(found(0.1, 0), 1)]).holds);
        assert!(!row([(Err(String::from("hung").into()), 0)]).holds);
        assert!(!row([]).holds);
    }
}
