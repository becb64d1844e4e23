//! An estimate of the next wait's length from the last waits.
//!
//! On virtual cores, waking a sleeping thread costs the waker and the woken thread some 20 us each, several times a window. A
//! solver's answers take about the same time in each window. So an end that shares its core stays awake, yielding to other
//! threads, for a little longer than the longest of the last waits of this kind, and only then sleeps until it is woken.
//! A wake-up costs little compared with a long wait, so an end sleeps through a long wait from its start.

use std::collections::{BTreeMap, VecDeque};
use std::time::{Duration, Instant};

use crate::frame::Header;

/// Number of remembered waits of one kind.
const REMEMBERED: usize = 8;

/// Fraction of the longest wait by which the next may be longer.
const LATE: f64 = 0.25;

/// Longest wait that is spent awake: a wake-up takes 2 % of this time.
const LONG: Duration = Duration::from_millis(1);

/// Waits after the same frame are of one kind and have about the same length.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct WaitKind {
    /// Kind of the frame that arrived last.
    after: u32,
    /// Its repeat of the window; later repeats count as repeat 2.
    iteration: u32,
}

/// The last waits of one end by kind, the oldest first.
#[derive(Debug, Default)]
pub(super) struct WaitEstimate {
    known: BTreeMap<WaitKind, VecDeque<Duration>>,
    next: WaitKind,
    /// Start of the current wait.
    since: Option<Instant>,
}

impl WaitEstimate {
    /// Begins a wait, or continues one that a call ended without a frame. Returns the end of the time spent awake,
    /// which lasts at least `at_least`.
    pub(super) fn awake_until(&mut self, now: Instant, at_least: Duration) -> Instant {
        let since = *self.since.get_or_insert(now);
        since + self.awake(self.next).max(at_least)
    }

    /// Ends a wait with the frame that came. A `typical` wait enters the estimate.
    pub(super) fn arrived(&mut self, header: &Header, typical: bool) {
        if let Some(since) = self.since.take().filter(|_| typical) {
            self.add(self.next, since.elapsed());
        }
        self.next = WaitKind {
            after: header.kind,
            iteration: header.iteration.min(2),
        };
    }

    /// Time to stay awake in a wait of this kind; zero until enough of them are known.
    fn awake(&self, kind: WaitKind) -> Duration {
        let known = self.known.get(&kind);
        let full = known.filter(|last| last.len() == REMEMBERED);
        let longest = full.and_then(|last| last.iter().max());
        let awake = longest.map_or(Duration::ZERO, |longest| longest.mul_f64(1.0 + LATE));
        if awake > LONG { Duration::ZERO } else { awake }
    }

    fn add(&mut self, kind: WaitKind, wait: Duration) {
        let last = self.known.entry(kind).or_default();
        if last.len() == REMEMBERED {
            last.pop_front();
        }
        last.push_back(wait);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FORCE: WaitKind = WaitKind {
        after: 13,
        iteration: 0,
    };

    fn of(micros: &[u64]) -> WaitEstimate {
        let mut estimate = WaitEstimate::default();
        for micros in micros {
            estimate.add(FORCE, Duration::from_micros(*micros));
        }
        estimate
    }

    #[test]
    fn the_longest_of_the_last_waits_decides_until_it_is_forgotten() {
        let mut estimate = of(&[500, 500, 500, 800, 500, 500, 500, 500]);
        assert_eq!(estimate.awake(FORCE), Duration::from_micros(1000));
        for _ in 0..4 {
            estimate.add(FORCE, Duration::from_micros(400));
        }
        assert_eq!(estimate.awake(FORCE), Duration::from_micros(625));
    }

    #[test]
    fn few_waits_and_other_kinds_give_no_estimate() {
        let motion = WaitKind {
            after: 11,
            iteration: 0,
        };
        assert_eq!(of(&[500; 7]).awake(FORCE), Duration::ZERO);
        assert_eq!(of(&[500; 8]).awake(motion), Duration::ZERO);
    }

    #[test]
    fn an_end_sleeps_through_long_waits() {
        assert_eq!(of(&[900; 8]).awake(FORCE), Duration::ZERO);
        assert_eq!(of(&[5_000_000; 8]).awake(FORCE), Duration::ZERO);
    }
}
