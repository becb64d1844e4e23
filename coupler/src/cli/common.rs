//! Arguments and answers that several verbs share.

use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde_json::json;

use crate::error::{Error, Refusal};
use crate::scenario::Scenario;

/// The scenario and its overrides, as several verbs take them.
#[derive(Debug, clap::Args)]
pub struct ScenarioArguments {
    /// A folder with scenario.toml, a file, or a name under scenarios/.
    pub scenario: String,
    /// Override a key: run.seed=2, participant.rail.config.mesh.size_m=1e-4, interface.layer-base.substeps=9.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Threads of each participant (results never depend on it); by default the cores of the machine.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
}

impl ScenarioArguments {
    /// Threads of each participant.
    pub fn threads(&self) -> usize {
        threads(self.threads)
    }
}

/// Threads of each participant: as asked, or the cores of the machine.
pub(super) fn threads(asked: Option<u16>) -> usize {
    asked.map_or_else(
        || std::thread::available_parallelism().map_or(1, usize::from),
        usize::from,
    )
}

/// The log of a run directory, or the log itself.
pub(super) fn log_of(run: &Path) -> Result<PathBuf, Error> {
    let path = if run.is_dir() {
        run.join("exchange.mcap")
    } else {
        run.to_path_buf()
    };
    if path.is_file() {
        return Ok(path);
    }
    let problem = "no such log; give a run directory or an exchange.mcap";
    Err(Refusal::file(path, problem).into())
}

/// Refuses a received scenario that starts programs which are not shipped: whoever sent it chose them.
pub(super) fn refuse_commands(scenario: &Scenario) -> Result<(), Error> {
    let mut participants = scenario.participant.iter();
    let foreign = participants.find_map(|participant| {
        let command = participant.command.as_ref()?;
        Some((&participant.name, command.join(" ")))
    });
    match foreign {
        None => Ok(()),
        Some((name, command)) => Err(Error::from(Refusal::ForeignCommand {
            participant: name.clone(),
            command,
        })),
    }
}

/// Exit code of a check that failed.
pub(super) const CHECK_FAILED: i32 = 8;

/// Exit code of a verb, or its error.
pub(super) type VerbResult = Result<i32, Error>;

/// Prints results. A reader that went away (a closed pipe) is not an error of ours; a full disk is.
pub(super) fn print(text: &str) -> Result<(), Error> {
    match writeln!(std::io::stdout().lock(), "{text}") {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Error::output("stdout")(error)),
        _ => Ok(()),
    }
}

/// Prints rows as JSON, or as a table.
pub(super) fn print_rows<R: Serialize + ?Sized>(
    rows: &R,
    json: bool,
    table: impl FnOnce(&R) -> String,
) -> Result<(), Error> {
    print(&if json {
        json!({ "results": rows }).to_string()
    } else {
        table(rows)
    })
}

/// Path of this program, to be started again as a participant.
pub(super) fn own_program() -> Result<PathBuf, Error> {
    std::env::current_exe().map_err(Error::input("finding this program"))
}
