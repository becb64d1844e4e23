//! Arguments and output shared by several verbs.

use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use clap::builder::RangedI64ValueParser;
use protocol::Cause;
use serde::Serialize;
use serde_json::json;

use coordinator::run::checkpoint::{RestartPoint, find};
use scenario::error::{Code, Error, Refusal};
use scenario::keys::Scenario;
use scenario::load::{Loaded, load};
use terminal::print_note;

use scenes::kept::user_cache;

/// The scenario and its overrides, arguments of several verbs.
#[derive(Debug, clap::Args)]
pub struct ScenarioArguments {
    /// Scenario: a folder with scenario.toml, a file, a name under scenarios/, or a name from `thirdbody scenes`.
    pub scenario: String,
    /// Override a key, for example run.seed=2, participant.rail.config.mesh.size_m=1e-4 or interface.layer-base.substeps=9; repeatable.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Threads per participant; results never depend on this number (default: the number of cores).
    #[arg(long, value_parser = thread_count())]
    pub threads: Option<u16>,
}

impl ScenarioArguments {
    /// Reads the scenario with its overrides; prints a note if a local file hides a different built-in scene of that name.
    pub(super) fn load(&self) -> Result<Loaded, Error> {
        let loaded = load(&self.scenario, &self.set)?;
        let shipped = scenes::scene_file(&self.scenario);
        let shipped = shipped.and_then(|file| scenes::text(&file));
        let keys = |text: &str| text.parse::<toml::Table>().ok();
        let here = &loaded.source.text;
        if shipped.is_some_and(|text| text != here && keys(text) != keys(here)) {
            let (name, file) = (&self.scenario, &loaded.source.name);
            print_note(&format!(
                "`{name}` means {file}, which differs from the built-in scene of that name"
            ));
        }
        Ok(loaded)
    }

    /// Reads the scenario with its overrides and further ones.
    pub(super) fn with(&self, set: &[String]) -> Result<Loaded, Error> {
        load(&self.scenario, &[&self.set[..], set].concat())
    }

    /// Threads per participant.
    pub fn threads(&self) -> usize {
        threads(self.threads)
    }
}

/// A scenario as it is found from any folder: the absolute path of its file, or the name of a shipped scene.
pub(super) fn from_anywhere(scenario: &str, loaded: &Loaded) -> String {
    let file = Path::new(&loaded.source.name);
    let full = std::path::absolute(file).ok().filter(|_| file.is_file());
    full.map_or(scenario.to_string(), |path| path.display().to_string())
}

/// The folder for prepared samples and files of shipped scenes: as asked, nothing for `none`, or a folder in the user's cache.
pub(super) fn cache_folder(asked: Option<PathBuf>) -> Option<PathBuf> {
    match asked {
        None => user_cache(),
        Some(folder) if folder.as_os_str() == "none" => None,
        Some(folder) => Some(std::path::absolute(&folder).unwrap_or(folder)),
    }
}

/// Accepted numbers of threads per participant.
pub(super) fn thread_count() -> RangedI64ValueParser<u16> {
    clap::value_parser!(u16).range(1..=1024)
}

/// Threads per participant: as asked, or the number of cores.
pub(super) fn threads(asked: Option<u16>) -> usize {
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    asked.map_or_else(cores, usize::from)
}

/// A file of a run directory, or the file itself.
pub(super) fn file_of(run: &Path, name: &str) -> PathBuf {
    let folder = run.is_dir().then(|| run.join(name));
    folder.unwrap_or_else(|| run.to_path_buf())
}

/// The log of a run directory, or the log itself.
pub(super) fn log_of(run: &Path) -> Result<PathBuf, Error> {
    let path = file_of(run, "exchange.mcap");
    if path.is_file() {
        return Ok(path);
    }
    let problem = "no such log; give a run directory or an exchange.mcap";
    Err(Refusal::file(path, problem).into())
}

/// Refuses a received scenario that starts foreign programs: its sender chose them.
pub(super) fn refuse_commands(scenario: &Scenario) -> Result<(), Error> {
    let Some((participant, command)) = foreign(scenario) else {
        return Ok(());
    };
    let text = format!(
        "the scenario starts `{}` for participant `{participant}`: read it, then repeat with --allow-commands",
        command.join(" ")
    );
    Err(Refusal::other(Code::ForeignCommand, text).into())
}

/// The first foreign participant, and the command that starts it.
pub(super) fn foreign(scenario: &Scenario) -> Option<(&str, &[String])> {
    let mut participants = scenario.participant.iter();
    participants.find_map(|p| {
        let own = p.launch.as_deref().or(p.command.as_deref())?;
        Some((p.name.as_str(), own))
    })
}

/// The checkpoint from which a run continues; prints a warning for each unusable one.
pub(super) fn restart_point(
    run: &Path,
    loaded: &Loaded,
    from: Option<u64>,
) -> Result<Option<RestartPoint>, Error> {
    let (origin, passed_over) = find(run, loaded, from)?;
    for unusable in passed_over {
        let code = Code::Of(Cause::CheckpointUnusable).word();
        print_note(&format!(
            "warning[{code}]: {unusable}; the checkpoint before it is used"
        ));
    }
    Ok(origin)
}

/// Permission to use a damaged log.
#[derive(Debug, clap::Args)]
pub struct RecoverArgument {
    /// Accept the valid part of a damaged log instead of ending with exit code 6.
    #[arg(long)]
    pub recover: bool,
}

/// Exit code of a verb, or its error.
pub(super) type VerbResult = Result<i32, Error>;

/// Prints results; the exit code is 0. A closed pipe is no error, but a full disk is.
pub(super) fn print(text: &str) -> VerbResult {
    match writeln!(std::io::stdout().lock(), "{text}") {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Error::output("stdout")(error)),
        _ => Ok(0),
    }
}

/// Prints rows as JSON, or as a table; the exit code is 0.
pub(super) fn print_rows<R: Serialize + ?Sized>(
    rows: &R,
    json: bool,
    table: impl FnOnce(&R) -> String,
) -> VerbResult {
    print(&if json {
        json!({ "results": rows }).to_string()
    } else {
        table(rows)
    })
}

/// Path of this program, for starting it again as a participant.
pub(super) fn own_program() -> Result<PathBuf, Error> {
    std::env::current_exe().map_err(Error::input("finding this program"))
}
