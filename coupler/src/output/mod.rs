//! What is written while a run goes on: signals, the interface traction, progress.

use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

use protocol::{Phase, Window};

use crate::couple::ledger::total;
use crate::couple::scheme::Coupling;

pub mod profile;
pub mod signals;

pub use signals::SignalsFile;

/// Means over the last half of the phase named `hold`, when the transients of the loading have passed.
pub struct HoldMeans {
    /// Start and end of the second half (s).
    span: Option<(f64, f64)>,
    windows: u64,
    force_sum_n: f64,
    profile: Option<profile::Traction>,
}

impl HoldMeans {
    /// Means for a load history; without a hold there are none.
    pub fn new(phases: &[Phase]) -> HoldMeans {
        let hold = phases.iter().find(|phase| phase.name == "hold");
        HoldMeans {
            span: hold.map(|hold| (0.5 * (hold.t0_s + hold.t1_s), hold.t1_s)),
            windows: 0,
            force_sum_n: 0.0,
            profile: None,
        }
    }

    /// Adds a window that stands.
    pub fn add(&mut self, window: &Window, coupling: &Coupling) {
        let Some((start, end)) = self.span else {
            return;
        };
        if window.t0_s >= start && window.t1_s <= end * (1.0 + 1e-9) {
            self.windows += 1;
            self.force_sum_n -= total(&coupling.lambda)[1];
        }
    }

    /// Keeps the interface traction at the end of the hold.
    pub fn keep_profile(&mut self, coupling: &Coupling, thickness_m: f64) {
        self.profile = Some(profile::Traction::of(coupling, thickness_m));
    }

    /// Results by their names in summary.json.
    pub fn results(&self) -> Vec<(String, f64)> {
        let mut results = Vec::new();
        if self.windows > 0 {
            let mean = self.force_sum_n / self.windows as f64;
            results.push(("interface_force_n".to_string(), mean));
        }
        if let Some(traction) = &self.profile {
            results.push(("p0_1mm_pa".to_string(), traction.peak_of_means(1e-3)));
            results.push(("half_width_98_m".to_string(), traction.half_width(0.98)));
        }
        results
    }
}

/// One progress line with the time that is left: redrawn on a terminal, a line every tenth elsewhere.
pub struct Progress {
    name: String,
    shown: bool,
    terminal: bool,
    start: Instant,
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
            steps: 0,
            last: now,
            tenths: 0,
        }
    }

    /// The windows start now, and hold so many explicit steps together.
    pub fn expect(&mut self, steps: u64) {
        self.steps = steps;
        self.start = Instant::now();
    }

    /// A window has passed.
    pub fn show(&mut self, window: &Window) {
        let done = window.step + u64::from(window.substeps);
        let tenth = 10 * done / self.steps.max(1);
        let due = match self.terminal {
            true => self.last.elapsed() > Duration::from_millis(200) || done == self.steps,
            false => tenth > self.tenths,
        };
        if !self.shown || !due {
            return;
        }
        self.last = Instant::now();
        self.tenths = tenth;
        let spent = self.start.elapsed().as_secs_f64();
        let left = spent * (self.steps - done) as f64 / done as f64;
        let line = format!(
            "{}: {} % ({} windows), t = {:.3} ms, {spent:.0} s spent, {left:.0} s left",
            self.name,
            100 * done / self.steps.max(1),
            window.index + 1,
            1e3 * window.t1_s
        );
        let mut stderr = std::io::stderr().lock();
        let _ = match self.terminal {
            true => write!(stderr, "\r\x1b[K{line}"),
            false => writeln!(stderr, "{line}"),
        };
    }

    /// Leaves the line standing.
    pub fn done(&self) {
        if self.shown && self.terminal {
            eprintln!();
        }
    }
}
