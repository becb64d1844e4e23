//! The faults of a schedule, drawn from its seed: either one, or many.

use super::bodies::DEADLINE_S;
use lab::random::Random;

/// A fault that hits a message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NetworkFault {
    /// It comes later, and so do all messages behind it (s).
    Late(f64),
    /// It comes later, and others overtake it (s).
    Overtaken(f64),
    /// It is lost.
    Lost,
    /// It comes again after a while (s).
    Repeated(f64),
    /// One of its bits is flipped; the number chooses which.
    Flipped(u64),
    /// The participant dies as it comes; true if its end of the connection closes.
    Crash(bool),
    /// The participant stops for a while as it comes (s).
    Stall(f64),
}

/// The faults of one schedule.
#[derive(Clone, Debug, Default)]
pub struct NetworkFaults {
    random: Random,
    /// The message that the only fault hits; `None` for a schedule of many faults.
    only: Option<u64>,
    /// Share of messages hit by a fault in a schedule of many.
    often: f64,
    /// Faults so far, each with the message that it hit.
    pub faults: Vec<(u64, NetworkFault)>,
}

impl NetworkFaults {
    /// The faults of a seed; a run has about this many messages.
    pub fn new(seed: u64, messages: u64) -> NetworkFaults {
        let mut random = Random::new(seed);
        let single = random.below(2) == 0;
        NetworkFaults {
            only: single.then(|| random.below(messages)),
            often: random.between(2e-3, 0.2),
            random,
            faults: Vec::new(),
        }
    }

    /// The fault that hits this message.
    pub fn fault(&mut self, message: u64) -> Option<NetworkFault> {
        let due = match self.only {
            Some(only) => only == message,
            None => self.often > 0.0 && self.random.share() < self.often,
        };
        if !due {
            return None;
        }
        let fault = self.draw();
        self.faults.push((message, fault));
        Some(fault)
    }

    fn draw(&mut self) -> NetworkFault {
        let random = &mut self.random;
        // From much shorter than a window of simulated time to beyond every deadline.
        let time_s = random.between(1e-4, 4.0 * DEADLINE_S);
        match random.below(7) {
            0 => NetworkFault::Late(time_s),
            1 => NetworkFault::Overtaken(time_s),
            2 => NetworkFault::Lost,
            3 => NetworkFault::Repeated(time_s),
            4 => NetworkFault::Flipped(random.draw()),
            5 => NetworkFault::Crash(random.below(2) == 0),
            _ => NetworkFault::Stall(time_s),
        }
    }
}
