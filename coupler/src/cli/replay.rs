//! `thirdbody replay`: run each solver again against the logged other side, and the coupler against both.

use std::path::PathBuf;

use serde_json::{Value, json};

use super::common::{
    RecoverArgument, VerbResult, file_of, foreign, log_of, own_program, print, refuse_commands,
    restart_point, thread_count,
};
use coordinator::participants::{Launcher, Registry, Watch};
use coordinator::run::checkpoint::RestartPoint;
use coordinator::run::session::fresh_run_id;
use kit::scratch::Scratch;
use lab::replay::replayed::Replayed;
use lab::replay::solver::ReplayOptions;
use lab::replay::{Recording, coupler, drift, recording, solver};
use runs::files::read_json;
use runs::run_dir::RunDir;
use scenario::error::{CHECK_FAILED, Code, DAMAGED, Error, Refusal};
use scenario::keys::TransportKind;
use terminal::print_note;

/// The picture of a drift.
const DRIFT: &str = "replay-drift.svg";

/// Exit code of a replay that departs from its log.
const DEPARTS: i32 = 7;

/// Arguments of `replay`.
#[derive(Debug, clap::Args)]
pub struct ReplayArguments {
    /// Run directory, or an exchange.mcap.
    run: PathBuf,
    /// Replay only this participant, or `coupler` (default: all).
    #[arg(long)]
    node: Option<String>,
    /// Threads per participant.
    #[arg(long, default_value_t = 1, value_parser = thread_count())]
    threads: u16,
    /// Begin at the latest checkpoint after at most WINDOW windows (default: at the start).
    #[arg(long, value_name = "WINDOW")]
    from: Option<u64>,
    /// Accept answers that deviate by at most REL of the largest number of their kind, for solvers that do not repeat every bit.
    #[arg(long, value_name = "REL", allow_negative_numbers = true)]
    tolerance: Option<f64>,
    /// Give a solver another parameter, for example participant.third-body.config.law.friction=0.2; repeatable. Its answers are compared to
    /// the end in open loop: the other side sends what it sent to the logged solver.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// File for the picture of the drift with --set (default: replay-drift.svg in the run directory).
    #[arg(long, value_name = "FILE.svg", requires = "set")]
    plot: Option<PathBuf>,
    /// Start the programs that the logged scenario names.
    #[arg(long)]
    allow_commands: bool,
    #[command(flatten)]
    damaged: RecoverArgument,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Replays a run; exit code 7 at the first departure, 8 if there was nothing to compare. With `--set`, departures are expected and the
/// code is 0. A log that is damaged inside has exit code 6, with any result of its valid part.
pub fn replay(arguments: &ReplayArguments, registry: &Registry) -> VerbResult {
    check_tolerance(arguments.tolerance)?;
    let log = log_of(&arguments.run)?;
    let mut recording = recording(&log, &[])?;
    let nearest = |window| nearest(arguments, &recording, window);
    let origin = arguments.from.map(nearest).transpose()?;
    if !arguments.set.is_empty() {
        recording.loaded = lab::replay::recording(&log, &arguments.set)?.loaded;
    }
    let chosen = chosen(&recording, arguments)?;
    prepare(&mut recording, arguments.allow_commands)?;
    let how = ReplayOptions {
        from: origin.as_ref(),
        tolerance_rel: arguments.tolerance,
        open_loop: !arguments.set.is_empty(),
    };
    let threads = arguments.threads.into();
    let corrupt = recording.damage.is_some() && !recording.torn && !arguments.damaged.recover;
    let mut results = match all(&recording, registry, threads, &chosen, &how) {
        // The valid part of a damaged log may be too short to replay.
        Err(error) if corrupt => {
            print_note(&format!("the valid part cannot be replayed: {error}"));
            Vec::new()
        }
        results => results?,
    };
    // A log without a summary beside it has been moved.
    let summary = read_json(&log.with_file_name("summary.json"));
    judge_states(&recording, &mut results, &summary, &how);
    if how.open_loop {
        draw(arguments, &results)?;
    }
    print(&match arguments.json {
        true => json(&summary, &recording, &results, &how).to_string(),
        false => table(&recording, &results, &how),
    })?;
    if let Some(damage) = recording.damage.filter(|_| corrupt) {
        let code = Code::LogCorrupt.word();
        print_note(&format!("error[{code}]: exchange log: {damage}"));
        return Ok(DAMAGED);
    }
    let departs = results.iter().any(|replayed| replayed.mismatch.is_some());
    if departs && !how.open_loop {
        return Ok(DEPARTS);
    }
    let failed = results.iter().any(compared_nothing);
    Ok(if failed { CHECK_FAILED } else { 0 })
}

/// True if there was nothing to compare, which proves nothing about the solver.
fn compared_nothing(replayed: &Replayed) -> bool {
    replayed.equal == 0 && replayed.mismatch.is_none()
}

/// Compares the final states with the hashes in summary.json, if the log reaches the end of the run and every bit counts. A solver
/// without requests has no final state.
fn judge_states(
    recording: &Recording,
    results: &mut [Replayed],
    summary: &Value,
    how: &ReplayOptions,
) {
    if recording.damage.is_some() || how.open_loop || how.tolerance_rel.is_some() {
        return;
    }
    for replayed in results.iter_mut().filter(|one| !compared_nothing(one)) {
        let state = &summary["participants"][&replayed.who]["state_hash"];
        if let Some(logged) = state.as_str() {
            replayed.compare_state(logged);
        }
    }
}

/// Refuses tolerances outside 0 to 1: with NaN or infinity a replay would find every log equal.
fn check_tolerance(tolerance: Option<f64>) -> Result<(), Error> {
    let outside = tolerance.filter(|tolerance| !(0.0..1.0).contains(tolerance));
    outside.map_or(Ok(()), |tolerance| {
        let problem =
            "must be at least 0 and below 1, it is a share of the largest number of a kind";
        Err(Refusal::argument(format!("--tolerance {tolerance}"), problem).into())
    })
}

fn nearest(
    arguments: &ReplayArguments,
    recording: &Recording,
    window: u64,
) -> Result<RestartPoint, Error> {
    let origin = restart_point(&arguments.run, &recording.loaded, Some(window))?;
    origin.ok_or_else(|| {
        let run = arguments.run.display();
        let problem = format!("{run} has no checkpoint that early; `thirdbody inspect` lists the checkpoints, run.checkpoints_kept keeps more");
        Refusal::argument(format!("--from {window}"), problem).into()
    })
}

fn all(
    recording: &Recording,
    registry: &Registry,
    threads: usize,
    chosen: &[String],
    how: &ReplayOptions,
) -> Result<Vec<Replayed>, Error> {
    let run_id = fresh_run_id();
    // Temporary logs and fields of the replayed participants.
    let scratch = Scratch::new("replay", run_id);
    let rundir = RunDir::create(Some(scratch.path()), "replay", run_id)?;
    let launcher = Launcher {
        loaded: &recording.loaded,
        registry,
        program: own_program()?,
        run_id,
        threads,
        rundir: &rundir,
    };
    let watch = Watch::default();
    let replay = |who: &String| match who.as_str() {
        "coupler" => coupler::replay(recording, &launcher, &watch, how.from),
        name => solver::replay(recording, &launcher, name, &watch, how),
    };
    chosen.iter().map(replay).collect()
}

fn draw(arguments: &ReplayArguments, results: &[Replayed]) -> Result<(), Error> {
    let drift: Vec<_> = results.iter().flat_map(|r| r.drift.clone()).collect();
    let beside = || file_of(&arguments.run, DRIFT).with_file_name(DRIFT);
    let path = arguments.plot.clone().unwrap_or_else(beside);
    std::fs::write(&path, drift::picture(&drift)).map_err(Error::output(path.display()))?;
    print_note(&path.display().to_string());
    Ok(())
}

/// Replays shipped solvers as threads; foreign solvers need their processes and the user's permission.
fn prepare(recording: &mut Recording, allow_commands: bool) -> Result<(), Error> {
    let scenario = &mut recording.loaded.scenario;
    scenario.bring_here();
    if !allow_commands {
        refuse_commands(scenario)?;
    }
    if foreign(scenario).is_none() {
        scenario.run.transport = TransportKind::Channel;
    }
    Ok(())
}

/// Names to replay: all, or the one that `--node` names. With `--set`, participants whose keys are set, never the coupler.
fn chosen(recording: &Recording, arguments: &ReplayArguments) -> Result<Vec<String>, Error> {
    let participants = recording.loaded.scenario.participant.iter();
    let mut names: Vec<String> = participants.map(|p| p.name.clone()).collect();
    if arguments.set.is_empty() {
        let coupled = !recording.loaded.scenario.interface.is_empty();
        names.extend(coupled.then(|| "coupler".into()));
    } else {
        let known = names.join(", ");
        names.retain(|name| {
            let prefix = format!("participant.{name}.config.");
            arguments.set.iter().any(|key| key.starts_with(&prefix))
        });
        if names.is_empty() {
            let set = format!("--set {}", arguments.set.join(" --set "));
            let problem = format!(
                "a replay changes keys of a solver, participant.NAME.config.KEY with NAME one of {known}"
            );
            return Err(Refusal::argument(set, problem).into());
        }
        if let Some(node) = arguments.node.as_ref().filter(|node| !names.contains(node)) {
            let problem = format!(
                "no --set changes a key of this participant: name {}",
                names.join(" or ")
            );
            return Err(Refusal::argument(format!("--node {node}"), problem).into());
        }
    }
    Ok(arguments.node.clone().map_or(names, |name| vec![name]))
}

fn table(recording: &Recording, results: &[Replayed], how: &ReplayOptions) -> String {
    let mut lines = Vec::new();
    let early = |damage| format!("the log ends early, its valid part is replayed: {damage}");
    lines.extend(recording.damage.as_ref().map(early));
    let from = |origin: &RestartPoint| format!("from {}", origin.path.display());
    lines.extend(how.from.map(from));
    if how.open_loop {
        lines.push("open loop: the other side sends what it sent to the logged solver".into());
    }
    let found = match how.tolerance_rel {
        None => "bitwise identical".to_string(),
        Some(tolerance) => format!("identical within {tolerance:e}"),
    };
    for replayed in results {
        let (who, equal, last) = (&replayed.who, replayed.equal, replayed.last_window);
        lines.push(match &replayed.mismatch {
            _ if compared_nothing(replayed) => {
                format!("{who}: nothing was compared, the log holds no answer for it")
            }
            None => format!("{who}: {equal} messages equal, up to window {last}: {found}"),
            Some(mismatch) => {
                let all = last + 1;
                format!("{who}: {mismatch}; {equal} messages equal in all {all} windows")
            }
        });
        let drifts = drift::table(&replayed.drift).into_iter();
        lines.extend(drifts.map(|(_, kind, last, largest)| {
            format!("  drift of {kind}: {last:.3e} in the last window, {largest:.3e} at most")
        }));
    }
    lines.join("\n")
}

fn json(
    summary: &Value,
    recording: &Recording,
    results: &[Replayed],
    how: &ReplayOptions,
) -> Value {
    let rows = results.iter().map(|replayed| {
        let mut row = json!({
            "who": replayed.who,
            "equal_messages": replayed.equal,
            "last_window": replayed.last_window,
            "departure": replayed.mismatch.as_ref().map(ToString::to_string),
            "wall_s": replayed.wall_s,
            "solve_wall_s": replayed.solve_wall_s,
            "run_solve_wall_s": summary["participants"][&replayed.who]["solve_wall_s"],
        });
        if how.open_loop {
            row["drift"] = drifts(replayed);
        }
        row
    });
    json!({
        "windows": recording.ends.len(),
        "damage": recording.damage,
        "from_window": how.from.map(|origin| origin.checkpoint.position.windows),
        "tolerance_rel": how.tolerance_rel,
        "open_loop": how.open_loop,
        "results": rows.collect::<Vec<_>>(),
    })
}

/// By kind: the drift in the last window, the largest drift, and the drift in each window.
fn drifts(replayed: &Replayed) -> Value {
    let rows = drift::table(&replayed.drift).into_iter();
    let rows = rows.map(|(kind, name, last, largest)| {
        let windows = drift::by_window(&replayed.drift, kind);
        let value = json!({ "last_rel": last, "max_rel": largest, "windows": windows });
        (name.to_string(), value)
    });
    Value::Object(rows.collect())
}
