//! A run as the report reads it: its files and tables.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::fields::{numbers, read_first};
use crate::columns::{Columns, read_csv};
use coordinator::error::{Error, Refusal};
use coordinator::scenario::Scenario;
use coordinator::scenario::load::load;

/// Files and tables of a run directory.
#[derive(Clone, Debug, Default)]
pub struct RunFiles {
    /// The directory.
    pub path: PathBuf,
    /// summary.json.
    pub summary: Value,
    /// manifest.json; null where there is none.
    pub manifest: Value,
    /// Its resolved scenario; none where it cannot be read any more.
    pub scenario: Option<Scenario>,
    /// signals.csv.
    pub signals: Columns,
    /// profile.csv.
    pub profile: Columns,
    /// The moments that the participants marked for a picture, then the end of the run.
    pub moments: Vec<Moment>,
    /// Names of the phases of the load, in their order.
    pub phases: Vec<String>,
    /// Mean radius of the grains that move freely (m), where there are some.
    pub mean_radius_m: Option<f64>,
}

/// A moment at which all participants wrote their fields.
#[derive(Clone, Debug)]
pub struct Moment {
    /// Its name in the files.
    pub name: String,
    /// Its name in captions, to follow `at the`.
    pub words: String,
}

impl RunFiles {
    /// Reads a run directory.
    ///
    /// # Errors
    /// summary.json is missing or damaged. Anything else that is missing is left out of the report.
    pub fn read(path: &Path) -> Result<RunFiles, Error> {
        let summary = read_summary(path)?;
        let manifest = std::fs::read_to_string(path.join("manifest.json")).unwrap_or_default();
        let scenario = load(&path.join("scenario.toml").display().to_string(), &[]);
        let moments = moments(&summary);
        Ok(RunFiles {
            path: path.to_path_buf(),
            mean_radius_m: mean_radius(path, &moments)?,
            moments,
            phases: phases(&summary),
            summary,
            manifest: serde_json::from_str(&manifest).unwrap_or_default(),
            scenario: scenario.ok().map(|loaded| loaded.scenario),
            signals: read_csv(&path.join("signals.csv")),
            profile: read_csv(&path.join("profile.csv")),
        })
    }

    /// A text of the summary.
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
}

fn read_summary(run: &Path) -> Result<Value, Error> {
    let path = run.join("summary.json");
    if run.is_dir() && !path.exists() {
        let problem =
            "is missing: the run goes on, or was killed (`thirdbody resume` goes on with it)";
        return Err(Refusal::file(path, problem).into());
    }
    let text = std::fs::read_to_string(&path).map_err(Error::input(path.display()))?;
    serde_json::from_str(&text).map_err(|error| Refusal::file(path, error.to_string()).into())
}

/// Mean radius at the first of the moments that has grains.
fn mean_radius(run: &Path, moments: &[Moment]) -> Result<Option<f64>, Error> {
    for moment in moments {
        let Some(arrays) = read_first(run, &moment.name, "vtp")? else {
            continue;
        };
        let (glued, wheel) = (numbers(&arrays, "glued"), numbers(&arrays, "wheel"));
        let marked = |flags: &[f64], k: usize| flags.get(k).is_some_and(|flag| *flag > 0.0);
        let radii = numbers(&arrays, "radius_m").iter().enumerate();
        let free = radii.filter(|(k, r)| **r > 0.0 && !marked(glued, *k) && !marked(wheel, *k));
        let (sum, count) = free.fold((0.0, 0), |(sum, count), (_, r)| (sum + r, count + 1));
        return Ok((count > 0).then(|| sum / f64::from(count)));
    }
    Ok(None)
}

fn moments(summary: &Value) -> Vec<Moment> {
    let phases = summary["phases"].as_array().into_iter().flatten();
    let marked = phases.filter(|phase| phase["picture"] == true);
    let names = marked.filter_map(|phase| phase["name"].as_str());
    let all = names.map(|name| (name, name)).chain([("end", "run")]);
    let moment = |(name, of): (&str, &str)| Moment {
        name: name.into(),
        words: format!("end of the {of}"),
    };
    all.map(moment).collect()
}

fn phases(summary: &Value) -> Vec<String> {
    let all = summary["phases"].as_array().into_iter().flatten();
    let names = all.filter_map(|phase| phase["name"].as_str());
    names.map(String::from).collect()
}
