//! The whole life of a participant in its own process.

use std::io::{BufRead, Write};
use std::path::PathBuf;
use std::time::Duration;

use nix::sys::prctl::set_pdeathsig;
use nix::sys::signal::Signal;
use nix::unistd::getppid;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use thiserror::Error;

use crate::link::shm::{self, ShmLink};
use crate::link::{Link, LinkError};
use crate::node::{Node, NodeError};
use crate::serve::{ServeError, serve};
use crate::session::{SESSION_VARIABLE, STANDARD_INPUT, Session, Transport};

/// The reason why a participant could not take part, or stopped.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum ParticipateError {
    #[error(
        "{SESSION_VARIABLE} is not set: this program is a participant, `thirdbody run` launches it"
    )]
    NoSession,
    #[error("session file {path}: {why}")]
    Session { path: PathBuf, why: String },
    #[error("the coordinator (process {0}) has ended")]
    Orphan(u32),
    #[error("the session asks for an in-process channel, but this participant is another process")]
    NoChannel,
    #[error(
        "the session is for another host, and this program was built without links between hosts: build it with the feature `zenoh`"
    )]
    NoNetwork,
    #[error("listening for signals: {0}")]
    Signals(std::io::Error),
    #[error("link to the coordinator: {0}")]
    Link(#[from] LinkError),
    #[error(transparent)]
    Serve(#[from] ServeError),
}

/// Takes part in the run that the environment names: reads the session, ties this process's life to the coordinator's, connects through
/// shared memory and serves the node that `build` makes.
///
/// The process ends on SIGTERM, SIGINT and SIGHUP, even during a computation. The system sends it SIGTERM when the coordinator
/// ends for any reason.
pub fn participate<F>(build: F) -> Result<(), ParticipateError>
where
    F: FnOnce(&Session) -> Result<Box<dyn Node>, NodeError>,
{
    participate_over(None, build)
}

/// A way to connect to a coordinator on another host.
pub type Connect = fn(&Session) -> Result<Box<dyn Link>, LinkError>;

/// Like [`participate`], for a program that can also connect to other hosts.
pub fn participate_over<F>(connect: Option<Connect>, build: F) -> Result<(), ParticipateError>
where
    F: FnOnce(&Session) -> Result<Box<dyn Node>, NodeError>,
{
    let mut session = read_session()?;
    end_on_signals(&session)?;
    if !session_is_input() {
        end_with_coordinator(&session, Signal::SIGTERM)?;
    }
    let mut link: Box<dyn Link> = match &session.transport {
        Transport::Shm { root, prefix } => {
            let patience = Duration::from_secs_f64(session.idle_deadline_s);
            let name = &session.setting.participant;
            Box::new(ShmLink::participant(root, prefix, name, patience)?)
        }
        Transport::Zenoh { .. } => connect.ok_or(ParticipateError::NoNetwork)?(&session)?,
        Transport::Channel => return Err(ParticipateError::NoChannel),
    };
    if !session.sees_run() {
        // These folders are on another host.
        (session.setting.fields, session.setting.cache) = (None, None);
    }
    Ok(serve(&session, &mut *link, build)?)
}

/// A participant must end on a signal without finishing a long computation first. If the coordinator is gone,
/// no other process may be left to remove the run's shared memory, so this one removes it.
fn end_on_signals(session: &Session) -> Result<(), ParticipateError> {
    let mut signals = Signals::new([SIGTERM, SIGINT, SIGHUP]).map_err(ParticipateError::Signals)?;
    let (pid, transport) = (session.coordinator_pid, session.transport.clone());
    // Behind a shell, this process has another parent.
    let its_child = is_child_of(pid);
    std::thread::spawn(move || {
        if let Some(signal) = signals.forever().next() {
            if let Transport::Shm { root, prefix } = &transport {
                let is_there = if its_child {
                    is_child_of(pid)
                } else {
                    shm::is_alive(prefix)
                };
                if !is_there {
                    let _ = shm::remove_run(root, prefix);
                }
            }
            let _ = writeln!(std::io::stderr(), "ended by signal {signal}");
            std::process::exit(128 + signal);
        }
    });
    Ok(())
}

/// The session that the environment names. If it is the first line of standard input, this process ends when the input ends: behind a
/// launcher such as ssh the coordinator is not its parent.
pub fn read_session() -> Result<Session, ParticipateError> {
    let path: PathBuf = std::env::var_os(SESSION_VARIABLE)
        .ok_or(ParticipateError::NoSession)?
        .into();
    let fault = |why: String| ParticipateError::Session {
        path: path.clone(),
        why,
    };
    let mut text = String::new();
    let read = if session_is_input() {
        std::io::stdin().lock().read_line(&mut text).map(drop)
    } else {
        std::fs::read_to_string(&path).map(|content| text = content)
    };
    read.map_err(|error| fault(error.to_string()))?;
    let session = serde_json::from_str(&text).map_err(|error| fault(error.to_string()))?;
    if session_is_input() {
        std::thread::spawn(|| {
            let _ = std::io::copy(&mut std::io::stdin(), &mut std::io::sink());
            let _ = writeln!(
                std::io::stderr(),
                "the coordinator closed its end of the input"
            );
            std::process::exit(1);
        });
    }
    Ok(session)
}

fn session_is_input() -> bool {
    std::env::var_os(SESSION_VARIABLE).is_some_and(|path| path == STANDARD_INPUT)
}

/// Ties the life of this process to the coordinator's: the system sends `signal` when the coordinator ends. A coordinator that ended
/// before the request took effect would go unnoticed, so the function then checks that it lives. Behind a shell the coordinator is
/// not the parent, and the system reports the end of the shell.
pub fn end_with_coordinator(session: &Session, signal: Signal) -> Result<(), ParticipateError> {
    let lives =
        || matches!(&session.transport, Transport::Shm { prefix, .. } if shm::is_alive(prefix));
    let pid = session.coordinator_pid;
    end_with_parent(pid, signal).or_else(|orphan| lives().then_some(()).ok_or(orphan))
}

/// Like [`end_with_coordinator`], for a process without a run.
pub fn end_with_parent(pid: u32, signal: Signal) -> Result<(), ParticipateError> {
    // Cannot fail with a valid signal, and the check below does not depend on the call.
    let _ = set_pdeathsig(signal);
    let is_there = is_child_of(pid).then_some(());
    is_there.ok_or(ParticipateError::Orphan(pid))
}

fn is_child_of(coordinator_pid: u32) -> bool {
    getppid().as_raw() as u32 == coordinator_pid
}
