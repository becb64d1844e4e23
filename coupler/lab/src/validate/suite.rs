//! Running the cases of a folder of scenes.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::Duration;

use serde::Serialize;
use serde_json::{Value, json};

use super::case::{Basis, Number, SuiteCase, Take, read};
use coordinator::run::session::RunOptions;
use protocol::larger;
use runs::curve::median;
use runs::files::RunFiles;
use scenario::error::{Error, Refusal};
use scenario::load::load;
use study::plan::run_id;
use study::task::{TaskFolder, TaskOutcome, TaskStage};
use terminal::tell_progress;

/// Interval of checks of a run in another process.
const LOOK: Duration = Duration::from_secs(1);

/// One line of the table.
#[derive(Clone, Debug, Default, Serialize)]
pub struct CaseRow {
    /// Scene, case and number.
    pub name: String,
    /// The value of the run; the median with several seeds.
    pub ours: Value,
    /// Smallest and largest value over several seeds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seeds: Option<[f64; 2]>,
    /// The expected value.
    pub expected: Value,
    /// Published value, if another value is expected.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub published: Option<f64>,
    /// Predicted or calibrated, for a published value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub basis: Option<Basis>,
    /// Source of the expectation.
    pub source: String,
    /// True if it is close enough for every seed; a number that is only reported holds.
    pub holds: bool,
    /// True for a number that is reported but not judged.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub reported: bool,
}

/// A case that ran.
pub struct CaseOutcome {
    /// Scene and case.
    pub name: String,
    /// Folder of its scenario.
    pub scenario: PathBuf,
    /// The case.
    pub case: SuiteCase,
    /// Text of its file above all cases, for the first case.
    pub above: String,
    /// Its rows.
    pub rows: Vec<CaseRow>,
    /// Its runs that reached the end, one per seed.
    pub runs: Vec<Held>,
}

/// Options of the runs of a suite.
pub struct SuiteOptions<'a> {
    /// Options of each run, whose directory is below `folder`.
    pub run: RunOptions<'a>,
    /// Folder of the run directories. Runs of the same scenario and build that are already there are not repeated.
    pub folder: &'a Path,
    /// True if the long cases run too.
    pub full: bool,
    /// Text that `scene: case` must contain for a case to run; empty for all.
    pub only: String,
}

/// Runs all cases of all scenes below `folder`, in the order of their names.
pub fn run_suite(folder: &Path, runs: &SuiteOptions) -> Result<Vec<CaseOutcome>, Error> {
    let entries = std::fs::read_dir(folder).map_err(Error::input(folder.display()))?;
    let paths = entries.flatten().map(|entry| entry.path());
    let scenes = paths.filter(|path| path.join("expected.toml").is_file());
    let mut scenes: Vec<PathBuf> = scenes.collect();
    scenes.sort();
    let mut cases = Vec::new();
    for scene in &scenes {
        let expected = read(&scene.join("expected.toml"))?;
        let mut above = expected.text;
        let folder = scene.file_name().unwrap_or_default().to_string_lossy();
        for case in expected.case {
            let name = format!("{folder}: {}", case.name);
            if name.contains(&runs.only) && (runs.full || !case.full) {
                let above = std::mem::take(&mut above);
                let elsewhere = case.scene.as_ref().or(expected.scene.as_ref());
                let scenario = elsewhere.map_or(scene.clone(), |folder| scene.join(folder));
                cases.push(run_case(scene, &scenario, [name, above], case, runs)?);
            }
        }
    }
    if cases.is_empty() {
        let problem = "no name of a case or scene contains this, or the case is long and needs --full; without --only all cases run";
        let argument = format!("--only {}", runs.only);
        return Err(Refusal::argument(argument, problem).into());
    }
    Ok(cases)
}

fn run_case(
    beside: &Path,
    scenario: &Path,
    [name, above]: [String; 2],
    case: SuiteCase,
    runs: &SuiteOptions,
) -> Result<CaseOutcome, Error> {
    tell_progress(&name);
    let seed = |seed: &u64| vec![format!("run.seed={seed}")];
    let mut seeds: Vec<Vec<String>> = case.seeds.iter().map(seed).collect();
    if seeds.is_empty() {
        seeds.push(Vec::new());
    }
    let (mut ends, mut whole) = (Vec::new(), Vec::new());
    for seed in &seeds {
        let (outcome, run) = last_of(beside, scenario, seed, &case, runs)?;
        if outcome.message.is_empty() {
            let reference = referred(beside, scenario, seed, &case, runs)?;
            whole.extend(run.map(|run| (run, reference)));
        }
        ends.push(outcome);
    }
    let mut rows = vec![ending(&case, &ends)];
    if whole.len() == seeds.len() {
        rows.push(warnings(&case, &whole));
        let numbers = case.number.iter();
        rows.extend(numbers.map(|number| judged(&case, number, &whole)));
    }
    for row in &mut rows {
        row.name = format!("{name}: {}", row.name);
    }
    Ok(CaseOutcome {
        name,
        scenario: scenario.to_path_buf(),
        case,
        above,
        rows,
        runs: whole,
    })
}

/// The run of a case after its first runs, or the first run that failed.
fn last_of(
    beside: &Path,
    scenario: &Path,
    seed: &[String],
    case: &SuiteCase,
    runs: &SuiteOptions,
) -> Result<(TaskOutcome, Option<RunFiles>), Error> {
    let mut before: Vec<(String, RunFiles)> = Vec::new();
    let taken = |take: &[Take], before: &[(String, RunFiles)]| {
        let sets: Result<Vec<String>, String> = take.iter().map(|t| t.of_runs(before)).collect();
        sets.map_err(|path| {
            let problem = format!("takes `{path}`, which no run before it gives");
            let refusal = Refusal::file(beside.join("expected.toml"), problem);
            TaskOutcome::of(Err(refusal.into()))
        })
    };
    for first in &case.first {
        let (scene, above) = match &first.scene {
            Some(scene) => (beside.join(scene), &[][..]),
            None => (scenario.to_path_buf(), &case.set[..]),
        };
        let take = match taken(&first.take, &before) {
            Ok(take) => take,
            Err(refused) => return Ok((refused, None)),
        };
        let set = [above, &first.set, &take, seed].concat();
        match attempt(&scene, &set, runs)? {
            (outcome, Some(run)) if outcome.message.is_empty() => {
                before.push((first.name.clone(), run));
            }
            stopped => return Ok(stopped),
        }
    }
    match taken(&case.take, &before) {
        Ok(take) => attempt(scenario, &[&case.set, &take[..], seed].concat(), runs),
        Err(refused) => Ok((refused, None)),
    }
}

/// A run that reached its end, and its reference.
pub type Held = (RunFiles, Option<RunFiles>);

/// The reference run for a case's open numbers; `None` if it failed.
fn referred(
    beside: &Path,
    scenario: &Path,
    seed: &[String],
    case: &SuiteCase,
    runs: &SuiteOptions,
) -> Result<Option<RunFiles>, Error> {
    let Some(reference) = &case.reference else {
        return Ok(None);
    };
    let (outcome, run) = match &case.reference_scene {
        Some(other) if case.first.is_empty() => attempt(&beside.join(other), reference, runs)?,
        Some(other) => attempt(&beside.join(other), &[reference, seed].concat(), runs)?,
        None => attempt(scenario, &[&case.set[..], seed, reference].concat(), runs)?,
    };
    Ok(run.filter(|_| outcome.message.is_empty()))
}

/// The outcome and the directory of a run, possibly from an earlier time; an error ends the suite.
fn attempt(
    scene: &Path,
    set: &[String],
    runs: &SuiteOptions,
) -> Result<(TaskOutcome, Option<RunFiles>), Error> {
    let loaded = match load(&scene.display().to_string(), set) {
        Ok(loaded) => loaded,
        Err(error) => return Ok((TaskOutcome::of(Err(error)), None)),
    };
    let folder = TaskFolder::new(runs.folder, &run_id(&loaded));
    loop {
        match folder.execute(&loaded, false, &runs.run)? {
            TaskStage::Done(outcome) => {
                let run = folder.run();
                let left = run.is_dir().then(|| RunFiles::read_for_page(&run));
                return Ok((outcome, left.transpose()?));
            }
            TaskStage::Running => sleep(LOOK),
            TaskStage::Waiting => {}
        }
        if let Some(interrupted) = runs.run.watch.interrupted() {
            return Err(interrupted);
        }
    }
}

/// The exit codes of the runs, as a row.
fn ending(case: &SuiteCase, ends: &[TaskOutcome]) -> CaseRow {
    let holds = |end: &TaskOutcome| {
        let says_all = case.says.iter().all(|word| end.message.contains(word));
        end.exit_code == case.exit_code && says_all
    };
    let wrong = ends.iter().find(|end| !holds(end));
    let ours = match wrong {
        Some(TaskOutcome {
            exit_code, message, ..
        }) if !message.is_empty() => {
            json!(format!("{exit_code}: {message}"))
        }
        wrong => json!(wrong.map_or(case.exit_code, |end| end.exit_code)),
    };
    let values = [ours, json!(case.exit_code)];
    case_row(case, "exit code", values, wrong.is_none())
}

/// The warnings of runs that reached their end.
fn warnings(case: &SuiteCase, runs: &[Held]) -> CaseRow {
    let expected: BTreeSet<&str> = case.warns.iter().map(String::as_str).collect();
    let allowed = |code: &str| case.may_warn.iter().any(|may| may == code);
    let word = |warning: &Value, key: &str| warning[key].as_str().unwrap_or_default().to_string();
    let (mut all, mut lines, mut holds) = (BTreeSet::new(), Vec::new(), true);
    for (run, _) in runs {
        let codes: BTreeSet<String> = run.list("warnings").map(|w| word(w, "code")).collect();
        let judged = codes.iter().map(String::as_str);
        let judged: BTreeSet<&str> = judged.filter(|code| !allowed(code)).collect();
        if judged != expected {
            holds = false;
            lines.extend(run.list("warnings").map(|w| word(w, "text")));
        }
        all.extend(codes);
    }
    let ours = if holds { json!(all) } else { json!(lines) };
    case_row(case, "warnings", [ours, json!(expected)], holds)
}

fn judged(case: &SuiteCase, number: &Number, runs: &[Held]) -> CaseRow {
    let pair = |(run, reference): &Held| {
        let of_reference = || number.value(reference.as_ref()?, None);
        let expected = number.expected.or_else(of_reference);
        [number.value(run, reference.as_ref()), expected]
    };
    let pairs: Vec<[Option<f64>; 2]> = runs.iter().map(pair).collect();
    let is_close = |(ours, of)| number.holds(ours, of);
    let holds = |[ours, expected]: &[Option<f64>; 2]| {
        if number.reported {
            ours.is_some()
        } else {
            ours.zip(*expected).is_some_and(is_close)
        }
    };
    let all = |k: usize| -> Vec<f64> { pairs.iter().filter_map(|pair| pair[k]).collect() };
    let least = all(0).into_iter().reduce(|a, b| -larger(-a, -b));
    let most = all(0).into_iter().reduce(larger);
    let ends = least.zip(most).map(<[f64; 2]>::from);
    let name = number.of.as_ref().unwrap_or(&number.path);
    let values = [0, 1].map(|k| json!(median(all(k))));
    CaseRow {
        seeds: ends.filter(|_| pairs.len() > 1),
        published: number.published,
        basis: number.basis,
        reported: number.reported,
        ..case_row(case, name, values, pairs.iter().all(holds))
    }
}

fn case_row(case: &SuiteCase, name: &str, [ours, expected]: [Value; 2], holds: bool) -> CaseRow {
    CaseRow {
        name: name.into(),
        ours,
        expected,
        source: case.source.clone(),
        holds,
        ..CaseRow::default()
    }
}
