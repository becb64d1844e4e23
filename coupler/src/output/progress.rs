//! The progress of a run on stderr.

use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

use protocol::Window;

/// One progress line with the time that is left: redrawn on a terminal, a line every tenth elsewhere.
pub struct Progress {
    name: String,
    shown: bool,
    terminal: bool,
    start: Instant,
    /// Steps that were done before, and those there are.
    before: u64,
    steps: u64,
    last: Instant,
    tenths: u64,
}

impl Progress {
    /// Progress of the run `name`; silent unless `shown`.
    pub fn new(name: &str, shown: bool) -> Progress {
        let now = Instant::now();
        Progress {
            name: name.to_string(),
            shown,
            terminal: std::io::stderr().is_terminal(),
            start: now,
            before: 0,
            steps: 0,
            last: now,
            tenths: 0,
        }
    }

    /// The windows start now, after `before` explicit steps of `steps`.
    pub fn expect(&mut self, before: u64, steps: u64) {
        self.before = before;
        self.steps = steps;
        self.start = Instant::now();
    }

    /// A window has passed.
    pub fn show(&mut self, window: &Window) {
        let done = window.step + u64::from(window.substeps);
        let tenth = 10 * done / self.steps.max(1);
        let due = if self.terminal {
            self.last.elapsed() > Duration::from_millis(200) || done == self.steps
        } else {
            tenth > self.tenths
        };
        if !self.shown || !due {
            return;
        }
        self.last = Instant::now();
        self.tenths = tenth;
        let spent = self.start.elapsed().as_secs_f64();
        let left = spent * (self.steps - done) as f64 / (done - self.before) as f64;
        let line = format!(
            "{}: {} % ({} windows), t = {:.3} ms, {spent:.0} s spent, {left:.0} s left",
            self.name,
            100 * done / self.steps.max(1),
            window.index + 1,
            1e3 * window.t1_s
        );
        let mut stderr = std::io::stderr().lock();
        let _ = if self.terminal {
            write!(stderr, "\r\x1b[K{line}")
        } else {
            writeln!(stderr, "{line}")
        };
    }

    /// Leaves the line standing.
    pub fn done(&self) {
        if self.shown && self.terminal {
            super::stderr::tell("");
        }
    }
}
