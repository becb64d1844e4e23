//! `thirdbody resume`: go on with a run that was cut off.

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
use terminal::tell;

/// Arguments of `resume`.
#[derive(Debug, clap::Args)]
pub struct ResumeArguments {
    /// The run directory of a run that was interrupted or killed. It is not changed.
    run: PathBuf,
    /// Go on from the latest checkpoint after at most so many windows.
    #[arg(long, value_name = "WINDOW")]
    from: Option<u64>,
    /// Run directory of the resumed run: a new or an empty folder. By default a new one below runs/.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Threads of each participant (results never depend on it); by default the cores of the machine.
    #[arg(long, value_parser = thread_count())]
    threads: Option<u16>,
    /// Run all participants on this host, over shared memory, wherever they ran before.
    #[arg(long)]
    here: bool,
    /// Start programs that the scenario of the run names.
    #[arg(long)]
    allow_commands: bool,
    #[command(flatten)]
    damaged: RecoverArgument,
    #[command(flatten)]
    ending: EndingArguments,
}

/// Goes on; the exit code is the run's. A damaged log is not gone on with unless that is asked for.
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
    let begins = "no checkpoint to go on from, the run begins again";
    tell(&match &origin {
        Some(origin) => format!("goes on from {}", origin.path.display()),
        None => format!("{}: {begins}", run.display()),
    });
    let (out, threads) = (arguments.out.as_deref(), threads(arguments.threads));
    let mut options = options(out, threads, registry)?;
    options.listener = terminal::listener();
    options.strict = arguments.ending.strict;
    let ended = run_from(&loaded, &options, origin.as_ref())?;
    conclude(ended, arguments.ending)
}

/// The folder that the path stands for now: runs/latest points to the resumed run as soon as that begins.
fn resolved(run: &Path) -> PathBuf {
    let whole = run.canonicalize().unwrap_or_else(|_| run.into());
    let here = std::env::current_dir().and_then(|here| here.canonicalize());
    let below = here.ok().and_then(|here| whole.strip_prefix(here).ok());
    below.map_or(whole.clone(), Path::to_path_buf)
}
