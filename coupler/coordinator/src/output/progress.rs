//! The progress of a run on stderr: a block that is redrawn on a terminal, now and then a line elsewhere, objects for a program.

use serde_json::{Value, json};

use super::pace::Remaining;
use super::run_progress::RunProgress;
use super::stderr::{StderrMode, columns, draw, stderr_mode, tell_of};

/// A line is printed after each tenth of a run, and after this time (s) at the latest.
const PARTS: f64 = 10.0;
pub(super) const LINE_EVERY_S: f64 = 60.0;

/// Time between two updates of a block (ns).
const UPDATE_NS: u64 = 200_000_000;

/// Time between two objects (s).
pub(super) const OBJECT_EVERY_S: f64 = 1.0;

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
    shown: bool,
    course: ProgressSpan,
    remaining: Remaining,
    looked_ns: u64,
    told_ns: u64,
    told_parts: u64,
}

impl Progress {
    /// Progress of a run; silent unless `shown`.
    pub fn new(shown: bool) -> Progress {
        Progress {
            shown: shown && stderr_mode() != StderrMode::Quiet,
            ..Progress::default()
        }
    }

    /// The windows start now.
    pub fn begin(&mut self, course: ProgressSpan) {
        self.looked_ns = course.at_ns;
        self.told_ns = course.at_ns;
        self.told_parts = (PARTS * course.from_s / course.end_s) as u64;
        self.remaining = Remaining::from(course.from_s);
        self.course = course;
    }

    /// The course, if it is time to look at a run that has come to `t_s` at the instant `now_ns`.
    pub fn due(&self, t_s: f64, now_ns: u64) -> Option<&ProgressSpan> {
        let due = now_ns.saturating_sub(self.looked_ns) >= UPDATE_NS || self.is_over(t_s);
        Some(&self.course).filter(|_| self.shown && due)
    }

    fn is_over(&self, t_s: f64) -> bool {
        t_s >= self.course.end_s * (1.0 - 1e-9)
    }

    /// Shows how far a run has come; it was due.
    pub fn show(&mut self, mut run_progress: RunProgress, now_ns: u64) {
        let seconds = |since_ns: u64| 1e-9 * now_ns.saturating_sub(since_ns) as f64;
        self.looked_ns = now_ns;
        run_progress.spent_s = seconds(self.course.at_ns);
        self.remaining.add(run_progress.t_s, run_progress.spent_s);
        run_progress.left_s = self.remaining.until(self.course.end_s);
        let over = self.is_over(run_progress.t_s);
        let parts = (PARTS * run_progress.t_s / run_progress.end_s + 1e-9) as u64;
        let since_s = seconds(self.told_ns);
        match (stderr_mode(), columns()) {
            (StderrMode::JsonLines, _) if since_s < OBJECT_EVERY_S && !over => return,
            (StderrMode::JsonLines, _) => tell_of("progress", run_progress.object(), String::new),
            (_, Some(columns)) => draw(&run_progress.block(), columns),
            _ if parts == self.told_parts && since_s < LINE_EVERY_S => return,
            _ => tell_of("progress", Value::Null, || run_progress.line()),
        }
        self.told_ns = now_ns;
        self.told_parts = parts;
    }
}

/// Tells that the participants of a run prepare themselves, which may take long.
pub fn prepare(run: &str, participants: &[&str]) {
    let object = json!({ "run": run, "participants": participants });
    let line = format!("{run}: {} prepare", participants.join(", "));
    match (stderr_mode(), columns()) {
        (StderrMode::JsonLines, _) => tell_of("prepare", object, String::new),
        (StderrMode::Progress, Some(columns)) => draw(&[line], columns),
        _ => {}
    }
}

/// Time after which a line says that a set-up goes on, and again after twice as long (s).
const SETUP_LINE_S: f64 = 10.0;

/// Tells that a participant is waited for in its set-up, between the times (s) `before` and `now` of that wait, which `limit_s` ends.
pub fn prepares(participant: &str, [before, now]: [f64; 2], limit_s: f64) {
    let object = json!({ "participant": participant, "waited_s": now, "limit_s": limit_s });
    let line = format!(
        "{participant} prepares: {now:.0} s so far; run.deadlines.setup_s allows {limit_s} s"
    );
    let next_second = now.floor() > before.floor();
    match (stderr_mode(), columns()) {
        (StderrMode::Quiet, _) => {}
        (StderrMode::JsonLines, _) if next_second => tell_of("prepares", object, String::new),
        (StderrMode::Progress, Some(columns)) if next_second => draw(&[line], columns),
        (StderrMode::Progress, None) if doubles([before, now]) => {
            tell_of("prepares", object, || line)
        }
        _ => {}
    }
}

/// True where a wait passes 10, 20, 40, .. s.
fn doubles(times: [f64; 2]) -> bool {
    let [before, now] = times.map(|s| (s / SETUP_LINE_S).log2().floor());
    now >= 0.0 && now > before
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_set_up_is_told_after_ten_seconds_and_each_time_that_it_has_doubled() {
        let told = (0..2000).filter(|k| doubles([0.05 * f64::from(*k), 0.05 * f64::from(k + 1)]));
        let told: Vec<f64> = told.map(|k| (0.05 * f64::from(k + 1)).round()).collect();
        assert_eq!(told, [10.0, 20.0, 40.0, 80.0]);
    }
}
