//! What happens in a run, for whoever listens. A run prints nothing itself.

use std::sync::Arc;

use runs::warning::Warning;

/// Something that happens in a run.
pub enum RunEvent<'a> {
    /// The participants prepare themselves, which may take long.
    Prepare {
        /// Name of the run.
        run: &'a str,
        /// Their names.
        participants: &'a [&'a str],
    },
    /// The coordinator still waits for the set-up of a participant.
    Prepares {
        /// Its name.
        participant: &'a str,
        /// Time waited (s) before and after this slice of the wait.
        waited_s: [f64; 2],
        /// Its deadline (s).
        limit_s: f64,
    },
    /// A warning, once.
    Warning(&'a Warning),
    /// How far the run has come, five times a second at most.
    Progress(&'a RunProgress),
    /// Nothing more happens.
    Ended,
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
    pub traction_ratio: Option<f64>,
    /// Energy without account over the work, of all participants together.
    pub energy_defect_rel: Option<f64>,
    /// Shares of the time in which the coordinator waited for each participant.
    pub waited: Vec<(String, f64)>,
    /// Wall-clock time since the first window (s).
    pub spent_s: f64,
    /// Wall-clock time that is left (s), once it can be told.
    pub left_s: Option<f64>,
}

/// Somebody who hears of what happens in a run, or nobody.
#[derive(Clone, Default)]
pub struct Listener(Option<Arc<Hears>>);

type Hears = dyn Fn(&RunEvent) + Send + Sync;

impl Listener {
    /// This function hears of each event.
    pub fn new(hears: impl Fn(&RunEvent) + Send + Sync + 'static) -> Listener {
        Listener(Some(Arc::new(hears)))
    }

    /// True where somebody listens.
    pub fn is_some(&self) -> bool {
        self.0.is_some()
    }

    /// Passes an event on.
    pub fn tell(&self, event: &RunEvent) {
        if let Some(hears) = &self.0 {
            hears(event);
        }
    }
}
