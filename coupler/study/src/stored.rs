//! A study stored for `run --budget`: `study.json`.

use draw::axis::range;
use kit::student::student;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::collect::Results;
use super::file::{StudyFile, Vary, positive, shipped_or_read, shown_values};
use super::measure::Measure;
use super::plan::Task;
use super::settings::{StudySetting, settings};
use super::statistics::{ErrorPrediction, least_scenes, predict};
use runs::identity::build;
use scenario::error::{Error, Refusal};
use scenario::overrides::{key_of, remove_at, value_at};

/// Name and version of the format.
const SCHEMA: &str = "thirdbody.study/1";

/// File name in the folder of a study.
const STORED: &str = "study.json";

/// Keys that do not change results.
const NO_RESULT: [&str; 7] = [
    "run.name",
    "run.output",
    "run.deadlines",
    "run.transport",
    "run.checkpoint_every_windows",
    "run.checkpoints_kept",
    "run.plausible",
];

/// A study whose runs are finished.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct StoredStudy {
    schema: String,
    /// Its name.
    pub study: String,
    /// Build that ran it.
    pub build: String,
    /// The resolved scenario without the varied keys.
    scenario: String,
    /// Overrides that turn it into the reference.
    pub reference: Vec<String>,
    /// The keys of the scene and their values, scene by scene.
    pub scene_keys: Vec<SceneKey>,
    /// The measures.
    pub measures: Vec<Measure>,
    /// Floors of noise by measure, scene by scene.
    pub floors: Vec<Vec<f64>>,
    /// The settings that are trusted in all scenes, the reference first.
    pub settings: Vec<StoredSetting>,
    /// True if another seed gives the same bits: the errors of one scene then hold for all.
    #[serde(default)]
    pub seedless: bool,
    /// Extrapolated error of the reference itself by measure; empty if it was not extrapolated.
    #[serde(default)]
    pub reference_misses: Vec<f64>,
}

/// A key of the scene.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SceneKey {
    /// The key.
    pub key: String,
    /// True for seeds: any value is covered.
    pub any: bool,
    /// Its value in each scene.
    pub values: Vec<toml::Value>,
}

/// A setting with its errors and costs.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct StoredSetting {
    /// Its values in words.
    pub words: String,
    /// Overrides that turn the scenario into this setting.
    pub set: Vec<String>,
    /// Errors by measure, scene by scene, each at least the floor of noise.
    pub errors: Vec<Vec<f64>>,
    /// Median of the processor times relative to the reference.
    pub cpu_rel: f64,
    /// Median of the wall-clock times (s), on the machine of the study.
    pub wall_s: f64,
    /// Codes of warnings of its runs that the reference does not have; absent in studies of older builds.
    #[serde(default)]
    pub warned: Vec<String>,
}

/// Codes of the warnings of all runs of a setting, without advice.
fn codes(setting: &StudySetting) -> BTreeSet<String> {
    let rows = setting.rows.iter();
    let all = rows.flat_map(|row| row.warnings.split_whitespace());
    all.filter(|code| *code != "advice")
        .map(String::from)
        .collect()
}

/// Says whether `--budget` can use the study once its runs are finished, or why not; `None` without a reference.
pub fn serves_budgets(file: &StudyFile, tasks: &[Task]) -> Option<String> {
    let scenes = 1 + tasks.last()?.scene;
    let varied = |key: &usize| {
        let mut values = tasks.iter().map(|task| &task.values[*key]);
        let vary = &file.vary[*key];
        vary.scene && !vary.is_seed() && values.any(|value| *value != tasks[0].values[*key])
    };
    let numbers = (0..file.vary.len()).filter(varied).count();
    let least = least_scenes(numbers);
    let not = |why: &str| Some(format!("not for `run --budget`: {why}"));
    match &file.reference {
        reference if !reference.is_given() => None,
        reference if reference.set.is_none() => not("its reference is no `set`"),
        reference if reference.perturbed() == 0 => {
            not("reference.perturb is 0, so the floor of noise is unknown")
        }
        _ if scenes < least => not(&format!(
            "{scenes} combinations of its keys with `scene = true` are too few for the bound of an error, which needs {least}; run.seed with scene = true and seeds = {least} provides them"
        )),
        _ => {
            let scene = file.vary.iter().filter(|vary| vary.scene);
            let words = scene.map(|vary| {
                let extent = if vary.is_seed() {
                    "any"
                } else {
                    "the range of"
                };
                format!("{extent} {}", vary.key)
            });
            Some(format!(
                "for `run --budget`: {scenes} scenes ({least} would be enough) for {}; a bound lies {:.1} standard deviations of the logarithm of an error above the median",
                Vec::from_iter(words).join(" and "),
                student(scenes - numbers - 1)
            ))
        }
    }
}

impl SceneKey {
    /// Its values, if all are positive numbers.
    fn numbers(&self) -> Option<Vec<f64>> {
        self.values.iter().map(positive).collect()
    }
}

impl StoredStudy {
    /// Stores a study whose reference is one of its runs and whose runs are all finished; else says why it cannot serve budgets.
    pub fn of(results: &Results) -> Result<StoredStudy, String> {
        let file = results.file;
        if file.reference.set.is_none() {
            return Err("its reference is no run of the study".into());
        }
        if let Some(row) = results.rows.iter().find(|row| row.exit_code.is_none()) {
            return Err(format!("task {} is not done", row.task.index));
        }
        let all = settings(results);
        let first = all.first();
        let reference = first.filter(|first| first.chosen.is_empty() && first.is_trusted());
        let reference = reference.ok_or("a reference did not complete")?;
        let first = reference.rows[0].task;
        let table =
            |task: &Task| -> toml::Table { task.loaded.resolved.parse().unwrap_or_default() };
        let scenes = reference.rows.iter().map(|row| table(row.task));
        let scenes: Vec<toml::Table> = scenes.collect();
        let scene_key = |vary: &Vary| {
            let values = scenes.iter();
            let values = values.map(|scene| value_at(scene, &vary.key).cloned());
            Some(SceneKey {
                key: vary.key.clone(),
                any: vary.is_seed(),
                values: values.collect::<Option<_>>()?,
            })
        };
        let keys = file.vary.iter().filter(|vary| vary.scene);
        let scene_keys: Option<Vec<SceneKey>> = keys.map(scene_key).collect();
        let measures = 0..file.measure.len();
        let floors = |measure: usize| {
            let floors = reference.rows.iter().map(|row| row.floors[measure]);
            floors.collect()
        };
        let floors: Option<Vec<Vec<f64>>> = measures.clone().map(floors).collect();
        let floors = floors.ok_or(
            "its floor of noise is unknown, and no budget can be kept below it: `reference.perturb` must be at least 1, and all perturbed runs must complete",
        )?;
        let usual = codes(reference);
        let stored = |setting: &StudySetting| {
            let errors = measures.clone().map(|measure| setting.errors(measure));
            Some(StoredSetting {
                words: setting.words(results),
                set: last_of_each(setting.rows[0].task.fidelity.as_ref()?),
                errors: errors.collect::<Option<_>>()?,
                cpu_rel: setting.cost_rel("cpu_s")?,
                wall_s: setting.cost("wall_s")?,
                warned: codes(setting).difference(&usual).cloned().collect(),
            })
        };
        let stand = all.iter().filter(|setting| setting.is_trusted());
        let stand = stand.filter_map(|of| Some((of.rows[0].task, stored(of)?)));
        let mut stand: Vec<(&Task, StoredSetting)> = stand.collect();
        let own = first.fidelity.as_deref().unwrap_or_default();
        let sets = stand.iter().flat_map(|(_, setting)| &setting.set);
        let is_table = |set: &&String| {
            let value = set.split_once('=').map(|(_, value)| value.trim_start());
            value.is_some_and(|value| value.starts_with('{'))
        };
        if let Some(set) = sets.chain(own).find(is_table) {
            return Err(format!(
                "`{set}` replaces a whole table, including keys of the scene: give its keys one by one"
            ));
        }
        let scene_keys = scene_keys.ok_or("a key of the scene is a name of cases")?;
        let mut reference = last_of_each(own);
        // A key that only one setting varies has the scene's value in the others.
        let all = stand.iter().flat_map(|(_, setting)| &setting.set);
        let keys = all.chain(&reference).map(|set| key_of(set).to_string());
        let keys: BTreeSet<String> = keys.collect();
        complete(&mut reference, &keys, &table(first));
        for (task, setting) in &mut stand {
            complete(&mut setting.set, &keys, &table(task));
        }
        let mut study = StoredStudy {
            schema: SCHEMA.into(),
            study: file.study.name.clone(),
            build: build().hash.into(),
            scenario: String::new(),
            reference,
            scene_keys,
            measures: file.measure.clone(),
            floors,
            settings: stand.into_iter().map(|(_, setting)| setting).collect(),
            seedless: false,
            reference_misses: Vec::new(),
        };
        let scenario = study.without_varied(table(first));
        study.scenario = toml::to_string(&scenario).unwrap_or_default();
        Ok(study)
    }

    /// Reads a `study.json`, given the file, its folder, or the name of a shipped study.
    ///
    /// # Errors
    /// The file cannot be read, or is no stored study.
    pub fn read(path: &Path) -> Result<StoredStudy, Error> {
        let inside = path.join(STORED);
        let path = if path.is_dir() { &inside } else { path };
        let text = shipped_or_read(path, STORED).map_err(Error::input(path.display()))?;
        StoredStudy::parse(path, &text)
    }

    /// Reads the text of the `study.json` at this path.
    fn parse(path: &Path, text: &str) -> Result<StoredStudy, Error> {
        let refuse = |problem: String| Refusal::file(path, problem);
        let mut study: StoredStudy =
            serde_json::from_str(text).map_err(|error| refuse(error.to_string()))?;
        // Studies of older builds use this name for the pressure alone.
        for of in &mut study.measures {
            if of.name == "traction" && of.of == "profile.pressure_pa" {
                of.name = "pressure".into();
            }
        }
        if study.schema != SCHEMA {
            return Err(refuse(format!("is a {}, not a {SCHEMA}", study.schema)).into());
        }
        let scenes = study.scenes();
        let whole = |rows: &[Vec<f64>]| {
            rows.len() == study.measures.len() && rows.iter().all(|row| row.len() == scenes)
        };
        let mut keys = study.scene_keys.iter();
        let keys = keys.all(|key| key.values.len() == scenes);
        if !(whole(&study.floors) && keys && study.settings.iter().all(|s| whole(&s.errors))) {
            return Err(refuse("has tables that do not fit its scenes and measures".into()).into());
        }
        Ok(study)
    }

    /// Number of scenes.
    fn scenes(&self) -> usize {
        self.floors.first().map_or(0, Vec::len)
    }

    /// The text of study.json.
    pub fn json(&self) -> String {
        serde_json::to_string_pretty(self).expect("plain data always serialises")
    }

    /// A scenario without the keys that a setting or a scene may change, and without keys that do not change results.
    fn without_varied(&self, mut table: toml::Table) -> toml::Table {
        let sets = self.settings.iter().flat_map(|setting| &setting.set);
        let set = sets.chain(&self.reference).map(|set| key_of(set));
        let scene = self.scene_keys.iter().map(|key| key.key.as_str());
        for key in set.chain(scene).chain(NO_RESULT) {
            remove_at(&mut table, key);
        }
        table
    }

    /// Position of a scenario among the scenes of the study: the logarithms of its numbers.
    ///
    /// # Errors
    /// The study does not cover the scenario; the text names the key that differs.
    pub fn locate(&self, resolved: &str) -> Result<Vec<f64>, String> {
        let table: toml::Table = resolved.parse().unwrap_or_default();
        let known: toml::Table = self.scenario.parse().unwrap_or_default();
        let own = shown_values(&self.without_varied(table.clone()));
        let known = shown_values(&known);
        let mut keys = own.keys().chain(known.keys());
        if let Some(key) = keys.find(|key| own.get(*key) != known.get(*key)) {
            let [known, own] =
                [&known, &own].map(|of| of.get(key).cloned().unwrap_or("nothing".into()));
            return Err(format!("it has {key} = {known}, and this scene {own}"));
        }
        let mut position = Vec::new();
        for key in self.scene_keys.iter().filter(|key| !key.any) {
            let own = value_at(&table, &key.key);
            let own = own.ok_or_else(|| format!("this scene has no {}", key.key))?;
            match (positive(own), key.numbers()) {
                (Some(own), Some(known)) => {
                    let [least, most] = range(known.into_iter()).unwrap_or([f64::NAN; 2]);
                    if !(least..=most).contains(&own) {
                        return Err(format!(
                            "it covers {} from {least} to {most}, and this scene has {own}",
                            key.key
                        ));
                    }
                    position.push(own.ln());
                }
                _ if key.values.contains(own) => {}
                _ => return Err(format!("it does not cover {} = {own}", key.key)),
            }
        }
        Ok(position)
    }

    /// The predicted error in a measure (its index) with a setting, for a scene at this position; for the reference, the floor of noise.
    pub fn predict(
        &self,
        setting: &StoredSetting,
        measure: usize,
        position: &[f64],
    ) -> Option<ErrorPrediction> {
        let floor = self.floor(measure);
        let known = |expected, bound| Some(ErrorPrediction { expected, bound });
        if setting.set == self.reference {
            return known(0.0, floor);
        }
        if self.seedless {
            let error = setting.errors[measure].first()?.max(floor);
            return known(error, error);
        }
        let varied = self.scene_keys.iter().filter(|key| !key.any);
        let numbers: Vec<Vec<f64>> = varied.filter_map(SceneKey::numbers).collect();
        let of_scene = |scene: usize| numbers.iter().map(|of| of[scene].ln()).collect();
        let positions: Vec<Vec<f64>> = (0..self.scenes()).map(of_scene).collect();
        let found = predict(&positions, &setting.errors[measure], position)?;
        known(found.expected, found.bound.max(floor))
    }

    /// The floor of noise of a measure: the largest over its scenes.
    pub fn floor(&self, measure: usize) -> f64 {
        self.floors[measure].iter().copied().fold(0.0, f64::max)
    }
}

/// Adds overrides for the keys without one, with their values in the scenario.
fn complete(set: &mut Vec<String>, keys: &BTreeSet<String>, scenario: &toml::Table) {
    for key in keys {
        let is_missing = !set.iter().any(|set| key_of(set) == key);
        let value = value_at(scenario, key).filter(|_| is_missing);
        set.extend(value.map(|value| format!("{key}={value}")));
    }
}

/// Overrides without those that a later override of the same key replaces.
fn last_of_each(sets: &[String]) -> Vec<String> {
    let is_last = |(k, set): &(usize, &String)| {
        let mut later = sets[k + 1..].iter();
        later.all(|later| key_of(later) != key_of(set))
    };
    let kept = sets.iter().enumerate().filter(is_last);
    kept.map(|(_, set)| set.clone()).collect()
}

/// The stored studies in `runs/study-*`, then the shipped studies, with the names of their files; a folder in `scenarios/studies` takes
/// precedence over the built-in study. Each study is read on demand.
pub fn known() -> impl Iterator<Item = Result<(PathBuf, StoredStudy), Error>> {
    let folders = ["runs", "scenarios/studies"];
    let entries = folders.iter().flat_map(std::fs::read_dir).flatten();
    let files = entries.flatten().map(|entry| entry.path().join(STORED));
    let mut files: Vec<PathBuf> = files.filter(|file| file.is_file()).collect();
    files.sort();
    let here = files.clone();
    let is_new = move |path: &str| !here.contains(&Path::new("scenarios").join(path));
    let shipped = scenes::of_studies(STORED).filter(move |(path, _)| is_new(path));
    let shipped = shipped.map(|(path, text)| {
        let path = PathBuf::from(format!("{path} (built in)"));
        StoredStudy::parse(&path, text).map(|study| (path, study))
    });
    let read = |file: PathBuf| StoredStudy::read(&file).map(|study| (file, study));
    files.into_iter().map(read).chain(shipped)
}
