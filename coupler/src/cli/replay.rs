//! `thirdbody replay`: run each solver again against the logged other side, and the coupler against both.

use std::path::PathBuf;

use serde_json::json;

use super::{VerbResult, log_of, own_program, print, refuse_commands};
use crate::couple::run::fresh_run_id;
use crate::error::Error;
use crate::launch::{Launcher, Registry, Watch};
use crate::replay::{Recording, Replayed, coupler, recording, solver};
use crate::rundir::{RunDir, Scratch};
use crate::scenario::{Participant, TransportKind};

/// Exit code of a replay that departs from its log.
const DEPARTS: i32 = 7;

/// Arguments of `replay`.
#[derive(Debug, clap::Args)]
pub struct ReplayArguments {
    /// A run directory, or an exchange.mcap.
    run: PathBuf,
    /// Replay this participant only, or `coupler`.
    #[arg(long)]
    node: Option<String>,
    /// Threads of each participant.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    threads: u16,
    /// Start programs that the logged scenario names.
    #[arg(long)]
    allow_commands: bool,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Replays; exit code 7 at the first departure.
pub fn replay(arguments: &ReplayArguments, registry: &Registry) -> VerbResult {
    let mut recording = recording(&log_of(&arguments.run)?)?;
    prepare(&mut recording, arguments.allow_commands)?;
    let run_id = fresh_run_id();
    // Logs and fields of the replayed participants, which nobody keeps.
    let scratch = Scratch::new("replay", run_id);
    let rundir = RunDir::create(Some(scratch.path()), "replay", run_id)?;
    let launcher = Launcher {
        loaded: &recording.loaded,
        registry,
        program: own_program()?,
        run_id,
        threads: arguments.threads.into(),
        rundir: &rundir,
    };
    let watch = Watch::default();
    let mut results = Vec::new();
    for who in chosen(&recording, arguments.node.as_deref()) {
        results.push(match who.as_str() {
            "coupler" => coupler::replay(&recording, &launcher, &watch)?,
            name => solver::replay(&recording, &launcher, name, &watch)?,
        });
    }
    match arguments.json {
        true => print(&json(&recording, &results)),
        false => print(&table(&recording, &results)),
    }
    match results.iter().any(|replayed| replayed.departure.is_some()) {
        true => Ok(DEPARTS),
        false => Ok(0),
    }
}

/// Shipped solvers are replayed as threads; foreign ones need their processes, and the user's leave.
fn prepare(recording: &mut Recording, allow_commands: bool) -> Result<(), Error> {
    let scenario = &mut recording.loaded.scenario;
    if !allow_commands {
        refuse_commands(scenario)?;
    }
    let foreign = |participant: &Participant| participant.command.is_some();
    if !scenario.participant.iter().any(foreign) {
        scenario.run.transport = TransportKind::Channel;
    }
    Ok(())
}

fn chosen(recording: &Recording, only: Option<&str>) -> Vec<String> {
    if let Some(name) = only {
        return vec![name.to_string()];
    }
    let participants = recording.loaded.scenario.participant.iter();
    participants
        .map(|participant| participant.name.clone())
        .chain(["coupler".to_string()])
        .collect()
}

fn table(recording: &Recording, results: &[Replayed]) -> String {
    let mut lines = Vec::new();
    if let Some(damage) = &recording.damage {
        lines.push(format!(
            "the log ends early, its valid part is replayed: {damage}"
        ));
    }
    for replayed in results {
        let found = match &replayed.departure {
            None => "bitwise identical".to_string(),
            Some(departure) => departure.to_string(),
        };
        lines.push(format!(
            "{}: {} messages compared, up to window {}: {found}",
            replayed.who, replayed.equal, replayed.last_window
        ));
    }
    lines.join("\n")
}

fn json(recording: &Recording, results: &[Replayed]) -> String {
    let rows: Vec<_> = results
        .iter()
        .map(|replayed| {
            json!({
                "who": replayed.who,
                "equal_messages": replayed.equal,
                "last_window": replayed.last_window,
                "departure": replayed.departure.as_ref().map(ToString::to_string),
            })
        })
        .collect();
    json!({ "windows": recording.windows, "damage": recording.damage, "results": rows }).to_string()
}
