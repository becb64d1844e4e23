//! `thirdbody validate`: the shipped scenes against their expected results.

use std::path::{Path, PathBuf};

use clap::ValueEnum;

use super::common::{VerbResult, print_rows, thread_count};
use super::start::options;
use coordinator::participants::Registry;
use coordinator::run::session::fresh_run_id;
use kit::scratch::Scratch;
use lab::validate::page;
use lab::validate::suite::{CaseRow, SuiteOptions, run_suite};
use report::provenance::quoted;
use scenario::error::CHECK_FAILED;
use scenes::{FILES, kept};
use terminal::print_note;

/// Arguments of `validate`.
#[derive(Debug, clap::Args)]
pub struct ValidateArguments {
    /// Suite to run: the folder in scenarios/ if it exists, else the built-in scenes.
    #[arg(long, default_value = "verification")]
    suite: Suite,
    /// Run only scenes and cases whose name contains WORDS.
    #[arg(long, value_name = "WORDS", default_value = "")]
    only: String,
    /// Also run the long cases.
    #[arg(long)]
    full: bool,
    /// Folder that keeps the runs and validation.html, a page about them (default: keep nothing). Runs of the same scenario and build that
    /// it already holds are not repeated. Several processes may share it.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Threads per participant; results never depend on this number.
    #[arg(long, default_value_t = 1, value_parser = thread_count())]
    threads: u16,
    /// Print the rows as JSON.
    #[arg(long)]
    json: bool,
}

/// The shipped suites.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Suite {
    /// Exact answers of the solvers, alone and coupled.
    Verification,
    /// Published cases of other authors: a minute, with --full a quarter of an hour or more.
    Benchmarks,
    /// Wheels that roll: creep curves of line contacts, rails in motion, and grains.
    Rolling,
    /// Heat in bodies and grains: half-spaces, a moving source, a column of disks, and what a layer dissipates.
    Heat,
    /// Inputs at their limits: computed correctly, refused by name, or detected.
    Extremes,
    /// Shipped scenes with other seeds, loads, layers, friction and substeps, all without warnings; takes minutes.
    Variants,
    /// The shipped scenes as they are, against published and measured figures; takes minutes.
    Scenes,
    /// The paper that this project began with, figure by figure, and the effect of coupling both scales: two minutes, with --full hours.
    Paper,
}

/// Runs a suite; exit code 8 if a row does not hold. Scenes on the disk take precedence over built-in ones.
pub fn validate(arguments: &ValidateArguments, registry: &Registry) -> VerbResult {
    let word = arguments.suite.to_possible_value();
    let suite = word.as_ref().map_or("", |word| word.get_name());
    let folder = match arguments.suite {
        Suite::Scenes => "",
        _ => suite,
    };
    let mut scenes = Path::new("scenarios").join(folder);
    let unpacked = Scratch::new("scenes", fresh_run_id());
    if !scenes.is_dir() {
        kept::write(FILES, unpacked.path())?;
        scenes = unpacked.path().join(folder);
    }
    let kept = Scratch::new("validate", fresh_run_id());
    let mut run = options(None, usize::from(arguments.threads), registry)?;
    if arguments.full {
        run.listener = terminal::listener();
    }
    let runs = SuiteOptions {
        run,
        folder: arguments.out.as_deref().unwrap_or(kept.path()),
        full: arguments.full,
        only: arguments.only.clone(),
    };
    let cases = run_suite(&scenes, &runs)?;
    if let Some(out) = &arguments.out {
        let full = if arguments.full { " --full" } else { "" };
        let only = match arguments.only.as_str() {
            "" => String::new(),
            words => format!(" --only {}", quoted(words)),
        };
        let out_word = quoted(&out.display().to_string());
        let command = format!("thirdbody validate --suite {suite}{full}{only} --out {out_word}");
        let page = page::write(out, &format!("Validation: {suite}"), &command, &cases)?;
        print_note(&format!("wrote {}", out.join(page).display()));
    }
    let rows: Vec<CaseRow> = cases.into_iter().flat_map(|case| case.rows).collect();
    print_rows(&rows[..], arguments.json, table)?;
    let all_hold = rows.iter().all(|row| row.holds);
    Ok(if all_hold { 0 } else { CHECK_FAILED })
}

fn table(rows: &[CaseRow]) -> String {
    let mut lines = vec![format!(
        "{:<8} {:>14} {:>14}  name (source)",
        "holds", "ours", "expected"
    )];
    lines.extend(rows.iter().map(|row| {
        let holds = match (row.reported, row.holds) {
            (_, false) => "NO",
            (true, _) => "reported",
            _ => "yes",
        };
        let (ours, expected) = (number(&row.ours), number(&row.expected));
        let (name, source) = (&row.name, &row.source);
        let seeds = |[a, b]: [f64; 2]| format!("; seeds {a:.4e} to {b:.4e}");
        let seeds = row.seeds.map(seeds);
        let paper = row.published.map(|paper| format!("; paper {paper:.4e}"));
        let basis = row.basis.map(|basis| format!("; {basis}"));
        let more: String = [seeds, paper, basis].into_iter().flatten().collect();
        format!("{holds:<8} {ours:>14} {expected:>14}  {name} ({source}{more})")
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
