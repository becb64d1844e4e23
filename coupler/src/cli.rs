//! The command line: one file a verb.

use std::io::IsTerminal;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use clap::{CommandFactory, Parser, Subcommand};
use serde_json::{Value, json};
use signal_hook::consts::SIGXFSZ;

use ::scenes::kept::keep_below;
use coordinator::participants::Registry;
use scenario::error::{Code, Error};
use terminal::stderr::{StderrMode, set_stderr_mode, tell_of};

pub mod bench;
mod budget;
pub mod check;
mod common;
pub mod compare;
pub mod completions;
pub mod conform;
pub mod explain;
pub mod export;
pub mod inspect;
pub mod man;
pub mod new;
pub mod new_node;
pub mod node;
pub mod replay;
pub mod report;
pub mod resume;
pub mod run;
pub mod scenes;
mod seeds;
mod start;
pub mod study;
mod study_new;
pub mod tune;
pub mod validate;

/// Concurrent FE-DEM co-simulation of wheel, third body and rail.
#[derive(Debug, Parser)]
#[command(name = "thirdbody", version, about)]
struct Cli {
    /// Folder in which prepared samples are kept for later runs, or none; by default thirdbody/ in the user's cache.
    #[arg(long, global = true, value_name = "DIR")]
    cache: Option<PathBuf>,
    /// Show no progress on stderr; warnings and errors stay.
    #[arg(long, global = true, conflicts_with = "json_lines")]
    quiet: bool,
    /// Write stderr for programs: one JSON object a line. The page `progress-for-programs` of the manual has the keys.
    #[arg(long, global = true)]
    json_lines: bool,
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// List the scenes that are inside this program.
    #[command(alias = "list")]
    Scenes(crate::cli::scenes::ScenesArguments),
    /// Copy a scene of this program into a folder, to be changed.
    New(new::NewArguments),
    /// Run a scenario: a folder, a file, a name under scenarios/, or a scene of this program.
    Run(run::RunArguments),
    /// Check a scenario without running it.
    Check(check::CheckArguments),
    /// Tell cause and cure of an error or a warning by its code, or what a key or a result is.
    Explain(explain::ExplainArguments),
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
    /// Try the rules of the wire on one participant, or on a program in its place.
    Conform(conform::ConformArguments),
    /// Make a participant to begin with: a folder with a solver, a scenario, and what to do next.
    NewNode(new_node::NewNodeArguments),
    /// Draw what a run left: report.html and its pictures.
    Report(crate::cli::report::ReportArguments),
    /// Hold a run against another one: signals, tractions, results and costs.
    Compare(compare::CompareArguments),
    /// Run a scenario many times with other numbers, and hold the runs against a reference.
    Study(crate::cli::study::StudyArguments),
    /// Find the cheapest setting of a scene that keeps an error, store it for `run --budget`, and run the scene with it.
    Tune(tune::TuneArguments),
    /// Measure what the machine gives.
    Bench(bench::BenchArguments),
    /// Write completions of this command for a shell.
    Completions(completions::CompletionsArguments),
    /// Write the manual page of this command, or one a verb into a folder.
    Man(man::ManArguments),
    /// Serve a shipped solver to the coordinator that launched this process.
    Node(node::NodeArguments),
    /// Start a foreign participant whose life is tied to the coordinator's.
    #[command(hide = true)]
    ExecChild(node::ExecArguments),
    /// End this process group when the standard input ends.
    #[command(hide = true)]
    EndGroup(node::EndGroupArguments),
}

/// The command line as clap has it, for those who document it.
pub fn command() -> clap::Command {
    Cli::command()
}

/// Runs the command line with the solvers that this binary ships.
pub fn main(registry: &Registry) -> ExitCode {
    // A file that may not grow further is then an error of the write, not the end of the process.
    let _ = signal_hook::flag::register(SIGXFSZ, Arc::default());
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(told) => return usage(&told),
    };
    let cache = common::cache_folder(cli.cache);
    keep_below(cache.clone());
    set_stderr_mode(match (cli.quiet, cli.json_lines) {
        (_, true) => StderrMode::JsonLines,
        (true, _) => StderrMode::Quiet,
        _ => StderrMode::Progress,
    });
    // A key that is broken at the end of a line cannot be copied.
    let _ = miette::set_hook(Box::new(|_| {
        Box::new(miette::MietteHandlerOpts::new().wrap_lines(false).build())
    }));
    let registry = &Registry {
        cache,
        ..registry.clone()
    };
    let result = match cli.verb {
        Verb::Scenes(arguments) => crate::cli::scenes::scenes(&arguments),
        Verb::New(arguments) => new::new(&arguments, registry),
        Verb::Completions(arguments) => completions::completions(&arguments, Cli::command()),
        Verb::Man(arguments) => man::man(&arguments, Cli::command()),
        Verb::Run(arguments) => run::run(&arguments, registry),
        Verb::Check(arguments) => check::check(&arguments, registry),
        Verb::Explain(arguments) => explain::explain(&arguments, registry),
        Verb::Inspect(arguments) => inspect::inspect(&arguments),
        Verb::Export(arguments) => export::export(&arguments),
        Verb::Replay(arguments) => replay::replay(&arguments, registry),
        Verb::Resume(arguments) => resume::resume(&arguments, registry),
        Verb::Validate(arguments) => validate::validate(&arguments, registry),
        Verb::Conform(arguments) => conform::conform(&arguments, registry),
        Verb::NewNode(arguments) => new_node::new_node(&arguments),
        Verb::Report(arguments) => crate::cli::report::report(&arguments),
        Verb::Compare(arguments) => compare::compare(&arguments),
        Verb::Study(arguments) => crate::cli::study::study(&arguments, registry),
        Verb::Tune(arguments) => tune::tune(&arguments, registry),
        Verb::Bench(arguments) => bench::bench(&arguments, registry),
        Verb::Node(arguments) => node::node(&arguments, registry),
        Verb::ExecChild(arguments) => node::exec_child(&arguments),
        Verb::EndGroup(arguments) => node::end_group(&arguments),
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
    let ending = (error.exit_code(), error.status());
    let object = error_object(ending, error.code(), &error.to_string());
    tell_of("error", object, || match error {
        Error::Scenario(scenario) => format!("{:?}", scenario.report()),
        other => other.line(),
    });
}

/// An error with the exit code and the status that it ends with, as programs are told it.
fn error_object((exit_code, status): (i32, &str), code: Code, text: &str) -> Value {
    json!({ "exit_code": exit_code, "status": status, "code": code.word(), "text": text })
}

/// Help and version as clap prints them; what cannot be understood with its code.
fn usage(told: &clap::Error) -> ExitCode {
    let code = told.exit_code();
    if !told.use_stderr() {
        let _ = told.print();
        return ExitCode::from(code as u8);
    }
    // Nothing was parsed: what a program asks for is known by its word alone.
    if std::env::args_os().any(|argument| argument == "--json-lines") {
        set_stderr_mode(StderrMode::JsonLines);
    }
    let plain = told.to_string();
    let plain = plain.trim_start_matches("error: ").trim_end();
    let object = error_object(Code::Usage.ending(), Code::Usage, plain);
    let text = if std::io::stderr().is_terminal() {
        told.render().ansi().to_string()
    } else {
        told.render().to_string()
    };
    let headed = format!("error[{}]:", Code::Usage.word());
    tell_of("error", object, || {
        text.replacen("error:", &headed, 1).trim_end().into()
    });
    ExitCode::from(code as u8)
}
