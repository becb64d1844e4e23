//! The time that a call may take, and pauses until then.

use std::thread;
use std::time::{Duration, Instant};

use crate::link::LinkError;

/// Time after which a pause is a sleep.
const POLLING: Duration = Duration::from_micros(20);

/// The time that a call may take.
pub(super) struct Deadline {
    start: Instant,
    patience: Duration,
}

impl Deadline {
    pub(super) fn new(patience: Duration) -> Deadline {
        Deadline {
            start: Instant::now(),
            patience,
        }
    }

    pub(super) fn elapsed(&self) -> Duration {
        self.start.elapsed()
    }

    pub(super) fn left(&self) -> Duration {
        self.patience.saturating_sub(self.elapsed())
    }

    /// Yields to other threads at first and sleeps after that, never beyond the deadline.
    pub(super) fn pause(&self) -> Result<(), LinkError> {
        let left = self.left();
        if left.is_zero() {
            return Err(LinkError::Full {
                seconds: self.patience.as_secs_f64(),
            });
        }
        if self.elapsed() < POLLING {
            thread::yield_now();
        } else {
            thread::sleep(left.min(Duration::from_micros(100)));
        }
        Ok(())
    }
}
