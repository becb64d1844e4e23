//! The time of a run's windows, by the process at work.

use protocol::busy::{BusyTimes, kept_before_ns};
use serde::Serialize;

/// Wall-clock times (s) that add up to the time of the windows. Each moment counts once, for any number of processes at
/// work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct TimeAccount {
    /// At least one participant was at work.
    pub solve_wall_s: f64,
    /// Only the coordinator was at work.
    pub own_wall_s: f64,
    /// No process was at work: frames were under way, processes woke up.
    pub wait_s: f64,
}

impl TimeAccount {
    /// Splits the time between two instants (ns). `reported` are the times in which each participant was at work by its
    /// own report, `awaited` the times in which the coordinator only waited for it. The latter replace the former for a
    /// participant that reports no times in this stretch.
    pub fn of(stretch_ns: [u64; 2], reported: &[BusyTimes], awaited: &[BusyTimes]) -> TimeAccount {
        let pairs = reported.iter().zip(awaited);
        let busy = pairs.map(|(own, awaited)| match covers(own, stretch_ns) {
            true => own,
            false => awaited,
        });
        let busy: Vec<&BusyTimes> = busy.collect();
        let all = busy.iter().copied().chain(awaited);
        let every = all.clone().map(|times| times.every).max().unwrap_or(1);
        let solving = union_ns(busy.iter().copied(), stretch_ns, every);
        let occupied = union_ns(all, stretch_ns, every);
        let [start, end] = stretch_ns;
        let kept = kept_before_ns(end, every) - kept_before_ns(start, every);
        let seconds = |ns: u64| 1e-9 * (end - start) as f64 * ns as f64 / kept.max(1) as f64;
        TimeAccount {
            solve_wall_s: seconds(solving),
            own_wall_s: seconds(kept - occupied),
            wait_s: seconds(occupied - solving),
        }
    }
}

/// True for times with a span in the stretch. A program with another clock has none there, and a number of slots that
/// is not a power of two is not ours.
fn covers(times: &BusyTimes, [start, end]: [u64; 2]) -> bool {
    let inside = |span: &[u64; 2]| span[0] < end && span[1] > start;
    times.every.is_power_of_two() && times.every < 1 << 30 && times.spans_ns.iter().any(inside)
}

/// Length of the union of all spans within the stretch and the kept slots (ns).
fn union_ns<'a>(
    times: impl Iterator<Item = &'a BusyTimes>,
    [start, end]: [u64; 2],
    every: u64,
) -> u64 {
    let spans = times.flat_map(|times| &times.spans_ns);
    let clipped = spans.map(|span| span.map(|at| at.clamp(start, end)));
    let mut spans: Vec<[u64; 2]> = clipped.filter(|[from, to]| from < to).collect();
    spans.sort_unstable();
    let (mut reached, mut length) = (start, 0);
    for [from, to] in spans {
        let from = from.max(reached);
        if from < to {
            length += kept_before_ns(to, every) - kept_before_ns(from, every);
            reached = to;
        }
    }
    length
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    fn times(spans: &[[u64; 2]]) -> BusyTimes {
        let mut times = BusyTimes::default();
        for span in spans {
            times.add(span.map(|at| at * MS));
        }
        times
    }

    /// Times (ms) in a stretch of 100 ms that begins at 1 000 ms.
    fn account(reported: [&[[u64; 2]]; 2], awaited: [&[[u64; 2]]; 2]) -> [f64; 3] {
        let [reported, awaited] = [reported, awaited].map(|all| all.map(times));
        let account = TimeAccount::of([1000 * MS, 1100 * MS], &reported, &awaited);
        [account.solve_wall_s, account.own_wall_s, account.wait_s]
            .map(|s| (1e3 * s * 1e6).round() / 1e6)
    }

    #[test]
    fn work_at_the_same_time_counts_once() {
        // The second participant works at the same time as the first, and while the coordinator handles the first
        // answer.
        let reported: [&[[u64; 2]]; 2] = [&[[1002, 1040]], &[[1010, 1060]]];
        let awaited: [&[[u64; 2]]; 2] = [&[[1001, 1041]], &[[1050, 1061]]];
        // No process works in [1001, 1002] and [1060, 1061]; the coordinator alone works in [1000, 1001] and from 1061
        // on.
        assert_eq!(account(reported, awaited), [58.0, 40.0, 2.0]);
    }

    #[test]
    fn work_before_and_after_the_windows_does_not_count() {
        let reported: [&[[u64; 2]]; 2] = [&[[900, 1010], [1090, 1200]], &[[200, 300]]];
        let awaited: [&[[u64; 2]]; 2] = [&[[900, 1010], [1090, 1200]], &[]];
        assert_eq!(account(reported, awaited), [20.0, 80.0, 0.0]);
    }

    #[test]
    fn waits_replace_the_times_of_a_participant_without_useful_ones() {
        let awaited: [&[[u64; 2]]; 2] = [&[[1000, 1030]], &[[1030, 1090]]];
        for silent in [&[][..], &[[1, 50]]] {
            let account = account([&[[1000, 1025]], silent], awaited);
            assert_eq!(account, [85.0, 10.0, 5.0]);
        }
    }

    #[test]
    fn a_sample_of_slots_is_scaled_to_the_whole() {
        let [mut reported, mut awaited] = [BusyTimes::default(), BusyTimes::default()];
        // Each 100 us: 60 at work, 10 under way, 30 of the coordinator.
        for at in (0..1_000_000 * 100_000).step_by(100_000) {
            reported.add([at + 5_000, at + 65_000]);
            awaited.add([at, at + 70_000]);
        }
        assert!(reported.every > 1);
        let account = TimeAccount::of([0, 100_000 * MS], &[reported], &[awaited]);
        let parts = [account.solve_wall_s, account.own_wall_s, account.wait_s];
        for (part, exact) in parts.into_iter().zip([60.0, 30.0, 10.0]) {
            assert!((part - exact).abs() < 0.02 * exact, "{parts:?}");
        }
    }
}
