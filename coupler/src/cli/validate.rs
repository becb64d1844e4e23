//! `thirdbody validate`: the shipped scenes against what must come out of them.

use std::path::Path;

use clap::ValueEnum;

use super::common::{CHECK_FAILED, VerbResult, own_program, print_rows};
use crate::participants::{Registry, Watch};
use crate::validate::run_suite;
use crate::validate::suite::{Row, Runs};

/// Arguments of `validate`.
#[derive(Debug, clap::Args)]
pub struct ValidateArguments {
    /// Scenes to run: a folder below scenarios/.
    #[arg(long, default_value = "verification")]
    suite: Suite,
    /// Print the rows as JSON.
    #[arg(long)]
    json: bool,
}

/// The suites that ship.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Suite {
    /// Exact answers of the solvers alone and coupled.
    Verification,
    /// Inputs at their limits: right, refused by name, or detected.
    Extremes,
    /// The shipped scenes as they are, against their published and measured figures; takes minutes.
    Scenes,
}

/// Runs a suite; exit code 8 if a row does not hold.
pub fn validate(arguments: &ValidateArguments, registry: &Registry) -> VerbResult {
    let folder = match arguments.suite {
        Suite::Verification => Path::new("scenarios/verification"),
        Suite::Extremes => Path::new("scenarios/extremes"),
        Suite::Scenes => Path::new("scenarios"),
    };
    let runs = Runs {
        registry,
        program: own_program()?,
        threads: 1,
        watch: Watch::default(),
    };
    let rows = run_suite(folder, &runs)?;
    print_rows(&rows[..], arguments.json, table)?;
    let all_hold = rows.iter().all(|row| row.holds);
    Ok(if all_hold { 0 } else { CHECK_FAILED })
}

fn table(rows: &[Row]) -> String {
    let mut lines = vec![format!(
        "{:<5} {:>14} {:>14}  name (source)",
        "holds", "ours", "expected"
    )];
    lines.extend(rows.iter().map(|row| {
        let holds = if row.holds { "yes" } else { "NO" };
        let (ours, expected) = (number(&row.ours), number(&row.expected));
        let (name, source) = (&row.name, &row.source);
        format!("{holds:<5} {ours:>14} {expected:>14}  {name} ({source})")
    }));
    let failed = rows.iter().filter(|row| !row.holds).count();
    lines.push(format!("{} rows, {failed} do not hold", rows.len()));
    lines.join("\n")
}

fn number(value: &serde_json::Value) -> String {
    match value.as_f64() {
        Some(number) if value.is_f64() => format!("{number:.6e}"),
        _ => value.to_string(),
    }
}
