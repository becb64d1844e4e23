//! Rows of a study: measures and costs of each run, and its distance from the reference, if there is one.

use std::collections::{BTreeMap, BTreeSet};

use std::path::Path;

use super::file::{StudyFile, shown_values};
use super::measure::ReferenceNumbers;
use super::plan::{Plan, Task, TaskRole};
use super::task::{TaskFolder, TaskStage};
use runs::files::RunFiles;
use scenario::error::Error;

/// Status of a run whose files have become unreadable.
pub const DAMAGED: &str = "damaged";

/// Costs in the order of their columns.
pub const COSTS: [&str; 6] = [
    "wall_s",
    "cpu_s",
    "peak_rss_bytes",
    "element_steps",
    "contact_iterations",
    "messages",
];

/// A run of the study, done or not.
#[derive(Clone, Debug)]
pub struct StudyRow<'a> {
    /// Its task.
    pub task: &'a Task,
    /// `waiting`, `running`, `damaged`, or the status of the run.
    pub status: String,
    /// Exit code of the run, once it is done.
    pub exit_code: Option<i32>,
    /// Number of times it started.
    pub attempts: usize,
    /// Distance from the reference of its scene in each measure; the deviation of a single number has a sign.
    pub deviations: Vec<Option<f64>>,
    /// Value of each measure.
    pub numbers: Vec<Option<f64>>,
    /// Largest distance of a perturbed reference of its scene in each measure.
    pub floors: Vec<Option<f64>>,
    /// Costs by name.
    pub cost: BTreeMap<String, f64>,
    /// Costs relative to the reference of its scene.
    pub cost_rel: BTreeMap<String, f64>,
    /// Hashes of exchange and state.
    pub hashes: [String; 2],
    /// Codes of the run's warnings, each once.
    pub warnings: String,
    /// Why something is missing.
    pub message: String,
}

impl StudyRow<'_> {
    /// True for a run whose result can be trusted.
    pub fn is_trusted(&self) -> bool {
        self.status == "completed" && self.exit_code == Some(0)
    }

    /// Its random draw: runs with equal draws have the same bits, under any seed or name of a case.
    pub fn draw(&self) -> &[String] {
        let unknown = self.hashes.iter().any(String::is_empty);
        if unknown {
            std::slice::from_ref(&self.task.id)
        } else {
            &self.hashes
        }
    }

    /// Its distance from the reference in a measure, trusted or not.
    pub fn distance(&self, measure: usize) -> Option<f64> {
        self.deviations[measure].map(f64::abs)
    }

    /// Its error in a measure, if the run can be trusted.
    pub fn error(&self, measure: usize) -> Option<f64> {
        self.distance(measure).filter(|_| self.is_trusted())
    }
}

/// The rows of a study.
#[derive(Clone, Debug)]
pub struct Results<'a> {
    /// The study.
    pub file: &'a StudyFile,
    /// One row per task.
    pub rows: Vec<StudyRow<'a>>,
}

impl<'a> Results<'a> {
    /// Reads the tasks of a study from its folder, finished or not.
    ///
    /// # Errors
    /// The state of a task, or the run given as the reference, cannot be read. A damaged run is a row.
    pub fn read(plan: &'a Plan, tasks: &'a [Task], folder: &Path) -> Result<Results<'a>, Error> {
        let file = &plan.file;
        let read = |run| RunFiles::read(&plan.beside.join(run));
        let given = file.reference.run.as_ref().map(read).transpose()?;
        let mut rows = Vec::new();
        for tasks in tasks.chunk_by(|a, b| a.scene == b.scene) {
            let task = tasks.iter().find(|task| task.role == TaskRole::Reference);
            let own = task.and_then(|task| finished(folder, task).ok().flatten());
            // A suspect run is no reference for others.
            let own = own.filter(|run| run.text("status") == "completed");
            let reference = own.as_ref().or(given.as_ref());
            let numbers = match (&file.reference.value, reference) {
                (Some(values), _) => ReferenceNumbers::Values(values),
                (None, Some(run)) => ReferenceNumbers::Run(run),
                (None, None) => ReferenceNumbers::Nothing,
            };
            let first = rows.len();
            for own in tasks {
                let mut row = row(own, file, numbers, folder)?;
                let other_load = task.and_then(|task| other_load(own, task));
                add(&mut row.message, &other_load.unwrap_or_default());
                rows.push(row);
            }
            relate(&mut rows[first..], reference);
        }
        Ok(Results { file, rows })
    }

    /// results.csv.
    pub fn csv(&self) -> String {
        let rows = self.rows.iter();
        let rows = rows.map(|row| self.cells(row).into_iter().unzip());
        let rows: Vec<(Vec<String>, Vec<String>)> = rows.collect();
        let head = rows.first().map(|(names, _)| line(names));
        let lines = rows.iter().map(|(_, cells)| line(cells));
        head.into_iter().chain(lines).collect()
    }

    /// Names of the columns, and the cells of a row.
    fn cells(&self, row: &StudyRow) -> Vec<(String, String)> {
        let held = self.file.reference.is_given();
        let named = |(name, cell): (&str, String)| (name.to_string(), cell);
        let exit_code = row.exit_code.map(|code| code.to_string());
        let first = [
            ("index", row.task.index.to_string()),
            ("id", row.task.id.clone()),
            ("status", row.status.clone()),
            ("exit_code", exit_code.unwrap_or_default()),
            ("attempts", row.attempts.to_string()),
        ];
        let mut cells: Vec<(String, String)> = first.map(named).into();
        for (vary, value) in self.file.vary.iter().zip(&row.task.values) {
            cells.push((vary.key.clone(), value.clone()));
        }
        let errors = (0..row.deviations.len()).map(|k| row.distance(k)).collect();
        let kinds = [
            ("error", &errors),
            ("floor", &row.floors),
            ("value", &row.numbers),
        ];
        for (kind, numbers) in kinds.into_iter().skip(if held { 0 } else { 2 }) {
            let numbers = self.file.measure.iter().zip(numbers);
            cells.extend(numbers.map(|(m, x)| (format!("{kind}_{}", m.name), cell(*x))));
        }
        let cost = |name: &str| row.cost.get(name).map(f64::to_string).unwrap_or_default();
        let [exchange, state] = row.hashes.clone();
        let last = [
            ("hash_exchange", exchange),
            ("hash_state", state),
            ("message", row.message.clone()),
            ("role", row.task.role.word()),
            ("warnings", row.warnings.clone()),
        ];
        let over = [("wall_rel", "wall_s"), ("cpu_rel", "cpu_s")];
        let over = over.map(|(name, of)| (name, cell(row.cost_rel.get(of).copied())));
        let costs = COSTS.map(|name| (name, cost(name))).into_iter();
        let more = costs.chain(last).chain(over.into_iter().filter(|_| held));
        cells.extend(more.map(named));
        cells
    }

    /// The reference of a scene, if it is a run of this study.
    pub fn reference(&self, scene: usize) -> Option<&StudyRow<'a>> {
        let mut rows = self.rows.iter();
        rows.find(|row| row.task.scene == scene && row.task.role == TaskRole::Reference)
    }
}

/// Sets floors and relative costs in the rows of a scene.
fn relate(rows: &mut [StudyRow], reference: Option<&RunFiles>) {
    let perturbed = rows.iter();
    let perturbed = perturbed.filter(|row| matches!(row.task.role, TaskRole::Perturbed(_)));
    let floors = (0..rows[0].floors.len()).map(|k| {
        let errors: Option<Vec<f64>> = perturbed.clone().map(|row| row.error(k)).collect();
        errors?.into_iter().reduce(f64::max)
    });
    let floors: Vec<Option<f64>> = floors.collect();
    let failed = |row: &StudyRow| row.exit_code.is_some() && !row.is_trusted();
    let unknown = perturbed.clone().any(failed);
    let whole = reference.map(RunFiles::cost).unwrap_or_default();
    for row in rows {
        row.floors.clone_from(&floors);
        if unknown {
            let why = "the floor of noise is unknown: a perturbed reference did not complete";
            add(&mut row.message, why);
        }
        let parts = row.cost.iter().filter_map(|(name, number)| {
            let whole = whole.get(name).filter(|whole| **whole > 0.0)?;
            Some((name.clone(), number / whole))
        });
        row.cost_rel = parts.collect();
    }
}

/// Keys of scenarios for loads and imposed motions.
const LOADS: [&str; 7] = [
    "load_n",
    "load_table",
    "amplitude_m",
    "traction_pa",
    "pressure_pa",
    "velocity_m_per_s",
    "displacement_m",
];

/// The load of a task that its reference does not have, if there is one: the deviation is then the effect of the load, and no error.
fn other_load(task: &Task, reference: &Task) -> Option<String> {
    let [own, other] = [task, reference].map(|task| {
        let values = shown_values(&task.loaded.resolved.parse().unwrap_or_default());
        let named = values.into_iter().filter_map(|(key, value)| {
            let name = key.split('.').find(|part| LOADS.contains(part))?;
            Some(((name.to_string(), value), key))
        });
        named.collect::<BTreeMap<_, _>>()
    });
    let ((_, value), key) = own.iter().find(|(load, _)| !other.contains_key(load))?;
    Some(format!(
        "{key} = {value} is not the load of the reference: the error shown is the effect of this load; with `scene = true` each load has its own reference"
    ))
}

/// The run of a task that has reached its end.
pub fn finished(folder: &Path, task: &Task) -> Result<Option<RunFiles>, Error> {
    let of = TaskFolder::new(folder, &task.id);
    match of.stage()? {
        TaskStage::Done(outcome) if ["completed", "suspect"].contains(&outcome.status.as_str()) => {
            RunFiles::read(&of.run()).map(Some)
        }
        _ => Ok(None),
    }
}

fn row<'a>(
    task: &'a Task,
    file: &StudyFile,
    reference: ReferenceNumbers,
    folder: &Path,
) -> Result<StudyRow<'a>, Error> {
    let nothing = vec![None; file.measure.len()];
    let of = TaskFolder::new(folder, &task.id);
    let (status, exit_code, message) = match of.stage()? {
        TaskStage::Waiting => ("waiting".to_string(), None, String::new()),
        TaskStage::Running => ("running".to_string(), None, String::new()),
        TaskStage::Done(done) => (done.status, Some(done.exit_code), done.message),
    };
    let mut row = StudyRow {
        task,
        status,
        exit_code,
        attempts: of.attempts(),
        deviations: nothing.clone(),
        numbers: nothing.clone(),
        floors: nothing,
        cost: BTreeMap::new(),
        cost_rel: BTreeMap::new(),
        hashes: Default::default(),
        warnings: String::new(),
        message,
    };
    let run = finished(folder, task).unwrap_or_else(|why| {
        let why = format!("{why}; `study run --retry` repeats the run");
        row.status = DAMAGED.into();
        add(&mut row.message, &why);
        None
    });
    let Some(run) = run else {
        return Ok(row);
    };
    for (k, measure) in file.measure.iter().enumerate() {
        let number = measure.number(&run);
        row.numbers[k] = number.as_ref().ok().copied();
        let (missing, kind) = match file.reference.is_given() {
            true => {
                let deviation = measure.deviation(&run, reference);
                row.deviations[k] = deviation.as_ref().ok().copied();
                (deviation.err(), "error")
            }
            false => (number.err(), "value"),
        };
        if let Some(why) = missing {
            add(&mut row.message, &format!("{kind}_{}: {why}", measure.name));
        }
    }
    let codes = run.list("warnings").filter_map(|w| w["code"].as_str());
    let codes: BTreeSet<&str> = codes.collect();
    row.warnings = Vec::from_iter(codes).join(" ");
    if row.status == "suspect" {
        add(&mut row.message, &warnings(&run));
    }
    row.cost = run.cost();
    let messages = run.summary["log"]["messages"].as_f64();
    let messages = messages.map(|messages| ("messages".into(), messages));
    row.cost.extend(messages);
    row.hashes = ["exchange", "state"].map(|name| run.hash(name).unwrap_or_default().to_string());
    Ok(row)
}

/// Codes and values of a run's warnings.
fn warnings(run: &RunFiles) -> String {
    let warnings = run.list("warnings").filter_map(|warning| {
        let [code, position] = ["code", "where"].map(|key| warning[key].as_str());
        let value = warning["value"].as_f64()?;
        Some(format!("{} at {}: {value}", code?, position?))
    });
    Vec::from_iter(warnings).join("; ")
}

/// Appends a reason to a message.
fn add(message: &mut String, reason: &str) {
    if !message.is_empty() && !reason.is_empty() {
        message.push_str("; ");
    }
    message.push_str(reason);
}

/// A line of a table of comma-separated cells.
pub fn line(cells: &[impl AsRef<str>]) -> String {
    let cells = cells.iter().map(|cell| quoted(cell.as_ref()));
    Vec::from_iter(cells).join(",") + "\n"
}

/// A number in a cell.
pub(super) fn cell(number: Option<f64>) -> String {
    number.map_or(String::new(), |number| format!("{number:e}"))
}

/// A cell as RFC 4180 quotes it.
fn quoted(cell: &str) -> String {
    if !cell.contains([',', '"', '\n', '\r']) {
        return cell.to_string();
    }
    let cell = cell.replace('"', "\"\"").replace(['\n', '\r'], " ");
    format!("\"{cell}\"")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_with_commas_stay_cells() {
        assert_eq!(quoted("a, \"b\""), "\"a, \"\"b\"\"\"");
        assert_eq!(quoted("a"), "a");
    }
}
