//! A run that has ended, as it lies in its directory.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;

use super::table::Table;
use coordinator::error::{Error, Refusal};

/// Summary, signals and traction of a run.
#[derive(Clone, Debug)]
pub struct Finished {
    /// summary.json.
    pub summary: Value,
    /// signals.csv; empty where nothing was reported.
    pub signals: Table,
    /// profile.csv, where there is one.
    pub profile: Option<Table>,
}

impl Finished {
    /// Reads a run directory.
    ///
    /// # Errors
    /// There is no summary.json: the run goes on still, or was killed; or a file is damaged.
    pub fn read(run: &Path) -> Result<Finished, Error> {
        let path = run.join("summary.json");
        if run.is_dir() && !path.exists() {
            let problem =
                "is missing: the run goes on, or was killed (`thirdbody resume` goes on with it)";
            return Err(Refusal::file(path, problem).into());
        }
        let text = std::fs::read_to_string(&path).map_err(Error::input(path.display()))?;
        let summary = serde_json::from_str(&text);
        Ok(Finished {
            summary: summary.map_err(|error| Refusal::file(path, error.to_string()))?,
            signals: Table::read(&run.join("signals.csv"))?.unwrap_or_default(),
            profile: Table::read(&run.join("profile.csv"))?,
        })
    }

    /// Status in a word.
    pub fn status(&self) -> &str {
        self.summary["status"].as_str().unwrap_or_default()
    }

    /// The results, by name.
    pub fn results(&self) -> BTreeMap<String, f64> {
        numbers(&self.summary["results"])
    }

    /// A hash of the summary.
    pub fn hash(&self, name: &str) -> Option<&str> {
        self.summary["hashes"][name].as_str()
    }

    /// Costs by name: wall-clock time, processor time and memory of all processes, and the work of all participants, each kind summed.
    /// Participants that are threads of the coordinator tell of its process, which counts once.
    pub fn cost(&self) -> BTreeMap<String, f64> {
        let mut cost = BTreeMap::new();
        let wall = self.summary["wall_s"].as_f64();
        cost.extend(wall.map(|wall| ("wall_s".to_string(), wall)));
        let participants = self.summary["participants"].as_object();
        let participants = participants.into_iter().flat_map(|all| all.values());
        let mut processes: BTreeMap<(&str, u64), f64> = BTreeMap::new();
        for process in participants.clone().chain([&self.summary["coordinator"]]) {
            for name in ["cpu_s", "peak_rss_bytes"] {
                let Some(number) = process[name].as_f64() else {
                    continue;
                };
                let pid = process["pid"].as_u64().unwrap_or(0);
                let known = processes.entry((name, pid)).or_insert(0.0);
                *known = known.max(number);
            }
        }
        let of_processes = processes
            .into_iter()
            .map(|((name, _), number)| (name.to_string(), number));
        let work = participants.flat_map(|participant| numbers(&participant["work"]));
        for (name, number) in of_processes.chain(work) {
            *cost.entry(name).or_insert(0.0) += number;
        }
        cost
    }
}

/// The numbers of an object, by name.
fn numbers(object: &Value) -> BTreeMap<String, f64> {
    let entries = object.as_object().into_iter().flatten();
    let numbers = entries.filter_map(|(name, value)| Some((name.clone(), value.as_f64()?)));
    numbers.collect()
}
