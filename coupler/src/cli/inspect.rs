//! `thirdbody inspect`: the contents of a run directory or an exchange log.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde_json::{Value, json};

use super::common::{RecoverArgument, VerbResult, log_of, print};
use coordinator::run::checkpoint::{FOLDER, file};
use exchange_log::{COUPLER, LogError, LogSummary, summarize};

/// Arguments of `inspect`.
#[derive(Debug, clap::Args)]
pub struct InspectArguments {
    /// Run directory, or an exchange.mcap.
    path: PathBuf,
    #[command(flatten)]
    damaged: RecoverArgument,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Lists streams, windows, checkpoints and provenance; for a log that ends early, of its valid part. Damage has exit code 6 unless
/// `--recover` accepts it. A torn end of a run without summary.json is no damage: a killed writer leaves it.
pub fn inspect(arguments: &InspectArguments) -> VerbResult {
    let path = log_of(&arguments.path)?;
    let summary = summarize(&path, true)?;
    let found = file::list(&arguments.path.join(FOLDER)).into_iter();
    let checkpoints: Vec<u64> = found.map(|found| found.window).collect();
    print(&match arguments.json {
        true => json(&summary, &checkpoints).to_string(),
        false => describe(&summary, &checkpoints),
    })?;
    let torn = summary.damage.as_ref().is_some_and(LogError::is_torn);
    let killed = torn && !path.with_file_name("summary.json").exists();
    match summary.damage {
        Some(damage) if !(killed || arguments.damaged.recover) => Err(damage.into()),
        _ => Ok(0),
    }
}

fn describe(summary: &LogSummary, checkpoints: &[u64]) -> String {
    let payload: u64 = summary.streams.iter().map(|stream| stream.bytes).sum();
    let messages: u64 = summary.streams.iter().map(|stream| stream.messages).sum();
    let mut lines = vec![
        format!("run       {:016x}", summary.provenance.run_id),
        format!("windows   {}", summary.windows),
        format!("exchange  {}", summary.hash),
        format!("simulated {:e} s", summary.stats.end_s),
        format!(
            "size      {} bytes, {payload} of payload in {messages} messages",
            summary.file_bytes
        ),
        format!("iterations {}", counts(&summary.stats.by_iterations)),
        format!("substeps  {}", counts(&summary.stats.by_substeps)),
        format!("checkpoints {checkpoints:?}"),
        format!(
            "{:<44} {:>9} {:>13}  windows",
            "stream", "messages", "payload bytes"
        ),
    ];
    lines.extend(summary.streams.iter().map(|stream| {
        // A message from the coupler has one receiver.
        let name = match stream.sender.as_str() {
            COUPLER => format!("{} -> {}", stream.topic, stream.receiver),
            _ => stream.topic.clone(),
        };
        let (messages, bytes) = (stream.messages, stream.bytes);
        let (first, last) = (stream.first_window, stream.last_window);
        format!("{name:<44} {messages:>9} {bytes:>13}  {first} to {last}")
    }));
    lines.push(match &summary.non_finite {
        None => "all numbers are finite".into(),
        Some(found) => format!(
            "first NaN or infinite number: {} at entry {} of {}, window {}, iteration {}",
            found.value, found.entry, found.topic, found.window, found.iteration
        ),
    });
    let early = |damage| format!("the log ends early: {damage}");
    lines.extend(summary.damage.as_ref().map(early));
    lines.extend(["manifest".into(), summary.provenance.manifest_json.clone()]);
    lines.join("\n")
}

/// `2833 x 1, 4 x 2`: the number of windows for each value.
fn counts(of: &BTreeMap<u32, u64>) -> String {
    let each = of
        .iter()
        .map(|(number, windows)| format!("{windows} x {number}"));
    Vec::from_iter(each).join(", ")
}

fn json(summary: &LogSummary, checkpoints: &[u64]) -> Value {
    let manifest: Value =
        serde_json::from_str(&summary.provenance.manifest_json).unwrap_or(Value::Null);
    json!({
        "run_id": format!("{:016x}", summary.provenance.run_id),
        "blocks": summary.windows,
        "windows": summary.stats.by_iterations.values().sum::<u64>(),
        "last_window": summary.last_window,
        "sim_time_s": summary.stats.end_s,
        "exchange_hash": summary.hash,
        "file_bytes": summary.file_bytes,
        "windows_by_iterations": summary.stats.by_iterations,
        "windows_by_substeps": summary.stats.by_substeps,
        "checkpoints": checkpoints,
        "streams": summary.streams,
        "non_finite": summary.non_finite,
        "damage": summary.damage.as_ref().map(ToString::to_string),
        "manifest": manifest,
        "scenario": summary.provenance.scenario_toml,
    })
}
