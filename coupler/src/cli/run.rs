//! `thirdbody run`: launch, couple, record.

use std::path::PathBuf;

use super::budget::BudgetArguments;
use super::common::{ScenarioArguments, VerbResult, print};
use super::seeds;
use super::start::options;
use ::report::terminal::table;
use coordinator::participants::Registry;
use coordinator::run::session::{Ended, run as run_scenario};

/// Arguments of `run`.
#[derive(Debug, clap::Args)]
pub struct RunArguments {
    #[command(flatten)]
    scenario: ScenarioArguments,
    /// Run directory, new or empty (default: a new folder in runs/).
    #[arg(long)]
    out: Option<PathBuf>,
    /// Run the scene in parallel under N seeds, counted up from its own. Print the mean of each result with its 95 % interval and write one
    /// report that overlays the runs. Each run keeps tables and fields, but no log.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(2..=1000), conflicts_with_all = ["budget", "strict"])]
    seeds: Option<u64>,
    #[command(flatten)]
    budget: BudgetArguments,
    #[command(flatten)]
    ending: EndingArguments,
}

/// Arguments of the verbs that complete a run.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct EndingArguments {
    /// Print summary.json on stdout instead of a short table.
    #[arg(long)]
    json: bool,
    /// Print all results and balances (default: the most important ones).
    #[arg(long)]
    all: bool,
    /// End any run that has a warning as suspect, with exit code 8.
    #[arg(long)]
    pub(super) strict: bool,
}

/// Runs a scenario and returns the run's exit code.
pub fn run(arguments: &RunArguments, registry: &Registry) -> VerbResult {
    if let Some(count) = arguments.seeds {
        let EndingArguments { json, all, .. } = arguments.ending;
        let wanted = (arguments.out.as_deref(), json, all);
        return seeds::run(&arguments.scenario, count, wanted, registry);
    }
    let (loaded, budget) = arguments.budget.load(&arguments.scenario, registry)?;
    let threads = arguments.scenario.threads();
    let mut options = options(arguments.out.as_deref(), threads, registry)?;
    options.listener = terminal::listener();
    options.strict = arguments.ending.strict;
    options.budget = budget;
    conclude(run_scenario(&loaded, &options)?, arguments.ending)
}

/// Prints the summary of a run and returns the run's exit code.
pub(super) fn conclude(ended: Ended, ending: EndingArguments) -> VerbResult {
    let summary = &ended.summary;
    let printed = print(&if ending.json {
        summary.to_json()
    } else {
        table(&ended.path, summary.value(), &summary.warnings, ending.all)
    });
    let code = ended.summary.exit_code;
    ended.error.map_or(printed, Err).map(|_| code)
}
