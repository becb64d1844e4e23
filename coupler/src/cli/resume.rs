//! `thirdbody resume`: go on with a run that was cut off.

use std::path::{Path, PathBuf};

use super::common::{VerbResult, own_program, refuse_commands, threads};
use super::run::{conclude, listen};
use crate::error::{Error, Refusal};
use crate::participants::Registry;
use crate::run::checkpoint::{Unusable, find};
use crate::run::session::{Options, go_on};
use crate::scenario::load::load;

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
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Start programs that the scenario of the run names.
    #[arg(long)]
    allow_commands: bool,
    /// Print summary.json on stdout instead of a short table.
    #[arg(long)]
    json: bool,
}

/// Goes on; the exit code is the run's.
pub fn resume(arguments: &ResumeArguments, registry: &Registry) -> VerbResult {
    let run = &resolved(&arguments.run);
    if !run.join("scenario.toml").is_file() {
        return Err(Error::from(Refusal::file(
            run,
            "no run directory with a scenario.toml",
        )));
    }
    let loaded = load(&run.to_string_lossy(), &[])?;
    if !arguments.allow_commands {
        refuse_commands(&loaded.scenario)?;
    }
    let (origin, passed_over) = find(run, &loaded, arguments.from)?;
    tell(
        run,
        origin.as_ref().map(|origin| origin.path.as_path()),
        &passed_over,
    );
    let ended = go_on(
        &loaded,
        &Options {
            out: arguments.out.as_deref(),
            threads: threads(arguments.threads),
            registry,
            program: own_program()?,
            watch: listen()?,
            progress: true,
        },
        origin.as_ref(),
    )?;
    conclude(ended, arguments.json)
}

/// The folder that the path stands for now: runs/latest points to the resumed run as soon as that begins.
fn resolved(run: &Path) -> PathBuf {
    let Ok(whole) = run.canonicalize() else {
        return run.into();
    };
    let here = std::env::current_dir().and_then(|here| here.canonicalize());
    match here.map(|here| whole.strip_prefix(here).map(Path::to_path_buf)) {
        Ok(Ok(below)) => below,
        _ => whole,
    }
}

fn tell(run: &Path, taken: Option<&Path>, passed_over: &[Unusable]) {
    for unusable in passed_over {
        eprintln!("warning: {unusable}; the one before it is taken");
    }
    match taken {
        Some(path) => eprintln!("goes on from {}", path.display()),
        None => eprintln!(
            "{}: no checkpoint to go on from, the run begins again",
            run.display()
        ),
    }
}
