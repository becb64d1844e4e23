//! Thousands of runs in simulated time, over a network that delays, reorders, loses, repeats and damages messages, and with participants
//! that crash and stall. The real coupler and the real serving loop use it; the same seed gives the same schedule.
//!
//! - `bodies`: the small scenes; `network_faults`: the faults of a schedule; [`network`]: the simulated [`Link`](protocol::Link);
//! - [`schedule`]: one schedule and its verdict.

mod bodies;
pub mod network;
mod network_faults;
pub mod schedule;

use std::time::Instant;

use lab::cores::on_all_cores;
use network::Wrap;
use schedule::{ScheduleEnd, Simulation};

use coordinator::participants::Watch;

/// Counts of many schedules.
#[derive(Clone, Debug, Default)]
pub struct Counts {
    /// Runs that completed, bit-equal.
    pub completed: u64,
    /// Runs that ended early with a named fault.
    pub named: u64,
    /// Named runs that were resumed from a checkpoint, bit-equal.
    pub resumed: u64,
    /// Descriptions of schedules with another end.
    pub wrong: Vec<String>,
    /// Schedules per minute.
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
    let ends = on_all_cores(count, |index| {
        let going = watch.interrupted().is_none();
        going.then(|| simulation.schedule(seed.wrapping_add(index)))
    });
    let mut counts = Counts::default();
    ends.into_iter().flatten().for_each(|end| counts.add(end));
    counts.wrong.sort();
    counts.per_minute = counts.schedules() as f64 / start.elapsed().as_secs_f64() * 60.0;
    Ok(counts)
}
