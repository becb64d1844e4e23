//! Running the cases of a folder of scenes.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use protocol::larger;
use serde::Serialize;
use serde_json::{Value, json};

use super::case::{Number, SuiteCase, read};
use crate::quiet::whole;
use coordinator::error::{Error, Refusal};
use coordinator::output::tell_progress;
use coordinator::participants::{Registry, Watch};
use coordinator::plausible::Warning;
use coordinator::run::session::{Ended, RunOptions, fresh_run_id, run};
use coordinator::scenario::load::load;
use kit::scratch::Scratch;
use runs::table::Table;

/// One line of the table.
#[derive(Clone, Debug, Serialize)]
pub struct CaseRow {
    /// Scene, case and number.
    pub name: String,
    /// The value that came out.
    pub ours: Value,
    /// The value that should.
    pub expected: Value,
    /// Source of the expectation.
    pub source: String,
    /// True if it is near enough.
    pub holds: bool,
}

/// Circumstances of the runs of a suite.
pub struct SuiteOptions<'a> {
    /// Shipped solvers.
    pub registry: &'a Registry,
    /// The program whose `node` verb serves them.
    pub program: PathBuf,
    /// Threads of each participant.
    pub threads: usize,
    /// True if the long cases are run too.
    pub full: bool,
    /// Text that `scene: case` contains for each case that is run; empty for all.
    pub only: String,
    /// Signals that end the suite.
    pub watch: Watch,
}

/// Runs all cases of all scenes below `folder`, in the order of their names.
pub fn run_suite(folder: &Path, runs: &SuiteOptions) -> Result<Vec<CaseRow>, Error> {
    let mut scenes: Vec<PathBuf> = std::fs::read_dir(folder)
        .map_err(Error::input(folder.display()))?
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.join("expected.toml").is_file())
        .collect();
    scenes.sort();
    let mut rows = Vec::new();
    for scene in &scenes {
        let expected = read(&scene.join("expected.toml"))?;
        let elsewhere = expected.scene.map(|elsewhere| scene.join(elsewhere));
        let scenario = elsewhere.unwrap_or_else(|| scene.clone());
        for case in expected.case {
            let name = format!("{}: {}", name_of(scene), case.name);
            if name.contains(&runs.only) && (runs.full || !case.full) {
                rows.extend(run_case(&name, &scenario, &case, runs)?);
            }
        }
    }
    if rows.is_empty() {
        let problem = "no case has this in its name or in its scene's, or they are long ones, which --full runs; without --only all are listed";
        let argument = format!("--only {}", runs.only);
        return Err(Refusal::argument(argument, problem).into());
    }
    Ok(rows)
}

/// A scene as its folder is named.
fn name_of(scene: &Path) -> Cow<'_, str> {
    scene.file_name().unwrap_or_default().to_string_lossy()
}

fn run_case(
    name: &str,
    scenario: &Path,
    case: &SuiteCase,
    runs: &SuiteOptions,
) -> Result<Vec<CaseRow>, Error> {
    tell_progress(name);
    let outcome = attempt(scenario, &case.set, runs)?;
    let mut rows = vec![ending(case, &outcome)];
    if let Ok(left) = &outcome {
        rows.push(warnings(case, &left.ended.summary.warnings));
        let reference = referred(scenario, case, runs)?;
        let numbers = case.number.iter();
        rows.extend(numbers.map(|number| {
            let expected = number
                .expected
                .or(reference.as_ref().and_then(|left| left.number(number)));
            judged(case, number, left.number(number), expected)
        }));
    }
    for row in &mut rows {
        row.name = format!("{name}: {}", row.name);
    }
    Ok(rows)
}

/// The run that a case's open numbers are from; an end that is no result gives none.
fn referred(scenario: &Path, case: &SuiteCase, runs: &SuiteOptions) -> Result<Option<Left>, Error> {
    let Some(reference) = &case.reference else {
        return Ok(None);
    };
    let set = [case.set.as_slice(), reference].concat();
    attempt(scenario, &set, runs).map(Result::ok)
}

/// The numbers that a run left.
struct Left {
    ended: Ended,
    summary: Value,
    signals: Table,
}

impl Left {
    fn number(&self, number: &Number) -> Option<f64> {
        match number.path.strip_prefix("signals.") {
            Some(path) => of_signals(&self.signals, path),
            None => {
                let keys = number.path.split('.');
                keys.fold(&self.summary, |value, key| &value[key]).as_f64()
            }
        }
    }
}

/// A run in a folder of its own; the outer error ends the suite.
fn attempt(
    scene: &Path,
    set: &[String],
    runs: &SuiteOptions,
) -> Result<Result<Left, Error>, Error> {
    let out = Scratch::new("validate", fresh_run_id());
    match complete(scene, set, runs, out.path()) {
        Err(Error::Interrupted { signal }) => Err(Error::Interrupted { signal }),
        Err(error) => Ok(Err(error)),
        Ok(ended) => Ok(Ok(Left {
            summary: ended.summary.value(),
            signals: Table::read_whole_rows(&out.path().join("signals.csv")),
            ended,
        })),
    }
}

fn complete(scene: &Path, set: &[String], runs: &SuiteOptions, out: &Path) -> Result<Ended, Error> {
    let loaded = load(&scene.display().to_string(), set)?;
    let options = RunOptions {
        threads: runs.threads,
        watch: runs.watch.clone(),
        ..RunOptions::quiet(Some(out), runs.registry, &runs.program)
    };
    whole(run(&loaded, &options))
}

/// The end of the run, as a row of its own.
fn ending(case: &SuiteCase, outcome: &Result<Left, Error>) -> CaseRow {
    let (code, message) = match outcome {
        Ok(left) => (left.ended.summary.exit_code, String::new()),
        Err(error) => (error.exit_code(), error.to_string()),
    };
    let says_all = case.says.iter().all(|word| message.contains(word));
    let holds = code == case.exit_code && says_all;
    let ours = if message.is_empty() || holds {
        json!(code)
    } else {
        json!(format!("{code}: {message}"))
    };
    case_row(case, "exit code", ours, json!(case.exit_code), holds)
}

/// The warnings of a run that came to its end.
fn warnings(case: &SuiteCase, found: &[Warning]) -> CaseRow {
    let codes: BTreeSet<&str> = found.iter().map(|warning| warning.code.as_str()).collect();
    let expected: BTreeSet<&str> = case.warns.iter().map(String::as_str).collect();
    let holds = codes == expected;
    let lines = || found.iter().map(Warning::line).collect::<Vec<String>>();
    let ours = if holds { json!(codes) } else { json!(lines()) };
    case_row(case, "warnings", ours, json!(expected), holds)
}

fn judged(case: &SuiteCase, number: &Number, ours: Option<f64>, expected: Option<f64>) -> CaseRow {
    let both = ours.zip(expected);
    let holds = both.is_some_and(|(ours, expected)| number.holds(ours, expected));
    case_row(case, &number.path, ours.into(), expected.into(), holds)
}

fn case_row(case: &SuiteCase, name: &str, ours: Value, expected: Value, holds: bool) -> CaseRow {
    CaseRow {
        name: name.into(),
        ours,
        expected,
        source: case.source.clone(),
        holds,
    }
}

/// `<column>.<last | max | min | mean | t_max | t_min>`, `t_` being the time of the extreme (s); the column's name may hold dots
/// itself, and columns joined by `+` are summed.
fn of_signals(signals: &Table, path: &str) -> Option<f64> {
    let (columns, what) = path.rsplit_once('.')?;
    let columns = columns.split('+').map(|column| signals.get(column));
    let columns = columns.collect::<Option<Vec<&[f64]>>>()?;
    let reports = columns.iter().map(|column| column.len()).min()?;
    let sum = |row| columns.iter().map(|column| column[row]).sum();
    let values = &(0..reports).map(sum).collect::<Vec<f64>>();
    match what {
        "last" => values.last().copied(),
        "max" => values.iter().copied().reduce(larger),
        "min" => values.iter().copied().reduce(|a, b| -larger(-a, -b)),
        "t_max" => time_of(signals, values, 1.0),
        "t_min" => time_of(signals, values, -1.0),
        "mean" => Some(values.iter().sum::<f64>() / values.len() as f64),
        _ => None,
    }
}

/// Time of the first of the largest values (s), of the smallest where the sign is -1.
fn time_of(signals: &Table, values: &[f64], sign: f64) -> Option<f64> {
    let extreme = values.iter().map(|value| sign * value).reduce(larger)?;
    let at = values.iter().position(|value| sign * value == extreme)?;
    signals.get("t_s")?.get(at).copied()
}
