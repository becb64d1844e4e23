//! The progress of a run.

use super::pace::Remaining;
use crate::events::{Listener, RunEvent, RunProgress};

/// Time between two reports (ns).
const REPORT_NS: u64 = 200_000_000;

/// The span of a run between two simulated times, from an instant on.
#[derive(Clone, Debug, Default)]
pub struct ProgressSpan {
    /// Simulated time at which its windows begin (s).
    pub from_s: f64,
    /// Simulated time of its end (s).
    pub end_s: f64,
    /// Number of its windows from the start of the scenario, if none is halved.
    pub windows: u64,
    /// The instant (ns of the monotonic clock).
    pub at_ns: u64,
    /// Time for which the coordinator had waited for each participant until then (ns).
    pub waited_ns: Vec<u64>,
}

/// Progress of a run. It reads no clock: its instants are the coordinator's last readings.
#[derive(Default)]
pub struct Progress {
    listener: Listener,
    course: ProgressSpan,
    remaining: Remaining,
    reported_ns: u64,
}

impl Progress {
    /// Progress of a run with a listener.
    pub fn new(listener: Listener) -> Progress {
        Progress {
            listener,
            ..Progress::default()
        }
    }

    /// The windows start now.
    pub fn begin(&mut self, course: ProgressSpan) {
        self.reported_ns = course.at_ns;
        self.remaining = Remaining::from(course.from_s);
        self.course = course;
    }

    /// The span, if a report is due for a run that has reached `t_s` at the instant `now_ns`.
    pub fn due(&self, t_s: f64, now_ns: u64) -> Option<&ProgressSpan> {
        let over = t_s >= self.course.end_s * (1.0 - 1e-9);
        let due = now_ns.saturating_sub(self.reported_ns) >= REPORT_NS || over;
        Some(&self.course).filter(|_| self.listener.is_some() && due)
    }

    /// Reports the progress of a run, which was due.
    pub fn show(&mut self, mut run_progress: RunProgress, now_ns: u64) {
        self.reported_ns = now_ns;
        run_progress.spent_s = 1e-9 * now_ns.saturating_sub(self.course.at_ns) as f64;
        self.remaining.add(run_progress.t_s, run_progress.spent_s);
        run_progress.left_s = self.remaining.until(self.course.end_s);
        self.listener.report(&RunEvent::Progress(&run_progress));
    }
}
