//! The engine for a cluster: one job array of Slurm, whose tasks share only the folder.
//!
//! Slurm reports the queue. The tasks' own files show which tasks run, because Slurm calls a lost node RUNNING for minutes. Tasks that are
//! neither queued nor running are submitted again.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::io::Write as _;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use super::heartbeats::HeartbeatWatch;
use super::open_study::{OpenStudy, TaskCommand};
use super::plan::Task;
use super::progress::{MOST_ATTEMPTS, StudyProgress};
use super::task::TaskStage;
use scenario::error::{Error, Refusal};
use terminal::print_note;

/// Intervals of checks of the tasks' files, and of Slurm's queue.
const LOOK: Duration = Duration::from_millis(500);
const LOOK_QUEUE: Duration = Duration::from_secs(3);
/// Longest time without an answer from Slurm.
const UNANSWERED: Duration = Duration::from_secs(600);
/// Time after which a submitted job should be in the queue.
const SHOWN: Duration = Duration::from_secs(6);

/// Resources to request for a task.
#[derive(Clone, Copy, Debug)]
pub struct SlurmRequest {
    /// Wall-clock time (s).
    pub wall_s: f64,
    /// Memory (bytes).
    pub memory_bytes: u64,
    /// Cores.
    pub cores: u16,
}

/// The engine of one study.
#[derive(Clone, Debug)]
pub struct Slurm<'a> {
    /// The study.
    pub study: &'a OpenStudy,
    /// The command of a task.
    pub exec: TaskCommand,
    /// Tasks at a time; no limit if absent.
    pub throttle: Option<u16>,
    /// Resources to request for a task.
    pub ask: SlurmRequest,
    /// Further arguments of `sbatch`.
    pub extra: Vec<String>,
    /// Longest silence of a task that Slurm calls running.
    pub silent: Duration,
}

/// A task in Slurm's queue.
#[derive(Clone, Debug, PartialEq)]
pub struct Queued {
    /// `ARRAY_INDEX`, the form for `scancel`.
    pub job: String,
    /// Slurm's word for the state: `PENDING`, `RUNNING`, ...
    pub state: String,
}

/// Submissions of a task by this process.
#[derive(Clone, Debug, Default)]
struct Submitted {
    times: usize,
    last: Option<Instant>,
    /// Job of the last submission, once it was seen.
    job: Option<String>,
    /// Factor on the requested resources, for a task that ran out of time or memory.
    factor: u32,
}

impl Slurm<'_> {
    /// Submits all unfinished runs and watches them until they are finished; `stopped` leaves the rest to Slurm.
    ///
    /// # Errors
    /// Slurm refuses, or does not answer for ten minutes; a folder cannot be read. A run that fails is a row.
    pub fn run(
        &self,
        progress: &mut StudyProgress,
        stopped: impl Fn() -> bool,
    ) -> Result<(), Error> {
        let mut left = progress.left()?;
        let mut submitted: BTreeMap<usize, Submitted> = BTreeMap::new();
        let mut heartbeats = HeartbeatWatch::new(self.silent);
        let (mut answered, mut looked) = (Instant::now(), None::<Instant>);
        loop {
            for task in std::mem::take(&mut left) {
                if !matches!(progress.stage(task)?, TaskStage::Done(_)) {
                    left.push(task);
                }
            }
            if left.is_empty() {
                return Ok(());
            }
            if stopped() {
                let (count, names) = (left.len(), array_names(self.study, &left));
                print_note(&format!(
                    "{count} runs are left to Slurm; the same command continues with them, `scancel --name={names}` ends them"
                ));
                return Ok(());
            }
            if looked.is_none_or(|looked| looked.elapsed() > LOOK_QUEUE) {
                let first = looked.replace(Instant::now()).is_none();
                match queue(self.study, &left) {
                    // If Slurm has never answered, it is not available.
                    Err(why) if first || answered.elapsed() > UNANSWERED => return Err(why),
                    Err(_) => {}
                    Ok(queue) => {
                        answered = Instant::now();
                        self.mend(progress, &mut left, &queue, &mut submitted, &mut heartbeats)?;
                    }
                }
            }
            std::thread::sleep(LOOK);
            progress.show();
        }
    }

    /// Submits tasks that are neither queued nor alive, ends dead tasks that Slurm calls running, and gives up tasks with too many attempts.
    fn mend(
        &self,
        progress: &mut StudyProgress,
        left: &mut Vec<&Task>,
        queue: &BTreeMap<usize, Queued>,
        submitted: &mut BTreeMap<usize, Submitted>,
        heartbeats: &mut HeartbeatWatch,
    ) -> Result<(), Error> {
        let mut again: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        let mut given_up = Vec::new();
        for task in left.iter() {
            let known = submitted.entry(task.index).or_default();
            let folder = progress.folder(task);
            if let Some(queued) = queue.get(&task.index) {
                known.job = Some(queued.job.clone());
                if queued.state == "PENDING" {
                    heartbeats.forget(&task.id);
                    continue;
                }
                if !heartbeats.is_over(&task.id, folder.heartbeat()) {
                    continue;
                }
                let _ = slurm("scancel", &["--signal=KILL", &queued.job]);
                let _ = slurm("scancel", &[&queued.job]);
                let (index, Queued { job, state }) = (task.index, queued);
                print_note(&format!(
                    "task {index}: {job} is {state} but has no heartbeat"
                ));
            } else {
                let fresh = known.last.is_some_and(|last| last.elapsed() < SHOWN);
                let works = folder.stage()? != TaskStage::Waiting
                    && !heartbeats.is_over(&task.id, folder.heartbeat());
                if fresh || works {
                    continue;
                }
            }
            heartbeats.forget(&task.id);
            let times = known.times.max(folder.attempts());
            if times >= MOST_ATTEMPTS {
                progress.lost(task, &format!("it started {times} times and did not end"));
                given_up.push(task.index);
                continue;
            }
            if let Some(job) = known.job.take() {
                let state = ended(&job);
                let too_little = ["TIMEOUT", "OUT_OF_MEMORY"].contains(&state.as_str());
                known.factor *= if too_little { 2 } else { 1 };
                let index = task.index;
                print_note(&format!(
                    "task {index}: {job} ended as {state} and is submitted again"
                ));
            }
            known.factor = known.factor.max(1);
            known.times += 1;
            known.last = Some(Instant::now());
            again.entry(known.factor).or_default().push(task.index);
        }
        left.retain(|task| !given_up.contains(&task.index));
        let mut again = again.iter();
        again.try_for_each(|(factor, indices)| self.submit(indices, *factor))
    }

    /// Submits tasks as one array, or as several if Slurm's limit on indices requires it.
    fn submit(&self, indices: &[usize], factor: u32) -> Result<(), Error> {
        let start = Instant::now();
        let most = indices_most();
        let mut rest = indices;
        while let Some(first) = rest.first() {
            let offset = first / most * most;
            let count = rest.partition_point(|index| *index < offset + most);
            let (array, others) = rest.split_at(count);
            let local: Vec<usize> = array.iter().map(|index| index - offset).collect();
            let job = self.submit_array(&local, offset, factor)?;
            let (count, wall) = (array.len(), start.elapsed().as_secs_f64());
            print_note(&format!(
                "submitted {count} tasks as job array {job} ({wall:.2} s)"
            ));
            rest = others;
        }
        Ok(())
    }

    fn submit_array(&self, local: &[usize], offset: usize, factor: u32) -> Result<String, Error> {
        let logs = self.study.folder.join("slurm");
        std::fs::create_dir_all(&logs).map_err(Error::output(logs.display()))?;
        let throttle = self
            .throttle
            .map(|most| format!("%{most}"))
            .unwrap_or_default();
        let minutes = (self.ask.wall_s * f64::from(factor) / 60.0).ceil().max(1.0);
        let megabytes = (self.ask.memory_bytes * u64::from(factor)).div_ceil(1 << 20);
        let mut arguments = vec![
            "--parsable".to_string(),
            format!("--job-name={}-{offset}", self.study.array_name()),
            format!("--array={}{throttle}", ranges(local)),
            format!("--cpus-per-task={}", self.ask.cores),
            format!("--mem={megabytes}M"),
            format!("--time={minutes:.0}"),
            format!("--output={}/%A_%a.log", logs.display()),
        ];
        arguments.extend(self.extra.iter().cloned());
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let answer = with_input("sbatch", &arguments, &self.script(offset))?;
        // JOB or JOB;CLUSTER.
        let job = answer.trim().split(';').next().unwrap_or_default();
        Ok(job.to_string())
    }

    /// The script of an array: each array task runs one task of the study.
    fn script(&self, offset: usize) -> String {
        let arguments = self.exec.arguments.iter().map(|word| word.as_os_str());
        let words = [self.exec.program.as_os_str()].into_iter().chain(arguments);
        let words = words.map(|word| quoted(&word.to_string_lossy()));
        let words = Vec::from_iter(words).join(" ");
        format!("#!/bin/sh\nexec {words} $((SLURM_ARRAY_TASK_ID + {offset}))\n")
    }
}

/// Possible names of arrays with these tasks, separated by commas.
fn array_names(study: &OpenStudy, tasks: &[&Task]) -> String {
    let most = indices_most();
    let offsets = tasks.iter().map(|task| task.index / most * most);
    let offsets: BTreeSet<usize> = offsets.collect();
    let name = study.array_name();
    let names = offsets.iter().map(|offset| format!("{name}-{offset}"));
    Vec::from_iter(names).join(",")
}

/// States of these tasks of a study in Slurm's queue, by index.
///
/// # Errors
/// Slurm does not answer.
pub fn queue(study: &OpenStudy, tasks: &[&Task]) -> Result<BTreeMap<usize, Queued>, Error> {
    let names = format!("--name={}", array_names(study, tasks));
    let arguments = ["--noheader", "--array", "--format=%i|%T|%j", &names];
    Ok(parse_queue(&slurm("squeue", &arguments)?))
}

/// State of a job that has ended: from Slurm's memory of the last minutes, else from its accounting, if there is any.
pub fn ended(job: &str) -> String {
    let shown = slurm("scontrol", &["--oneliner", "show", "job", job]);
    let shown = shown.unwrap_or_default();
    let mut words = shown.split_whitespace();
    if let Some(state) = words.find_map(|word| word.strip_prefix("JobState=")) {
        return state.to_string();
    }
    let accounts = "--noheader --allocations --format=State --jobs".split(' ');
    let accounts = slurm("sacct", &Vec::from_iter(accounts.chain([job]))).unwrap_or_default();
    let state = accounts.split_whitespace().next();
    state.unwrap_or("no longer known to Slurm").to_string()
}

/// Largest number of indices of an array.
fn indices_most() -> usize {
    let config = slurm("scontrol", &["show", "config"]).unwrap_or_default();
    let line = config.lines().find(|line| line.starts_with("MaxArraySize"));
    let number = line.and_then(|line| line.split('=').nth(1)?.trim().parse().ok());
    // Slurm's default.
    number.unwrap_or(1001).max(1)
}

/// Runs one of Slurm's programs.
fn slurm(program: &str, arguments: &[&str]) -> Result<String, Error> {
    with_input(program, arguments, "")
}

/// Runs one of Slurm's programs; its stderr is the reason if it fails.
fn with_input(program: &str, arguments: &[&str], input: &str) -> Result<String, Error> {
    let mut child = Command::new(program)
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|why| {
            let problem = format!("`{program}` of Slurm: {why}: run this on a login node of Slurm; another scheduler can run each task by `thirdbody study exec`, see the manual, page `cluster`");
            Refusal::argument("--engine slurm", problem)
        })?;
    if let Some(mut stdin) = child.stdin.take() {
        // A program that does not read its input reports that by its exit.
        let _ = stdin.write_all(input.as_bytes());
    }
    let output = child.wait_with_output();
    let output = output.map_err(Error::input(format!("`{program}` of Slurm")))?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    let words = String::from_utf8_lossy(&output.stderr);
    let command = format!("{program} {}", arguments.join(" "));
    Err(Refusal::argument(command, words.trim().replace('\n', "; ")).into())
}

/// States of a job that has ended or is ending.
const OVER: &str = "COMPLETED CANCELLED FAILED TIMEOUT NODE_FAIL OUT_OF_MEMORY COMPLETING";

/// The queue as `squeue --array --format=%i|%T|%j` prints it. The last part of a name is the offset of the array's indices.
fn parse_queue(text: &str) -> BTreeMap<usize, Queued> {
    let entry = |line: &str| {
        let mut cells = line.trim().split('|');
        let (job, state, name) = (cells.next()?, cells.next()?, cells.next()?);
        let index: usize = job.rsplit_once('_')?.1.parse().ok()?;
        let offset: usize = name.rsplit_once('-')?.1.parse().ok()?;
        let [job, state] = [job, state].map(String::from);
        let is_over = OVER.split(' ').any(|over| over == state);
        (!is_over).then_some((index + offset, Queued { job, state }))
    };
    text.lines().filter_map(entry).collect()
}

/// Ascending indices as Slurm lists them: `0-3,7`.
fn ranges(indices: &[usize]) -> String {
    let mut text = String::new();
    let mut rest = indices;
    while let Some(first) = rest.first() {
        let run = rest.iter();
        let run = run.zip(*first..).take_while(|(a, b)| *a == b).count();
        let comma = if text.is_empty() { "" } else { "," };
        let _ = match run {
            1 => write!(text, "{comma}{first}"),
            _ => write!(text, "{comma}{first}-{}", first + run - 1),
        };
        rest = &rest[run..];
    }
    text
}

/// A word quoted for a shell.
fn quoted(word: &str) -> String {
    format!("'{}'", word.replace('\'', "'\\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_are_listed_in_ranges() {
        assert_eq!(ranges(&[0, 1, 2, 3, 7, 9, 10]), "0-3,7,9-10");
        assert_eq!(ranges(&[5]), "5");
        assert_eq!(ranges(&[]), "");
    }

    #[test]
    fn the_queue_is_read_by_index_and_offset() {
        let text = "12_0|RUNNING|thirdbody-a-b-0\n12_17|PENDING|thirdbody-a-b-0\n13_4|RUNNING|thirdbody-a-b-1001\n12_3|COMPLETING|thirdbody-a-b-0\nnonsense\n";
        let queue = parse_queue(text);
        let states: Vec<(usize, &str)> =
            queue.iter().map(|(k, q)| (*k, q.state.as_str())).collect();
        assert_eq!(states, [(0, "RUNNING"), (17, "PENDING"), (1005, "RUNNING")]);
        assert_eq!(queue[&1005].job, "13_4");
    }

    #[test]
    fn words_reach_the_shell_unchanged() {
        assert_eq!(quoted("a b'c$(d)"), "'a b'\\''c$(d)'");
    }
}
