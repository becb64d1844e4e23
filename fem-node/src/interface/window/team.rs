//! The threads of a body, and work that they do side by side.

use std::hint;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use protocol::link::Core;
use rayon::ThreadPool;

use crate::error::FemError;

/// Time that a thread waits awake for the next window, and for the other threads at the end of a window. Waking a thread takes some 100 us on virtual
/// cores, little compared with longer waits.
const AWAKE: Duration = Duration::from_millis(1);

/// Pauses of the processor, some 20 ns each, in which a thread reports that its work is done.
const REPORT: u32 = 100;

/// Threads, the calling one included.
#[derive(Debug)]
pub(crate) struct Team {
    /// All threads, for work that hands out its own parts.
    pub(crate) pool: ThreadPool,
    /// The threads other than the calling one, if any. All of them are busy or stand by when work is handed out, so that none has to be woken.
    others: Option<ThreadPool>,
    /// Rounds of work; a new one ends the standby.
    round: Arc<AtomicU64>,
    /// The cores on which the others, and then the calling thread, wait.
    cores: Vec<Arc<Mutex<Core>>>,
}

impl Team {
    /// A team of this many threads.
    pub(crate) fn new(threads: usize) -> Result<Team, FemError> {
        let others = (threads > 1).then(|| FemError::pool(threads - 1));
        Ok(Team {
            pool: FemError::pool(threads)?,
            others: others.transpose()?,
            round: Arc::default(),
            cores: (0..threads).map(|_| Arc::default()).collect(),
        })
    }

    /// Does all of this work, some of it on the calling thread; at most one item for each thread.
    pub(super) fn side_by_side<T: Send>(&self, items: &mut [T], work: impl Fn(&mut T) + Sync) {
        let (Some(others), Some((own, rest))) = (&self.others, items.split_first_mut()) else {
            return items.iter_mut().for_each(work);
        };
        let handed_out = rest.len();
        let left = AtomicUsize::new(handed_out);
        others.in_place_scope(|scope| {
            for item in rest {
                let (work, left) = (&work, &left);
                scope.spawn(move |_| {
                    work(item);
                    left.fetch_sub(1, Ordering::Release);
                });
            }
            self.round.fetch_add(1, Ordering::Release);
            work(own);
            if let Some(core) = self.cores.last() {
                wait(&mut lock(core), || left.load(Ordering::Acquire) == 0);
            }
            // The others still report to the scope, which would sleep at once: a moment more.
            (0..REPORT).for_each(|_| hint::spin_loop());
        });
        let here = Core::number();
        for core in &self.cores[..handed_out.min(self.cores.len() - 1)] {
            let (core, round) = (core.clone(), self.round.clone());
            let now = round.load(Ordering::Acquire);
            others.spawn(move || {
                let is_over = || round.load(Ordering::Acquire) != now;
                let mut core = lock(&core);
                core.keep_off(here);
                wait(&mut core, is_over);
                if !is_over() {
                    // The thread sleeps from now on, and the system may wake it on any core.
                    core.keep_off(None);
                }
            });
        }
    }
}

/// Spins until the wait is over, for [`AWAKE`] at most, and yields to threads that compute. It stops at once if another program needs the core; then
/// the thread sleeps. If another participant of the run has had the core the thread stays awake: its work comes soon.
fn wait(core: &mut Core, is_over: impl Fn() -> bool) {
    let start = Instant::now();
    while !is_over() && !core.is_wanted(Instant::now()) && start.elapsed() < AWAKE {
        core.give_way();
    }
}

fn lock(core: &Mutex<Core>) -> MutexGuard<'_, Core> {
    core.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_work_is_done_whether_the_others_stand_by_or_sleep() {
        for threads in [1, 2, 3] {
            let team = Team::new(threads).expect("the threads start");
            for pause in [Duration::ZERO, 3 * AWAKE] {
                for _ in 0..20 {
                    let mut items = vec![1; threads];
                    team.side_by_side(&mut items, |item| *item += 1);
                    assert_eq!(items, vec![2; threads]);
                    std::thread::sleep(pause);
                }
            }
        }
    }
}
