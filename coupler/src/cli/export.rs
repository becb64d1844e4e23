//! `thirdbody export`: the exchange of a run as CSV tables, and its wall-clock times as a trace.

use std::path::{Path, PathBuf};

use kit::keys::proposal;
use protocol::Kind;

use super::common::{RecoverArgument, VerbResult, file_of, log_of, print};
use exchange_log::export::{Selection, bytes, long, wide};
use exchange_log::timing;
use exchange_log::trace;
use scenario::error::{Code, DAMAGED, Error, Refusal};
use terminal::print_note;

/// Size of the tables above which a note comes before they are written (bytes).
const MANY_BYTES: u64 = 50_000_000;

/// Arguments of `export`.
#[derive(Debug, clap::Args)]
pub struct ExportArguments {
    /// Run directory, or an exchange.mcap (with --trace a timing.mcap).
    run: PathBuf,
    /// FILE.csv for one table in long form (one number per row), or a folder for one table per stream in wide form (one message per row).
    /// With --trace, FILE.json (default: trace.json beside timing.mcap).
    #[arg(long, required_unless_present = "trace")]
    out: Option<PathBuf>,
    /// Export only messages that this participant sends or receives.
    #[arg(long)]
    node: Option<String>,
    /// Export only messages of this kind, for example Motion.
    #[arg(long)]
    kind: Option<String>,
    /// Export only every Nth window, from the first on.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    every: Option<u64>,
    /// Write a trace of work and waiting in wall-clock time, for ui.perfetto.dev, instead of tables.
    #[arg(long, conflicts_with_all = ["node", "kind", "recover"])]
    trace: bool,
    /// Restrict the trace to windows A to B, both included.
    #[arg(long, value_name = "A..B", requires = "trace", value_parser = windows)]
    windows: Option<trace::Windows>,
    #[command(flatten)]
    damaged: RecoverArgument,
}

/// Writes the tables or the trace, of a log that ends early the valid part. If the log is damaged inside, the exit code is 6.
pub fn export(arguments: &ExportArguments) -> VerbResult {
    match &arguments.out {
        Some(out) if !arguments.trace => tables(arguments, out),
        out => trace(arguments, out.as_deref()),
    }
}

fn tables(arguments: &ExportArguments, out: &Path) -> VerbResult {
    let log = log_of(&arguments.run)?;
    let selection = Selection {
        node: arguments.node.clone(),
        kind: arguments.kind.as_deref().map(kind_named).transpose()?,
        every: arguments.every,
    };
    refuse_existing(out)?;
    let is_long = out.extension().is_some_and(|ending| ending == "csv");
    let bytes = bytes(&log, &selection, is_long)?;
    if bytes > MANY_BYTES {
        let less = ["", "a folder in place of the file, "][usize::from(is_long)];
        let megabytes = bytes as f64 * 1e-6;
        print_note(&format!(
            "about {megabytes:.0} MB of text; {less}--every 10, --node or --kind reduce it"
        ));
    }
    let exported = if is_long {
        long(&log, &selection, out)?
    } else {
        wide(&log, &selection, out)?
    };
    let mut code = 0;
    if let Some(damage) = exported.damage {
        print_note(&format!(
            "the log ends early, its valid part is exported: {damage}"
        ));
        if !damage.is_torn() && !arguments.damaged.recover {
            code = DAMAGED;
        }
    }
    if exported.messages == 0 && code == 0 {
        let text = "no message matches: `thirdbody inspect` lists the streams";
        return Err(Refusal::other(Code::NothingChosen, text).into());
    }
    print(&format!("{} messages", exported.messages))?;
    for file in &exported.files {
        print(&file.display().to_string())?;
    }
    Ok(code)
}

fn trace(arguments: &ExportArguments, out: Option<&Path>) -> VerbResult {
    let file = file_of(&arguments.run, timing::TIMING);
    if !file.is_file() {
        let problem = "no such file: runs with run.output.exchange = false and runs of older builds have no wall-clock times; give a run directory, or run the scenario again";
        return Err(Refusal::file(file, problem).into());
    }
    let beside = file.with_file_name("trace.json");
    let out = out.unwrap_or(&beside);
    refuse_existing(out)?;
    let timing = timing::read(&file)?;
    let traced = trace::write(&timing, arguments.windows, out)?;
    for note in &traced.notes {
        print_note(&format!("note: {note}"));
    }
    let megabytes = 1e-6 * traced.bytes as f64;
    print(&format!("{} events, {megabytes:.1} MB", traced.events))?;
    print(&out.display().to_string())
}

fn refuse_existing(out: &Path) -> Result<(), Error> {
    let fills = || std::fs::read_dir(out).is_ok_and(|mut files| files.next().is_some());
    if out.is_file() || fills() {
        let problem = "exists already; an export never overwrites anything";
        return Err(Refusal::argument(format!("--out {}", out.display()), problem).into());
    }
    Ok(())
}

fn windows(text: &str) -> Result<trace::Windows, String> {
    let ends = text.split_once("..").map(|(first, last)| [first, last]);
    let numbers = ends.map(|ends| ends.map(|end| end.trim().parse::<u64>().ok()));
    match numbers {
        Some([Some(first), Some(last)]) if first <= last => Ok([first, last]),
        _ => Err("expected two window numbers, the first not above the last: 100..200".into()),
    }
}

fn kind_named(name: &str) -> Result<Kind, Error> {
    let mut kinds = Kind::WORDS.to_vec();
    kinds.retain(|(kind, _)| kind.is_exchange());
    let mut all = kinds.iter();
    if let Some((kind, _)) = all.find(|(_, known)| known.eq_ignore_ascii_case(name)) {
        return Ok(*kind);
    }
    let names: Vec<&str> = kinds.iter().map(|(_, name)| *name).collect();
    let meant = proposal(name, "kinds", &names);
    let problem = format!("no such kind of message; {meant}");
    Err(Refusal::argument(format!("--kind {name}"), problem).into())
}
