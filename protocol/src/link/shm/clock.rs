//! How long a call may take, and how it waits meanwhile.

use std::thread;
use std::time::{Duration, Instant};

use crate::link::LinkError;

/// The time that a call may take.
pub(super) struct Clock {
    start: Instant,
    patience: Duration,
}

impl Clock {
    pub(super) fn new(patience: Duration) -> Clock {
        Clock {
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

    /// Gives way to others: first for an instant, later for a nap, never beyond the end of the patience.
    pub(super) fn pause(&self, polling_time: Duration) -> Result<(), LinkError> {
        let left = self.left();
        if left.is_zero() {
            return Err(LinkError::Full {
                seconds: self.patience.as_secs_f64(),
            });
        }
        if self.elapsed() < polling_time {
            thread::yield_now();
        } else {
            thread::sleep(left.min(Duration::from_micros(100)));
        }
        Ok(())
    }
}
