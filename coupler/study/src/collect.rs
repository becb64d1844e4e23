//! Rows of a study: what each run measured and cost, and how far it is from the reference, where there is one.

use std::collections::{BTreeMap, BTreeSet};

use std::path::Path;

use super::file::{StudyFile, shown_values};
use super::measure::ReferenceNumbers;
use super::plan::{Plan, Task, TaskRole};
use super::task::{TaskFolder, TaskStage};
use runs::files::RunFiles;
use scenario::error::Error;

/// Status of a run whose files cannot be read any more.
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
#[derive(Clone, Debug, Default)]
pub struct StudyRow {
    /// Index of its task.
    pub index: usize,
    /// Its part.
    pub role: TaskRole,
    /// Number of its combination of scene keys.
    pub scene: usize,
    /// Hash of scenario and build.
    pub id: String,
    /// `waiting`, `running`, `damaged`, or that of the run.
    pub status: String,
    /// Exit code of the run, once it is done.
    pub exit_code: Option<i32>,
    /// Number of times it was begun.
    pub attempts: usize,
    /// Value of each key.
    pub values: Vec<String>,
    /// True for the keys that are varied in it.
    pub varied: Vec<bool>,
    /// Distance from the reference of its scene by each measure, with the sign that the deviation of a single number has.
    pub deviations: Vec<Option<f64>>,
    /// What each measure is.
    pub numbers: Vec<Option<f64>>,
    /// Largest distance of a perturbed reference of its scene by each measure.
    pub floors: Vec<Option<f64>>,
    /// Costs by name.
    pub cost: BTreeMap<String, f64>,
    /// Costs over those of the reference of its scene.
    pub cost_rel: BTreeMap<String, f64>,
    /// Hashes of exchange and state.
    pub hashes: [String; 2],
    /// Codes of what the run was warned of, each once.
    pub warnings: String,
    /// Why something is missing.
    pub message: String,
}

impl StudyRow {
    /// True for a run whose result is to be trusted.
    pub fn is_trusted(&self) -> bool {
        self.status == "completed" && self.exit_code == Some(0)
    }

    /// Its distance from the reference by a measure, to be trusted or not.
    pub fn distance(&self, measure: usize) -> Option<f64> {
        self.deviations[measure].map(f64::abs)
    }

    /// Its error by a measure, where it is to be trusted.
    pub fn error(&self, measure: usize) -> Option<f64> {
        self.distance(measure).filter(|_| self.is_trusted())
    }
}

/// The rows of a study.
#[derive(Clone, Debug)]
pub struct Results {
    /// The study.
    pub file: StudyFile,
    /// A row for each task.
    pub rows: Vec<StudyRow>,
}

impl Results {
    /// Looks at the tasks of a study in its folder, done or not.
    ///
    /// # Errors
    /// The state of a task, or the run that is given as the reference, cannot be read. A damaged run is a row.
    pub fn read(plan: &Plan, tasks: &[Task], folder: &Path) -> Result<Results, Error> {
        let file = &plan.file;
        let given = file.reference.run.as_ref();
        let given = given.map(|run| RunFiles::read(&plan.beside.join(run)));
        let given = given.transpose()?;
        let mut rows = Vec::new();
        for tasks in tasks.chunk_by(|a, b| a.scene == b.scene) {
            let task = tasks.iter().find(|task| task.role == TaskRole::Reference);
            let own = task.and_then(|task| finished(folder, task).ok().flatten());
            // What a run is warned of so much that it is suspect is nothing to hold others against.
            let own = own.filter(|run| run.text("status") == "completed");
            let reference = own.as_ref().or(given.as_ref());
            let numbers = match (&file.reference.value, reference) {
                (Some(values), _) => ReferenceNumbers::Values(values),
                (None, Some(run)) => ReferenceNumbers::Run(run),
                (None, None) => ReferenceNumbers::Nothing,
            };
            let of_scene = tasks.iter().map(|task| row(task, file, numbers, folder));
            let mut of_scene = of_scene.collect::<Result<Vec<_>, Error>>()?;
            for (row, other) in of_scene.iter_mut().zip(tasks) {
                let told = task.and_then(|task| other_load(other, task));
                add(&mut row.message, &told.unwrap_or_default());
            }
            relate(&mut of_scene, file, reference);
            rows.extend(of_scene);
        }
        Ok(Results {
            file: file.clone(),
            rows,
        })
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

    /// Names of the columns, and what a row has in them.
    fn cells(&self, row: &StudyRow) -> Vec<(String, String)> {
        let number = |number: Option<f64>| number.map_or(String::new(), |x| format!("{x:e}"));
        let relative = |name: &str| number(row.cost_rel.get(name).copied());
        let measures = || self.file.measure.iter().enumerate();
        let held = self.file.reference.is_given();
        let distances = || measures().filter(|_| held);
        let errors = distances().map(|(k, m)| (format!("error_{}", m.name), row.distance(k)));
        let floors = distances().map(|(k, m)| (format!("floor_{}", m.name), row.floors[k]));
        let values = measures().map(|(k, m)| (format!("value_{}", m.name), row.numbers[k]));
        let named = |(name, cell): (&str, String)| (name.to_string(), cell);
        let exit_code = row.exit_code.map_or(String::new(), |code| code.to_string());
        let first = [
            ("index", row.index.to_string()),
            ("id", row.id.clone()),
            ("status", row.status.clone()),
            ("exit_code", exit_code),
            ("attempts", row.attempts.to_string()),
        ];
        let keys = self.file.vary.iter().map(|vary| vary.key.clone());
        let cost = |name: &str| row.cost.get(name).map_or(String::new(), f64::to_string);
        let costs = COSTS.map(|name| (name, cost(name)));
        let last = [
            ("hash_exchange", row.hashes[0].clone()),
            ("hash_state", row.hashes[1].clone()),
            ("message", row.message.clone()),
            ("role", row.role.word()),
            ("warnings", row.warnings.clone()),
        ];
        let of_reference = [
            ("wall_rel", relative("wall_s")),
            ("cpu_rel", relative("cpu_s")),
        ];
        let mut cells: Vec<(String, String)> = first.map(named).into();
        cells.extend(keys.zip(row.values.iter().cloned()));
        let numbers = errors.chain(floors).chain(values);
        cells.extend(numbers.map(|(name, value)| (name, number(value))));
        cells.extend(costs.into_iter().chain(last).map(named));
        cells.extend(of_reference.map(named).into_iter().filter(|_| held));
        cells
    }

    /// The reference of a scene, where it is a run of this study.
    pub fn reference(&self, scene: usize) -> Option<&StudyRow> {
        let mut rows = self.rows.iter();
        rows.find(|row| row.scene == scene && row.role == TaskRole::Reference)
    }
}

/// Enters floors and relative costs into the rows of a scene.
fn relate(rows: &mut [StudyRow], file: &StudyFile, reference: Option<&RunFiles>) {
    let perturbed = rows.iter();
    let perturbed = perturbed.filter(|row| matches!(row.role, TaskRole::Perturbed(_)));
    let floors = (0..file.measure.len()).map(|k| {
        let errors: Option<Vec<f64>> = perturbed.clone().map(|row| row.error(k)).collect();
        let errors = errors.filter(|errors| !errors.is_empty())?;
        Some(errors.into_iter().fold(0.0, f64::max))
    });
    let floors: Vec<Option<f64>> = floors.collect();
    let failed = |row: &StudyRow| row.exit_code.is_some() && !row.is_trusted();
    let unknown = perturbed.clone().any(failed);
    let whole = reference.map(RunFiles::cost).unwrap_or_default();
    for row in rows {
        row.floors.clone_from(&floors);
        if unknown {
            let why = "the floor of noise is not known: a perturbed reference did not complete";
            add(&mut row.message, why);
        }
        let parts = row.cost.iter().filter_map(|(name, number)| {
            let whole = whole.get(name).filter(|whole| **whole > 0.0)?;
            Some((name.clone(), number / whole))
        });
        row.cost_rel = parts.collect();
    }
}

/// Keys of scenarios that give loads and imposed motions.
const LOADS: [&str; 7] = [
    "load_n",
    "load_table",
    "amplitude_m",
    "traction_pa",
    "pressure_pa",
    "velocity_m_per_s",
    "displacement_m",
];

/// The load of a task that its reference does not have, if there is one: its deviation is the effect of that, and no error.
fn other_load(task: &Task, reference: &Task) -> Option<String> {
    let [own, other] = [task, reference].map(|task| {
        let values = shown_values(&task.loaded.resolved.parse().unwrap_or_default());
        let named = values.into_iter().map(|(key, value)| {
            let name = key.split('.').find(|part| LOADS.contains(part));
            (name.map(String::from), key, value)
        });
        let named = named.filter_map(|(name, key, value)| Some(((name?, value), key)));
        named.collect::<BTreeMap<_, _>>()
    });
    let ((_, value), key) = own.iter().find(|(load, _)| !other.contains_key(load))?;
    Some(format!(
        "{key} = {value} is not the load of the reference: what stands as an error is its effect; with `scene = true` each load has a reference of its own"
    ))
}

/// The run of a task that came to its end.
pub fn finished(folder: &Path, task: &Task) -> Result<Option<RunFiles>, Error> {
    let of = TaskFolder::new(folder, &task.id);
    match of.stage()? {
        TaskStage::Done(outcome) if ["completed", "suspect"].contains(&outcome.status.as_str()) => {
            RunFiles::read(&of.run()).map(Some)
        }
        _ => Ok(None),
    }
}

fn row(
    task: &Task,
    file: &StudyFile,
    reference: ReferenceNumbers,
    folder: &Path,
) -> Result<StudyRow, Error> {
    let measures = &file.measure;
    let of = TaskFolder::new(folder, &task.id);
    let (mut status, exit_code, mut message) = match of.stage()? {
        TaskStage::Waiting => ("waiting".to_string(), None, String::new()),
        TaskStage::Running => ("running".to_string(), None, String::new()),
        TaskStage::Done(done) => (done.status, Some(done.exit_code), done.message),
    };
    let run = finished(folder, task).unwrap_or_else(|why| {
        let why = format!("{why}; `study run --retry` does the run anew");
        status = DAMAGED.into();
        add(&mut message, &why);
        None
    });
    let mut row = StudyRow {
        index: task.index,
        role: task.role,
        scene: task.scene,
        id: task.id.clone(),
        status,
        exit_code,
        attempts: of.attempts(),
        values: task.values.clone(),
        varied: task.varied.clone(),
        deviations: vec![None; measures.len()],
        numbers: vec![None; measures.len()],
        floors: vec![None; measures.len()],
        message,
        ..StudyRow::default()
    };
    let Some(run) = run else {
        return Ok(row);
    };
    for (k, measure) in measures.iter().enumerate() {
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
    row.cost
        .extend(messages.map(|messages| ("messages".to_string(), messages)));
    row.hashes = ["exchange", "state"].map(|name| run.hash(name).unwrap_or_default().to_string());
    Ok(row)
}

/// Codes and values of what a run was warned of.
fn warnings(run: &RunFiles) -> String {
    let told = run.list("warnings").filter_map(|warning| {
        let (code, position) = (warning["code"].as_str()?, warning["where"].as_str()?);
        let value = warning["value"].as_f64()?;
        Some(format!("{code} at {position}: {value}"))
    });
    told.collect::<Vec<String>>().join("; ")
}

/// Adds a reason to others.
fn add(message: &mut String, reason: &str) {
    if !message.is_empty() && !reason.is_empty() {
        message.push_str("; ");
    }
    message.push_str(reason);
}

/// A line of a table of comma-separated cells.
pub fn line(cells: &[impl AsRef<str>]) -> String {
    let cells: Vec<String> = cells.iter().map(|cell| quoted(cell.as_ref())).collect();
    cells.join(",") + "\n"
}

/// A cell as RFC 4180 has it.
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
