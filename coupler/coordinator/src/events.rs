//! What happens in a run, for whoever listens. A run prints nothing itself.

use std::fmt;
use std::sync::Arc;

use runs::warning::Warning;

use crate::output::RunProgress;

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

/// Somebody who hears of what happens in a run, or nobody.
#[derive(Clone, Default)]
pub struct Listener(Option<Arc<dyn Fn(&RunEvent) + Send + Sync>>);

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

impl fmt::Debug for Listener {
    fn fmt(&self, to: &mut fmt::Formatter) -> fmt::Result {
        write!(to, "Listener({})", self.is_some())
    }
}
