//! Forecast of the cost of the tasks of a study, from the first windows of one.

use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::measure::Measure;
use super::plan::Task;
use super::slurm::SlurmRequest;
use coordinator::error::Error;
use coordinator::run::session::{RunOptions, fresh_run_id, run};
use coordinator::rundir::{BUILD, write_whole};
use kit::keys::proposal;
use kit::scratch::Scratch;
use runs::table::Table;

/// Factors on the prediction: other tasks cost more than the one that was looked at, and nodes of a cluster are slower than this
/// machine. A task that runs into its limit is given twice as much.
const WALL_FACTOR: f64 = 4.0;
const MEMORY_FACTOR: u64 = 2;
/// The least that is asked for.
const WALL_LEAST_S: f64 = 600.0;
const MEMORY_LEAST: u64 = 512 << 20;

/// Cost of the reference, or of the first task, as its first second predicted it: `cost.json` in the study's folder.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Forecast {
    /// Build that was looked at.
    build: String,
    /// Wall-clock time (s), if all windows go as the slowest of those seen.
    pub wall_s: f64,
    /// Peak memory of all processes together (bytes).
    pub memory_bytes: u64,
    /// Columns of its signals.
    signals: Vec<String>,
}

impl Forecast {
    /// The one that the folder keeps, if it is this build's; else that of this task, which the folder then keeps.
    ///
    /// # Errors
    /// The folder cannot be written, or a signal came. A task whose run ends early predicts nothing: then the least is asked for.
    pub fn of(task: &Task, folder: &Path, options: &RunOptions) -> Result<Forecast, Error> {
        let path = folder.join("cost.json");
        let kept = fs::read_to_string(&path).ok();
        let kept = kept.and_then(|text| serde_json::from_str::<Forecast>(&text).ok());
        if let Some(kept) = kept.filter(|kept| kept.build == BUILD) {
            return Ok(kept);
        }
        let scratch = Scratch::new("study", fresh_run_id());
        let options = RunOptions {
            out: Some(scratch.path()),
            dry_run: true,
            ..options.clone()
        };
        let ended = run(&task.loaded, &options)?;
        if let Some(error @ Error::Interrupted { .. }) = ended.error {
            return Err(error);
        }
        let signals = Table::read_whole_rows(&scratch.path().join("signals.csv"));
        let told = ended.summary.spent.as_ref().and_then(|spent| spent.told);
        let forecast = Forecast {
            build: BUILD.into(),
            wall_s: told.map_or(0.0, |told| told.wall_high_s),
            memory_bytes: told.map_or(0, |told| told.memory_bytes),
            signals: signals.columns.into_iter().map(|(name, _)| name).collect(),
        };
        let text = serde_json::to_string_pretty(&forecast).unwrap_or_default();
        fs::create_dir_all(folder).map_err(Error::output(path.display()))?;
        write_whole(&path, text.as_bytes())?;
        Ok(forecast)
    }

    /// Refuses a measure of nothing that the task reports, before runs are made for it. `results` are the names of results that the
    /// shipped solvers know, some with a `<set>` in front; only the end of a run tells which of them it has.
    ///
    /// # Errors
    /// The measure, and what was perhaps meant.
    pub fn check(&self, measures: &[Measure], task: &Task, results: &[&str]) -> Result<(), String> {
        let signals: Vec<&str> = self.signals.iter().map(String::as_str).collect();
        let mut participants = task.loaded.scenario.participant.iter();
        let others = participants.any(|participant| participant.command.is_some());
        for measure in measures {
            let (known, what) = match measure.table() {
                Some(("signals", _)) => (&signals[..], "its signals"),
                Some(("results", _)) if !others => (results, "results"),
                _ => continue,
            };
            let name = measure.table().map_or("", |(_, name)| name);
            let end = format!(".{name}");
            let is_it = |known: &&str| match known.strip_prefix("<set>") {
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

    /// Resources asked of Slurm for a task.
    pub fn ask(&self, threads: u16) -> SlurmRequest {
        SlurmRequest {
            wall_s: (WALL_FACTOR * self.wall_s).max(WALL_LEAST_S),
            memory_bytes: (MEMORY_FACTOR * self.memory_bytes).max(MEMORY_LEAST),
            cores: threads.max(1),
        }
    }
}
