//! A task in its folder: the files that its process writes and others read.
//!
//! `tasks/ID/` contains `attempts`, one line per attempt; `attempt-K/`, the run directory of the current attempt; `heartbeat`, which the
//! process of the task rewrites every two seconds; `lock`, which that process holds as long as it lives; and at the end `run/`, the run
//! directory, and `task.json`, the outcome. Thus a task is done, running, or waiting, also after a kill. Tasks share nothing else: they may
//! run on any machines that see the folder. On the machine of a task the lock shows whether it lives, on others its heartbeat.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, SystemTime};

use nix::errno::Errno;
use nix::fcntl::{Flock, FlockArg};
use serde::{Deserialize, Serialize};

use coordinator::run::session::{Ended, RunOptions, run};
use exchange_log::timing::TIMING;
use runs::run_dir::write_whole;
use scenario::error::Error;
use scenario::load::Loaded;

/// Interval of heartbeats.
const BEAT: Duration = Duration::from_secs(2);

/// A task whose heartbeat is older has no process any more. We have seen no machine so busy that a sleeping thread does not wake up for a
/// minute.
pub const SILENT: Duration = Duration::from_secs(60);

/// Endings that may have an external cause. If a second attempt ends like this, it is the outcome.
const CIRCUMSTANCES: [&str; 3] = ["peer_lost", "deadline", "output_failed"];

/// Time in which the signal that ended a participant also reaches the coordinator.
const SIGNAL_COMES: Duration = Duration::from_secs(1);

/// Outcome of a task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TaskOutcome {
    /// Status of the run; `refused` if nothing was started.
    pub status: String,
    /// Its exit code.
    pub exit_code: i32,
    /// Reason for an early end, with the code of the error; empty otherwise.
    pub message: String,
}

impl TaskOutcome {
    /// The outcome of a run, or of a refusal before the start.
    pub fn of(ended: Result<Ended, Error>) -> TaskOutcome {
        match ended {
            Err(error) => TaskOutcome {
                status: "refused".into(),
                exit_code: error.exit_code(),
                message: error.line(),
            },
            Ok(ended) => TaskOutcome {
                status: ended.summary.status.into(),
                exit_code: ended.summary.exit_code,
                message: ended.error.map_or(String::new(), |error| error.line()),
            },
        }
    }
}

/// Stage of a task.
#[derive(Clone, Debug, PartialEq)]
pub enum TaskStage {
    /// No process works on it.
    Waiting,
    /// A process works on it.
    Running,
    /// Finished.
    Done(TaskOutcome),
}

/// The folder of a task.
#[derive(Clone, Debug)]
pub struct TaskFolder {
    path: PathBuf,
}

impl TaskFolder {
    /// The folder of a task, in the folder of the study.
    pub fn new(study: &Path, id: &str) -> TaskFolder {
        TaskFolder {
            path: study.join("tasks").join(id),
        }
    }

    /// The run directory, once the task is done.
    pub fn run(&self) -> PathBuf {
        self.path.join("run")
    }

    /// Number of attempts.
    pub fn attempts(&self) -> usize {
        self.text("attempts").lines().count()
    }

    /// The Slurm job of the last attempt, if it was one.
    pub fn last_job(&self) -> Option<String> {
        let lines = self.text("attempts");
        let job = lines.lines().last()?.split_whitespace().nth(2)?;
        Some(job.to_string())
    }

    /// The latest heartbeat, a different text each time; empty before the first one.
    pub fn heartbeat(&self) -> String {
        self.text("heartbeat")
    }

    /// The text of one of its files; empty if the file is missing.
    fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path.join(name)).unwrap_or_default()
    }

    /// Its stage.
    ///
    /// # Errors
    /// Its files cannot be read.
    pub fn stage(&self) -> Result<TaskStage, Error> {
        if let Some(done) = self.done() {
            return Ok(done);
        }
        if !self.path.join("lock").exists() {
            return Ok(TaskStage::Waiting);
        }
        let free = self.lock()?.is_some() && !self.lives_elsewhere();
        // It may have ended between the two checks.
        let otherwise = match free {
            true => TaskStage::Waiting,
            false => TaskStage::Running,
        };
        Ok(self.done().unwrap_or(otherwise))
    }

    /// `Done` with the outcome, if there is one. A damaged file counts as missing: the task runs again.
    fn done(&self) -> Option<TaskStage> {
        let text = fs::read_to_string(self.path.join("task.json")).ok()?;
        serde_json::from_str(&text).ok().map(TaskStage::Done)
    }

    /// Removes the outcome, so that the task runs again.
    ///
    /// # Errors
    /// Its files cannot be removed.
    pub fn forget(&self) -> Result<(), Error> {
        let path = self.path.join("task.json");
        fs::remove_file(&path).map_err(Error::output(path.display()))
    }

    /// True if another machine works on it: its heartbeat is recent by the clock of the disk.
    fn lives_elsewhere(&self) -> bool {
        let host = self.heartbeat();
        let host = host.split_whitespace().next().unwrap_or_default();
        if host.is_empty() || host == own_host() {
            return false;
        }
        let beaten = modified(&self.path.join("heartbeat"));
        let probe = self.path.join(format!(".now-{}", std::process::id()));
        let now = fs::write(&probe, "").ok().and_then(|()| modified(&probe));
        let _ = fs::remove_file(&probe);
        let all = beaten.zip(now);
        all.is_some_and(|(beaten, now)| now.duration_since(beaten).unwrap_or_default() < SILENT)
    }

    /// The lock; `None` while another process holds it.
    fn lock(&self) -> Result<Option<Flock<File>>, Error> {
        let (file, path) = self.open("lock")?;
        match Flock::lock(file, FlockArg::LockExclusiveNonblock) {
            Ok(lock) => Ok(Some(lock)),
            Err((_, Errno::EWOULDBLOCK)) => Ok(None),
            Err((_, errno)) => Err(Error::output(path.display())(errno.into())),
        }
    }

    /// One of its files, opened to append.
    fn open(&self, name: &str) -> Result<(File, PathBuf), Error> {
        let path = self.path.join(name);
        let file = File::options().create(true).append(true).open(&path);
        Ok((file.map_err(Error::output(path.display()))?, path))
    }

    /// Runs the scenario of the task, unless it is finished or another process runs it. `keep_logs` keeps exchange log and checkpoints.
    ///
    /// # Errors
    /// The folder cannot be written. A failed run is an outcome.
    pub fn execute(
        &self,
        loaded: &Loaded,
        keep_logs: bool,
        options: &RunOptions,
    ) -> Result<TaskStage, Error> {
        fs::create_dir_all(&self.path).map_err(Error::output(self.path.display()))?;
        let Some(_lock) = self.lock()? else {
            return Ok(TaskStage::Running);
        };
        if let Some(done) = self.done() {
            return Ok(done);
        }
        if self.lives_elsewhere() {
            return Ok(TaskStage::Running);
        }
        let attempt = self.begin()?;
        let out = self.path.join(format!("attempt-{attempt}"));
        let options = &RunOptions {
            out: Some(&out),
            ..options.clone()
        };
        let (stop, stopped) = channel();
        let ended = thread::scope(|scope| {
            scope.spawn(|| self.beat(stopped));
            let ended = run(loaded, options);
            drop(stop);
            ended
        });
        let outcome = TaskOutcome::of(ended);
        if self.blames_circumstances(&outcome, attempt, options) {
            let _ = fs::remove_dir_all(&out);
            return Ok(TaskStage::Waiting);
        }
        // An interrupted task must run again; a task that was taken for dead already runs again.
        if outcome.status == "interrupted" || self.attempts() != attempt {
            let _ = fs::remove_dir_all(&out);
            return Ok(self.done().unwrap_or(TaskStage::Waiting));
        }
        if !keep_logs {
            // Nothing measures them, and many of them fill a disk. A failed removal only leaves a large folder.
            for log in ["exchange.mcap", TIMING] {
                let _ = fs::remove_file(out.join(log));
            }
            let _ = fs::remove_dir_all(out.join("checkpoints"));
        }
        self.finish(&out, &outcome)?;
        Ok(TaskStage::Done(outcome))
    }

    /// Writes heartbeats until the other end of the channel is dropped.
    fn beat(&self, stopped: Receiver<()>) {
        let path = self.path.join("heartbeat");
        let prefix = format!("{} {}", own_host(), std::process::id());
        for count in 0.. {
            // A disk that refuses a heartbeat also refuses results, and the run reports that.
            let _ = fs::write(&path, format!("{prefix} {count}\n"));
            if stopped.recv_timeout(BEAT) != Err(RecvTimeoutError::Timeout) {
                break;
            }
        }
    }

    /// True if a run that lost a participant, missed a deadline or could not write must run once more: a cluster that ends a task also ends
    /// its participants, some of them before the coordinator.
    fn blames_circumstances(
        &self,
        outcome: &TaskOutcome,
        attempt: usize,
        options: &RunOptions,
    ) -> bool {
        if !CIRCUMSTANCES.contains(&outcome.status.as_str()) {
            return false;
        }
        thread::sleep(SIGNAL_COMES);
        options.watch.interrupted().is_some() || attempt == 1
    }

    /// Counts the attempt, removes the files of killed attempts, and returns its number.
    fn begin(&self) -> Result<usize, Error> {
        for attempt in 1..=self.attempts() {
            remove(&self.path.join(format!("attempt-{attempt}")))?;
        }
        let (mut file, path) = self.open("attempts")?;
        let job = own_job().map_or(String::new(), |job| format!(" {job}"));
        writeln!(file, "{} {}{job}", own_host(), std::process::id())
            .map_err(Error::output(path.display()))?;
        Ok(self.attempts())
    }

    /// Renames the run directory, if there is one, and writes the outcome.
    fn finish(&self, out: &Path, outcome: &TaskOutcome) -> Result<(), Error> {
        let run = self.run();
        remove(&run)?;
        if out.exists() {
            fs::rename(out, &run).map_err(Error::output(run.display()))?;
        }
        let text = serde_json::to_string_pretty(outcome).unwrap_or_default();
        write_whole(&self.path.join("task.json"), text.as_bytes())
    }
}

/// Removes a folder, if it exists.
fn remove(folder: &Path) -> Result<(), Error> {
    if folder.exists() {
        fs::remove_dir_all(folder).map_err(Error::output(folder.display()))?;
    }
    Ok(())
}

fn modified(path: &Path) -> Option<SystemTime> {
    fs::metadata(path).and_then(|file| file.modified()).ok()
}

/// The Slurm job of this process, in the form for `scancel`.
fn own_job() -> Option<String> {
    let variable = |name: &str| std::env::var(name).ok();
    let array = variable("SLURM_ARRAY_JOB_ID")?;
    Some(format!("{array}_{}", variable("SLURM_ARRAY_TASK_ID")?))
}

fn own_host() -> String {
    let name = nix::unistd::gethostname().ok();
    let name = name.and_then(|name| name.into_string().ok());
    name.filter(|name| !name.contains(char::is_whitespace))
        .unwrap_or("unknown".into())
}
