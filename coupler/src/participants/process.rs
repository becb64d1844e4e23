//! A participant in a process of its own.

use std::fs::File;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use protocol::Session;
use protocol::setting::SESSION_VARIABLE;

use crate::error::Error;

/// How long a participant that was asked to end may take before it is killed.
const GRACE: Duration = Duration::from_millis(1000);

/// Starts the command of a participant in its own process group (an interrupt from the keyboard must reach the coordinator alone,
/// which then ends the run in order), its output going to `<name>.log` in this folder.
pub fn spawn(command: &mut Command, session: &Session, logs: &Path) -> Result<Child, Error> {
    let name = &session.setting.participant;
    let path = logs.join(format!("{name}.session.json"));
    let text = serde_json::to_string_pretty(session).expect("our own types always serialise");
    std::fs::write(&path, text).map_err(Error::output(path.display()))?;
    let log_path = logs.join(format!("{name}.log"));
    let log = File::create(&log_path).map_err(Error::output(log_path.display()))?;
    let errors = log.try_clone().map_err(Error::output(log_path.display()))?;
    command
        .env(SESSION_VARIABLE, &path)
        .stdin(Stdio::null())
        .stdout(log)
        .stderr(errors)
        .process_group(0)
        .spawn()
        .map_err(Error::input(format!("starting participant `{name}`")))
}

/// Refuses a command that names no file, directly or on `PATH`.
pub fn require_program(participant: &str, program: &str) -> Result<(), Error> {
    match find_program(program) {
        Some(_) => Ok(()),
        None => Err(Error::Refused(format!(
            "participant `{participant}`: command `{program}` is not a program that can be started; give its path, or a name on PATH"
        ))),
    }
}

fn find_program(name: &str) -> Option<std::path::PathBuf> {
    if name.contains('/') {
        return Some(Path::new(name).to_path_buf()).filter(|path| path.is_file());
    }
    std::env::split_paths(&std::env::var_os("PATH")?)
        .map(|folder| folder.join(name))
        .find(|path| path.is_file())
}

/// Waits for a child that should end by itself, then asks it to, then ends it.
pub fn end(child: &mut Child) {
    let asked = Pid::from_raw(child.id() as i32);
    for signal in [None, Some(Signal::SIGTERM), Some(Signal::SIGKILL)] {
        if let Some(signal) = signal {
            // A stopped process receives nothing but SIGKILL before it is continued.
            let _ = kill(asked, signal);
        }
        let start = Instant::now();
        while start.elapsed() < GRACE {
            match child.try_wait() {
                Ok(None) => std::thread::sleep(Duration::from_millis(2)),
                Ok(Some(_)) | Err(_) => return,
            }
        }
    }
}

/// Whether a process is stopped (SIGSTOP, a debugger), read off the process table.
pub fn is_stopped(pid: u32) -> bool {
    std::fs::read_to_string(format!("/proc/{pid}/stat"))
        .ok()
        .and_then(|stat| {
            stat.rsplit_once(") ")
                .map(|(_, rest)| rest.starts_with(['T', 't']))
        })
        .unwrap_or(false)
}
