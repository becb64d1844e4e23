//! The way in which an end of a link waits. On a core that no unrelated program wants, it stays awake and yields for the expected
//! length of the wait; otherwise it sleeps. Another participant may use the core meanwhile: a sleeping end must then be woken
//! when its frame arrives, while an awake end continues as soon as the core is free.

use std::time::{Duration, Instant};

use super::core::{Core, Yield};
use super::wait_estimate::WaitEstimate;
use crate::frame::Header;

/// Time that an end polls before it sleeps: most answers of a solver come earlier. It is less than 5 % of a wait of 20 ms.
const POLLING: Duration = Duration::from_micros(900);

/// The same for an end that shares its core. The sleep then costs as much again, so polling at most doubles the cost.
const POLLING_ON_SHARED_CORE: Duration = Duration::from_micros(20);

/// One end's way of waiting.
#[derive(Debug)]
pub(super) struct Waiting {
    polling: Duration,
    /// Only for an end that shares its core.
    estimate: Option<WaitEstimate>,
    core: Core,
    /// End of the awake part of the current wait.
    awake_until: Instant,
    /// A yield of the current wait returned late.
    late: bool,
}

impl Waiting {
    /// For an end that has a core to itself, or for one that shares it.
    pub(super) fn new(alone: bool) -> Waiting {
        Waiting {
            polling: if alone {
                POLLING
            } else {
                POLLING_ON_SHARED_CORE
            },
            estimate: (!alone).then(WaitEstimate::default),
            core: Core::default(),
            awake_until: Instant::now(),
            late: false,
        }
    }

    /// Begins a wait, or continues one that a call ended without a frame.
    pub(super) fn begin(&mut self) {
        let now = Instant::now();
        let awake_until = match &mut self.estimate {
            Some(estimate) => estimate.awake_until(now, self.polling),
            None => now + self.polling,
        };
        let wanted = self.core.is_wanted(now);
        self.awake_until = if wanted { now } else { awake_until };
        self.late = wanted;
    }

    /// Yields once; false if the end should sleep.
    pub(super) fn give_way(&mut self) -> bool {
        let now = Instant::now();
        let awake = now < self.awake_until && !self.core.is_wanted(now);
        if awake {
            self.late |= self.core.give_way() == Yield::Late;
        }
        awake
    }

    /// Ends a wait with the frame that came. A late wait does not enter the estimate.
    pub(super) fn arrived(&mut self, header: &Header) {
        if let Some(estimate) = &mut self.estimate {
            estimate.arrived(header, !self.late);
        }
        self.late = false;
    }
}
