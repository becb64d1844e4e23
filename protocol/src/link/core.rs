//! The core that a thread waits on, as its yields show it.
//!
//! A thread that waits by yielding runs again at once while no other thread wants its core. An unrelated program that computes
//! there keeps the core for a whole time slice of some milliseconds at each yield; a sleeping thread runs before it when woken.
//! So after a yield that takes that long, the thread should sleep.

use std::thread;
use std::time::{Duration, Instant};

use nix::sched::{CpuSet, sched_getaffinity, sched_getcpu, sched_setaffinity};
use nix::unistd::Pid;

/// Longest yield on a core that no other thread wants.
const PROMPT: Duration = Duration::from_micros(50);

/// Longest yield that the work of a participant of the same run explains. A wake-up costs little compared with a longer one.
const OWN: Duration = Duration::from_millis(1);

/// Time without yields after a stolen one. It doubles each time the next yield is stolen too.
const SHORTEST_PAUSE: Duration = Duration::from_millis(50);

/// Longest of these times: a stolen yield of 4 ms in each costs 0.4 %.
const LONGEST_PAUSE: Duration = Duration::from_secs(1);

/// The way in which a yield returned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Yield {
    /// At once.
    Prompt,
    /// Later than on a core that no other thread wants.
    Late,
}

/// The core that a thread waits on.
#[derive(Debug)]
pub struct Core {
    /// End of the time without yields.
    wanted_until: Instant,
    pause: Duration,
    /// The core that the thread is kept off, and the cores that it may use otherwise.
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

    /// Keeps the calling thread off this core from now on; `None` lifts that. To the system a thread that waits awake is as busy as a
    /// thread that computes. While each core has as many of them it moves none, and two computing threads may share a core.
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
        // The system refuses if no other core is left.
        let set = removed.and_then(|()| sched_setaffinity(this, &allowed));
        self.kept_off = core.filter(|_| set.is_ok()).map(|core| (core, all));
    }

    /// True while an unrelated program wants the core: a waiting thread should sleep.
    pub fn is_wanted(&self, now: Instant) -> bool {
        now < self.wanted_until
    }

    /// Yields to other threads once.
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
            // Long after the last stolen yield, another program took this one.
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
        let allowed = || sched_getaffinity(Pid::from_raw(0)).expect("Linux knows the cores");
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
        assert!(!core.is_wanted(start), "a participant had work to do");
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
