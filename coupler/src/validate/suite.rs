//! Running the cases of a folder of scenes.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde_json::{Value, json};

use super::case::{Case, Number, read};
use crate::error::Error;
use crate::output::tell;
use crate::participants::{Registry, Watch};
use crate::plausible::Warning;
use crate::run::session::{Ended, Options, fresh_run_id, run};
use crate::rundir::Scratch;
use crate::scenario::load::load;
use crate::scheme::vectors::larger;

/// Columns of signals.csv.
type Signals = BTreeMap<String, Vec<f64>>;

/// One line of the table.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
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
pub struct Runs<'a> {
    /// Shipped solvers.
    pub registry: &'a Registry,
    /// The program whose `node` verb serves them.
    pub program: PathBuf,
    /// Threads of each participant.
    pub threads: usize,
    /// Signals that end the suite.
    pub watch: Watch,
}

/// Runs all cases of all scenes below `folder`, in the order of their names.
pub fn run_suite(folder: &Path, runs: &Runs) -> Result<Vec<Row>, Error> {
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
            rows.extend(run_case(scene, &scenario, &case, runs)?);
        }
    }
    Ok(rows)
}

fn run_case(scene: &Path, scenario: &Path, case: &Case, runs: &Runs) -> Result<Vec<Row>, Error> {
    let scene = scene.file_name().unwrap_or_default().to_string_lossy();
    let name = format!("{scene}: {}", case.name);
    tell(&name);
    let out = Scratch::new("validate", fresh_run_id());
    let outcome = attempt(scenario, case, runs, out.path());
    if let Err(Error::Interrupted { signal }) = outcome {
        return Err(Error::Interrupted { signal });
    }
    let mut rows = vec![ending(case, &outcome)];
    if let Ok(ended) = &outcome {
        let summary = ended.summary.value();
        rows.push(warnings(case, &ended.summary.warnings));
        let signals = crate::report::curves::read_csv(&out.path().join("signals.csv"));
        let numbers = case.number.iter();
        rows.extend(numbers.map(|number| judged(case, number, &summary, &signals)));
    }
    for row in &mut rows {
        row.name = format!("{name}: {}", row.name);
    }
    Ok(rows)
}

fn attempt(scene: &Path, case: &Case, runs: &Runs, out: &Path) -> Result<Ended, Error> {
    let loaded = load(&scene.display().to_string(), &case.set)?;
    let options = Options {
        out: Some(out),
        threads: runs.threads,
        registry: runs.registry,
        program: runs.program.clone(),
        watch: runs.watch.clone(),
        progress: false,
        strict: false,
    };
    let mut ended = run(&loaded, &options)?;
    ended.error.take().map_or(Ok(ended), Err)
}

/// The end of the run, as a row of its own.
fn ending(case: &Case, outcome: &Result<Ended, Error>) -> Row {
    let (code, message) = match outcome {
        Ok(ended) => (ended.summary.exit_code(), String::new()),
        Err(error) => (error.exit_code(), error.to_string()),
    };
    let says_all = case.says.iter().all(|word| message.contains(word));
    let holds = code == case.exit_code && says_all;
    Row {
        name: "exit code".into(),
        ours: if message.is_empty() || holds {
            code.into()
        } else {
            format!("{code}: {message}").into()
        },
        expected: case.exit_code.into(),
        source: case.source.clone(),
        holds,
    }
}

/// The warnings of a run that came to its end.
fn warnings(case: &Case, found: &[Warning]) -> Row {
    let ours: BTreeSet<&str> = found.iter().map(|warning| warning.code.as_str()).collect();
    let expected: BTreeSet<&str> = case.warns.iter().map(String::as_str).collect();
    let lines: Vec<String> = found.iter().map(Warning::line).collect();
    Row {
        name: "warnings".into(),
        holds: ours == expected,
        ours: if ours == expected {
            json!(ours)
        } else {
            json!(lines)
        },
        expected: json!(expected),
        source: case.source.clone(),
    }
}

fn judged(case: &Case, number: &Number, summary: &Value, signals: &Signals) -> Row {
    let keys = number.path.split('.');
    let ours = match number.path.strip_prefix("signals.") {
        Some(path) => of_signals(signals, path),
        None => keys.fold(summary, |value, key| &value[key]).as_f64(),
    };
    Row {
        name: number.path.clone(),
        ours: ours.into(),
        expected: number.expected.into(),
        source: case.source.clone(),
        holds: ours.is_some_and(|ours| number.holds(ours)),
    }
}

/// `<column>.<last | max | min | mean>`; the column's name may hold dots itself.
fn of_signals(signals: &Signals, path: &str) -> Option<f64> {
    let (column, what) = path.rsplit_once('.')?;
    let values = signals.get(column)?;
    match what {
        "last" => values.last().copied(),
        "max" => values.iter().copied().reduce(larger),
        "min" => values.iter().copied().reduce(|a, b| -larger(-a, -b)),
        "mean" => Some(values.iter().sum::<f64>() / values.len() as f64),
        _ => None,
    }
}
