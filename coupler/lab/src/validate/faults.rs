//! The fault campaign: runs of the program, started as a user starts them, that are killed, stopped, starved and damaged at random
//! instants, and thousands of simulated ones.
//!
//! The scene is `quick`, cut short, with many checkpoints and short deadlines. Instants come from a seed: handshake, windows,
//! checkpoints and the finish in turn. Each row is right if all of its trials are, if faults are found in time (99th percentile),
//! and if no process and no file in shared memory is left of a trial at its end. A trial that ends before its fault comes must
//! have completed bit-equal. "Bit-equal" means that the hashes of exchange and state are those of the undisturbed run.
//!
//! | fault | rule, and bound of the time until all has ended |
//! |---|---|
//! | a participant killed | [`kills::participant`], 1 s |
//! | the coordinator killed | [`kills::coordinator`], 1 s |
//! | everything killed | [`kills::everything`], 1 s |
//! | a participant stopped for 1 s | [`stops::participant_for`] |
//! | a participant stopped for ever | [`stops::participant_for_ever`], `answer_s` + 1 s |
//! | the coordinator stopped for 3 s | [`stops::coordinator_for`] |
//! | the coordinator stopped for ever | [`stops::coordinator_for_ever`], `idle_s` + 1 s |
//! | jitter | [`stops::jitter`] |
//! | a full disk | [`surroundings::disk`] |
//! | full shared memory | [`surroundings::shared_memory`], 1 s |
//! | a closed terminal | [`surroundings::terminal`], 1 s |
//! | a damaged log, a damaged checkpoint | [`damage::log`], [`damage::checkpoint`] |
//! | a simulated network | [`simulated::schedule`], 500 schedules a trial |

pub mod damage;
pub mod kills;
mod resumes;
pub mod row;
pub mod simulated;
pub mod stops;
pub mod surroundings;
pub mod trial;

use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

use crate::random::Random;
use row::{FaultResult, FaultRow, Wrong};
use trial::{ANSWER_S, FaultTrial, RunPhase, UndisturbedRun};

use coordinator::error::{Error, Refusal};
use coordinator::output::tell_progress;
use coordinator::participants::Watch;
use simulated::run_schedules;

/// Simulated schedules for each trial of the other rows.
const SCHEDULES: u64 = 500;

/// Circumstances of a campaign.
pub struct Campaign {
    /// The program.
    pub program: PathBuf,
    /// Trials of each row.
    pub trials: u64,
    /// Seed of all instants.
    pub seed: u64,
    /// Signals that end it.
    pub watch: Watch,
    /// Part of the names of the rows to run; empty for all.
    pub only: String,
}

/// Name of the row of simulated runs.
const SIMULATED: &str = "simulated network";

/// A fault: one trial of it, of this number.
type Fault<'a> = &'a (dyn Fn(&mut FaultTrial, &mut Random, u64) -> FaultResult + Sync);

/// Runs all rows.
pub fn run_campaign(campaign: &Campaign) -> Result<Vec<FaultRow>, Error> {
    let stage = UndisturbedRun::new(campaign.program.clone(), &campaign.watch).map_err(
        |wrong| match wrong {
            Wrong::Campaign(error) => error,
            Wrong::Outcome(why) => Refusal::Benchmark(why).into(),
        },
    )?;
    let phase = |index: u64| RunPhase::ALL[(index % 4) as usize];
    let name = |index: u64| ["rail", "third-body"][(index / 4 % 2) as usize];
    let (soon, named) = (Some(1.0), Some(ANSWER_S + 1.0));
    let faults: [(&str, Option<f64>, Fault); 14] = [
        ("rail killed", soon, &|t, r, i| {
            kills::participant(t, r, phase(i), "rail")
        }),
        ("third-body killed", soon, &|t, r, i| {
            kills::participant(t, r, phase(i), "third-body")
        }),
        ("coordinator killed", soon, &|t, r, i| {
            kills::coordinator(t, r, phase(i))
        }),
        ("everything killed", soon, &|t, r, i| {
            kills::everything(t, r, phase(i))
        }),
        ("participant stopped for 1 s", None, &|t, r, i| {
            stops::participant_for(t, r, phase(i), name(i), 1.0)
        }),
        ("participant stopped for ever", named, &|t, r, i| {
            stops::participant_for_ever(t, r, phase(i), name(i))
        }),
        ("coordinator stopped for 3 s", None, &|t, r, i| {
            stops::coordinator_for(t, r, phase(i), 3.0)
        }),
        ("coordinator stopped for ever", named, &|t, r, i| {
            stops::coordinator_for_ever(t, r, phase(i))
        }),
        ("jitter", None, &|t, r, _| stops::jitter(t, r)),
        ("full disk", None, &|t, r, _| surroundings::disk(t, r)),
        ("full shared memory", soon, &|t, r, _| {
            surroundings::shared_memory(t, r)
        }),
        ("closed terminal", soon, &|t, r, i| {
            surroundings::terminal(t, r, phase(i), i % 2 == 0)
        }),
        ("damaged log", None, &|t, r, i| damage::log(t, r, i)),
        ("damaged checkpoint", None, &|t, r, i| {
            damage::checkpoint(t, r, i)
        }),
    ];
    let chosen = |name: &str| name.contains(&campaign.only);
    let faults = (0u64..).zip(faults);
    let rows = faults.filter(|(_, (name, ..))| chosen(name));
    let rows = rows.map(|(place, (name, bound_s, fault))| {
        let row = FaultRow::new(name, campaign.seed, bound_s);
        run_row(campaign, &stage, row, place, fault)
    });
    let mut rows = rows.collect::<Result<Vec<_>, Error>>()?;
    if chosen(SIMULATED) {
        rows.push(simulated_row(campaign)?);
    }
    if rows.is_empty() {
        let problem = "no fault has this in its name; without --only all are listed";
        let argument = format!("--only {}", campaign.only);
        return Err(Refusal::argument(argument, problem).into());
    }
    Ok(rows)
}

/// Runs the trials of the row at this place of the table, as many at a time as the machine has cores.
fn run_row(
    campaign: &Campaign,
    stage: &UndisturbedRun,
    mut row: FaultRow,
    place: u64,
    fault: Fault,
) -> Result<FaultRow, Error> {
    tell_progress(&row.name);
    let next = AtomicU64::new(0);
    let work = || {
        let mut done = Vec::new();
        while let index = next.fetch_add(1, Ordering::Relaxed)
            && index < campaign.trials
        {
            let seed = Random::new(campaign.seed ^ (place << 32) ^ index).draw();
            done.push((index, run_trial(stage, fault, seed, index)));
        }
        done
    };
    let mut done: Vec<_> = thread::scope(|scope| {
        let workers = available_cores()
            .map(|_| scope.spawn(work))
            .collect::<Vec<_>>();
        let joined = workers.into_iter().map(|worker| worker.join());
        joined
            .flat_map(|done| done.expect("a trial does not panic"))
            .collect()
    });
    done.sort_by_key(|(index, _)| *index);
    for (index, (tried, leftovers)) in done {
        row.add(tried.map_err(|wrong| numbered(wrong, index)), leftovers)?;
    }
    Ok(row.judged())
}

/// Runs one trial, and tells what was left of it.
fn run_trial(stage: &UndisturbedRun, fault: Fault, seed: u64, index: u64) -> (FaultResult, u64) {
    match FaultTrial::new(stage) {
        Ok(mut trial) => {
            let tried = fault(&mut trial, &mut Random::new(seed), index);
            let leftovers = trial.leftovers();
            (tried, leftovers)
        }
        Err(error) => (Err(error.into()), 0),
    }
}

fn available_cores() -> std::ops::Range<usize> {
    0..thread::available_parallelism().map_or(1, usize::from)
}

fn numbered(wrong: Wrong, index: u64) -> Wrong {
    match wrong {
        Wrong::Outcome(why) => Wrong::Outcome(format!("trial {index}: {why}")),
        wrong => wrong,
    }
}

fn simulated_row(campaign: &Campaign) -> Result<FaultRow, Error> {
    let mut row = FaultRow::new(SIMULATED, campaign.seed, None);
    tell_progress(&row.name);
    let (count, watch) = (SCHEDULES * campaign.trials, &campaign.watch);
    let counts = run_schedules(campaign.seed, count, |link| link, watch);
    let counts = counts.map_err(Refusal::Benchmark)?;
    watch.interrupted().map_or(Ok(()), Err)?;
    row.ended("completed", counts.completed);
    row.ended("named", counts.named - counts.resumed);
    row.ended("resumed", counts.resumed);
    row.per_minute = Some(counts.per_minute);
    counts.wrong.into_iter().for_each(|why| row.failed(why));
    Ok(row.judged())
}
