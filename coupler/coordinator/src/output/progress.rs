//! How far a run has come, and how it goes.

use super::pace::Remaining;
use crate::events::{Listener, RunEvent};

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

/// How far a run has come, and how it goes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RunProgress {
    /// Name of the run.
    pub run: String,
    /// Part of the load history, and the share of it that has passed.
    pub phase: Option<(String, f64)>,
    /// Simulated time at which the windows began (s).
    pub from_s: f64,
    /// Simulated time (s).
    pub t_s: f64,
    /// Simulated time of the end (s).
    pub end_s: f64,
    /// Windows done.
    pub window: u64,
    /// All windows, if none is halved.
    pub windows: u64,
    /// Repeats of the last window, and their mean; none for a run without interfaces.
    pub repeats: Option<(u32, f64)>,
    /// Share of the sliding nodes among those in contact with the wheel (%).
    pub sn_pct: Option<f64>,
    /// Tangential over normal force on the wheel.
    pub friction_coefficient: Option<f64>,
    /// Energy without account over the work, of all participants together.
    pub energy_defect_rel: Option<f64>,
    /// Shares of the time in which the coordinator waited for each participant.
    pub waited: Vec<(String, f64)>,
    /// Wall-clock time since the first window (s).
    pub spent_s: f64,
    /// Wall-clock time that is left (s), once it can be told.
    pub left_s: Option<f64>,
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
