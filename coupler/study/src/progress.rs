//! The progress of a study while an engine does its runs: what is left, what is done, and what is given up.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::json;

use super::plan::{Task, runs};
use super::task::{TaskFolder, TaskStage};
use coordinator::error::Error;
use coordinator::output::stderr::{Manner, manner, tell_of};
use coordinator::output::{Count, tell, tell_progress};

/// Attempts at a run. One that was killed so often is killed by something that does not go away.
pub const MOST_ATTEMPTS: usize = 5;

/// Counts and words of a study under way.
pub struct StudyProgress<'a> {
    tasks: &'a [Task],
    folder: PathBuf,
    total: usize,
    done: BTreeSet<String>,
    given_up: BTreeSet<String>,
    begun: Instant,
    /// Runs that ended since it began.
    here: usize,
    count: Count,
}

impl<'a> StudyProgress<'a> {
    /// The runs of these tasks in a folder.
    pub fn new(tasks: &'a [Task], folder: &Path) -> StudyProgress<'a> {
        let total = runs(tasks).len();
        StudyProgress {
            tasks,
            folder: folder.to_path_buf(),
            total,
            done: BTreeSet::new(),
            given_up: BTreeSet::new(),
            begun: Instant::now(),
            here: 0,
            count: Count::new("study".into(), "runs", total),
        }
    }

    /// The folder of a task.
    pub fn folder(&self, task: &Task) -> TaskFolder {
        TaskFolder::new(&self.folder, &task.id)
    }

    /// The runs that are not done; tells how many are.
    ///
    /// # Errors
    /// A folder cannot be read.
    pub fn left(&mut self) -> Result<Vec<&'a Task>, Error> {
        let mut left = Vec::new();
        for task in runs(self.tasks) {
            match self.folder(task).stage()? {
                TaskStage::Done(_) => {
                    self.done.insert(task.id.clone());
                }
                _ => left.push(task),
            }
        }
        if !self.done.is_empty() {
            tell_progress(&format!(
                "{} of {} runs are done",
                self.done.len(),
                self.total
            ));
        }
        Ok(left)
    }

    /// Shows how many runs are done, if it is time to.
    pub fn show(&mut self) {
        self.count.at(self.done.len());
    }

    /// Tells of a run that ended, once.
    ///
    /// # Errors
    /// Its folder cannot be read.
    pub fn ended(&mut self, task: &Task) -> Result<(), Error> {
        let TaskStage::Done(outcome) = self.folder(task).stage()? else {
            return Ok(());
        };
        if !self.done.insert(task.id.clone()) {
            return Ok(());
        }
        self.here += 1;
        let each = self.begun.elapsed().as_secs_f64() / self.here as f64;
        let left = each * (self.total - self.done.len()) as f64;
        let why = outcome.message;
        let colon = if why.is_empty() { "" } else { ": " };
        let (done, total, status) = (self.done.len(), self.total, outcome.status);
        let index = task.index;
        let object = json!({
            "done": done,
            "runs": total,
            "task": index,
            "status": status,
            "message": why,
            "left_wall_s": left,
        });
        let words =
            || format!("{done} of {total}: task {index} {status}{colon}{why}; {left:.0} s left");
        if manner() != Manner::Quiet {
            tell_of("task", object, words);
        }
        Ok(())
    }

    /// True where a run whose process ended without an outcome is not begun again.
    ///
    /// # Errors
    /// Its folder cannot be read.
    pub fn gives_up(&mut self, task: &Task) -> Result<bool, Error> {
        let attempts = self.folder(task).attempts();
        if attempts < MOST_ATTEMPTS {
            tell(&format!(
                "task {} ended without an outcome, and is begun again (attempt {})",
                task.index,
                attempts + 1
            ));
            return Ok(false);
        }
        self.lost(
            task,
            &format!("it ended {attempts} times without an outcome"),
        );
        Ok(true)
    }

    /// Tells of a run that is given up.
    pub fn lost(&mut self, task: &Task, why: &str) {
        if self.given_up.insert(task.id.clone()) {
            tell(&format!("task {} is given up: {why}", task.index));
        }
    }
}
