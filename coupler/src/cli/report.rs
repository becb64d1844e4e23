//! `thirdbody report`: pictures and a page of what a run left.

use std::path::PathBuf;

use super::common::{VerbResult, print};
use crate::report;

/// Arguments of `report`.
#[derive(Debug, clap::Args)]
pub struct ReportArguments {
    /// A run directory.
    run: PathBuf,
}

/// Writes report.html and its pictures into the run directory.
pub fn report(arguments: &ReportArguments) -> VerbResult {
    for name in report::write(&arguments.run)? {
        print(&arguments.run.join(name).display().to_string())?;
    }
    Ok(0)
}
