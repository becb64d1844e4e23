//! Rows of a study: what each run cost, and how far it is from the reference.

use std::collections::BTreeMap;

use std::path::Path;

use super::file::StudyFile;
use super::measure::{Held, Measure};
use super::plan::{Plan, Role, Task};
use super::task::{Stage, TaskFolder};
use coordinator::error::Error;
use runs::files::RunFiles;

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
pub struct Row {
    /// Its place.
    pub index: usize,
    /// Its part.
    pub role: Role,
    /// Number of its combination of scene keys.
    pub scene: usize,
    /// Hash of scenario and build.
    pub id: String,
    /// `waiting`, `running`, or that of the run.
    pub status: String,
    /// Exit code of the run, once it is done.
    pub exit_code: Option<i32>,
    /// Number of times it was begun.
    pub attempts: usize,
    /// Value of each key.
    pub values: Vec<String>,
    /// True for the keys that are varied in it.
    pub varied: Vec<bool>,
    /// Distance from the reference of its scene by each measure.
    pub errors: Vec<Option<f64>>,
    /// The same with the signs that deviations of single numbers have.
    pub deviations: Vec<Option<f64>>,
    /// Largest distance of a perturbed reference of its scene by each measure.
    pub floors: Vec<Option<f64>>,
    /// Costs by name.
    pub cost: BTreeMap<String, f64>,
    /// Costs over those of the reference of its scene.
    pub cost_rel: BTreeMap<String, f64>,
    /// Hashes of exchange and state.
    pub hashes: [String; 2],
    /// Why something is missing.
    pub message: String,
}

impl Row {
    /// True for a run whose result is to be trusted.
    pub fn stands(&self) -> bool {
        self.status == "completed" && self.exit_code == Some(0)
    }

    /// Its error by a measure, where it stands.
    pub fn error(&self, measure: usize) -> Option<f64> {
        self.errors[measure].filter(|_| self.stands())
    }

    /// The largest distance by a measure that is noise.
    pub fn floor(&self, measure: usize) -> f64 {
        self.floors[measure].unwrap_or(0.0)
    }
}

/// The rows of a study.
#[derive(Clone, Debug)]
pub struct Results {
    /// The study.
    pub file: StudyFile,
    /// A row for each task.
    pub rows: Vec<Row>,
}

impl Results {
    /// Looks at the tasks of a study in its folder, done or not.
    ///
    /// # Errors
    /// A file of a task, or the reference, cannot be read.
    pub fn read(plan: &Plan, tasks: &[Task], folder: &Path) -> Result<Results, Error> {
        let file = &plan.file;
        let given = match &file.reference.run {
            Some(run) => Some(RunFiles::read(&plan.beside.join(run))?),
            None => None,
        };
        let mut rows = Vec::new();
        let mut start = 0;
        while start < tasks.len() {
            let scene = tasks[start].scene;
            let end = start
                + tasks[start..]
                    .iter()
                    .take_while(|task| task.scene == scene)
                    .count();
            let own = tasks[start..end]
                .iter()
                .find(|task| task.role == Role::Reference);
            let own = own
                .map(|task| finished(folder, task))
                .transpose()?
                .flatten();
            // What a run is warned of so much that it is suspect is nothing to hold others against.
            let own = own.filter(|run| run.status() == "completed");
            let held = match (&file.reference.value, own.as_ref().or(given.as_ref())) {
                (Some(values), _) => Held::Values(values),
                (None, Some(run)) => Held::Run(run),
                (None, None) => Held::Nothing,
            };
            let mut of_scene = Vec::new();
            for task in &tasks[start..end] {
                of_scene.push(row(task, &file.measure, held, folder)?);
            }
            relate(&mut of_scene, file, own.as_ref().or(given.as_ref()));
            rows.extend(of_scene);
            start = end;
        }
        Ok(Results {
            file: file.clone(),
            rows,
        })
    }

    /// results.csv.
    pub fn csv(&self) -> String {
        let measures = &self.file.measure;
        let mut head: Vec<String> = ["index", "id", "status", "exit_code", "attempts"]
            .map(String::from)
            .to_vec();
        head.extend(self.file.vary.iter().map(|vary| vary.key.clone()));
        head.extend(measures.iter().map(|m| format!("error_{}", m.name)));
        head.extend(measures.iter().map(|m| format!("floor_{}", m.name)));
        head.extend(COSTS.map(String::from));
        head.extend(
            [
                "hash_exchange",
                "hash_state",
                "message",
                "role",
                "wall_rel",
                "cpu_rel",
            ]
            .map(String::from),
        );
        let mut lines = vec![line(&head)];
        for row in &self.rows {
            let number = |number: &Option<f64>| number.map_or(String::new(), |x| format!("{x:e}"));
            let cost = |name: &str| row.cost.get(name).map_or(String::new(), f64::to_string);
            let relative = |name: &str| number(&row.cost_rel.get(name).copied());
            let code = row.exit_code.map_or(String::new(), |code| code.to_string());
            let attempts = row.attempts.to_string();
            let mut cells = vec![
                row.index.to_string(),
                row.id.clone(),
                row.status.clone(),
                code,
                attempts,
            ];
            cells.extend(row.values.iter().cloned());
            cells.extend(row.errors.iter().chain(&row.floors).map(number));
            cells.extend(COSTS.map(cost));
            cells.extend(row.hashes.iter().cloned());
            cells.extend([
                row.message.clone(),
                row.role.word(),
                relative("wall_s"),
                relative("cpu_s"),
            ]);
            lines.push(line(&cells));
        }
        lines.concat()
    }

    /// Number of scenes.
    pub fn scenes(&self) -> usize {
        self.rows.last().map_or(0, |row| row.scene + 1)
    }

    /// The reference of a scene, where it is a run of this study.
    pub fn reference(&self, scene: usize) -> Option<&Row> {
        let mut rows = self.rows.iter();
        rows.find(|row| row.scene == scene && row.role == Role::Reference)
    }
}

/// Enters floors and relative costs into the rows of a scene.
fn relate(rows: &mut [Row], file: &StudyFile, reference: Option<&RunFiles>) {
    let perturbed = rows
        .iter()
        .filter(|row| matches!(row.role, Role::Perturbed(_)));
    let floors = (0..file.measure.len()).map(|place| {
        let errors: Option<Vec<f64>> = perturbed.clone().map(|row| row.error(place)).collect();
        let errors = errors.filter(|errors| !errors.is_empty())?;
        Some(errors.into_iter().fold(0.0, f64::max))
    });
    let floors: Vec<Option<f64>> = floors.collect();
    let unknown = perturbed
        .clone()
        .any(|row| row.exit_code.is_some() && !row.stands());
    let whole = reference.map(RunFiles::cost).unwrap_or_default();
    for row in rows {
        row.floors.clone_from(&floors);
        if unknown {
            add(
                &mut row.message,
                "the floor of noise is not known: a perturbed reference did not complete",
            );
        }
        let parts = row.cost.iter().filter_map(|(name, number)| {
            let whole = whole.get(name).filter(|whole| **whole > 0.0)?;
            Some((name.clone(), number / whole))
        });
        row.cost_rel = parts.collect();
    }
}

/// The run of a task that came to its end.
fn finished(folder: &Path, task: &Task) -> Result<Option<RunFiles>, Error> {
    let of = TaskFolder::new(folder, &task.id);
    match of.stage()? {
        Stage::Done(outcome) if ["completed", "suspect"].contains(&outcome.status.as_str()) => {
            RunFiles::read(&of.run()).map(Some)
        }
        _ => Ok(None),
    }
}

fn row(task: &Task, measures: &[Measure], held: Held, folder: &Path) -> Result<Row, Error> {
    let of = TaskFolder::new(folder, &task.id);
    let run = finished(folder, task)?;
    let (status, exit_code, message) = match of.stage()? {
        Stage::Waiting => ("waiting".to_string(), None, String::new()),
        Stage::Running => ("running".to_string(), None, String::new()),
        Stage::Done(done) => (done.status, Some(done.exit_code), done.message),
    };
    let mut row = Row {
        index: task.index,
        role: task.role,
        scene: task.scene,
        id: task.id.clone(),
        status,
        exit_code,
        attempts: of.attempts(),
        values: task.values.clone(),
        varied: task.varied.clone(),
        errors: vec![None; measures.len()],
        deviations: vec![None; measures.len()],
        floors: vec![None; measures.len()],
        cost: BTreeMap::new(),
        cost_rel: BTreeMap::new(),
        hashes: Default::default(),
        message,
    };
    let Some(run) = run else {
        return Ok(row);
    };
    for (place, measure) in measures.iter().enumerate() {
        match measure.deviation(&run, held) {
            Ok(deviation) => {
                row.errors[place] = Some(deviation.abs());
                row.deviations[place] = Some(deviation);
            }
            Err(why) => add(&mut row.message, &format!("error_{}: {why}", measure.name)),
        }
    }
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
    let all = run.summary["warnings"].as_array().into_iter().flatten();
    let told = all.filter_map(|warning| {
        let (code, place) = (warning["code"].as_str()?, warning["where"].as_str()?);
        Some(format!("{code} at {place}: {}", warning["value"].as_f64()?))
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
pub fn line(cells: &[String]) -> String {
    let cells: Vec<String> = cells.iter().map(|cell| quoted(cell)).collect();
    cells.join(",") + "\n"
}

/// A cell as RFC 4180 has it.
fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n', '\r']) {
        format!(
            "\"{}\"",
            cell.replace('"', "\"\"").replace(['\n', '\r'], " ")
        )
    } else {
        cell.to_string()
    }
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
