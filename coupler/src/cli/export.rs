//! `thirdbody export`: the exchange of a run as tables of text.

use std::path::PathBuf;

use protocol::Kind;
use protocol::setting::proposal;

use super::common::{VerbResult, log_of, print};
use crate::error::{Error, Refusal};
use crate::log::export::{Selection, long, wide};

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
}

/// Writes the tables. Of a log that ends early, the valid beginning.
pub fn export(arguments: &ExportArguments) -> VerbResult {
    let log = log_of(&arguments.run)?;
    let selection = Selection {
        node: arguments.node.clone(),
        kind: arguments.kind.as_deref().map(kind_named).transpose()?,
    };
    let out = &arguments.out;
    if out.is_file() || std::fs::read_dir(out).is_ok_and(|mut files| files.next().is_some()) {
        return Err(Error::from(Refusal::argument(
            format!("--out {}", out.display()),
            "it exists already; an export never overwrites anything",
        )));
    }
    let exported = if out.extension().is_some_and(|ending| ending == "csv") {
        long(&log, &selection, out)?
    } else {
        wide(&log, &selection, out)?
    };
    if let Some(damage) = exported.damage {
        eprintln!("the log ends early, its valid part is exported: {damage}");
    }
    if exported.messages == 0 {
        return Err(Error::from(Refusal::EmptyExport));
    }
    print(&format!("{} messages", exported.messages))?;
    for file in &exported.files {
        print(&file.display().to_string())?;
    }
    Ok(0)
}

fn kind_named(name: &str) -> Result<Kind, Error> {
    let kinds = (0..100).filter_map(Kind::from_number);
    let kinds: Vec<Kind> = kinds.filter(|kind| kind.is_exchange()).collect();
    let names: Vec<String> = kinds.iter().map(|kind| format!("{kind:?}")).collect();
    let same = |known: &String| known.eq_ignore_ascii_case(name);
    if let Some(found) = names.iter().position(same) {
        return Ok(kinds[found]);
    }
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let proposal = proposal(name, "kinds", &names);
    Err(Error::from(Refusal::argument(
        format!("--kind {name}"),
        format!("no such kind of message; {proposal}"),
    )))
}
