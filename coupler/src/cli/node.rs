//! `thirdbody node` and `exec-child`: this program as a participant.

use std::io::{ErrorKind, Write};
use std::os::unix::process::CommandExt;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::Duration;

use nix::sys::signal::{Signal, killpg};
use nix::unistd::getpgrp;
use protocol::link::shm;
use protocol::participate::{Connect, end_with_coordinator, participate_over, read_session};
use protocol::{Cause, Session, Transport};
use signal_hook::consts::SIGTERM;
use signal_hook::flag;

use super::common::VerbResult;
use coordinator::participants::Registry;
use runs::identity::build;
use scenario::error::{Code, Error, Refusal};

/// Arguments of `node`.
#[derive(Debug, clap::Args)]
pub struct NodeArguments {
    /// Kind of the solver: fem or dem.
    kind: String,
    /// Refuse to serve unless this program is of this build.
    #[arg(long, hide = true)]
    build: Option<String>,
}

/// Arguments of `exec-child`.
#[derive(Debug, clap::Args)]
pub struct ExecArguments {
    /// Pass the session as the first line of the program's input, which stays open.
    #[arg(long)]
    pass_session: bool,
    /// Program and arguments.
    #[arg(trailing_var_arg = true, required = true)]
    command: Vec<String>,
}

/// Connects to a coordinator on another host.
#[cfg(feature = "zenoh")]
const CONNECT: Option<Connect> = Some(|session| Ok(Box::new(network::connect(session)?)));
#[cfg(not(feature = "zenoh"))]
const CONNECT: Option<Connect> = None;

/// Serves a shipped solver until the run ends.
pub fn node(arguments: &NodeArguments, registry: &Registry) -> VerbResult {
    let kind = &arguments.kind;
    let text = || format!("no solver of kind `{kind}` is built in");
    let missing = || Refusal::other(Code::UnknownKind, text());
    let solver = registry.get(kind).ok_or_else(missing)?;
    let own = build().hash;
    if let Some(build) = arguments.build.as_ref().filter(|build| *build != own) {
        let text = format!(
            "this program is of build {own}, the coordinator of build {build}: the bits would differ; put the same program on both hosts"
        );
        return Err(Refusal::other(Code::Of(Cause::OtherRelease), text).into());
    }
    participate_over(CONNECT, solver.build).map_err(Refusal::from)?;
    Ok(0)
}

/// Becomes a foreign participant. It requests SIGKILL at the coordinator's end, and the request survives `exec`: a foreign program may
/// ignore milder signals.
pub fn exec_child(arguments: &ExecArguments) -> VerbResult {
    let session = read_session().map_err(Refusal::from)?;
    end_with_coordinator(&session, Signal::SIGKILL).map_err(Refusal::from)?;
    let failed = |what: &str| Error::input(format!("cannot start {what}"));
    let watcher = "the watcher of its process group";
    let own = std::env::current_exe().map_err(failed(watcher))?;
    let mut watch = Command::new(own);
    watch
        .arg("end-group")
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    let input = if arguments.pass_session {
        let (input, output) = std::io::pipe().map_err(failed(watcher))?;
        watch.arg("--pass-session").stdout(output);
        input.into()
    } else {
        Stdio::null()
    };
    watch.spawn().map_err(failed(watcher))?;
    // This also drops the pipe's other end, which would keep the input open.
    drop(watch);
    let (program, rest) = (&arguments.command[0], &arguments.command[1..]);
    let error = Command::new(program).args(rest).stdin(input).exec();
    Err(failed(&format!("`{program}`"))(error))
}

/// Time between SIGTERM and SIGKILL to a process group.
const GRACE: Duration = Duration::from_millis(300);

/// Arguments of `end-group`.
#[derive(Debug, clap::Args)]
pub struct EndGroupArguments {
    /// Print the session in one line first, and keep the output open: another program reads it.
    #[arg(long)]
    pass_session: bool,
}

/// Ends its process group when its input closes; the coordinator holds that open as long as it lives. The system would end only the
/// shell in front of a program. This process also removes the run's shared memory, as no other process may be left to do so.
pub fn end_group(arguments: &EndGroupArguments) -> VerbResult {
    let session = read_session().map_err(Refusal::from)?;
    let failed = || Error::input("watching the coordinator");
    if arguments.pass_session {
        pass_on(&session).map_err(failed())?;
    }
    // This process survives the SIGTERM to its group and then kills the rest of the group.
    flag::register(SIGTERM, Arc::default()).map_err(failed())?;
    std::io::copy(&mut std::io::stdin(), &mut std::io::sink()).map_err(failed())?;
    let _ = killpg(getpgrp(), Signal::SIGTERM);
    std::thread::sleep(GRACE);
    if let Transport::Shm { root, prefix } = &session.transport
        && !shm::is_alive(prefix)
    {
        let _ = shm::remove_run(root, prefix);
    }
    let _ = killpg(getpgrp(), Signal::SIGKILL);
    Ok(0)
}

/// Prints the session. A broken pipe is no error: the program ended early, and the coordinator notices that.
fn pass_on(session: &Session) -> std::io::Result<()> {
    let mut text = serde_json::to_vec(session)?;
    text.push(b'\n');
    let mut output = std::io::stdout();
    let written = output.write_all(&text).and_then(|()| output.flush());
    written.or_else(|error| match error.kind() {
        ErrorKind::BrokenPipe => Ok(()),
        _ => Err(error),
    })
}
