//! The core that a thread waits on, as its yields show it.
//!
//! A thread that waits by giving way to others is back at once while nobody else wants its core. A program that computes there,
//! and knows nothing of this one, keeps it for a whole time slice of some milliseconds at each yield; a sleeping thread that is
//! woken is let in before it. So a yield that comes back as late as that says: sleep.

use std::thread;
use std::time::{Duration, Instant};

use nix::sched::{CpuSet, sched_getaffinity, sched_getcpu, sched_setaffinity};
use nix::unistd::Pid;

/// Longest yield on a core that nobody else wants.
const PROMPT: Duration = Duration::from_micros(50);

/// Longest yield that a participant of the same run explains: it had work of its own to do. A wake-up costs little beside more.
const OWN: Duration = Duration::from_millis(1);

/// Time without yields after one that was stolen. It doubles as long as the next yield is stolen, too.
const SHORTEST_PAUSE: Duration = Duration::from_millis(50);

/// Longest of these times: a stolen yield of 4 ms in each costs 0.4 %.
const LONGEST_PAUSE: Duration = Duration::from_secs(1);

/// The way in which a yield returned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Yield {
    /// At once.
    Prompt,
    /// Later than on a core that nobody else wants.
    Late,
}

/// The core that a thread waits on.
#[derive(Debug)]
pub struct Core {
    /// End of the time in which nothing is tried.
    wanted_until: Instant,
    pause: Duration,
    /// The core that the thread is kept off, and those on which it may run otherwise.
    kept_off: Option<(usize, CpuSet)>,
}

impl Default for Core {
    fn default() -> Core {
        Core {
            wanted_until: Instant::now(),
            pause: SHORTEST_PAUSE,
            kept_off: None,
        }
    }
}

impl Core {
    /// Number of the core that the calling thread is on.
    pub fn number() -> Option<usize> {
        sched_getcpu().ok()
    }

    /// Keeps the calling thread off this core from now on, or off none. To the system a thread that waits awake is as busy as one that
    /// computes: while each core has as many of either it moves none, and two that work side by side stay on one.
    pub fn keep_off(&mut self, core: Option<usize>) {
        if self.kept_off.map(|(core, _)| core) == core {
            return;
        }
        let this = Pid::from_raw(0);
        let all = self.kept_off.take().map(|(_, all)| all);
        let Some(all) = all.or_else(|| sched_getaffinity(this).ok()) else {
            return;
        };
        let mut allowed = all;
        let removed = core.map_or(Ok(()), |core| allowed.unset(core));
        // The system refuses where no other core is left.
        let set = removed.and_then(|()| sched_setaffinity(this, &allowed));
        self.kept_off = core.filter(|_| set.is_ok()).map(|core| (core, all));
    }

    /// True while a stranger wants the core: a thread that waits had better sleep.
    pub fn is_wanted(&self, now: Instant) -> bool {
        now < self.wanted_until
    }

    /// Gives way to other threads once.
    pub fn give_way(&mut self) -> Yield {
        let start = Instant::now();
        thread::yield_now();
        self.judge(start, start.elapsed())
    }

    fn judge(&mut self, start: Instant, took: Duration) -> Yield {
        if took <= PROMPT {
            return Yield::Prompt;
        }
        if took > OWN {
            // Long after the last one, it is another stranger.
            let again = start < self.wanted_until + self.pause;
            self.pause = if again {
                LONGEST_PAUSE.min(2 * self.pause)
            } else {
                SHORTEST_PAUSE
            };
            self.wanted_until = start + took + self.pause;
        }
        Yield::Late
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_is_kept_off_a_core_until_it_is_let_back() {
        let allowed = || sched_getaffinity(Pid::from_raw(0)).expect("Linux tells them");
        let all = allowed();
        let is_in = |core: usize| all.is_set(core) == Ok(true);
        let cores: Vec<usize> = (0..CpuSet::count()).filter(|core| is_in(*core)).collect();
        let mut core = Core::default();
        for off in &cores {
            core.keep_off(Some(*off));
            let kept = cores.len() > 1;
            assert_eq!(allowed().is_set(*off), Ok(!kept));
            assert!(!kept || Core::number() != Some(*off));
            assert_eq!(core.kept_off, kept.then_some((*off, all)));
        }
        core.keep_off(None);
        assert_eq!(allowed(), all);
    }

    #[test]
    fn a_core_is_wanted_for_twice_as_long_when_it_is_stolen_again() {
        let mut core = Core::default();
        let start = Instant::now();
        let after = |millis: u64| start + Duration::from_millis(millis);
        let stolen = Duration::from_millis(4);
        assert_eq!(core.judge(start, Duration::from_micros(40)), Yield::Prompt);
        assert_eq!(core.judge(start, Duration::from_micros(60)), Yield::Late);
        assert!(!core.is_wanted(start), "one of this run had work to do");
        core.judge(start, stolen);
        assert!(core.is_wanted(after(103)));
        assert!(!core.is_wanted(after(105)));
        core.judge(after(105), stolen);
        assert!(core.is_wanted(after(308)));
        assert!(!core.is_wanted(after(310)));
        core.judge(after(10_000), stolen);
        assert!(core.is_wanted(after(10_053)));
        assert!(!core.is_wanted(after(10_055)));
    }
}
