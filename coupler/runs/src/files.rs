//! The files of a run in its directory.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::fields::{Arrays, flags, numbers, read};
use super::scene::Setup;
use super::table::Table;
use crate::written::Written;
use scenario::content::{content_hash, contents};
use scenario::error::{Code, Error, Refusal};
use scenario::load::CHANGED_KEY;
use scenario::overrides::Changes;

/// Files of a run directory.
#[derive(Clone, Debug, Default)]
pub struct RunFiles {
    /// The directory.
    pub path: PathBuf,
    /// summary.json.
    pub summary: Value,
    /// signals.csv; empty if nothing was reported.
    pub signals: Table,
    /// profile.csv, if it exists.
    pub profile: Option<Table>,
}

/// A moment at which all participants wrote their fields.
#[derive(Clone, Debug)]
pub struct MarkedMoment {
    /// Its name in the files.
    pub name: String,
    /// Its name in captions, after `at the`.
    pub words: String,
}

impl RunFiles {
    /// Reads a run that has ended.
    ///
    /// # Errors
    /// There is no summary.json, as the run continues or was killed; or a table differs from what the run wrote.
    pub fn read(run: &Path) -> Result<RunFiles, Error> {
        let mut found = RunFiles {
            path: run.to_path_buf(),
            summary: read_summary(run)?,
            ..RunFiles::default()
        };
        found.damage().map_or(Ok(()), Err)?;
        found.signals = Table::read(&run.join("signals.csv"))?.unwrap_or_default();
        found.profile = Table::read(&run.join("profile.csv"))?;
        Ok(found)
    }

    /// The first table that differs from what the run wrote, by `tables` of summary.json, which runs of older builds
    /// lack.
    pub fn damage(&self) -> Option<Error> {
        let problem = |(name, written): (&String, &Value)| {
            let path = self.path.join(name);
            let written: Written = serde_json::from_value(written.clone()).ok()?;
            let [found, due] = [
                contents(&path).map(|text| Written::of(&text)),
                Some(written),
            ];
            match found.as_ref().zip(due.as_ref()) {
                Some((found, due)) if found.rows != due.rows => {
                    let (rows, due) = (found.rows, due.rows);
                    Some(damaged(
                        &path,
                        &format!("has {rows} rows, but the run wrote {due}"),
                    ))
                }
                _ => differs(&path, found, due, ""),
            }
        };
        let mut tables = self.entries("tables");
        tables.find_map(problem).or_else(|| self.scenario_damage())
    }

    /// A scenario.toml that is not the run's, by `hashes.scenario` of summary.json.
    fn scenario_damage(&self) -> Option<Error> {
        let path = self.path.join("scenario.toml");
        let hash = self.hash("scenario").filter(|hash| !hash.is_empty())?;
        differs(&path, content_hash(&path).as_deref(), Some(hash), "")
    }

    /// The first field file that differs from what the run wrote, by `fields.blake3` of summary.json.
    pub fn field_damage(&self) -> Option<Error> {
        let hashes = self.summary["fields"]["blake3"].as_object()?;
        let problem = |(name, hash): (&String, &Value)| {
            let (path, shown) = (
                self.path.join(name),
                ", and pictures show its present content",
            );
            differs(&path, content_hash(&path).as_deref(), hash.as_str(), shown)
        };
        hashes.iter().find_map(problem)
    }

    /// Reads a run that has ended, with the readable part of its tables.
    ///
    /// # Errors
    /// summary.json is missing or damaged.
    pub fn read_for_page(run: &Path) -> Result<RunFiles, Error> {
        Ok(RunFiles {
            summary: read_summary(run)?,
            ..RunFiles::read_what_is_there(run)
        })
    }

    /// Reads the readable part of a run that may have been killed.
    pub fn read_what_is_there(run: &Path) -> RunFiles {
        let profile = run.join("profile.csv");
        RunFiles {
            path: run.to_path_buf(),
            summary: read_json(&run.join("summary.json")),
            signals: Table::read_whole_rows(&run.join("signals.csv")),
            profile: profile.exists().then(|| Table::read_whole_rows(&profile)),
        }
    }

    /// manifest.json; null if it cannot be read.
    pub fn manifest(&self) -> Value {
        read_json(&self.path.join("manifest.json"))
    }

    /// The keys that were overridden, or in which the scenario differs from the shipped scene of which it is a copy:
    /// each with its value there, and its own value.
    pub fn changed(&self) -> Changes {
        serde_json::from_value(self.manifest()[CHANGED_KEY].clone()).unwrap_or_default()
    }

    /// The keys of its scenario; empty if it cannot be read.
    pub fn scenario_table(&self) -> toml::Table {
        let text = std::fs::read_to_string(self.path.join("scenario.toml"));
        text.unwrap_or_default().parse().unwrap_or_default()
    }

    /// Its own copy of its scenario.
    pub fn scenario(&self) -> Setup {
        Setup::from(&self.scenario_table())
    }

    /// A text of the summary, such as its `status`.
    pub fn text(&self, key: &str) -> &str {
        self.summary[key].as_str().unwrap_or_default()
    }

    /// A number of the summary, by its path: `coupling.gap_max_rel`.
    pub fn number(&self, path: &str) -> Option<f64> {
        let mut keys = path.split('.');
        keys.try_fold(&self.summary, |at, key| at.get(key))?
            .as_f64()
    }

    /// Names and entries of an object of the summary.
    pub fn entries(&self, key: &str) -> impl Iterator<Item = (&String, &Value)> {
        self.summary[key].as_object().into_iter().flatten()
    }

    /// The entries of a list of the summary.
    pub fn list(&self, key: &str) -> impl DoubleEndedIterator<Item = &Value> {
        self.summary[key].as_array().into_iter().flatten()
    }

    /// The results, by name.
    pub fn results(&self) -> BTreeMap<String, f64> {
        numbers_of(&self.summary["results"])
    }

    /// A hash of the summary.
    pub fn hash(&self, name: &str) -> Option<&str> {
        self.summary["hashes"][name].as_str()
    }

    /// Costs by name: wall-clock time, processor time and memory of all processes, and the work of all participants,
    /// each kind summed. Participants in threads of the coordinator report the numbers of its process, which counts
    /// once.
    pub fn cost(&self) -> BTreeMap<String, f64> {
        let mut cost = BTreeMap::new();
        cost.extend(self.number("wall_s").map(|wall| ("wall_s".into(), wall)));
        let participants = || self.entries("participants").map(|(_, of)| of);
        let mut processes: BTreeMap<(&str, u64), f64> = BTreeMap::new();
        for process in participants().chain([&self.summary["coordinator"]]) {
            for name in ["cpu_s", "peak_rss_bytes"] {
                let Some(number) = process[name].as_f64() else {
                    continue;
                };
                let pid = process["pid"].as_u64().unwrap_or(0);
                let known = processes.entry((name, pid)).or_insert(0.0);
                *known = known.max(number);
            }
        }
        let of_processes = processes.into_iter();
        let of_processes = of_processes.map(|((name, _), number)| (name.to_string(), number));
        let work = participants().flat_map(|participant| numbers_of(&participant["work"]));
        for (name, number) in of_processes.chain(work) {
            *cost.entry(name).or_insert(0.0) += number;
        }
        cost
    }

    /// Names of the phases of the load, in their order.
    pub fn phases(&self) -> Vec<&str> {
        let phases = self.list("phases");
        phases.filter_map(|phase| phase["name"].as_str()).collect()
    }

    /// The moments that the participants marked for a picture, then the end of the run.
    pub fn moments(&self) -> Vec<MarkedMoment> {
        let marked = self.list("phases").filter(|phase| phase["picture"] == true);
        let names = marked.filter_map(|phase| phase["name"].as_str());
        let all = names.map(|name| (name, name)).chain([("end", "run")]);
        let moment = |(name, of): (&str, &str)| MarkedMoment {
            name: name.into(),
            words: format!("end of the {of}"),
        };
        all.map(moment).collect()
    }

    /// The field files with this ending, in the order of their names.
    pub fn field_files(&self, ending: &str) -> Vec<PathBuf> {
        let entries = std::fs::read_dir(self.path.join("fields")).into_iter();
        let paths = entries.flatten().flatten().map(|entry| entry.path());
        let paths = paths.filter(|path| path.to_string_lossy().ends_with(ending));
        let mut paths: Vec<PathBuf> = paths.collect();
        paths.sort();
        paths
    }

    /// The fields of the first participant, by file name, that wrote a file with this ending at this moment: `.vtu`,
    /// `.vtp`, `-contacts.vtp`.
    pub fn fields(&self, moment: &str, ending: &str) -> Result<Option<Arrays>, Error> {
        let paths = self.field_files(&format!("-{moment}{ending}"));
        paths.first().map(|path| read(path)).transpose()
    }

    /// The fields of each participant that wrote a file with this ending at this moment, in the order of their names.
    pub fn all_fields(&self, moment: &str, ending: &str) -> Result<Vec<(String, Arrays)>, Error> {
        let ending = format!("-{moment}{ending}");
        let of = |path: &PathBuf| {
            let file = path.file_name()?.to_str()?;
            Some((file.strip_suffix(&ending)?.to_string(), path.clone()))
        };
        let mut named: Vec<_> = self.field_files(&ending).iter().filter_map(of).collect();
        named.sort();
        let fields = |(name, path): (String, PathBuf)| Ok((name, read(&path)?));
        named.into_iter().map(fields).collect()
    }

    /// The first of these moments with a file of this ending, and its fields.
    pub fn fields_among(
        &self,
        moments: impl IntoIterator<Item = MarkedMoment>,
        ending: &str,
    ) -> Result<Option<(MarkedMoment, Arrays)>, Error> {
        for moment in moments {
            if let Some(arrays) = self.fields(&moment.name, ending)? {
                return Ok(Some((moment, arrays)));
            }
        }
        Ok(None)
    }

    /// Mean radius of the freely moving grains at the first moment with grains (m).
    pub fn mean_radius_m(&self) -> Result<Option<f64>, Error> {
        let Some((_, arrays)) = self.fields_among(self.moments(), ".vtp")? else {
            return Ok(None);
        };
        let bound = ["glued", "wheel"].map(|name| flags(&arrays, name));
        let radii = numbers(&arrays, "radius_m").iter().enumerate();
        let is = |flags: &Vec<bool>, k: usize| flags.get(k) == Some(&true);
        let free = radii.filter(|(k, r)| **r > 0.0 && !bound.iter().any(|flags| is(flags, *k)));
        let (sum, count) = free.fold((0.0, 0), |(sum, count), (_, r)| (sum + r, count + 1));
        Ok((count > 0).then(|| sum / f64::from(count)))
    }
}

/// The error for a file whose content, if it can be read, is not the one that the run wrote; `shown` adds to the reason.
fn differs<T: PartialEq>(
    path: &Path,
    found: Option<T>,
    due: Option<T>,
    shown: &str,
) -> Option<Error> {
    match found {
        None => Some(damaged(path, "cannot be read, although the run wrote it")),
        found if found == due => None,
        _ => Some(damaged(
            path,
            &format!("was changed since the run wrote it{shown}"),
        )),
    }
}

fn damaged(path: &Path, why: &str) -> Error {
    let text = format!("{}: {why}", path.display());
    Refusal::other(Code::TableDamaged, text).into()
}

fn read_summary(run: &Path) -> Result<Value, Error> {
    let path = run.join("summary.json");
    if !path.exists() {
        let begun = run.join("manifest.json").exists();
        let problem = match (begun, run.is_dir()) {
            (true, _) => {
                "is missing: the run is still running, or was killed (`thirdbody resume` continues it)"
            }
            (_, true) => "is not a run directory: it has neither summary.json nor manifest.json",
            _ if run.exists() => "is a file: give the run directory, for instance runs/latest",
            _ => "there is no such folder: give a run directory, for instance runs/latest",
        };
        let place = if begun { &path } else { run };
        return Err(Refusal::file(place, problem).into());
    }
    let text = std::fs::read_to_string(&path).map_err(Error::input(path.display()))?;
    let summary: Value = serde_json::from_str(&text)
        .map_err(|error| Error::from(Refusal::file(&path, error.to_string())))?;
    if !summary["status"].is_string() {
        let problem = "is no summary of a run: it has no status";
        return Err(Refusal::file(path, problem).into());
    }
    Ok(summary)
}

/// The content of a JSON file; null if it cannot be read.
pub fn read_json(path: &Path) -> Value {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    serde_json::from_str(&text).unwrap_or_default()
}

/// The numbers of an object, by name.
fn numbers_of(object: &Value) -> BTreeMap<String, f64> {
    let entries = object.as_object().into_iter().flatten();
    let numbers = entries.filter_map(|(name, value)| Some((name.clone(), value.as_f64()?)));
    numbers.collect()
}
