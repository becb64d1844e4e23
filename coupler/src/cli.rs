//! The command line: one file per verb.

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
use terminal::stderr::{StderrMode, print_event, set_stderr_mode};

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
    /// Folder that keeps prepared samples and modes for later runs; `none` keeps nothing (default: thirdbody/ in the user's cache).
    #[arg(long, global = true, value_name = "DIR")]
    cache: Option<PathBuf>,
    /// Print no progress on stderr; warnings and errors still appear.
    #[arg(long, global = true, conflicts_with = "json_lines")]
    quiet: bool,
    /// Write stderr for programs, one JSON object per line; keys are in the manual, page `progress-for-programs`.
    #[arg(long, global = true)]
    json_lines: bool,
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// List the scenes and studies built into this program.
    #[command(alias = "list")]
    Scenes(crate::cli::scenes::ScenesArguments),
    /// Copy a built-in scene or study into a folder, to edit it there.
    New(new::NewArguments),
    /// Run a scenario: a folder, a file, a name under scenarios/, or a built-in scene.
    Run(run::RunArguments),
    /// Check a scenario without running it.
    Check(check::CheckArguments),
    /// Explain an error or warning by its code (cause and cure), a key, or a result.
    Explain(explain::ExplainArguments),
    /// Show the contents of a run directory or an exchange log.
    Inspect(inspect::InspectArguments),
    /// Write the exchange of a run as CSV tables, or its wall-clock times as a trace.
    Export(export::ExportArguments),
    /// Run each solver again against the logged other side and compare bit for bit.
    Replay(replay::ReplayArguments),
    /// Continue an interrupted or killed run from its last checkpoint.
    Resume(resume::ResumeArguments),
    /// Run a suite of built-in scenes and compare it with the expected results.
    Validate(validate::ValidateArguments),
    /// Test a participant, or a program in its place, against the rules of the protocol.
    Conform(conform::ConformArguments),
    /// Create a participant to start from: a folder with a solver and a scenario.
    NewNode(new_node::NewNodeArguments),
    /// Write report.html and its pictures for a run.
    Report(crate::cli::report::ReportArguments),
    /// Compare a run with a reference run: signals, tractions, results and costs.
    Compare(compare::CompareArguments),
    /// Run a scenario many times with varied keys and compare the runs with a reference.
    Study(crate::cli::study::StudyArguments),
    /// Find the cheapest setting of a scene that keeps an error, store it for `run --budget`, and run the scene with it.
    Tune(tune::TuneArguments),
    /// Benchmark the exchange and the coupling schemes.
    Bench(bench::BenchArguments),
    /// Print completions of this command for a shell.
    Completions(completions::CompletionsArguments),
    /// Print the manual page of this command, or write one page per verb into a folder.
    Man(man::ManArguments),
    /// Serve a shipped solver to the coordinator that started this process.
    Node(node::NodeArguments),
    /// Start a foreign participant that ends with its coordinator.
    #[command(hide = true)]
    ExecChild(node::ExecArguments),
    /// End this process group when standard input closes.
    #[command(hide = true)]
    EndGroup(node::EndGroupArguments),
}

/// The command line as clap has it, for those who document it.
pub fn command() -> clap::Command {
    Cli::command()
}

/// Runs the command line with the solvers that this binary ships.
pub fn main(registry: &Registry) -> ExitCode {
    // With this handler, a file at its size limit makes the write fail instead of ending the process.
    let _ = signal_hook::flag::register(SIGXFSZ, Arc::default());
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return usage(&error),
    };
    let cache = common::cache_folder(cli.cache);
    keep_below(cache.clone());
    set_stderr_mode(match (cli.quiet, cli.json_lines) {
        (_, true) => StderrMode::JsonLines,
        (true, _) => StderrMode::Quiet,
        _ => StderrMode::Progress,
    });
    // A key that wraps at the end of a line cannot be copied.
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

/// Prints an error on stderr; scenario errors point into the file.
fn print_error(error: Error) {
    let ending = (error.exit_code(), error.status());
    let object = error_object(ending, error.code(), &error.to_string());
    print_event("error", object, || match error {
        Error::Scenario(scenario) => format!("{:?}", scenario.report()),
        other => other.line(),
    });
}

/// An error as an object for programs, with its exit code and status.
fn error_object((exit_code, status): (i32, &str), code: Code, text: &str) -> Value {
    json!({ "exit_code": exit_code, "status": status, "code": code.word(), "text": text })
}

/// Prints help and version as clap does, and a usage error with its code.
fn usage(error: &clap::Error) -> ExitCode {
    let code = error.exit_code();
    if !error.use_stderr() {
        let _ = error.print();
        return ExitCode::from(code as u8);
    }
    // Parsing failed, so the option is searched for among the arguments.
    if std::env::args_os().any(|argument| argument == "--json-lines") {
        set_stderr_mode(StderrMode::JsonLines);
    }
    let plain = error.to_string();
    let plain = plain.trim_start_matches("error: ").trim_end();
    let object = error_object(Code::Usage.ending(), Code::Usage, plain);
    let text = if std::io::stderr().is_terminal() {
        error.render().ansi().to_string()
    } else {
        error.render().to_string()
    };
    let headed = format!("error[{}]:", Code::Usage.word());
    print_event("error", object, || {
        text.replacen("error:", &headed, 1).trim_end().into()
    });
    ExitCode::from(code as u8)
}
