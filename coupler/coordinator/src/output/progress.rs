//! How far a run has come, and how it goes.

use super::pace::Remaining;
use crate::events::{Listener, RunEvent, RunProgress};

/// Time between two looks (ns).
const LOOK_NS: u64 = 200_000_000;

/// A run that is on its way between two simulated times, from an instant on.
#[derive(Clone, Debug, Default)]
pub struct ProgressSpan {
    /// Simulated time at which its windows begin (s).
    pub from_s: f64,
    /// Simulated time of its end (s).
    pub end_s: f64,
    /// Its windows from the start of the scenario, if none is halved.
    pub windows: u64,
    /// The instant (ns of the monotonic clock).
    pub at_ns: u64,
    /// Time for which each participant had been waited for until then (ns).
    pub waited_ns: Vec<u64>,
}

/// Progress of a run. It reads no clock: instants are those at which the coordinator last looked at its own.
#[derive(Default)]
pub struct Progress {
    listener: Listener,
    course: ProgressSpan,
    remaining: Remaining,
    looked_ns: u64,
}

impl Progress {
    /// Progress of a run that somebody listens to.
    pub fn new(listener: Listener) -> Progress {
        Progress {
            listener,
            ..Progress::default()
        }
    }

    /// The windows start now.
    pub fn begin(&mut self, course: ProgressSpan) {
        self.looked_ns = course.at_ns;
        self.remaining = Remaining::from(course.from_s);
        self.course = course;
    }

    /// The course, if it is time to look at a run that has come to `t_s` at the instant `now_ns`.
    pub fn due(&self, t_s: f64, now_ns: u64) -> Option<&ProgressSpan> {
        let over = t_s >= self.course.end_s * (1.0 - 1e-9);
        let due = now_ns.saturating_sub(self.looked_ns) >= LOOK_NS || over;
        Some(&self.course).filter(|_| self.listener.is_some() && due)
    }

    /// Tells how far a run has come; it was due.
    pub fn show(&mut self, mut run_progress: RunProgress, now_ns: u64) {
        self.looked_ns = now_ns;
        run_progress.spent_s = 1e-9 * now_ns.saturating_sub(self.course.at_ns) as f64;
        self.remaining.add(run_progress.t_s, run_progress.spent_s);
        run_progress.left_s = self.remaining.until(self.course.end_s);
        self.listener.tell(&RunEvent::Progress(&run_progress));
    }
}
