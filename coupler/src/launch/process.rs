//! A participant in a process of its own.

use std::fs::File;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Instant;

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use protocol::Session;
use protocol::setting::SESSION_VARIABLE;

use super::{GRACE, Launcher};
use crate::error::Error;
use crate::scenario::Participant;

/// Starts a participant in its own process group (an interrupt from the keyboard must reach the coordinator alone,
/// which then ends the run in order), its output going to `logs/<name>.log`.
pub fn spawn(
    launcher: &Launcher,
    participant: &Participant,
    session: &Session,
) -> Result<Child, Error> {
    let name = &participant.name;
    let path = launcher.rundir.logs().join(format!("{name}.session.json"));
    let text = serde_json::to_string_pretty(session).expect("our own types always serialise");
    std::fs::write(&path, text).map_err(Error::output(path.display()))?;
    let log_path = launcher.rundir.logs().join(format!("{name}.log"));
    let log = File::create(&log_path).map_err(Error::output(log_path.display()))?;
    let errors = log.try_clone().map_err(Error::output(log_path.display()))?;
    command(launcher, participant)?
        .env(SESSION_VARIABLE, &path)
        .stdin(Stdio::null())
        .stdout(log)
        .stderr(errors)
        .process_group(0)
        .spawn()
        .map_err(Error::input(format!("starting participant `{name}`")))
}

/// The shipped solvers are served by this very program; a foreign program is started through `exec-child`,
/// which ties its life to the coordinator's before handing over.
fn command(launcher: &Launcher, participant: &Participant) -> Result<Command, Error> {
    let mut command = Command::new(&launcher.program);
    match &participant.command {
        None => {
            launcher.registry.find(participant)?;
            command.args(["node", &participant.kind]);
        }
        Some(words) => {
            require_program(&participant.name, &words[0])?;
            command.args(["exec-child", "--"]).args(words);
        }
    }
    Ok(command)
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
                Ok(None) => std::thread::sleep(std::time::Duration::from_millis(2)),
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
