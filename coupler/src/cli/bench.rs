//! `thirdbody bench`: times of the exchange, stability of the coupling schemes.

use std::path::PathBuf;

use clap::Subcommand;
use serde_json::Value;

use super::common::{VerbResult, own_program, print, print_rows};
use super::start::listen;
use coordinator::participants::Registry;
use lab::bench::{exchange, participant, stability};
use lab::conform::tested::ConformOptions;
use scenario::error::{CHECK_FAILED, Refusal};
use scenario::load::load;

/// Arguments of `bench`.
#[derive(Debug, clap::Args)]
pub struct BenchArguments {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Measure the time from a request of the coupler to the answer of a node, over shared memory.
    Exchange(ExchangeArguments),
    /// Map the stable and unstable cells of the coupling schemes: stability.csv, limits.csv and a picture.
    Stability {
        /// Folder for the files.
        #[arg(long)]
        out: PathBuf,
    },
    /// Serve as the other end of `exchange`.
    #[command(hide = true)]
    Echo,
}

/// Arguments of `exchange`; without any, the other end echoes its input.
#[derive(Debug, clap::Args)]
struct ExchangeArguments {
    /// Scenario with the participant to measure (default: an echo).
    #[arg(long, requires = "participant")]
    scenario: Option<String>,
    /// Name of the participant in the scenario.
    #[arg(long, requires = "scenario")]
    participant: Option<String>,
    /// Override a key of the scenario; repeatable.
    #[arg(long = "set", value_name = "KEY=VALUE", requires = "scenario")]
    set: Vec<String>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Program and arguments that replace the participant, or that are measured on their own, without configuration.
    #[arg(last = true)]
    command: Vec<String>,
}

/// Measures, and prints a table or JSON.
pub fn bench(arguments: &BenchArguments, registry: &Registry) -> VerbResult {
    match &arguments.what {
        What::Exchange(arguments) => exchange(arguments, registry),
        What::Stability { out } => {
            let findings = stability::bench(out)?;
            print(&findings.table())?;
            Ok(if findings.hold() { 0 } else { CHECK_FAILED })
        }
        What::Echo => Ok(exchange::echo().map(|()| 0).map_err(Refusal::from)?),
    }
}

/// Times the shipped echo, or a participant.
fn exchange(arguments: &ExchangeArguments, registry: &Registry) -> VerbResult {
    let json = arguments.json;
    let command = Some(&arguments.command[..]).filter(|words| !words.is_empty());
    let (loaded, name) = match (&arguments.scenario, &arguments.participant, command) {
        (Some(scenario), Some(name), _) => (load(scenario, &arguments.set)?, name.as_str()),
        (_, _, Some(_)) => (participant::scenario_of_a_command()?, participant::NAME),
        _ => return show(exchange::bench(&own_program()?)?, json),
    };
    let options = ConformOptions {
        registry,
        program: own_program()?,
        watch: listen()?,
        only: Vec::new(),
    };
    show(participant::bench(&loaded, name, command, &options)?, json)
}

/// A table, or JSON.
fn show(rows: impl serde::Serialize, json: bool) -> VerbResult {
    let rows = serde_json::to_value(rows).expect("rows are plain numbers");
    print_rows(&rows, json, table)
}

/// Rows with any columns: the names of the first row, then the values.
fn table(rows: &Value) -> String {
    let rows = rows.as_array().into_iter().flatten();
    let rows: Vec<_> = rows.filter_map(|row| row.as_object()).collect();
    let Some(first) = rows.first() else {
        return "nothing was measured".into();
    };
    let width = |name: &String| name.len().max(10);
    let header = first.keys().map(|name| format!("{name:>0$}", width(name)));
    let mut lines = vec![header.collect::<Vec<_>>().join("  ")];
    for row in &rows {
        let cells = first.keys();
        let cells = cells.map(|name| format!("{:>1$}", cell(&row[name]), width(name)));
        lines.push(cells.collect::<Vec<_>>().join("  "));
    }
    lines.join("\n")
}

/// Small numbers with an exponent, the others with a few decimals.
fn short(number: f64) -> String {
    match number.abs() {
        size if size > 0.0 && size < 0.05 => format!("{number:.1e}"),
        size if size < 1.0 => format!("{number:.3}"),
        _ => format!("{number:.1}"),
    }
}

fn cell(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Number(number) if number.is_f64() => short(number.as_f64().unwrap_or_default()),
        other => other.to_string(),
    }
}
