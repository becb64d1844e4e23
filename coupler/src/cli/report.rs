//! `thirdbody report`: pictures and a page of what a run left.

use std::path::{Path, PathBuf};

use super::common::{VerbResult, print};
use runs::front::MeasuredFront;
use study::scene_front::first_front;
use study::stored::known;
use terminal::tell;

/// Arguments of `report`.
#[derive(Debug, clap::Args)]
pub struct ReportArguments {
    /// A run directory.
    run: PathBuf,
    /// Lay another run over it: its curves beside this run's, and the distances between both.
    #[arg(long, value_name = "RUN2")]
    compare: Option<PathBuf>,
    /// Write movie.html instead: a player of the fields at all their moments, a page of its own of at most 5 MB.
    #[arg(long)]
    movie: bool,
}

/// Writes report.html and its pictures, or movie.html, into the run directory. They do not show the log; one that is damaged has
/// exit code 6, as a table that is not what the run wrote.
pub fn report(arguments: &ReportArguments) -> VerbResult {
    let (names, damage) = if arguments.movie {
        let (name, note) = report::movie::write(&arguments.run)?;
        note.iter().for_each(|note| tell(note));
        (vec![name], None)
    } else {
        let front = known_front(&arguments.run);
        report::write(&arguments.run, arguments.compare.as_deref(), front.as_ref())?
    };
    for name in names {
        print(&arguments.run.join(name).display().to_string())?;
    }
    damage.map_or(Ok(()), Err)?;
    let damage = exchange_log::damage(&arguments.run.join("exchange.mcap"))?;
    damage.map_or(Ok(0), |damage| Err(damage.into()))
}

/// The run among the settings of the first known study that covers its scene.
fn known_front(run: &Path) -> Option<MeasuredFront> {
    let resolved = std::fs::read_to_string(run.join("scenario.toml")).ok()?;
    first_front(known(), &resolved, |error| {
        tell(&format!("{error}; the report goes on without this study"));
    })
}
