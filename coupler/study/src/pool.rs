//! The local engine: a pool of processes, one per task.

use std::collections::VecDeque;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

use super::heartbeats::HeartbeatWatch;
use super::open_study::TaskCommand;
use super::plan::Task;
use super::progress::StudyProgress;
use super::task::{SILENT, TaskStage};
use scenario::error::Error;

/// Interval of checks of the processes.
const LOOK: Duration = Duration::from_millis(20);
/// Time in which a process can end in order.
const GRACE: Duration = Duration::from_secs(5);
/// Interval of checks of heartbeats, and of tasks that other processes run.
const LOOK_ELSEWHERE: Duration = Duration::from_secs(1);

impl TaskCommand {
    /// Starts the process of a task, which ends with this process.
    fn start(&self, task: &Task) -> Result<TaskProcess, Error> {
        let child = Command::new(&self.program)
            .args(&self.arguments)
            .arg(task.index.to_string())
            .args(["--parent", &std::process::id().to_string()])
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn();
        let child = child.map_err(Error::input("starting a task's process"))?;
        Ok(TaskProcess(child))
    }
}

/// The process of a task. Dropping it ends the process and waits for it, so that a refused study leaves no process behind.
struct TaskProcess(Child);

impl TaskProcess {
    /// Asks the process to end in order. After the process has ended, its id may belong to another one.
    fn interrupt(&mut self) {
        if let Ok(None) = self.0.try_wait() {
            let _ = kill(Pid::from_raw(self.0.id() as i32), Signal::SIGTERM);
        }
    }
}

impl Drop for TaskProcess {
    fn drop(&mut self) {
        self.interrupt();
        let asked = Instant::now();
        while let Ok(None) = self.0.try_wait() {
            if asked.elapsed() > GRACE {
                let _ = self.0.kill();
            }
            std::thread::sleep(LOOK);
        }
    }
}

/// Runs all unfinished runs, `jobs` at a time, and waits for runs of other processes as long as they have heartbeats. `stopped` ends the
/// loop in order.
///
/// # Errors
/// A process cannot be started, or a folder cannot be read. A run that fails is a row.
pub fn run(
    progress: &mut StudyProgress,
    exec: &TaskCommand,
    jobs: usize,
    stopped: impl Fn() -> bool,
) -> Result<(), Error> {
    let mut waiting: VecDeque<&Task> = progress.left()?.into();
    let mut running: Vec<(&Task, TaskProcess)> = Vec::new();
    let mut elsewhere: Vec<&Task> = Vec::new();
    let mut heartbeats = HeartbeatWatch::new(SILENT);
    let (mut looked, mut asked_to_stop) = (Instant::now(), false);
    while !running.is_empty() || !(stopped() || (waiting.is_empty() && elsewhere.is_empty())) {
        while running.len() < jobs.max(1) && !stopped() {
            let Some(task) = waiting.pop_front() else {
                break;
            };
            match progress.stage(task)? {
                TaskStage::Done(_) => {}
                TaskStage::Running => elsewhere.push(task),
                TaskStage::Waiting => running.push((task, exec.start(task)?)),
            }
        }
        std::thread::sleep(LOOK);
        progress.show();
        let look = looked.elapsed() > LOOK_ELSEWHERE;
        if look {
            looked = Instant::now();
        }
        for (task, mut process) in std::mem::take(&mut running) {
            let ended = process.0.try_wait();
            let ended = ended.map_err(Error::input("a task's process"))?;
            if ended.is_none() {
                // A process that is stopped but has not ended would block the loop forever.
                if look && heartbeats.is_over(&task.id, progress.folder(task).heartbeat()) {
                    let _ = process.0.kill();
                    heartbeats.forget(&task.id);
                }
                running.push((task, process));
                continue;
            }
            match progress.stage(task)? {
                TaskStage::Done(_) => {}
                TaskStage::Running => elsewhere.push(task),
                TaskStage::Waiting if stopped() || progress.gives_up(task) => {}
                TaskStage::Waiting => waiting.push_back(task),
            }
        }
        if look {
            for task in std::mem::take(&mut elsewhere) {
                let silent = heartbeats.is_over(&task.id, progress.folder(task).heartbeat());
                match progress.stage(task)? {
                    TaskStage::Done(_) => {}
                    TaskStage::Waiting => waiting.push_back(task),
                    TaskStage::Running if silent => {
                        progress.lost(task, "the process that holds it has no heartbeat");
                    }
                    TaskStage::Running => elsewhere.push(task),
                }
            }
        }
        if stopped() && !asked_to_stop {
            asked_to_stop = true;
            for (_, process) in &mut running {
                process.interrupt();
            }
        }
    }
    Ok(())
}
