//! Signals that end a run.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use scenario::error::{Error, Result};

/// Signals that reached the coordinator; 0 while there was none.
#[derive(Clone, Debug, Default)]
pub struct Watch {
    signal: Arc<AtomicUsize>,
    /// Time at which a wait first saw it.
    seen: Arc<OnceLock<Instant>>,
    /// Time that a window may still take then.
    grace: Duration,
}

/// Windows take milliseconds. A participant that needs longer than this is not waited for.
const WINDOW_GRACE: Duration = Duration::from_secs(2);

impl Watch {
    /// The flag that a signal handler writes the signal's number to.
    pub fn flag(&self) -> Arc<AtomicUsize> {
        Arc::clone(&self.signal)
    }

    /// From now on a wait goes on for a while after a signal, so that the window can end: whoever asks
    /// [`Watch::interrupted`] between windows ends the run with a checkpoint.
    pub fn let_windows_end(&mut self) {
        self.grace = WINDOW_GRACE;
    }

    /// The error of a run that got a signal.
    pub fn interrupted(&self) -> Option<Error> {
        let signal = self.signal.load(Ordering::Relaxed) as i32;
        (signal != 0).then_some(Error::Interrupted { signal })
    }

    /// Passes on the error of [`Watch::interrupted`] once the grace of a window has passed: for waits inside of one.
    pub fn check(&self) -> Result<()> {
        match self.interrupted() {
            Some(error) if self.seen.get_or_init(Instant::now).elapsed() >= self.grace => {
                Err(error)
            }
            _ => Ok(()),
        }
    }
}
