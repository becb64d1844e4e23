//! `thirdbody report`: pictures and a page of what a run left.

use std::path::PathBuf;

use super::common::{VerbResult, print};
use crate::{log, report};

/// Arguments of `report`.
#[derive(Debug, clap::Args)]
pub struct ReportArguments {
    /// A run directory.
    run: PathBuf,
    /// Lay another run over it: its curves beside this run's, and the distances between both.
    #[arg(long, value_name = "RUN2")]
    compare: Option<PathBuf>,
}

/// Writes report.html and its pictures into the run directory. They do not show the log; one that is damaged has exit code 6.
pub fn report(arguments: &ReportArguments) -> VerbResult {
    for name in report::write(&arguments.run, arguments.compare.as_deref())? {
        print(&arguments.run.join(name).display().to_string())?;
    }
    let damage = log::damage(&arguments.run.join("exchange.mcap"))?;
    damage.map_or(Ok(0), |damage| Err(damage.into()))
}
