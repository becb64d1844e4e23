//! `thirdbody check`: all checks and predictions before a run.

use serde_json::{Map, Value};

use super::common::{ScenarioArguments, VerbResult, foreign, print};
use super::start::rehearse;
use coordinator::cost::prediction::CostPrediction;
use coordinator::participants::Registry;
use coordinator::run::check::check as check_scenario;
use coordinator::run::session::Ended;
use coordinator::summary::Summary;
use scenario::error::{CHECK_FAILED, Error};
use scenario::load::Loaded;
use scenario::schema::schema;

/// Longest set-up that a check waits for (s): preparing a large sample takes minutes.
const SETUP_S: f64 = 8.0;

/// Arguments of `check`.
#[derive(Debug, clap::Args)]
pub struct CheckArguments {
    #[command(flatten)]
    scenario: Option<ScenarioArguments>,
    /// Print the JSON Schema of all keys instead, for editors.
    #[arg(long, exclusive = true)]
    schema: bool,
    /// Do not start the solvers; leaves out stability, which they must report, and cost, which is measured.
    #[arg(long)]
    no_start: bool,
    /// Also start the programs that the scenario names.
    #[arg(long)]
    allow_commands: bool,
}

/// Checks a scenario; an error ends with exit code 2.
pub fn check(arguments: &CheckArguments, registry: &Registry) -> VerbResult {
    let Some(scenario) = &arguments.scenario else {
        return print(&format!("{:#}", schema_of(registry)));
    };
    let mut loaded = scenario.load()?;
    let threads = scenario.threads();
    let warnings = check_scenario(&loaded, registry, threads)?;
    print(&describe(&loaded))?;
    for warning in &warnings {
        print(&warning.line())?;
    }
    if arguments.no_start {
        return Ok(0);
    }
    if let Some((name, _)) = foreign(&loaded.scenario)
        && !arguments.allow_commands
    {
        return print(&format!(
            "stability and cost: not predicted, participant {name} is a foreign program; --allow-commands starts it"
        ));
    }
    let deadlines = &mut loaded.scenario.run.deadlines;
    deadlines.setup_s = deadlines.setup_s.min(SETUP_S);
    let ended = rehearse(&loaded, threads, registry)?;
    let mut foreseen = ended.summary.foreseen_warnings().to_vec();
    foreseen.retain(|warning| !warnings.contains(warning));
    for warning in &foreseen {
        print(&warning.line())?;
    }
    let (lines, refused) = predictions(ended)?;
    for line in lines {
        print(&line)?;
    }
    let condemned = foreseen.iter().find(|warning| warning.suspect);
    if let (Some(warning), None) = (condemned, &refused) {
        print(&format!(
            "suspect: a run would end with exit code {CHECK_FAILED}, because `{}` is beyond its second bound",
            warning.code
        ))?;
        return Ok(CHECK_FAILED);
    }
    refused.map_or(Ok(0), Err)
}

/// The schema of scenarios with the keys of these solvers.
pub(super) fn schema_of(registry: &Registry) -> Value {
    let solvers = registry.solvers.iter();
    let solvers = solvers.map(|solver| (solver.kind, solver.schema.map(|schema| schema())));
    let solvers: Vec<(&str, Option<Value>)> = solvers.collect();
    schema(&solvers)
}

/// Stability, log and cost as a dry run predicts them, and the error that ended the dry run early.
fn predictions(ended: Ended) -> Result<(Vec<String>, Option<Error>), Error> {
    let summary = &ended.summary;
    let mut lines = summary.foreseen.clone();
    let predicted = summary.spent.as_ref().and_then(|spent| spent.told);
    match (predicted, ended.error) {
        (_, Some(error @ Error::Interrupted { .. })) => return Err(error),
        (Some(cost), _) => lines.extend(cost_lines(summary, &cost)),
        (
            None,
            Some(Error::Deadline {
                peer,
                key: "setup_s",
                ..
            }),
        ) => {
            lines.push(format!(
                "stability and cost: not predicted, the set-up of participant {peer} takes longer than {SETUP_S} s and a check does not wait for it; a run keeps the prepared sample, and later checks are quick"
            ));
        }
        (None, refused) => return Ok((lines, refused)),
    }
    Ok((lines, None))
}

fn cost_lines(summary: &Summary, cost: &CostPrediction) -> Vec<String> {
    let value = summary.value();
    let setup_s = number(&value["setup_wall_s"]);
    let mut lines = vec![format!(
        "cost: about {:.1} s, including {setup_s:.1} s of set-up; extrapolated from the first {} windows, which took {:.1} s",
        cost.wall_s, cost.windows, cost.windows_wall_s
    )];
    for (name, participant) in value["participants"].as_object().into_iter().flatten() {
        lines.extend(work_line(name, participant));
        lines.extend(way_line(name, participant, cost));
    }
    let results = value["results"].as_object();
    lines.extend(results.into_iter().flat_map(reduced_lines));
    let coupling = &value["coupling"];
    if coupling.is_object() {
        let each_us = |key: &str| 1e6 * number(&coupling[key]) / cost.windows as f64;
        let logged = value["log"]["messages"].as_u64();
        let messages = logged.map(|count| format!(", {count} messages so far"));
        let messages = messages.unwrap_or_default();
        let [own, wait] = ["own_wall_s", "wait_s"].map(each_us);
        lines.push(format!(
            "cost: coupler: {own:.0} us of work and {wait:.0} us of waiting for frames per window{messages}"
        ));
    }
    lines.push(format!(
        "cost: range: {:.1} s to {:.1} s, if all later windows cost as much as the fastest or the slowest quarter so far; iterations per window follow the load history",
        cost.wall_low_s, cost.wall_high_s
    ));
    lines.push(format!(
        "memory: about {:.3e} bytes at the peak, summed over all processes",
        cost.memory_bytes as f64
    ));
    lines
}

/// Work of a participant in a dry run, and the time per unit of work.
fn work_line(name: &str, participant: &Value) -> Option<String> {
    let work = participant["work"].as_object()?;
    let done = work.iter().filter(|(_, amount)| number(amount) > 0.0);
    let done = done.map(|(kind, amount)| format!("{:.3e} {kind}", number(amount)));
    let done = done.collect::<Vec<_>>().join(", ");
    let [wall_s, each_ns] = ["solve_wall_s", "ns_per_work"].map(|key| number(&participant[key]));
    Some(format!(
        "cost: {name}: {done} so far in {wall_s:.2} s, {each_ns:.1} ns each"
    ))
}

/// Modes and near field of each reduced body.
fn reduced_lines(results: &Map<String, Value>) -> Vec<String> {
    let names = results.keys();
    let bodies = names.filter_map(|name| name.strip_suffix("reduced_modes"));
    let line = |body: &str| {
        let value = |name: &str| results.get(&format!("{body}reduced_{name}"));
        let of = |name: &str| value(name).map_or(0.0, number);
        format!(
            "reduced: {body}{} modes up to {:.3e} 1/s, the first one left out has {:.2} periods in a window; {:.2} of the flexibility is massless; near field {:.2e} m, {:.2} of a change of force returns one window later",
            of("modes"),
            of("omega_max_per_s"),
            of("window_turns"),
            of("static_share"),
            of("near_m"),
            of("near_radius")
        )
    };
    bodies.map(line).collect()
}

/// Share of the network in the cost, for a participant that may be on another host.
fn way_line(name: &str, participant: &Value, cost: &CostPrediction) -> Option<String> {
    let host = participant["host"].as_str()?;
    let way_s = number(&participant["round_trip_s"]);
    let each = number(&participant["round_trips"]) / cost.windows as f64;
    let all_s = each * way_s * cost.windows_of_run;
    Some(format!(
        "cost: {name} on host `{host}`: {each:.2} round trips per window at {:.3} ms each, in {:.0} windows {all_s:.2} s; longer windows, scheme = \"velocity\" or a participant on this host reduce this time",
        1e3 * way_s,
        cost.windows_of_run
    ))
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_default()
}

fn describe(loaded: &Loaded) -> String {
    let scenario = &loaded.scenario;
    let (name, hash) = (&scenario.run.name, &loaded.hash);
    let mut lines = vec![format!("{name}: valid, scenario {hash}")];
    for participant in &scenario.participant {
        let (name, kind) = (&participant.name, &participant.kind);
        let mut words = participant.launch.clone().unwrap_or_default();
        match &participant.command {
            None => words.push(format!("thirdbody node {kind}")),
            Some(command) => words.extend_from_slice(command),
        }
        lines.push(format!("participant {name} ({kind}): {}", words.join(" ")));
    }
    for interface in &scenario.interface {
        let ([a, b], scheme) = (&interface.between, interface.scheme);
        lines.push(format!(
            "interface {}: {a} <-> {b}, {scheme}, {} substeps per window, gap within {:.1e} node spacings",
            interface.name, interface.substeps(), interface.tolerance_rel
        ));
    }
    if scenario.interface.is_empty() {
        lines.push("no interface: the solver runs alone".into());
    }
    lines.join("\n")
}
