//! Spans of time in which a process was at work, on the clock that all processes of a host share.

use nix::time::{ClockId, clock_gettime};
use serde::{Deserialize, Serialize};

/// Length of a slot of time (ns): several windows of a usual run.
const SLOT_NS: u64 = 1 << 22;

/// Most spans that are kept, 2 MB: enough for 30 000 to 60 000 windows. A longer run keeps every second slot, then every fourth, and
/// so on.
const SPANS: usize = 1 << 17;

/// Spans of time (ns of the monotonic clock) in order. Totals hide how much work several processes did at the same time;
/// spans show it. Memory and message stay small because a span is kept only if it touches a slot of time whose number is a
/// multiple of `every`. Slots are counted on the common clock, so all processes keep the same ones.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BusyTimes {
    /// One slot of time in `every` is kept; a power of two.
    pub every: u64,
    /// Start and end of each span.
    pub spans_ns: Vec<[u64; 2]>,
}

impl Default for BusyTimes {
    fn default() -> BusyTimes {
        BusyTimes {
            every: 1,
            spans_ns: Vec::new(),
        }
    }
}

impl BusyTimes {
    /// Adds a span.
    pub fn add(&mut self, span: [u64; 2]) {
        if !touches(span, self.every) {
            return;
        }
        self.spans_ns.push(span);
        while self.spans_ns.len() > SPANS {
            self.every *= 2;
            let every = self.every;
            self.spans_ns.retain(|span| touches(*span, every));
        }
    }
}

/// The monotonic clock (ns), the same for all processes of a host.
pub fn monotonic_ns() -> u64 {
    let now = clock_gettime(ClockId::CLOCK_MONOTONIC).expect("Linux has a monotonic clock");
    now.tv_sec() as u64 * 1_000_000_000 + now.tv_nsec() as u64
}

/// Length (ns) of the kept slots before an instant.
pub fn kept_before_ns(at_ns: u64, every: u64) -> u64 {
    let period = SLOT_NS.saturating_mul(every.max(1));
    at_ns / period * SLOT_NS + (at_ns % period).min(SLOT_NS)
}

/// True for a span that has time in a kept slot.
fn touches([start, end]: [u64; 2], every: u64) -> bool {
    kept_before_ns(end, every) > kept_before_ns(start, every)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slots_whose_number_is_a_multiple_are_kept() {
        assert_eq!(kept_before_ns(10 * SLOT_NS + 7, 1), 10 * SLOT_NS + 7);
        // Slots 0, 4 and 8 lie before slot 10.
        assert_eq!(kept_before_ns(10 * SLOT_NS + 7, 4), 3 * SLOT_NS);
        assert_eq!(kept_before_ns(8 * SLOT_NS + 7, 4), 2 * SLOT_NS + 7);
    }

    #[test]
    fn long_runs_keep_few_spans_and_the_share_of_their_time() {
        let mut busy = BusyTimes::default();
        let (spans, step) = (40 * SPANS as u64, SLOT_NS / 8);
        for at in 0..spans {
            // A quarter of the time.
            busy.add([at * step, at * step + step / 4]);
        }
        assert!(busy.spans_ns.len() <= SPANS);
        assert!(busy.every.is_power_of_two() && busy.every > 16);
        let kept = |at| kept_before_ns(at, busy.every);
        let worked: u64 = busy.spans_ns.iter().map(|s| kept(s[1]) - kept(s[0])).sum();
        assert_eq!(4 * worked, kept(spans * step));
    }

    #[test]
    fn a_span_across_many_slots_is_kept() {
        let mut busy = BusyTimes {
            every: 1 << 10,
            ..BusyTimes::default()
        };
        busy.add([SLOT_NS, 2 * SLOT_NS]);
        assert!(busy.spans_ns.is_empty(), "no kept slot");
        busy.add([SLOT_NS, SLOT_NS << 11]);
        assert_eq!(busy.spans_ns.len(), 1);
    }
}
