//! Signals that end a run.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use scenario::error::{Error, Result};

/// The signal that reached the coordinator; 0 without a signal.
#[derive(Clone, Debug, Default)]
pub struct Watch {
    signal: Arc<AtomicUsize>,
    /// Time at which a wait first noticed it.
    seen: Arc<OnceLock<Instant>>,
    /// Time that is left to the window after it.
    grace: Duration,
}

/// Windows take milliseconds. The coordinator does not wait longer than this for a participant.
const WINDOW_GRACE: Duration = Duration::from_secs(2);

impl Watch {
    /// The flag to which a signal handler writes the signal's number.
    pub fn flag(&self) -> Arc<AtomicUsize> {
        Arc::clone(&self.signal)
    }

    /// From now on a wait continues for a while after a signal, so that the window can end. A caller of
    /// [`Watch::interrupted`] between windows then ends the run with a checkpoint.
    pub fn let_windows_end(&mut self) {
        self.grace = WINDOW_GRACE;
    }

    /// The error of a run that received a signal.
    pub fn interrupted(&self) -> Option<Error> {
        let signal = self.signal.load(Ordering::Relaxed) as i32;
        (signal != 0).then_some(Error::Interrupted { signal })
    }

    /// Returns the error of [`Watch::interrupted`] once the time left to a window has passed: for waits inside a
    /// window.
    pub fn check(&self) -> Result<()> {
        match self.interrupted() {
            Some(error) if self.seen.get_or_init(Instant::now).elapsed() >= self.grace => {
                Err(error)
            }
            _ => Ok(()),
        }
    }
}
