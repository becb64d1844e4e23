//! `thirdbody resume`: continue a run that was cut off.

use std::path::{Path, PathBuf};

use super::common::{
    RecoverArgument, VerbResult, refuse_commands, restart_point, thread_count, threads,
};
use super::run::{EndingArguments, conclude};
use super::start::options;
use coordinator::participants::Registry;
use coordinator::run::session::run_from;
use exchange_log::damage;
use scenario::error::Refusal;
use scenario::inputs::refuse_changed_inputs;
use scenario::load::load;
use terminal::print_note;

/// Arguments of `resume`.
#[derive(Debug, clap::Args)]
pub struct ResumeArguments {
    /// Run directory of an interrupted or killed run; it is not changed.
    run: PathBuf,
    /// Continue from the latest checkpoint after at most WINDOW windows (default: the latest usable checkpoint).
    #[arg(long, value_name = "WINDOW")]
    from: Option<u64>,
    /// Run directory of the resumed run, new or empty (default: a new folder in runs/).
    #[arg(long)]
    out: Option<PathBuf>,
    /// Threads per participant; results never depend on this number (default: the number of cores).
    #[arg(long, value_parser = thread_count())]
    threads: Option<u16>,
    /// Run all participants on this host, over shared memory, wherever they ran before.
    #[arg(long)]
    here: bool,
    /// Start the programs that the run's scenario names.
    #[arg(long)]
    allow_commands: bool,
    #[command(flatten)]
    damaged: RecoverArgument,
    #[command(flatten)]
    ending: EndingArguments,
}

/// Continues a run and returns its exit code. Refuses a damaged log unless `--recover` is given.
pub fn resume(arguments: &ResumeArguments, registry: &Registry) -> VerbResult {
    let run = &resolved(&arguments.run);
    if !run.join("scenario.toml").is_file() {
        return Err(Refusal::file(run, "no run directory with a scenario.toml").into());
    }
    let mut loaded = load(&run.to_string_lossy(), &[])?;
    if arguments.here {
        loaded.scenario.bring_here();
    }
    if !arguments.allow_commands {
        refuse_commands(&loaded.scenario)?;
    }
    refuse_changed_inputs(run)?;
    if !arguments.damaged.recover
        && let Some(damage) = damage(&run.join("exchange.mcap"))?
    {
        return Err(damage.into());
    }
    let origin = restart_point(run, &loaded, arguments.from)?;
    let begins = "no checkpoint to continue from, the run starts again";
    print_note(&match &origin {
        Some(origin) => format!("continues from {}", origin.path.display()),
        None => format!("{}: {begins}", run.display()),
    });
    let (out, threads) = (arguments.out.as_deref(), threads(arguments.threads));
    let mut options = options(out, threads, registry)?;
    options.listener = terminal::listener();
    options.strict = arguments.ending.strict;
    let ended = run_from(&loaded, &options, origin.as_ref())?;
    conclude(ended, arguments.ending)
}

/// The folder behind the path: runs/latest points to the resumed run as soon as that run begins.
fn resolved(run: &Path) -> PathBuf {
    let whole = run.canonicalize().unwrap_or_else(|_| run.into());
    let here = std::env::current_dir().and_then(|here| here.canonicalize());
    let below = here.ok().and_then(|here| whole.strip_prefix(here).ok());
    below.map_or(whole.clone(), Path::to_path_buf)
}
