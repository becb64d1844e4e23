//! An estimate of the next wait's length from the last ones.
//!
//! To wake a sleeping thread costs its waker and itself some 20 us each where cores are virtual, several times a window. The
//! answers of a solver take about the same time in each window, so an end that sleeps stays awake, giving way to all who
//! compute, for a little longer than the longest of the last waits of this kind, and only then sleeps until it is woken.
//! A wake-up costs little beside a long wait: that is slept through from its beginning.

use std::collections::{BTreeMap, VecDeque};
use std::time::{Duration, Instant};

use crate::frame::Header;

/// Waits of one kind that are remembered.
const REMEMBERED: usize = 8;

/// Part of the longest wait by which the next may be longer.
const LATE: f64 = 0.25;

/// Longest wait that is spent awake: a wake-up is 2 % of it.
const LONG: Duration = Duration::from_millis(1);

/// Waits after the same frame are of one kind, and about as long as each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct WaitKind {
    /// Kind of the frame that arrived last.
    after: u32,
    /// Its repeat of the window; all after the second count as the second.
    iteration: u32,
}

/// The last waits of one end by their kind, the oldest first.
#[derive(Debug, Default)]
pub(super) struct WaitEstimate {
    known: BTreeMap<WaitKind, VecDeque<Duration>>,
    next: WaitKind,
    /// Start of the wait that goes on.
    since: Option<Instant>,
}

impl WaitEstimate {
    /// Begins a wait, or goes on with one that a call ended without a frame. Returns the end of the time that is spent
    /// awake, which lasts `at_least` so long.
    pub(super) fn awake_until(&mut self, now: Instant, at_least: Duration) -> Instant {
        let since = *self.since.get_or_insert(now);
        since + self.awake(self.next).max(at_least)
    }

    /// Ends a wait by the frame that came; its length may tell the next one's.
    pub(super) fn arrived(&mut self, header: &Header, tells: bool) {
        if let Some(since) = self.since.take().filter(|_| tells) {
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
    fn few_waits_and_other_kinds_are_not_foreseen() {
        let motion = WaitKind {
            after: 11,
            iteration: 0,
        };
        assert_eq!(of(&[500; 7]).awake(FORCE), Duration::ZERO);
        assert_eq!(of(&[500; 8]).awake(motion), Duration::ZERO);
    }

    #[test]
    fn long_waits_are_slept_through() {
        assert_eq!(of(&[900; 8]).awake(FORCE), Duration::ZERO);
        assert_eq!(of(&[5_000_000; 8]).awake(FORCE), Duration::ZERO);
    }
}
