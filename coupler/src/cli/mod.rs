//! The command line: one file a verb.

use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use serde::Serialize;
use serde_json::json;

use crate::error::{Error, Refusal};
use crate::launch::Registry;
use crate::scenario::Scenario;

pub mod bench;
pub mod check;
pub mod export;
pub mod inspect;
pub mod node;
pub mod replay;
pub mod report;
pub mod resume;
pub mod run;
pub mod validate;

/// Concurrent FE-DEM co-simulation of wheel, third body and rail.
#[derive(Debug, Parser)]
#[command(name = "thirdbody", version, about)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Run a scenario: a folder, a file, or a name under scenarios/.
    Run(run::RunArguments),
    /// Check a scenario without running it.
    Check(check::CheckArguments),
    /// Show what a run directory or an exchange log holds.
    Inspect(inspect::InspectArguments),
    /// Write the exchange of a run as tables of text (CSV).
    Export(export::ExportArguments),
    /// Run each solver again against the logged other side, and compare bit for bit.
    Replay(replay::ReplayArguments),
    /// Go on with a run that was interrupted or killed, from its last checkpoint.
    Resume(resume::ResumeArguments),
    /// Run the shipped verification scenes against what must come out of them.
    Validate(validate::ValidateArguments),
    /// Draw what a run left: report.html and its pictures.
    Report(report::ReportArguments),
    /// Measure what the machine gives.
    Bench(bench::BenchArguments),
    /// Serve a shipped solver to the coordinator that launched this process.
    Node(node::NodeArguments),
    /// Start a foreign participant whose life is tied to the coordinator's.
    #[command(hide = true)]
    ExecChild(node::ExecArguments),
}

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
pub fn threads(asked: Option<u16>) -> usize {
    asked.map_or_else(
        || std::thread::available_parallelism().map_or(1, usize::from),
        usize::from,
    )
}

/// The log of a run directory, or the log itself.
fn log_of(run: &Path) -> Result<PathBuf, Error> {
    let path = match run.is_dir() {
        true => run.join("exchange.mcap"),
        false => run.to_path_buf(),
    };
    match path.is_file() {
        true => Ok(path),
        false => Err(Error::from(Refusal::file(
            path,
            "no such log; give a run directory or an exchange.mcap",
        ))),
    }
}

/// Refuses a received scenario that starts programs which are not shipped: whoever sent it chose them.
fn refuse_commands(scenario: &Scenario) -> Result<(), Error> {
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
const CHECK_FAILED: i32 = 8;

/// What a verb came to, for the exit code.
pub type VerbResult = Result<i32, Error>;

/// Runs the command line with the solvers that this binary ships.
pub fn main(registry: &Registry) -> ExitCode {
    let result = match Cli::parse().verb {
        Verb::Run(arguments) => run::run(&arguments, registry),
        Verb::Check(arguments) => check::check(&arguments, registry),
        Verb::Inspect(arguments) => inspect::inspect(&arguments),
        Verb::Export(arguments) => export::export(&arguments),
        Verb::Replay(arguments) => replay::replay(&arguments, registry),
        Verb::Resume(arguments) => resume::resume(&arguments, registry),
        Verb::Validate(arguments) => validate::validate(&arguments, registry),
        Verb::Report(arguments) => report::report(&arguments),
        Verb::Bench(arguments) => bench::bench(&arguments, registry),
        Verb::Node(arguments) => node::node(&arguments, registry),
        Verb::ExecChild(arguments) => node::exec_child(&arguments),
    };
    let code = result.unwrap_or_else(|error| {
        let code = error.exit_code();
        print_error(error);
        code
    });
    ExitCode::from(code as u8)
}

/// Tells on stderr what went wrong; scenario errors point into the file.
fn print_error(error: Error) {
    match error {
        Error::Scenario(scenario) => eprintln!("{:?}", miette::Report::new(*scenario)),
        other => eprintln!("error: {other}"),
    }
}

/// Prints results. A reader that went away (a closed pipe) is not an error of ours; a full disk is.
fn print(text: &str) -> Result<(), Error> {
    match writeln!(std::io::stdout().lock(), "{text}") {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Error::output("stdout")(error)),
        _ => Ok(()),
    }
}

/// Prints rows as JSON, or as a table.
fn print_rows<R: Serialize + ?Sized>(
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

/// Where this program lies, to be started again as a participant.
pub fn own_program() -> Result<PathBuf, Error> {
    std::env::current_exe().map_err(Error::input("finding this program"))
}
