//! A participant in its own process.

use std::fs::File;
use std::io::{PipeWriter, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus};
use std::time::{Duration, Instant};

use nix::sys::resource::{Resource, getrlimit, setrlimit};
use nix::sys::signal::{Signal, killpg};
use nix::unistd::Pid;
use protocol::Session;
use protocol::link::shm;
use protocol::session::SESSION_VARIABLE;

use super::printed::Printed;
use scenario::error::{Code, Error, Refusal, Result};

/// Time for a participant to end by itself after its farewell, and to end after a signal.
const GRACE: Duration = Duration::from_millis(1000);

/// Time for a participant to end by itself when its run was cut off: it may be in a set-up that is no longer needed.
const CUT_OFF: Duration = Duration::from_millis(100);

/// The files of a run in shared memory; removed when dropped, after any end of the run.
pub struct SharedMemory {
    /// Folder of all runs.
    pub root: PathBuf,
    /// Beginning of the names of this run's files.
    pub prefix: String,
    /// Shows other runs that this run lives.
    _alive: Option<File>,
}

impl SharedMemory {
    /// The place of a run, after removal of the files of this user's dead coordinators.
    pub fn new(run_id: u64) -> SharedMemory {
        let root = shm::run_root();
        let _ = shm::remove_dead_runs(&root);
        let prefix = shm::run_prefix(std::process::id(), run_id);
        SharedMemory {
            root,
            _alive: shm::mark_alive(&prefix).ok(),
            prefix,
        }
    }
}

impl Drop for SharedMemory {
    fn drop(&mut self) {
        // Files that cannot be removed stay; the next run tries again.
        let _ = shm::remove_run(&self.root, &self.prefix);
    }
}

/// Number of bytes shown from the end of the log of a lost participant.
const LAST_WORDS: usize = 600;

/// A process whose output goes to a log; ended when dropped, with its whole process group.
pub struct Process {
    child: Child,
    /// Time for it to end by itself.
    grace: Duration,
    /// File with its output.
    log: PathBuf,
    /// Ends after the process.
    printed: Printed,
    /// The system closes it at any end of this process. It is the input of the watcher of a foreign program.
    _alive: PipeWriter,
}

impl Process {
    /// Its process id.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Notes that its run has reached its end: it may finish its writing.
    pub fn said_farewell(&mut self) {
        self.grace = GRACE;
    }

    /// The end of its output in one line, once it has ended.
    pub fn last_words(&mut self) -> String {
        self.printed.end();
        let text = std::fs::read(&self.log).unwrap_or_default();
        let text = String::from_utf8_lossy(&text);
        let start = text.len().saturating_sub(LAST_WORDS);
        let start = (start..text.len()).find(|at| text.is_char_boundary(*at));
        let lines = text[start.unwrap_or(text.len())..].lines();
        let lines = lines.map(str::trim).filter(|line| !line.is_empty());
        let line = lines.collect::<Vec<_>>().join(" | ");
        line.escape_debug().to_string()
    }

    /// Asks its process group to end.
    pub fn ask_to_end(&self) {
        self.signal(Signal::SIGTERM);
    }

    /// True if it ends by itself in this time.
    pub fn ends_within(&mut self, patience: Duration) -> bool {
        let start = Instant::now();
        while start.elapsed() < patience {
            match self.child.try_wait() {
                Ok(None) => std::thread::sleep(Duration::from_millis(2)),
                Ok(Some(_)) | Err(_) => return true,
            }
        }
        false
    }

    /// Its exit status, if it has ended.
    pub fn try_wait(&mut self) -> std::io::Result<Option<ExitStatus>> {
        self.child.try_wait()
    }

    /// Sends a signal to its process group.
    fn signal(&self, signal: Signal) {
        let _ = killpg(Pid::from_raw(self.id() as i32), signal);
    }

    /// Waits for its end during the grace, then sends SIGTERM, then SIGKILL.
    fn end(&mut self) {
        let stages = [
            (None, self.grace),
            (Some(Signal::SIGTERM), GRACE),
            (Some(Signal::SIGKILL), GRACE),
        ];
        for (signal, grace) in stages {
            // A stopped process ends only by SIGKILL until it is continued.
            if is_stopped(self.id()) {
                self.signal(Signal::SIGKILL);
            } else if let Some(signal) = signal {
                self.signal(signal);
            }
            if self.ends_within(grace) {
                return;
            }
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        self.end();
        // Children of a shell outlive the shell.
        self.signal(Signal::SIGKILL);
    }
}

/// Open files of the coordinator, and of each connection over shared memory: `two-rails` has 8 + 3 x 24 open, its nodes
/// fewer.
const OPEN_FILES: u64 = 24;
const OPEN_FILES_EACH: u64 = 26;

/// Refuses a limit on open files that is too low for these participants, after raising it as far as needed and allowed.
pub fn require_open_files(participants: usize) -> Result<()> {
    let needed = OPEN_FILES + OPEN_FILES_EACH * participants as u64;
    let Ok((now, most)) = getrlimit(Resource::RLIMIT_NOFILE) else {
        return Ok(());
    };
    let is_set = || setrlimit(Resource::RLIMIT_NOFILE, needed.min(most), most).is_ok();
    if now >= needed || !is_set() || most >= needed {
        return Ok(());
    }
    let why = format!(
        "they need {needed} open files, but this user may have {most}: raise the limit (ulimit -n), or set run.transport = \"channel\""
    );
    let what = format!("starting {participants} participants over shared memory");
    Err(Error::input(what)(std::io::Error::other(why)))
}

/// Starts the command of a participant in its own process group; its output goes to `<name>.log` in this folder. An
/// interrupt from the keyboard must reach the coordinator alone, which then ends the run in an orderly way.
pub fn spawn(mut command: Command, session: &Session, logs: &Path) -> Result<Process> {
    let name = &session.setting.participant;
    let path = logs.join(format!("{name}.session.json"));
    let text = serde_json::to_string_pretty(session).expect("our own types always serialise");
    // The session may hold secrets.
    let mut secret = File::options();
    secret.write(true).create(true).truncate(true).mode(0o600);
    let file = secret.open(&path);
    let written = file.and_then(|mut file| file.write_all(text.as_bytes()));
    written.map_err(Error::output(path.display()))?;
    let log_path = logs.join(format!("{name}.log"));
    let log = File::create(&log_path).map_err(Error::output(log_path.display()))?;
    let failed = || Error::input(format!("starting participant `{name}`"));
    let (words, printer) = std::io::pipe().map_err(failed())?;
    let errors = printer.try_clone().map_err(failed())?;
    let (watched, alive) = std::io::pipe().map_err(failed())?;
    let child = command
        .env(SESSION_VARIABLE, &path)
        .stdin(watched)
        .stdout(printer)
        .stderr(errors)
        .process_group(0)
        .spawn()
        .map_err(failed())?;
    // The command holds our ends of the pipe, which would keep it open.
    drop(command);
    let printed = Printed::keep(words, log).map_err(failed())?;
    Ok(Process {
        child,
        grace: CUT_OFF,
        log: log_path,
        printed,
        _alive: alive,
    })
}

/// Refuses a command that cannot start in this folder: it names no file there or on `PATH`, or the folder does not
/// exist.
pub fn require_program(participant: &str, program: &str, folder: &Path) -> Result<()> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let found = if program.contains('/') {
        folder.join(program).is_file()
    } else {
        std::env::split_paths(&path).any(|folder| folder.join(program).is_file())
    };
    let shown = folder.display();
    let problem = if !folder.is_dir() {
        format!(
            "command `{program}` starts in {shown}, the folder of its scenario, which no longer exists: restore it"
        )
    } else if found {
        return Ok(());
    } else {
        format!(
            "command `{program}` is not a program that can be started; give a name on PATH, or a path that is absolute or begins in {shown}, the folder of its scenario"
        )
    };
    let text = format!("participant `{participant}`: {problem}");
    Err(Refusal::other(Code::CommandNotFound, text).into())
}

/// True if a process is stopped (SIGSTOP, a debugger), by the process table.
pub fn is_stopped(pid: u32) -> bool {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
    let state = stat.rsplit_once(") ").map_or("", |(_, state)| state);
    state.starts_with(['T', 't'])
}
