//! The progress of a study while an engine works on it: runs that are left, finished, and given up.

use std::collections::BTreeSet;
use std::time::Instant;

use serde_json::json;

use super::open_study::OpenStudy;
use super::plan::{Task, TaskRole, runs};
use super::task::{TaskFolder, TaskOutcome, TaskStage};
use runs::files::RunFiles;
use scenario::error::{Error, Refusal};
use terminal::stderr::{StderrMode, print_event, stderr_mode};
use terminal::{Count, print_note, tell_progress};

/// Largest number of attempts at a run: the cause of that many kills does not go away.
pub const MOST_ATTEMPTS: usize = 5;

/// Counts and messages of a running study.
pub struct StudyProgress<'a> {
    study: &'a OpenStudy,
    total: usize,
    done: BTreeSet<String>,
    given_up: BTreeSet<String>,
    begun: Instant,
    /// Runs that ended since the beginning.
    here: usize,
    count: Count,
    /// The first task of the first scene, in whose run the measures are looked up. A case with a scenario of its own may lack some.
    first: Option<usize>,
}

impl<'a> StudyProgress<'a> {
    /// The runs of a study.
    pub fn new(study: &'a OpenStudy) -> StudyProgress<'a> {
        let total = runs(&study.tasks).len();
        StudyProgress {
            study,
            total,
            done: BTreeSet::new(),
            given_up: BTreeSet::new(),
            begun: Instant::now(),
            here: 0,
            count: Count::new("study".into(), "runs", total),
            first: study
                .tasks
                .iter()
                .position(|task| task.scene == 0 && task.fidelity.is_some()),
        }
    }

    /// The folder of a task.
    pub fn folder(&self, task: &Task) -> TaskFolder {
        self.study.task_folder(task)
    }

    /// The unfinished runs; prints the number of finished ones.
    ///
    /// # Errors
    /// A folder cannot be read.
    pub fn left(&mut self) -> Result<Vec<&'a Task>, Error> {
        let mut left = Vec::new();
        for task in runs(&self.study.tasks) {
            match self.folder(task).stage()? {
                TaskStage::Done(_) => {
                    self.done.insert(task.id.clone());
                }
                _ => left.push(task),
            }
        }
        let (done, total) = (self.done.len(), self.total);
        if done > 0 {
            tell_progress(&format!("{done} of {total} runs are done"));
        }
        Ok(left)
    }

    /// Shows the number of finished runs, if an update is due.
    pub fn show(&mut self) {
        self.count.at(self.done.len());
    }

    /// The stage of a run; announces once that it has ended.
    ///
    /// # Errors
    /// The folder cannot be read; or the first run, which is the reference if there is one, lacks a measure.
    pub fn stage(&mut self, task: &Task) -> Result<TaskStage, Error> {
        let stage = self.folder(task).stage()?;
        if let TaskStage::Done(outcome) = &stage
            && self.done.insert(task.id.clone())
        {
            self.ended(task.index, outcome);
            if self.first == Some(task.index) && outcome.status == "completed" {
                self.check(task)?;
            }
        }
        Ok(stage)
    }

    /// Refuses measures that the reference, or without a reference the first run, does not have: no comparison would be possible.
    fn check(&self, task: &Task) -> Result<(), Error> {
        let run = RunFiles::read(&self.folder(task).run())?;
        for measure in &self.study.plan.file.measure {
            if let Err(why) = measure.number(&run) {
                let name = &measure.name;
                let place = match task.role {
                    TaskRole::Reference => "reference",
                    _ => "first run",
                };
                let problem = format!("measure `{name}`: {why} in the {place}, which has ended");
                return Err(Refusal::file(&run.path, problem).into());
            }
        }
        Ok(())
    }

    fn ended(&mut self, index: usize, outcome: &TaskOutcome) {
        self.here += 1;
        let each = self.begun.elapsed().as_secs_f64() / self.here as f64;
        let left = each * (self.total - self.done.len()) as f64;
        let (status, message) = (&outcome.status, &outcome.message);
        let colon = if message.is_empty() { "" } else { ": " };
        let (done, total) = (self.done.len(), self.total);
        let object = json!({
            "done": done,
            "runs": total,
            "task": index,
            "status": status,
            "message": message,
            "left_wall_s": left,
        });
        let words = || {
            format!("{done} of {total}: task {index} {status}{colon}{message}; {left:.0} s left")
        };
        if stderr_mode() != StderrMode::Quiet {
            print_event("task", object, words);
        }
    }

    /// True if a run whose process ended without an outcome is given up; else announces another attempt.
    pub fn gives_up(&mut self, task: &Task) -> bool {
        let attempts = self.folder(task).attempts();
        if attempts >= MOST_ATTEMPTS {
            let why = format!("it ended {attempts} times without an outcome");
            self.lost(task, &why);
            return true;
        }
        let (index, next) = (task.index, attempts + 1);
        print_note(&format!(
            "task {index} ended without an outcome and starts again (attempt {next})"
        ));
        false
    }

    /// Announces a run that is given up.
    pub fn lost(&mut self, task: &Task, why: &str) {
        if self.given_up.insert(task.id.clone()) {
            print_note(&format!("task {} is given up: {why}", task.index));
        }
    }
}
