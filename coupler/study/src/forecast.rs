//! Forecast of the cost of a study's tasks, from the first windows of one task.

use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::knobs::Knobs;
use super::measure::Measure;
use super::open_study::write_in;
use super::plan::Task;
use super::slurm::SlurmRequest;
use coordinator::run::session::{Ended, RunOptions, fresh_run_id, run};
use kit::keys::proposal;
use kit::scratch::Scratch;
use runs::identity::build;
use runs::steps::bin_fits;
use runs::table::Table;
use scenario::error::Error;
use scenario::load::Loaded;

/// Factors on the prediction: other tasks cost more than the predicted one, and nodes of a cluster are slower than this machine. A task
/// that reaches its limit gets twice as much.
const WALL_FACTOR: f64 = 4.0;
const MEMORY_FACTOR: u64 = 2;
/// Smallest request.
const WALL_LEAST_S: f64 = 600.0;
const MEMORY_LEAST: u64 = 512 << 20;

/// The file of a forecast in the study's folder.
const KEPT: &str = "cost.json";

/// Cost of the reference, or of the first task, predicted from its first second: `cost.json` in the study's folder.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Forecast {
    /// Build and task of the dry run.
    build: String,
    #[serde(default)]
    task: String,
    /// Wall-clock time (s), if all windows take as long as the slowest ones seen.
    pub wall_s: f64,
    /// Peak memory, summed over all processes (bytes).
    pub memory_bytes: u64,
    /// Columns of the signals.
    signals: Vec<String>,
    /// First instant of the signals (s), if the dry run came so far.
    #[serde(default)]
    start_s: Option<f64>,
    /// End of the simulated time (s), if the dry run got to know it.
    end_s: Option<f64>,
}

/// Runs the first windows of a scenario in a temporary folder, to predict its cost; also returns its signals.
///
/// # Errors
/// The scenario is refused.
pub fn rehearse(loaded: &Loaded, options: &RunOptions) -> Result<(Ended, Table), Error> {
    let scratch = Scratch::new("rehearsal", fresh_run_id());
    let options = RunOptions {
        out: Some(scratch.path()),
        dry_run: true,
        ..options.clone()
    };
    let ended = run(loaded, &options)?;
    let signals = Table::read_whole_rows(&scratch.path().join("signals.csv"));
    Ok((ended, signals))
}

impl Forecast {
    /// The forecast in the folder, if it is of this build and task; else a new one, which is kept there.
    ///
    /// # Errors
    /// The scenario is refused, the folder cannot be written, or a signal came. If a run ends early for another reason, the forecast is the
    /// smallest request.
    pub fn of(task: &Task, folder: &Path, options: &RunOptions) -> Result<Forecast, Error> {
        let kept = fs::read_to_string(folder.join(KEPT)).ok();
        let kept = kept.and_then(|text| serde_json::from_str::<Forecast>(&text).ok());
        if let Some(kept) = kept.filter(|kept| kept.build == build().hash && kept.task == task.id) {
            return Ok(kept);
        }
        // The host of a job is unknown before it starts.
        let mut loaded = task.loaded.clone();
        loaded.scenario.bring_here();
        let (ended, signals) = rehearse(&loaded, options)?;
        match ended.error {
            Some(error @ Error::Interrupted { .. }) => return Err(error),
            Some(error) if error.exit_code() == 2 => return Err(error),
            _ => {}
        }
        let prediction = ended.summary.spent.as_ref().and_then(|spent| spent.told);
        let forecast = Forecast {
            build: build().hash.into(),
            task: task.id.clone(),
            wall_s: prediction.map_or(0.0, |prediction| prediction.wall_high_s),
            memory_bytes: prediction.map_or(0, |prediction| prediction.memory_bytes),
            start_s: signals.get("t_s").and_then(|t| t.first().copied()),
            signals: signals.columns.into_iter().map(|(name, _)| name).collect(),
            end_s: ended.summary.end_s,
        };
        let text = serde_json::to_string_pretty(&forecast).unwrap_or_default();
        write_in(folder, KEPT, &text)?;
        Ok(forecast)
    }

    /// Refuses a measure that the task does not report, before any run. `results` are the names of results that the shipped solvers know, some
    /// with the prefix `<set>`; which of them a run has is known only at its end. The results `of_cycles` need a full cycle of a wheel.
    ///
    /// # Errors
    /// The measure, and a proposal for its name.
    pub fn check(
        &self,
        measures: &[Measure],
        task: &Task,
        results: &[String],
        of_cycles: &[String],
    ) -> Result<(), String> {
        let mut participants = task.loaded.scenario.participant.iter();
        let others = participants.any(|participant| participant.command.is_some());
        let surface_m = Knobs::of(&task.loaded).surface_m();
        for measure in measures {
            let (name, end_s) = (&measure.name, self.end_s.unwrap_or(f64::INFINITY));
            let start_s = self.start_s.unwrap_or(0.0);
            let instants = start_s * (1.0 - 1e-9)..=end_s * (1.0 + 1e-9);
            if let Some(at_s) = measure.at_s.filter(|at_s| !instants.contains(at_s)) {
                return Err(format!(
                    "measure `{name}`: at_s = {at_s:e} is no instant of the run, which ends at {end_s:.4e} s and has its first signals at {start_s:.4e} s"
                ));
            }
            if let Some((bin_m, length)) = measure.bin_m.zip(surface_m) {
                bin_fits(bin_m, [length; 2]).map_err(|why| format!("measure `{name}`: {why}"))?;
            }
            let (known, what, name) = match measure.table() {
                Some(("signals", name)) => (&self.signals[..], "its signals", name),
                Some(("results", name)) if !others => (results, "results", name),
                _ => continue,
            };
            if !others && of_cycles.iter().any(|known| known == name) && !makes_full_cycle(task) {
                return Err(format!(
                    "measure `{}`: {} needs a full cycle, and no wheel of the scene completes one before the run ends; set wheel.cycles = 1",
                    measure.name, measure.of
                ));
            }
            let end = format!(".{name}");
            let is_it = |known: &String| match known.strip_prefix("<set>") {
                Some(ending) => name.ends_with(ending),
                None => *known == name || known.ends_with(&end),
            };
            if !known.is_empty() && !known.iter().any(is_it) {
                let mut last: Vec<&str> = known.iter().flat_map(|k| k.rsplit('.').next()).collect();
                last.dedup();
                let meant = proposal(name, what, &last);
                return Err(format!(
                    "measure `{}`: no run reports {}; {meant}",
                    measure.name, measure.of
                ));
            }
        }
        Ok(())
    }

    /// Resources to request from Slurm for a task.
    pub fn ask(&self, threads: u16) -> SlurmRequest {
        SlurmRequest {
            wall_s: (WALL_FACTOR * self.wall_s).max(WALL_LEAST_S),
            memory_bytes: (MEMORY_FACTOR * self.memory_bytes).max(MEMORY_LEAST),
            cores: threads.max(1),
        }
    }
}

/// True if a wheel of the task's scenario completes a cycle before the end.
fn makes_full_cycle(task: &Task) -> bool {
    let knobs = Knobs::of(&task.loaded);
    let end_s = task.loaded.scenario.run.end_s.unwrap_or(f64::INFINITY);
    let mut participants = task.loaded.scenario.participant.iter();
    participants.any(|participant| {
        let number = |key| knobs.number(&participant.name, &format!("wheel.{key}"));
        let keys = ["cycles", "ramp_s", "hold_s", "frequency_hz"];
        let [cycles, ramp, hold, frequency] = keys.map(|key| number(key).unwrap_or(0.0));
        // The end may be rounded.
        cycles >= 1.0 && ramp + hold + 1.0 / frequency <= end_s * (1.0 + 1e-9)
    })
}
