//! The plan of a study: its tasks, each with its own scenario.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::file::{self, KeyValue, MOST_RUNS, Mode, Small, StudyFile, Vary, shown};
use super::knobs::shipped;
use runs::curve::evenly;
use runs::identity::build;
use scenario::error::{Error, Refusal};
use scenario::keys::Scenario;
use scenario::load::{Loaded, load};
use scenario::overrides::{key_of, remove_at, value_at};
use scenes::{STUDY, kept, stands_alone};

/// Role of a task in its study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TaskRole {
    /// The others are compared with it.
    Reference,
    /// The reference with grains, or nodes, displaced by a tiny amount; the number is the seed of the displacements.
    Perturbed(u64),
    /// A measured run.
    Point,
}

impl TaskRole {
    /// The role in a word.
    pub fn word(self) -> String {
        match self {
            TaskRole::Reference => "reference".into(),
            TaskRole::Perturbed(seed) => format!("perturbed-{seed}"),
            TaskRole::Point => "point".into(),
        }
    }
}

/// The chosen value of each key.
type Point = Vec<Option<KeyValue>>;

/// A run of the study before its scenario is read.
#[derive(Clone, Debug, PartialEq)]
struct Entry {
    role: TaskRole,
    /// Index of its combination of scene keys.
    scene: usize,
    /// The chosen value of each key, in the order of the study.
    choices: Point,
    scenario: String,
    set: Vec<String>,
    /// The part of `set` that belongs neither to the scene nor to all runs; `None` with its own scenario.
    fidelity: Option<Vec<String>>,
}

/// A run of the study.
#[derive(Clone, Debug)]
pub struct Task {
    /// Row of results.csv.
    pub index: usize,
    /// Its role.
    pub role: TaskRole,
    /// Index of its combination of scene keys.
    pub scene: usize,
    /// Value of each key, in the order of the study; a key that is not varied has the scenario's value. Empty for a name of cases without a
    /// chosen case, and for a key that the scenario does not give.
    pub values: Vec<String>,
    /// True for the keys that this task varies.
    pub varied: Vec<bool>,
    /// Overrides that turn the scenario of the study into this setting, for any scene; `None` for another scenario.
    pub fidelity: Option<Vec<String>>,
    /// The scenario.
    pub loaded: Loaded,
    /// True if exchange log and checkpoints are kept after the run.
    pub keep_logs: bool,
    /// Hash of scenario and build: tasks with the same hash are the same run.
    pub id: String,
}

/// All runs of a study.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The study.
    pub file: StudyFile,
    /// The study file.
    pub path: PathBuf,
    /// Its folder.
    pub beside: PathBuf,
    /// True for the small study.
    pub is_small: bool,
    /// Further overrides of all runs.
    pub set: Vec<String>,
    entries: Vec<Entry>,
}

impl Plan {
    /// Plans a study, in its small form if `is_small`, with further overrides of all runs. It reads only the scenario of the reference.
    ///
    /// # Errors
    /// The study or the scenario of its reference is refused.
    pub fn read(path: &Path, is_small: bool, set: &[String]) -> Result<Plan, Error> {
        let path = &StudyFile::locate(path);
        let file = StudyFile::read(path)?;
        let beside = beside(path)?;
        let small = if is_small {
            file.small.clone()
        } else {
            Small::default()
        };
        let common = [&file.study.set[..], &small.set, set].concat();
        let varied = |set: &&String| {
            let mut keys = file.vary.iter().filter(|vary| vary.case.is_none());
            keys.any(|vary| vary.key == key_of(set))
        };
        if let Some(set) = common.iter().find(varied) {
            let why = format!(
                "`{set}` has no effect: the study varies this key; remove the override, or the key from [[vary]]"
            );
            return Err(Refusal::file(path, why).into());
        }
        let axes = axes(&file, &small).map_err(|why| Refusal::file(path, why))?;
        let count = count(&file, &axes);
        if count > MOST_RUNS as f64 {
            let why = format!(
                "plans {count} runs, and a study has at most {MOST_RUNS}: give its keys fewer values, or `mode = \"one-at-a-time\"`"
            );
            return Err(Refusal::file(path, why).into());
        }
        let scenario = found(&beside, &file.study.scenario);
        let reference = file.reference.set.as_deref();
        let perturbations = match (reference, file.reference.perturbed()) {
            (Some(set), count @ 1..) => {
                let loaded = load(&scenario, &[&common[..], set].concat())?;
                perturbations(count, &loaded, path)?
            }
            _ => Vec::new(),
        };
        let base = reference.filter(|_| file.study.mode == Mode::OneAtATime);
        let scenes = combined(&axes, &vec![None; axes.len()], |k| file.vary[k].scene);
        let mut entries = Vec::new();
        for (scene, of_scene) in scenes.into_iter().enumerate() {
            let entry = |role: TaskRole, own: &[String], choices: Point| {
                let mut chosen = choices.iter().flatten();
                let other = chosen.find_map(|choice| choice.scenario.as_deref());
                let sets = |scene: bool| -> Vec<String> {
                    let chosen = file.vary.iter().zip(&choices);
                    let chosen = chosen.filter(|(vary, _)| vary.scene == scene);
                    let chosen = chosen.filter_map(|(_, choice)| choice.as_ref());
                    chosen.flat_map(|choice| choice.set.clone()).collect()
                };
                let (base, own) = match other {
                    Some(_) => (&[][..], &[][..]),
                    None => (&common[..], own),
                };
                let fidelity = [own, &sets(false)].concat();
                Entry {
                    role,
                    scene,
                    scenario: other.map_or(scenario.clone(), |name| found(&beside, name)),
                    set: [base, &sets(true), &fidelity].concat(),
                    fidelity: other.is_none().then_some(fidelity),
                    choices,
                }
            };
            if let Some(set) = reference {
                entries.push(entry(TaskRole::Reference, set, of_scene.clone()));
                for (seed, perturbed) in (1..).zip(&perturbations) {
                    let set = [set, perturbed].concat();
                    entries.push(entry(TaskRole::Perturbed(seed), &set, of_scene.clone()));
                }
            }
            let points = points(&file, &axes, &of_scene).into_iter();
            let base = base.unwrap_or_default();
            entries.extend(points.map(|point| entry(TaskRole::Point, base, point)));
        }
        Ok(Plan {
            path: path.clone(),
            set: set.to_vec(),
            file,
            beside,
            is_small,
            entries,
        })
    }

    /// Number of its tasks.
    pub fn task_count(&self) -> usize {
        self.entries.len()
    }

    /// A task; `None` beyond the last one.
    ///
    /// # Errors
    /// Its scenario is refused.
    pub fn task(&self, index: usize) -> Result<Option<Task>, Error> {
        let entry = self.entries.get(index);
        entry.map(|entry| self.read_task(index, entry)).transpose()
    }

    fn read_task(&self, index: usize, entry: &Entry) -> Result<Task, Error> {
        let loaded = load(&entry.scenario, &entry.set)?;
        let table: toml::Table = loaded.resolved.parse().unwrap_or_default();
        let value = |(vary, choice): (&Vary, &Option<KeyValue>)| {
            let own = value_at(&table, &vary.key).filter(|_| vary.case.is_none());
            let chosen = choice.as_ref().map(|choice| choice.text.clone());
            chosen.or(own.map(shown)).unwrap_or_default()
        };
        let values = self.file.vary.iter().zip(&entry.choices).map(value);
        Ok(Task {
            index,
            role: entry.role,
            scene: entry.scene,
            values: values.collect(),
            varied: entry.choices.iter().map(Option::is_some).collect(),
            fidelity: entry.fidelity.clone(),
            keep_logs: self.file.study.keep_logs,
            id: run_id(&loaded),
            loaded,
        })
    }

    /// All tasks: for each combination of scene keys the reference, if it is a run of this study, its perturbed references, and the points.
    ///
    /// # Errors
    /// A scenario is refused.
    pub fn tasks(&self) -> Result<Vec<Task>, Error> {
        let all = self.entries.iter().enumerate();
        all.map(|(index, entry)| self.read_task(index, entry))
            .collect()
    }
}

/// Hash of scenario and build: two runs with the same hash are the same.
pub fn run_id(loaded: &Loaded) -> String {
    // The scenario's own hash covers only the names of its input files.
    let inputs = loaded.inputs();
    let (scene, build) = (&loaded.hash, build().hash);
    let hash = blake3::hash(format!("{scene} {build} {inputs:?}").as_bytes());
    hash.to_hex()[..16].to_string()
}

/// Hash of a scene, the same for any seed.
pub fn scene_id(loaded: &Loaded) -> String {
    let mut table: toml::Table = loaded.resolved.parse().unwrap_or_default();
    remove_at(&mut table, "run.seed");
    blake3::hash(table.to_string().as_bytes()).to_hex()[..8].to_string()
}

/// The first task of each run: the runs to do.
pub fn runs(tasks: &[Task]) -> Vec<&Task> {
    let mut seen = BTreeSet::new();
    tasks.iter().filter(|task| seen.insert(&task.id)).collect()
}

/// The folder of a study. A shipped study whose scenarios are files beside it is unpacked.
fn beside(path: &Path) -> Result<PathBuf, Error> {
    let with_files = |(_, folder): &(&str, String)| !stands_alone(&format!("{folder}/{STUDY}"));
    match file::shipped(path).filter(with_files) {
        Some((name, folder)) => Ok(kept::all(name)?.join(folder)),
        None => Ok(path.parent().unwrap_or(Path::new("")).to_path_buf()),
    }
}

/// A scenario beside the study or up to two folders above, because shipped studies lie below the scenes; or a name for `run`.
fn found(beside: &Path, scenario: &str) -> String {
    let above = beside.ancestors().take(3);
    let mut above = above.map(|folder| folder.join(scenario));
    let own = above.find(|path| path.is_file() || path.join("scenario.toml").is_file());
    own.map_or(scenario.to_string(), |path| path.display().to_string())
}

/// Kinds of shipped solvers with `perturb_seed`, grains before nodes.
const PERTURBED_KINDS: [&str; 2] = ["dem", "fem"];

/// The participants that perturbed references perturb: those with grains, or else those with nodes.
pub fn perturbed_participants(scenario: &Scenario) -> Vec<&str> {
    let all = PERTURBED_KINDS.map(|kind| Vec::from_iter(shipped(scenario, kind)));
    let first = all.into_iter().find(|names| !names.is_empty());
    first.unwrap_or_default()
}

/// Overrides of each perturbed reference.
fn perturbations(count: u64, loaded: &Loaded, path: &Path) -> Result<Vec<Vec<String>>, Error> {
    let names = perturbed_participants(&loaded.scenario);
    if names.is_empty() {
        let why = "reference.perturb: no participant of the scenario is a shipped solver, so none can be perturbed; write perturb = 0 to do without a floor of noise";
        return Err(Refusal::file(path, why).into());
    }
    let key = |name: &&str, seed: u64| format!("participant.{name}.config.perturb_seed={seed}");
    let of_seed = |seed| names.iter().map(|name| key(name, seed)).collect();
    Ok((1..=count).map(of_seed).collect())
}

/// The values of each key, limited for a small study.
fn axes(file: &StudyFile, small: &Small) -> Result<Vec<Vec<KeyValue>>, String> {
    let axis = |vary: &Vary| {
        let values = vary.choices()?;
        Ok(match (vary.scene, small.scenes) {
            (true, Some(most)) => values.into_iter().take(most.max(1)).collect(),
            (true, None) => values,
            (false, _) => thinned(&values, small.limit),
        })
    };
    file.vary.iter().map(axis).collect()
}

/// Number of tasks of a study whose keys have these values.
fn count(file: &StudyFile, axes: &[Vec<KeyValue>]) -> f64 {
    let lengths = |scene: bool| {
        let of = file.vary.iter().zip(axes);
        let of = of.filter(move |(vary, _)| vary.scene == scene);
        of.map(|(_, axis)| axis.len() as f64)
    };
    let points: f64 = match file.study.mode {
        Mode::Grid => lengths(false).product(),
        Mode::OneAtATime => lengths(false).sum(),
    };
    let references = match file.reference.set {
        Some(_) => 1.0 + file.reference.perturbed() as f64,
        None => 0.0,
    };
    lengths(true).product::<f64>() * (points + references)
}

/// At most `limit` values: the first, the last, and some between.
fn thinned<T: Clone>(axis: &[T], limit: Option<usize>) -> Vec<T> {
    let count = limit.map_or(axis.len(), |limit| limit.max(1));
    let kept = evenly(count, axis.len());
    kept.iter().map(|k| axis[*k].clone()).collect()
}

/// All combinations of the keys that `takes` accepts, the last changing first; the others stay as in `start`.
fn combined(
    axes: &[Vec<KeyValue>],
    start: &[Option<KeyValue>],
    takes: impl Fn(usize) -> bool,
) -> Vec<Point> {
    let mut points = vec![start.to_vec()];
    for (k, axis) in axes.iter().enumerate().filter(|(k, _)| takes(*k)) {
        let longer = points.iter().flat_map(|point| {
            axis.iter().map(move |choice| {
                let mut point = point.clone();
                point[k] = Some(choice.clone());
                point
            })
        });
        points = longer.collect();
    }
    points
}

/// The points of a scene.
fn points(file: &StudyFile, axes: &[Vec<KeyValue>], scene: &[Option<KeyValue>]) -> Vec<Point> {
    let is_varied = |k: usize| !file.vary[k].scene;
    let alone = |k| combined(axes, scene, |own| own == k);
    let varied = (0..axes.len()).filter(|k| is_varied(*k));
    match file.study.mode {
        Mode::Grid => combined(axes, scene, is_varied),
        Mode::OneAtATime => varied.flat_map(alone).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "[study]\nname = \"s\"\nscenario = \"quick\"\n[reference]\nset = []\n[[measure]]\nname = \"m\"\nof = \"results.approach_m\"\nnorm = \"at\"\n";

    /// Values of the points of a study, in words.
    fn points_in_words(mode: Mode) -> Vec<String> {
        let keys = "[[vary]]\nkey = \"run.seed\"\nscene = true\nseeds = 2\n[[vary]]\nkey = \"a\"\nvalues = [1, 2]\n[[vary]]\nkey = \"b\"\nvalues = [\"x\", \"y\"]\n";
        let mut file = StudyFile::parse(&format!("{HEAD}{keys}")).expect("a study");
        let axes: Vec<Vec<KeyValue>> = file
            .vary
            .iter()
            .map(|vary| vary.choices().expect("values"))
            .collect();
        file.study.mode = mode;
        let scenes = combined(&axes, &vec![None; axes.len()], |k| file.vary[k].scene);
        let points = scenes.iter().flat_map(|scene| points(&file, &axes, scene));
        let in_words = points.map(|point| {
            let words = point.iter().map(|c| c.as_ref().map_or("-", |c| &c.text));
            words.collect::<Vec<&str>>().join(" ")
        });
        in_words.collect()
    }

    #[test]
    fn a_grid_has_all_combinations_and_the_other_mode_each_value() {
        let grid = points_in_words(Mode::Grid);
        let first = ["1 1 x", "1 1 y", "1 2 x", "1 2 y", "2 1 x"];
        assert_eq!((&grid[..5], grid.len()), (&first.map(String::from)[..], 8));
        let single = points_in_words(Mode::OneAtATime);
        let first = ["1 1 -", "1 2 -", "1 - x", "1 - y", "2 1 -"];
        assert_eq!(
            (&single[..5], single.len()),
            (&first.map(String::from)[..], 8)
        );
    }

    #[test]
    fn a_shipped_study_finds_the_scenarios_beside_it() {
        let scratch = kit::scratch::Scratch::new("shipped-study", 1);
        kept::keep_below(Some(scratch.path().into()));
        let plan = Plan::read(Path::new("creep-curve"), true, &[]).expect("it is shipped");
        let names = plan.tasks().expect("its scenarios are valid").into_iter();
        let names: BTreeSet<String> = names.map(|task| task.loaded.scenario.run.name).collect();
        assert!(
            names.contains("creep-clean") && names.contains("creep-layer"),
            "{names:?}"
        );
    }

    #[test]
    fn a_thinned_axis_keeps_its_ends() {
        let all = vec![1, 2, 3, 4, 5];
        assert_eq!(thinned(&all, Some(3)), [1, 3, 5]);
        assert_eq!(thinned(&all, Some(2)), [1, 5]);
        assert_eq!(thinned(&all, Some(1)), [1]);
        assert_eq!(thinned(&all, None), all);
    }
}
