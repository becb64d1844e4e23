//! `thirdbody inspect`: what a run directory or an exchange log holds.

use std::path::PathBuf;

use super::{VerbResult, print};
use crate::error::Error;
use crate::log::{LogError, LogSummary, summarize};

/// Arguments of `inspect`.
#[derive(Debug, clap::Args)]
pub struct InspectArguments {
    /// A run directory, or an exchange.mcap.
    path: PathBuf,
    /// Read the valid part of a log whose writer was killed.
    #[arg(long)]
    recover: bool,
}

/// Lists streams, windows and provenance. A damaged log has exit code 6.
pub fn inspect(arguments: &InspectArguments) -> VerbResult {
    let path = match arguments.path.is_dir() {
        true => arguments.path.join("exchange.mcap"),
        false => arguments.path.clone(),
    };
    if !path.is_file() {
        return Err(Error::Refused(format!(
            "{}: no such log; give a run directory or an exchange.mcap",
            path.display()
        )));
    }
    let summary =
        summarize(&path, arguments.recover).map_err(|error| propose_recovery(error, arguments))?;
    print(&describe(&summary));
    Ok(0)
}

fn propose_recovery(error: LogError, arguments: &InspectArguments) -> Error {
    if !arguments.recover {
        eprintln!(
            "note: `thirdbody inspect --recover {}` reads the valid part of a damaged log",
            arguments.path.display()
        );
    }
    Error::Log(error)
}

fn describe(summary: &LogSummary) -> String {
    let mut lines = vec![
        format!("run       {:016x}", summary.provenance.run_id),
        format!("windows   {}", summary.windows),
        format!("exchange  {}", summary.hash),
        format!(
            "{:<44} {:>9} {:>13}  windows",
            "stream", "messages", "payload bytes"
        ),
    ];
    lines.extend(summary.streams.iter().map(|stream| {
        format!(
            "{:<44} {:>9} {:>13}  {} to {}",
            stream.topic(),
            stream.messages,
            stream.bytes,
            stream.first_window,
            stream.last_window
        )
    }));
    if let Some(found) = &summary.non_finite {
        lines.push(format!(
            "first number that is not finite: {} at entry {} of {}, window {}, iteration {}",
            found.value, found.index, found.topic, found.window, found.iteration
        ));
    }
    if let Some(damage) = &summary.damage {
        lines.push(format!("the log ends early: {damage}"));
    }
    lines.push("manifest".into());
    lines.push(summary.provenance.manifest_json.clone());
    lines.join("\n")
}
