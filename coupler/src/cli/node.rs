//! `thirdbody node` and `exec-child`: this program as a participant.

use std::os::unix::process::CommandExt;
use std::process::Command;

use nix::sys::signal::Signal;
use protocol::participate;
use protocol::participate::{end_with_coordinator, read_session};

use super::common::VerbResult;
use crate::error::{Error, Refusal};
use crate::participants::Registry;

/// Arguments of `node`.
#[derive(Debug, clap::Args)]
pub struct NodeArguments {
    /// Kind of the solver: fem or dem.
    kind: String,
}

/// Arguments of `exec-child`.
#[derive(Debug, clap::Args)]
pub struct ExecArguments {
    /// Program and arguments.
    #[arg(trailing_var_arg = true, required = true)]
    command: Vec<String>,
}

/// Serves a shipped solver until the run ends.
pub fn node(arguments: &NodeArguments, registry: &Registry) -> VerbResult {
    let solver = registry
        .get(&arguments.kind)
        .ok_or_else(|| Refusal::NoSolver(arguments.kind.clone()))?;
    participate(solver.build).map_err(Refusal::from)?;
    Ok(0)
}

/// Becomes a foreign participant: asks for SIGKILL at the coordinator's end, which survives `exec`. A program that is
/// not ours may have no answer to anything milder.
pub fn exec_child(arguments: &ExecArguments) -> VerbResult {
    let session = read_session().map_err(Refusal::from)?;
    end_with_coordinator(session.coordinator_pid, Signal::SIGKILL).map_err(Refusal::from)?;
    let (program, rest) = (&arguments.command[0], &arguments.command[1..]);
    let error = Command::new(program).args(rest).exec();
    Err(Error::input(format!("cannot start `{program}`"))(error))
}
