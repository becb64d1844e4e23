//! A study with its folder: the list of its tasks, the command that runs a task, and the results.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use super::collect::{Results, line};
use super::file::shipped_or_read;
use super::plan::{Plan, Task};
use super::task::TaskFolder;
use runs::run_dir::write_whole;
use scenario::error::Error;
use scenes::STUDY;

/// A study with its folder.
#[derive(Clone, Debug)]
pub struct OpenStudy {
    /// Its plan.
    pub plan: Plan,
    /// Its tasks.
    pub tasks: Vec<Task>,
    /// Folder of the tasks and results.
    pub folder: PathBuf,
}

/// The command that runs a task of a study: `study exec` without the index.
#[derive(Clone, Debug)]
pub struct TaskCommand {
    /// This program.
    pub program: PathBuf,
    /// Arguments before the index.
    pub arguments: Vec<OsString>,
}

/// Writes a file into a folder, which is created if it is missing; returns the path.
///
/// # Errors
/// The file cannot be written.
pub fn write_in(folder: &Path, name: &str, text: &str) -> Result<PathBuf, Error> {
    let path = folder.join(name);
    fs::create_dir_all(folder).map_err(Error::output(path.display()))?;
    write_whole(&path, text.as_bytes())?;
    Ok(path)
}

impl OpenStudy {
    /// Reads the scenarios of a plan.
    ///
    /// # Errors
    /// A scenario is refused.
    pub fn of(plan: Plan, folder: PathBuf) -> Result<OpenStudy, Error> {
        let tasks = plan.tasks()?;
        Ok(OpenStudy {
            plan,
            tasks,
            folder,
        })
    }

    /// Hash of its folder and of its runs.
    fn hash(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        hasher.update(self.folder.as_os_str().as_encoded_bytes());
        for task in &self.tasks {
            hasher.update(task.id.as_bytes());
        }
        hasher.finalize().to_hex()[..12].to_string()
    }

    /// Prefix of the names of its arrays in Slurm's queue.
    pub fn array_name(&self) -> String {
        format!("thirdbody-{}-{}", self.plan.file.study.name, self.hash())
    }

    /// The tasks, one per line, below the names of the columns.
    pub fn listed(&self) -> String {
        let keys = self.plan.file.vary.iter().map(|vary| vary.key.as_str());
        let head = ["index", "id", "role"].into_iter().chain(keys);
        let lines = self.tasks.iter().map(|task| {
            let first = [task.index.to_string(), task.id.clone(), task.role.word()];
            line(&[&first[..], &task.values].concat())
        });
        line(&Vec::from_iter(head)) + &lines.collect::<String>()
    }

    /// The study file, below the options that change it.
    ///
    /// # Errors
    /// The file has become unreadable.
    pub fn settings(&self) -> Result<String, Error> {
        let (plan, path) = (&self.plan, &self.plan.path);
        let text = shipped_or_read(path, STUDY).map_err(Error::input(path.display()))?;
        let small = if plan.is_small { " --small" } else { "" };
        let set = plan.set.iter().map(|set| format!(" --set {set}"));
        let set: String = set.collect();
        Ok(format!("# {}{small}{set}\n{text}", path.display()))
    }

    /// Writes the list of tasks to a file with the study's hash in its name and returns the path; the process of a task compares with it.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn keep_list(&self) -> Result<PathBuf, Error> {
        let name = format!("tasks-{}.csv", self.hash());
        write_in(&self.folder, &name, &self.listed())
    }

    /// The command that runs a listed task, with prepared samples in this cache.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn command(&self, program: PathBuf, cache: Option<&Path>) -> Result<TaskCommand, Error> {
        let plan = &self.plan;
        let mut arguments = vec!["study".into(), "exec".into(), plan.path.clone().into()];
        arguments.extend(plan.is_small.then(|| "--small".into()));
        for set in &plan.set {
            arguments.extend(["--set".into(), set.into()]);
        }
        arguments.extend(["--out".into(), self.folder.clone().into()]);
        arguments.extend(["--planned".into(), self.keep_list()?.into()]);
        arguments.extend(["--cache".into(), cache.unwrap_or(Path::new("none")).into()]);
        arguments.push("--index".into());
        Ok(TaskCommand { program, arguments })
    }

    /// The folder of a task.
    pub fn task_folder(&self, task: &Task) -> TaskFolder {
        TaskFolder::new(&self.folder, &task.id)
    }

    /// Results of the tasks so far.
    ///
    /// # Errors
    /// As [`Results::read`].
    pub fn results(&self) -> Result<Results<'_>, Error> {
        Results::read(&self.plan, &self.tasks, &self.folder)
    }
}
