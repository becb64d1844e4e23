//! The way in which an end of a link waits: awake, giving way to all who compute, for as long as the wait is foreseen to last
//! on a core that no stranger wants; asleep otherwise. Another participant may have the core meanwhile: an end that sleeps then has
//! to be woken when its frame is there, one that is awake goes on as soon as the core is free.

use std::time::{Duration, Instant};

use super::core::{Core, Yield};
use super::wait_estimate::WaitEstimate;
use crate::frame::Header;

/// Time that an end polls before it sleeps: most answers of a solver come earlier. Beside a wait of 20 ms it is less than 5 %.
const POLLING: Duration = Duration::from_micros(900);

/// The same for an end that shares its core. The sleep then costs as much again, so at most that is wasted.
const POLLING_ON_SHARED_CORE: Duration = Duration::from_micros(20);

/// One end's way of waiting.
#[derive(Debug)]
pub(super) struct Waiting {
    polling: Duration,
    /// Only of an end that shares its core.
    estimate: Option<WaitEstimate>,
    core: Core,
    /// End of the time that the wait at hand is spent awake.
    awake_until: Instant,
    /// A yield of the wait at hand came back late.
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

    /// Begins a wait, or goes on with one that a call ended without a frame.
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

    /// Gives way once; false if the end had better sleep.
    pub(super) fn give_way(&mut self) -> bool {
        let now = Instant::now();
        let awake = now < self.awake_until && !self.core.is_wanted(now);
        if awake {
            self.late |= self.core.give_way() == Yield::Late;
        }
        awake
    }

    /// Ends a wait by the frame that came. Nothing is learnt from time that others took.
    pub(super) fn arrived(&mut self, header: &Header) {
        if let Some(estimate) = &mut self.estimate {
            estimate.arrived(header, !self.late);
        }
        self.late = false;
    }
}
