//! The fault campaign: runs of the program, started as by a user, that are killed, stopped, starved and damaged at random
//! instants, and thousands of simulated runs.
//!
//! The scene is a short `quick` with many checkpoints and short deadlines. Instants come from a seed: handshake, windows,
//! checkpoints and the finish in turn. A row is right if all its trials are right, if faults are found in time (99th percentile),
//! and if a trial leaves no process and no file in shared memory. A trial that ends before its fault comes must
//! complete bit-equal. "Bit-equal" means that the hashes of exchange and state equal the undisturbed run's.
//!
//! | fault | rule, and bound of the time until all has ended |
//! |---|---|
//! | a participant killed | [`kills::participant`], 1 s |
//! | the coordinator killed | [`kills::coordinator`], 1 s |
//! | everything killed | [`kills::everything`], 1 s |
//! | a participant stopped for 1 s | [`stops::participant_for_1_s`] |
//! | a participant stopped for ever | [`stops::participant_for_ever`], `answer_s` + 1 s |
//! | the coordinator stopped for 3 s | [`stops::coordinator_for_3_s`] |
//! | the coordinator stopped for ever | [`stops::coordinator_for_ever`], `idle_s` + 1 s |
//! | jitter | [`stops::jitter`] |
//! | jitter in the middle of long frames | [`stops::long_frames`] |
//! | a full disk | [`surroundings::disk`] |
//! | full shared memory | [`surroundings::shared_memory`], 1 s |
//! | a closed terminal | [`surroundings::terminal`], 1 s |
//! | a second run with its own process numbers | [`surroundings::namespace`] |
//! | a study started twice at once | [`surroundings::studies`] |
//! | a damaged log, a damaged checkpoint | [`damage::log`], [`damage::checkpoint`] |
//! | a damaged table | [`damage::table`] |
//! | a simulated network | [`simulated::schedule`], 500 schedules per trial |
//!
//! - [`trial`]: one run of the program and its processes; [`row`]: the trials of a fault, counted;
//! - [`kills`], [`stops`], [`surroundings`], [`damage`]: the faults; `resumes`: the resumed runs;
//! - [`simulated`]: runs in simulated time.

pub mod damage;
pub mod kills;
mod resumes;
pub mod row;
pub mod simulated;
pub mod stops;
pub mod surroundings;
pub mod trial;

use std::path::PathBuf;

use lab::cores::on_all_cores;
use lab::random::Random;
use row::{FaultResult, FaultRow, Wrong};
use trial::{ANSWER_S, FaultTrial, UndisturbedRun};

use coordinator::participants::Watch;
use scenario::error::{Error, Refusal};
use simulated::run_schedules;
use terminal::tell_progress;

/// Simulated schedules per trial of the other rows.
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

/// One trial of a fault.
type Fault = fn(&mut FaultTrial) -> FaultResult;

/// Bounds of the time (s) until a fault is found: at once, or by a deadline.
const AT_ONCE: Option<f64> = Some(1.0);
const BY_DEADLINE: Option<f64> = Some(ANSWER_S + 1.0);

/// Names of the faults, bounds of the time until they are found, if there is something to find, and their trials.
const FAULTS: [(&str, Option<f64>, Fault); 18] = [
    ("rail killed", AT_ONCE, |t| kills::participant(t, "rail")),
    ("third-body killed", AT_ONCE, |t| {
        kills::participant(t, "third-body")
    }),
    ("coordinator killed", AT_ONCE, kills::coordinator),
    ("everything killed", AT_ONCE, kills::everything),
    (
        "participant stopped for 1 s",
        None,
        stops::participant_for_1_s,
    ),
    (
        "participant stopped for ever",
        BY_DEADLINE,
        stops::participant_for_ever,
    ),
    (
        "coordinator stopped for 3 s",
        None,
        stops::coordinator_for_3_s,
    ),
    (
        "coordinator stopped for ever",
        BY_DEADLINE,
        stops::coordinator_for_ever,
    ),
    ("jitter", None, stops::jitter),
    ("long frames, jitter", None, stops::long_frames),
    ("full disk", None, surroundings::disk),
    ("full shared memory", AT_ONCE, surroundings::shared_memory),
    ("closed terminal", AT_ONCE, surroundings::terminal),
    ("other process numbers", None, surroundings::namespace),
    ("study begun twice at once", None, surroundings::studies),
    ("damaged log", None, damage::log),
    ("damaged checkpoint", None, damage::checkpoint),
    ("damaged table", None, damage::table),
];

/// Runs all rows.
pub fn run_campaign(campaign: &Campaign) -> Result<Vec<FaultRow>, Error> {
    let undisturbed = UndisturbedRun::new(campaign.program.clone(), &campaign.watch);
    let undisturbed = undisturbed.map_err(|wrong| match wrong {
        Wrong::Campaign(error) => error,
        Wrong::Outcome(why) => Refusal::Benchmark(why).into(),
    })?;
    let chosen = |name: &str| name.contains(&campaign.only);
    let mut rows = Vec::new();
    for (number, (name, bound_s, fault)) in (0..).zip(FAULTS) {
        if chosen(name) {
            let row = FaultRow::new(name, campaign.seed, bound_s);
            rows.push(run_row(campaign, &undisturbed, row, number, fault)?);
        }
    }
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

/// Runs the trials of the row with this number in the table, one per core at a time.
fn run_row(
    campaign: &Campaign,
    undisturbed: &UndisturbedRun,
    mut row: FaultRow,
    number: u64,
    fault: Fault,
) -> Result<FaultRow, Error> {
    tell_progress(&row.name);
    let tried = on_all_cores(campaign.trials, |index| {
        let seed = Random::new(campaign.seed ^ (number << 32) ^ index).draw();
        let trial = FaultTrial::new(undisturbed, seed, index);
        trial.map(|mut trial| (fault(&mut trial), trial.leftovers()))
    });
    for (index, tried) in tried.into_iter().enumerate() {
        let (tried, leftovers) = tried?;
        row.add(index, tried, leftovers)?;
    }
    Ok(row.judged())
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
