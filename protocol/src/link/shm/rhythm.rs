//! How long the next wait will last, as the last ones tell.
//!
//! To wake a sleeping thread costs its waker and itself some 20 us each where cores are virtual, several times a window. The
//! answers of a solver take about the same time in each window, so an end that sleeps can be awake when its answer comes:
//! it naps for less than the shortest of the last waits of this kind, then looks for a little while, giving way to all who
//! compute, and only then sleeps until it is woken. Short waits are spent awake.

use std::time::{Duration, Instant};

use crate::frame::Header;

/// Waits of one kind that are remembered.
const REMEMBERED: usize = 8;

/// Waits below this are not napped through.
const SHORT: Duration = Duration::from_micros(120);

/// Longest nap: what comes sooner than foreseen has to wait for its end.
const LONG: Duration = Duration::from_millis(10);

/// A nap ends earlier than the shortest wait by this part of it, and by the time that waking up takes.
const EARLY: f64 = 0.15;
const WAKING: Duration = Duration::from_micros(20);

/// How late a nap may end (ns).
#[cfg(target_os = "linux")]
const TIMER_SLACK_NS: core::ffi::c_ulong = 1_000;

/// When a wait begins: kind and repeat of the frame that arrived last.
type Occasion = (u32, u32);

/// The waits of one end.
#[derive(Debug, Default)]
pub(super) struct Rhythm {
    waits: Vec<(Occasion, Vec<Duration>)>,
    occasion: Occasion,
    /// Start of the wait that goes on.
    since: Option<Instant>,
}

/// How to wait: nap until `nap` has passed since the start, then look until `awake` has.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Plan {
    pub(super) nap: Duration,
    pub(super) awake: Duration,
}

impl Rhythm {
    /// For an end that waits on this thread.
    pub(super) fn new() -> Rhythm {
        // Else naps end up to 50 us late; where this is refused, so be it.
        #[cfg(target_os = "linux")]
        let _ = nix::sys::prctl::set_timerslack(TIMER_SLACK_NS);
        Rhythm::default()
    }

    /// The end waits, perhaps still. Returns since when, and how it may.
    pub(super) fn waiting(&mut self) -> (Instant, Plan) {
        let since = *self.since.get_or_insert_with(Instant::now);
        (since, self.plan(self.occasion))
    }

    /// What it waited for is there; all repeats after the first count as one.
    pub(super) fn arrived(&mut self, header: &Header) {
        if let Some(since) = self.since.take() {
            self.add(self.occasion, since.elapsed());
        }
        self.occasion = (header.kind, header.iteration.min(2));
    }

    /// How to wait this time; nothing is planned until enough waits are known.
    fn plan(&self, occasion: Occasion) -> Plan {
        let Some((_, waits)) = self.waits.iter().find(|(known, _)| *known == occasion) else {
            return Plan::default();
        };
        let shortest = waits.iter().min().copied().unwrap_or_default();
        if waits.len() < REMEMBERED {
            return Plan::default();
        }
        let early = shortest.mul_f64(EARLY) + WAKING;
        let nap = match shortest < SHORT {
            true => Duration::ZERO,
            false => (shortest - early).min(LONG),
        };
        Plan {
            nap,
            awake: (shortest + 2 * early).min(LONG),
        }
    }

    fn add(&mut self, occasion: Occasion, wait: Duration) {
        let known = self.waits.iter().position(|(known, _)| *known == occasion);
        let place = known.unwrap_or_else(|| {
            self.waits.push((occasion, Vec::with_capacity(REMEMBERED)));
            self.waits.len() - 1
        });
        let waits = &mut self.waits[place].1;
        if waits.len() == REMEMBERED {
            waits.remove(0);
        }
        waits.push(wait);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FORCE: Occasion = (13, 0);

    fn of(micros: &[u64]) -> Rhythm {
        let mut rhythm = Rhythm::default();
        for micros in micros {
            rhythm.add(FORCE, Duration::from_micros(*micros));
        }
        rhythm
    }

    #[test]
    fn regular_waits_are_napped_through_and_end_awake() {
        let plan = of(&[500, 510, 520, 500, 505, 500, 530, 500]).plan(FORCE);
        assert_eq!(plan.nap, Duration::from_micros(405));
        assert_eq!(plan.awake, Duration::from_micros(690));
    }

    #[test]
    fn the_shortest_of_the_last_waits_decides_until_it_is_forgotten() {
        let mut rhythm = of(&[500, 500, 500, 140, 500, 500, 500, 500]);
        assert_eq!(rhythm.plan(FORCE).nap, Duration::from_micros(99));
        for _ in 0..4 {
            rhythm.add(FORCE, Duration::from_micros(500));
        }
        assert_eq!(rhythm.plan(FORCE).nap, Duration::from_micros(405));
    }

    #[test]
    fn short_waits_are_spent_awake() {
        let plan = of(&[50; 8]).plan(FORCE);
        assert_eq!(plan.nap, Duration::ZERO);
        assert_eq!(plan.awake, Duration::from_micros(105));
    }

    #[test]
    fn few_waits_and_other_occasions_are_not_foreseen() {
        assert_eq!(of(&[500; 7]).plan(FORCE), Plan::default());
        assert_eq!(of(&[500; 8]).plan((11, 0)), Plan::default());
    }

    #[test]
    fn no_nap_is_longer_than_its_bound() {
        assert!(of(&[5_000_000; 8]).plan(FORCE).nap <= LONG);
    }
}
