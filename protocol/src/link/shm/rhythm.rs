//! How long the next wait will last, as the last ones tell.
//!
//! To wake a sleeping thread costs its waker and itself some 20 us each where cores are virtual, several times a window. The
//! answers of a solver take about the same time in each window, so an end that sleeps stays awake, giving way to all who
//! compute, for a little longer than the longest of the last waits of this kind, and only then sleeps until it is woken.
//! Where the wait is long, a wake-up costs nothing against it: then it sleeps at once.

use std::time::{Duration, Instant};

use crate::frame::Header;

/// Waits of one kind that are remembered.
const REMEMBERED: usize = 8;

/// Part of the longest wait by which the next may be longer.
const LATE: f64 = 0.25;

/// Longest wait that is spent awake.
const LONG: Duration = Duration::from_millis(10);

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

impl Rhythm {
    /// The end waits, perhaps still. Returns since when, and for how long it stays awake.
    pub(super) fn waiting(&mut self) -> (Instant, Duration) {
        let since = *self.since.get_or_insert_with(Instant::now);
        (since, self.awake(self.occasion))
    }

    /// What it waited for is there; all repeats after the first count as one.
    pub(super) fn arrived(&mut self, header: &Header) {
        if let Some(since) = self.since.take() {
            self.add(self.occasion, since.elapsed());
        }
        self.occasion = (header.kind, header.iteration.min(2));
    }

    /// How long to stay awake this time; nothing is planned until enough waits are known.
    fn awake(&self, occasion: Occasion) -> Duration {
        let known = self.waits.iter().find(|(known, _)| *known == occasion);
        let full = known.filter(|(_, waits)| waits.len() == REMEMBERED);
        let longest = full.and_then(|(_, waits)| waits.iter().max());
        let awake = longest.map_or(Duration::ZERO, |longest| longest.mul_f64(1.0 + LATE));
        if awake > LONG { Duration::ZERO } else { awake }
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
    fn the_longest_of_the_last_waits_decides_until_it_is_forgotten() {
        let mut rhythm = of(&[500, 500, 500, 800, 500, 500, 500, 500]);
        assert_eq!(rhythm.awake(FORCE), Duration::from_micros(1000));
        for _ in 0..4 {
            rhythm.add(FORCE, Duration::from_micros(400));
        }
        assert_eq!(rhythm.awake(FORCE), Duration::from_micros(625));
    }

    #[test]
    fn few_waits_and_other_occasions_are_not_foreseen() {
        assert_eq!(of(&[500; 7]).awake(FORCE), Duration::ZERO);
        assert_eq!(of(&[500; 8]).awake((11, 0)), Duration::ZERO);
    }

    #[test]
    fn long_waits_are_slept_through() {
        assert_eq!(of(&[9_000; 8]).awake(FORCE), Duration::ZERO);
        assert_eq!(of(&[5_000_000; 8]).awake(FORCE), Duration::ZERO);
    }
}
