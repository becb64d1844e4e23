//! Events of a run, for a listener. A run prints nothing itself.

use std::sync::Arc;

use runs::warning::Warning;

/// An event in a run.
pub enum RunEvent<'a> {
    /// The participants begin their set-up, which may take long.
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
    /// A warning; each comes once.
    Warning(&'a Warning),
    /// The progress of the run, at most five times a second.
    Progress(&'a RunProgress),
    /// The run has ended.
    Ended,
}

/// The progress of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RunProgress {
    /// Name of the run.
    pub run: String,
    /// Phase of the load history, and the fraction of it that has passed.
    pub phase: Option<(String, f64)>,
    /// Simulated time at which the windows began (s).
    pub from_s: f64,
    /// Simulated time (s).
    pub t_s: f64,
    /// Simulated time of the end (s).
    pub end_s: f64,
    /// Completed windows.
    pub window: u64,
    /// Number of all windows, if none is halved.
    pub windows: u64,
    /// Repeats of the last window, and their mean; `None` for a run without interfaces.
    pub repeats: Option<(u32, f64)>,
    /// Share of the sliding nodes among those in contact with the wheel (%).
    pub sn_pct: Option<f64>,
    /// Tangential over normal force on the wheel.
    pub traction_ratio: Option<f64>,
    /// Relative energy error of all participants together.
    pub energy_defect_rel: Option<f64>,
    /// Fraction of the time in which the coordinator waited for each participant.
    pub waited: Vec<(String, f64)>,
    /// Wall-clock time since the first window (s).
    pub spent_s: f64,
    /// Remaining wall-clock time (s), once it can be estimated.
    pub left_s: Option<f64>,
}

/// A function that receives the events of a run, or none.
#[derive(Clone, Default)]
pub struct Listener(Option<Arc<Handler>>);

type Handler = dyn Fn(&RunEvent) + Send + Sync;

impl Listener {
    /// A listener that passes each event to this function.
    pub fn new(handler: impl Fn(&RunEvent) + Send + Sync + 'static) -> Listener {
        Listener(Some(Arc::new(handler)))
    }

    /// True if there is a function.
    pub fn is_some(&self) -> bool {
        self.0.is_some()
    }

    /// Passes an event to the function.
    pub fn report(&self, event: &RunEvent) {
        if let Some(handler) = &self.0 {
            handler(event);
        }
    }
}
