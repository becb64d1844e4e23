//! The fault campaign of [`harness::campaign`], after `cargo build --release`:
//! `cargo run --release -p tests --bin faults -- --trials 200`. Exit code 8 if a row does not hold.

use clap::Parser;
use coordinator::participants::Watch;
use harness::campaign::row::FaultRow;
use harness::campaign::{Campaign, run_campaign};
use scenario::error::{CHECK_FAILED, Error};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

/// Kills and stops processes of short runs, fills disks and damages files at random instants, and checks that each fault is found
/// and named, and that the run resumes.
#[derive(Debug, Parser)]
struct Arguments {
    /// Trials of each row, 1 to 10 000.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..=10_000))]
    trials: u64,
    /// Seed of the instants and schedules.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Run only faults with this in their name (killed, stopped, disk, simulated).
    #[arg(long, value_name = "WORDS", default_value = "")]
    only: String,
    /// Print the rows as JSON.
    #[arg(long)]
    json: bool,
}

fn main() {
    let code = run(&Arguments::parse()).unwrap_or_else(|error| {
        eprintln!("faults: {error}");
        error.exit_code()
    });
    std::process::exit(code);
}

fn run(arguments: &Arguments) -> Result<i32, Error> {
    let watch = Watch::default();
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        signal_hook::flag::register_usize(signal, watch.flag(), signal as usize)
            .map_err(Error::input("listening for signals"))?;
    }
    let rows = run_campaign(&Campaign {
        program: harness::runs::program("thirdbody"),
        trials: arguments.trials,
        seed: arguments.seed,
        watch,
        only: arguments.only.clone(),
    })?;
    if arguments.json {
        println!("{}", serde_json::json!({ "results": rows }));
    } else {
        println!("{}", fault_table(&rows));
    }
    for why in rows.iter().flat_map(|row| &row.wrong) {
        eprintln!("wrong: {why}");
    }
    let all_hold = rows.iter().all(|row| row.holds);
    Ok(if all_hold { 0 } else { CHECK_FAILED })
}

fn fault_table(rows: &[FaultRow]) -> String {
    let mut lines = vec![format!(
        "{:<5} {:<29} {:>6} {:>6} {:>17} {:>5} {:>15} {:>5}  outcomes",
        "holds", "fault", "trials", "right", "found p50/p99 (s)", "bound", "lost mean/max", "left"
    )];
    let either = |number: Option<f64>, digits: usize| {
        number.map_or("-".into(), |number| format!("{number:.digits$}"))
    };
    lines.extend(rows.iter().map(|row| {
        let holds = if row.holds { "yes" } else { "NO" };
        let found = [row.detection_p50_s, row.detection_p99_s].map(|s| either(s, 3));
        let most = row.windows_lost_max.map(|most| most as f64);
        let lost = [either(row.windows_lost_mean, 1), either(most, 0)];
        let outcomes = row.outcomes.iter();
        let outcomes = outcomes.map(|(word, count)| format!("{count} {word}"));
        let mut outcomes: Vec<String> = outcomes.collect();
        outcomes.extend(row.per_minute.map(|rate| format!("{rate:.0} per minute")));
        format!(
            "{holds:<5} {:<29} {:>6} {:>6} {:>17} {:>5} {:>15} {:>5}  {}",
            row.name,
            row.trials,
            row.right,
            found.join(" / "),
            either(row.detection_bound_s, 1),
            lost.join(" / "),
            row.leftovers,
            outcomes.join(", ")
        )
    }));
    let failed = rows.iter().filter(|row| !row.holds).count();
    let (seed, all) = (rows.first().map_or(0, |row| row.seed), rows.len());
    lines.push(format!("seed {seed}, {all} rows, {failed} do not hold"));
    lines.join("\n")
}
