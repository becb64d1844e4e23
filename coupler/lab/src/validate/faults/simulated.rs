//! Thousands of runs behind a network that delays, reorders, loses, repeats and damages messages, and whose participants crash
//! and stall, in simulated time. The real coupler and the real serving loop speak over it; a seed gives the same schedule again.
//!
//! - `bodies`: the small scenes; `network_faults`: what befalls the messages of a schedule; [`network`]: the simulated [`Link`](protocol::Link);
//! - [`schedule`]: one schedule and its verdict.

mod bodies;
pub mod network;
mod network_faults;
pub mod schedule;

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::Instant;

use network::Wrap;
use schedule::{ScheduleEnd, Simulation};

use coordinator::participants::Watch;

/// Counts of many schedules.
#[derive(Clone, Debug, Default)]
pub struct Counts {
    /// Runs that completed, bit-equal.
    pub completed: u64,
    /// Runs that ended early and said why.
    pub named: u64,
    /// Those of them that went on from a checkpoint, bit-equal.
    pub resumed: u64,
    /// Schedules with another end, each with what is wrong.
    pub wrong: Vec<String>,
    /// Schedules in a minute.
    pub per_minute: f64,
}

impl Counts {
    /// Schedules in all.
    pub fn schedules(&self) -> u64 {
        self.completed + self.named + self.wrong.len() as u64
    }

    fn add(&mut self, verdict: Result<ScheduleEnd, String>) {
        match verdict {
            Ok(ScheduleEnd::Completed) => self.completed += 1,
            Ok(ScheduleEnd::Named) => self.named += 1,
            Ok(ScheduleEnd::Resumed) => {
                self.named += 1;
                self.resumed += 1;
            }
            Err(why) => self.wrong.push(why),
        }
    }
}

/// Runs the schedules of `count` seeds from `seed` on, on all cores, until a signal comes.
pub fn run_schedules(seed: u64, count: u64, wrap: Wrap, watch: &Watch) -> Result<Counts, String> {
    let start = Instant::now();
    let simulation = Simulation::new(wrap)?;
    let counts = Mutex::new(Counts::default());
    let next = AtomicU64::new(0);
    let work = || {
        while let index = next.fetch_add(1, Ordering::Relaxed)
            && index < count
            && watch.interrupted().is_none()
        {
            let verdict = simulation.schedule(seed.wrapping_add(index));
            counts.lock().expect("nothing panics with it").add(verdict);
        }
    };
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(work);
        }
    });
    let mut counts = counts.into_inner().expect("nothing panics with it");
    counts.wrong.sort();
    counts.per_minute = counts.schedules() as f64 / start.elapsed().as_secs_f64() * 60.0;
    Ok(counts)
}
