//! `thirdbody report`: a page and pictures of a run.

use std::path::{Path, PathBuf};

use super::common::{VerbResult, print};
use runs::front::MeasuredFront;
use study::scene_front::first_front;
use study::stored::known;
use terminal::print_note;

/// Arguments of `report`.
#[derive(Debug, clap::Args)]
pub struct ReportArguments {
    /// Run directory.
    run: PathBuf,
    /// Overlay the curves of another run, and list the distances between both runs.
    #[arg(long, value_name = "RUN2")]
    compare: Option<PathBuf>,
    /// Write movie.html instead: a self-contained page of at most 5 MB that plays all saved fields.
    #[arg(long)]
    movie: bool,
}

/// Writes report.html and its pictures, or movie.html, into the run directory. The exit code is 6 if the log, which the pages do not
/// show, is damaged, or if a table differs from what the run wrote.
pub fn report(arguments: &ReportArguments) -> VerbResult {
    let (names, damage) = if arguments.movie {
        let (name, note, damage) = report::movie::write(&arguments.run)?;
        note.iter().for_each(|note| print_note(note));
        (vec![name], damage)
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
        print_note(&format!("{error}; the report leaves this study out"));
    })
}
