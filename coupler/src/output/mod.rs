//! What is written while a run goes on: signals, the interface traction, progress.

use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

use protocol::{Phase, Window};
use serde::{Deserialize, Serialize};

use crate::scenario::Interface;
use crate::scheme::coupling::Coupling;
use crate::scheme::window::{AcceptedWindow, InterfaceSignals};

pub mod collection;
pub mod profile;
pub mod signals;

pub use signals::SignalsFile;

/// What the outputs remember from window to window.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct OutputState {
    /// Latest energies of each participant (J).
    pub energies: Vec<Vec<f64>>,
    /// The latest report of each participant.
    pub reports: Vec<Vec<f64>>,
    /// The latest signals of each interface.
    pub interfaces: Vec<InterfaceSignals>,
    /// What was gathered over the hold.
    pub hold: HoldMeans,
    /// Phases whose end was seen.
    pub snapshots_taken: usize,
    /// Size of signals.csv.
    pub signals_bytes: u64,
}

/// Means over the last half of the phase named `hold`, when the transients of the loading have passed.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct HoldMeans {
    /// Start and end of the second half (s).
    span: Option<(f64, f64)>,
    interfaces: Vec<HoldMean>,
}

/// The same of one interface.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct HoldMean {
    /// Prefix of its results: none for the only interface.
    prefix: String,
    windows: u64,
    force_sum_n: f64,
    profile: Option<profile::Traction>,
}

impl HoldMeans {
    /// Means for a load history; without a hold there are none.
    pub fn new(phases: &[Phase], interfaces: &[Interface]) -> HoldMeans {
        let hold = phases.iter().find(|phase| phase.name == "hold");
        let mean = |interface: &Interface| HoldMean {
            prefix: match interfaces.len() {
                1 => String::new(),
                _ => format!("{}.", interface.name),
            },
            windows: 0,
            force_sum_n: 0.0,
            profile: None,
        };
        HoldMeans {
            span: hold.map(|hold| (0.5 * (hold.t0_s + hold.t1_s), hold.t1_s)),
            interfaces: interfaces.iter().map(mean).collect(),
        }
    }

    /// Adds an accepted window.
    pub fn add(&mut self, window: &Window, accepted: &AcceptedWindow) {
        let Some((start, end)) = self.span else {
            return;
        };
        if window.t0_s >= start && window.t1_s <= end * (1.0 + 1e-9) {
            for (interface, seen) in &accepted.signals {
                let mean = &mut self.interfaces[*interface];
                mean.windows += 1;
                mean.force_sum_n += seen.pressing_n;
            }
        }
    }

    /// Keeps the traction of each interface at the end of the hold.
    pub fn keep_profiles<'a>(
        &mut self,
        couplings: impl Iterator<Item = &'a Coupling>,
        thickness_m: f64,
    ) {
        for coupling in couplings {
            for patch in &coupling.group().patches {
                let traction = profile::Traction::of(coupling, patch, thickness_m);
                self.interfaces[patch.index].profile = Some(traction);
            }
        }
    }

    /// Results by their names in summary.json.
    pub fn results(&self) -> Vec<(String, f64)> {
        let mut results = Vec::new();
        for interface in &self.interfaces {
            let mut add = |name: &str, value| {
                results.push((format!("{}{name}", interface.prefix), value));
            };
            if interface.windows > 0 {
                let mean = interface.force_sum_n / interface.windows as f64;
                add("interface_force_n", mean);
            }
            if let Some(traction) = &interface.profile {
                add("p0_1mm_pa", traction.peak_of_means(1e-3));
                add("half_width_98_m", traction.half_width(0.98));
            }
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
        let left = spent * (self.steps - done) as f64 / (done - self.before) as f64;
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
