//! The time of the windows of a run by who was at work.

use protocol::busy::{BusyTimes, kept_before_ns};
use serde::Serialize;

/// Wall-clock times (s) that add up to that of the windows. Each moment counts once, however many are at work in it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct TimeAccount {
    /// At least one participant was at work.
    pub solve_wall_s: f64,
    /// Only the coordinator was.
    pub own_wall_s: f64,
    /// Nobody was: frames were under way, processes woke up.
    pub wait_s: f64,
}

impl TimeAccount {
    /// Accounts for the time between two instants (ns), from the times in which each participant says it was at work and those in which
    /// the coordinator did nothing but wait for it. For a participant that tells no times of this stretch the latter stand.
    pub fn of(stretch_ns: [u64; 2], told: &[BusyTimes], awaited: &[BusyTimes]) -> TimeAccount {
        let busy = told
            .iter()
            .zip(awaited)
            .map(|(told, seen)| match speaks_of(told, stretch_ns) {
                true => told,
                false => seen,
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

/// True for times with a span in the stretch. A program with another clock tells none, and a number of slots that is no power of two is
/// not ours.
fn speaks_of(times: &BusyTimes, [start, end]: [u64; 2]) -> bool {
    let inside = |span: &[u64; 2]| span[0] < end && span[1] > start;
    times.every.is_power_of_two() && times.every < 1 << 30 && times.spans_ns.iter().any(inside)
}

/// Length of the union of all spans within the stretch and within the kept slots (ns).
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

    /// Milliseconds of a stretch of 100 that begins at 1 000.
    fn account(told: [&[[u64; 2]]; 2], awaited: [&[[u64; 2]]; 2]) -> [f64; 3] {
        let [told, awaited] = [told, awaited].map(|all| all.map(times));
        let account = TimeAccount::of([1000 * MS, 1100 * MS], &told, &awaited);
        [account.solve_wall_s, account.own_wall_s, account.wait_s]
            .map(|s| (1e3 * s * 1e6).round() / 1e6)
    }

    #[test]
    fn work_at_the_same_time_counts_once() {
        // The second works on while the first does, and while the coordinator is busy with the first answer.
        let told: [&[[u64; 2]]; 2] = [&[[1002, 1040]], &[[1010, 1060]]];
        let awaited: [&[[u64; 2]]; 2] = [&[[1001, 1041]], &[[1050, 1061]]];
        // Nobody works in [1001, 1002] and [1060, 1061]; the coordinator alone in [1000, 1001] and from 1061 on.
        assert_eq!(account(told, awaited), [58.0, 40.0, 2.0]);
    }

    #[test]
    fn work_before_and_after_the_windows_counts_nothing() {
        let told: [&[[u64; 2]]; 2] = [&[[900, 1010], [1090, 1200]], &[[200, 300]]];
        let awaited: [&[[u64; 2]]; 2] = [&[[900, 1010], [1090, 1200]], &[]];
        assert_eq!(account(told, awaited), [20.0, 80.0, 0.0]);
    }

    #[test]
    fn waits_stand_for_a_participant_that_tells_nothing_of_use() {
        let awaited: [&[[u64; 2]]; 2] = [&[[1000, 1030]], &[[1030, 1090]]];
        for silent in [&[][..], &[[1, 50]]] {
            let account = account([&[[1000, 1025]], silent], awaited);
            assert_eq!(account, [85.0, 10.0, 5.0]);
        }
    }

    #[test]
    fn a_sample_of_slots_is_scaled_to_the_whole() {
        let [mut told, mut awaited] = [BusyTimes::default(), BusyTimes::default()];
        // Of each 100 us: 60 at work, 10 under way, 30 the coordinator's own.
        for at in (0..1_000_000 * 100_000).step_by(100_000) {
            told.add([at + 5_000, at + 65_000]);
            awaited.add([at, at + 70_000]);
        }
        assert!(told.every > 1);
        let account = TimeAccount::of([0, 100_000 * MS], &[told], &[awaited]);
        let parts = [account.solve_wall_s, account.own_wall_s, account.wait_s];
        for (part, exact) in parts.into_iter().zip([60.0, 30.0, 10.0]) {
            assert!((part - exact).abs() < 0.02 * exact, "{parts:?}");
        }
    }
}
