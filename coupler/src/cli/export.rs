//! `thirdbody export`: the exchange of a run as tables of text.

use std::path::PathBuf;

use protocol::Kind;
use protocol::setting::proposal;

use super::common::{RecoverArgument, VerbResult, log_of, print};
use crate::error::{DAMAGED, Error, Refusal};
use crate::log::export::{Selection, long, wide};
use crate::output::tell;

/// Arguments of `export`.
#[derive(Debug, clap::Args)]
pub struct ExportArguments {
    /// A run directory, or an exchange.mcap.
    run: PathBuf,
    /// FILE.csv for one table in long form (one number a row), or a folder for one table a stream in wide form (one
    /// message a row).
    #[arg(long)]
    out: PathBuf,
    /// Only what this participant sends or receives.
    #[arg(long)]
    node: Option<String>,
    /// Only messages of this kind, for instance Motion.
    #[arg(long)]
    kind: Option<String>,
    #[command(flatten)]
    damaged: RecoverArgument,
}

/// Writes the tables. Of a log that ends early, the valid beginning; if it is damaged inside, the exit code is 6.
pub fn export(arguments: &ExportArguments) -> VerbResult {
    let log = log_of(&arguments.run)?;
    let selection = Selection {
        node: arguments.node.clone(),
        kind: arguments.kind.as_deref().map(kind_named).transpose()?,
    };
    let out = &arguments.out;
    if out.is_file() || std::fs::read_dir(out).is_ok_and(|mut files| files.next().is_some()) {
        let problem = "it exists already; an export never overwrites anything";
        return Err(Refusal::argument(format!("--out {}", out.display()), problem).into());
    }
    let exported = if out.extension().is_some_and(|ending| ending == "csv") {
        long(&log, &selection, out)?
    } else {
        wide(&log, &selection, out)?
    };
    let mut code = 0;
    if let Some(damage) = exported.damage {
        tell(&format!(
            "the log ends early, its valid part is exported: {damage}"
        ));
        if !damage.is_torn() && !arguments.damaged.recover {
            code = DAMAGED;
        }
    }
    if exported.messages == 0 && code == 0 {
        return Err(Refusal::EmptyExport.into());
    }
    print(&format!("{} messages", exported.messages))?;
    for file in &exported.files {
        print(&file.display().to_string())?;
    }
    Ok(code)
}

fn kind_named(name: &str) -> Result<Kind, Error> {
    let kinds = Kind::WORDS
        .into_iter()
        .filter(|(kind, _)| kind.is_exchange());
    let same = |(_, known): &(Kind, &str)| known.eq_ignore_ascii_case(name);
    if let Some((kind, _)) = kinds.clone().find(same) {
        return Ok(kind);
    }
    let names: Vec<&str> = kinds.map(|(_, name)| name).collect();
    let problem = format!(
        "no such kind of message; {}",
        proposal(name, "kinds", &names)
    );
    Err(Refusal::argument(format!("--kind {name}"), problem).into())
}
