//! `summary.json`, schema `thirdbody.summary/1`.

use std::collections::BTreeMap;

use protocol::Phase;
use protocol::serve::Farewell;
use serde_json::{Map, Value, json};

use crate::error::Error;
use crate::log::LogStats;
use crate::output::sample::load_history;
use crate::participants::handshake::Greeted;
use crate::participants::journal::Closed;
use crate::scenario::Scenario;
use crate::scheme::coupling::Coupling;
use crate::scheme::ledger::{EnergyLedger, InterfaceLedger, ratio, total_balance_rel};

/// Outcome of a run. Fields that never came about (a run that ended early) are left out of the file.
#[derive(Clone, Debug, Default)]
pub struct Summary {
    scenario: String,
    scenario_hash: String,
    status: String,
    exit_code: i32,
    message: String,
    /// Simulated time that stands (s).
    pub sim_time_s: f64,
    wall_s: f64,
    /// Windows that stand.
    pub windows: u64,
    participants: Vec<ParticipantSummary>,
    phases: Vec<Phase>,
    coupling: Option<InterfaceLedger>,
    interfaces: Vec<(String, InterfaceLedger)>,
    coupling_wall_s: Option<f64>,
    run_wall_s: f64,
    /// Results by name, unit in the name.
    pub results: BTreeMap<String, f64>,
    /// hashes.exchange
    pub exchange_hash: Option<String>,
    /// Size of the log (bytes) as it was foreseen after the handshake.
    pub log_predicted_bytes: Option<u64>,
    log: Option<LogStats>,
    hash_wall_s: f64,
    closed_wall_s: f64,
    state_hash: Option<String>,
}

#[derive(Clone, Debug, Default)]
struct ParticipantSummary {
    name: String,
    kind: String,
    pid: u32,
    energy: Option<EnergyLedger>,
    farewell: Option<Farewell>,
}

/// Wall-clock times that the coordinator measured.
pub struct Costs {
    /// Time from the greetings to the farewells (s).
    pub talk_wall_s: f64,
    /// Time since the start of the run (s).
    pub run_wall_s: f64,
}

impl Summary {
    /// A run that has not done anything yet.
    pub fn new(scenario: &str, scenario_hash: &str) -> Summary {
        Summary {
            scenario: scenario.to_string(),
            scenario_hash: scenario_hash.to_string(),
            ..Summary::default()
        }
    }

    /// Enters the participants that answered.
    pub fn greet(&mut self, scenario: &Scenario, greeted: &[Greeted]) {
        self.phases = load_history(greeted.iter().map(|greeted| &greeted.description));
        self.participants = scenario
            .participant
            .iter()
            .zip(greeted)
            .map(|(participant, greeted)| ParticipantSummary {
                name: participant.name.clone(),
                kind: greeted.description.kind.clone(),
                pid: greeted.pid,
                ..ParticipantSummary::default()
            })
            .collect();
    }

    /// Enters what the interfaces of all groups have seen so far.
    pub fn interfaces<'a>(&mut self, couplings: impl Iterator<Item = &'a Coupling>) {
        let mut all = InterfaceLedger::default();
        let (mut nodes, mut points) = (0, 0);
        self.interfaces.clear();
        for coupling in couplings {
            let group = coupling.group();
            nodes += group.nodes.len();
            points += group.points.len();
            let patches = group.patches.iter().zip(&coupling.ledgers);
            for (place, (patch, ledger)) in patches.enumerate() {
                all.merge(ledger, place > 0);
                self.interfaces.push((patch.name.clone(), ledger.clone()));
            }
        }
        self.windows = all.windows;
        self.coupling = Some(all);
        self.results.insert("interface_nodes".into(), nodes as f64);
        self.results
            .insert("interface_points".into(), points as f64);
    }

    /// Enters the latest energies of all participants; points with masses of their own count as one more.
    pub fn energies(&mut self, energies: &[EnergyLedger]) {
        for (participant, energy) in self.participants.iter_mut().zip(energies) {
            participant.energy = Some(energy.clone());
        }
        let points = self.coupling.as_ref().and_then(InterfaceLedger::points);
        let all: Vec<EnergyLedger> = energies.iter().cloned().chain(points).collect();
        let balance = total_balance_rel(&all);
        self.results.insert("energy_balance_rel".into(), balance);
    }

    /// Enters what the participants said at the end.
    pub fn farewell(&mut self, farewells: &[Farewell], costs: &Costs) {
        let mut state = blake3::Hasher::new();
        let mut solving = 0.0;
        for (participant, farewell) in self.participants.iter_mut().zip(farewells) {
            state.update(participant.name.as_bytes());
            state.update(farewell.outcome.state_hash.as_bytes());
            solving += farewell.solve_wall_s;
            for (name, value) in &farewell.outcome.results {
                self.results.insert(name.clone(), *value);
            }
            participant.farewell = Some(farewell.clone());
        }
        self.state_hash = Some(state.finalize().to_hex().to_string());
        self.run_wall_s = costs.run_wall_s;
        self.coupling_wall_s = Some((costs.talk_wall_s - solving).max(0.0));
    }

    /// Enters the hash and the log, so long (s) after the start of the run.
    pub fn close(&mut self, closed: &Closed, wall_s: f64) {
        self.exchange_hash = Some(closed.hash.clone());
        self.log = closed.log;
        self.hash_wall_s = closed.hash_wall.as_secs_f64();
        self.closed_wall_s = wall_s;
    }

    /// Enters the ending.
    pub fn end(&mut self, wall_s: f64, error: Option<&Error>) {
        self.wall_s = wall_s;
        self.status = error.map_or("completed", Error::status).to_string();
        self.exit_code = error.map_or(0, Error::exit_code);
        self.message = error.map_or_else(String::new, ToString::to_string);
    }

    /// The text of summary.json.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(&self.value()).expect("JSON values always serialise")
    }

    /// summary.json as a value.
    pub fn value(&self) -> Value {
        let participants: Map<String, Value> = self
            .participants
            .iter()
            .map(|participant| (participant.name.clone(), participant.value()))
            .collect();
        let mut value = json!({
            "schema": "thirdbody.summary/1",
            "scenario": self.scenario,
            "status": self.status,
            "exit_code": self.exit_code,
            "message": self.message,
            "sim_time_s": self.sim_time_s,
            "wall_s": self.wall_s,
            "windows": self.windows,
            "participants": participants,
            "results": self.results,
            "hashes": {
                "scenario": self.scenario_hash,
                "exchange": self.exchange_hash,
                "state": self.state_hash,
            },
        });
        if !self.phases.is_empty() {
            value["phases"] = json!(self.phases);
        }
        if let Some(log) = &self.log {
            value["log"] = self.log_value(log);
        }
        if let Some(ledger) = &self.coupling {
            value["repeats_mean"] = json!(ledger.repeats_mean());
            value["coupling"] = self.coupling_value(ledger);
            let interfaces = self.interfaces.iter();
            let interfaces: Map<String, Value> = interfaces
                .map(|(name, ledger)| (name.clone(), interface_value(ledger)))
                .collect();
            value["interfaces"] = Value::Object(interfaces);
        }
        value
    }

    /// `wall_s` is what the run loses to the log, `share` that of its wall-clock time; the writing thread's time and that
    /// of the hash, which is made without a log too, are told beside it.
    fn log_value(&self, log: &LogStats) -> Value {
        let wall_s = log.caller_wall.as_secs_f64();
        json!({
            "bytes": log.bytes,
            "predicted_bytes": self.log_predicted_bytes,
            "messages": log.messages,
            "wall_s": wall_s,
            "share": ratio(wall_s, self.closed_wall_s),
            "writer_wall_s": log.writer_wall.as_secs_f64(),
            "hash_wall_s": self.hash_wall_s,
        })
    }

    fn coupling_value(&self, ledger: &InterfaceLedger) -> Value {
        let mut value = interface_value(ledger);
        if let Some(wall_s) = self.coupling_wall_s {
            value["wall_s"] = json!(wall_s);
            value["share"] = json!(ratio(wall_s, self.run_wall_s));
        }
        value
    }
}

fn interface_value(ledger: &InterfaceLedger) -> Value {
    let mut value = json!({
        "gap_max_rel": ledger.gap_max_rel,
        "energy_defect_rel": ledger.energy_defect_rel(),
        "force_residual_rel": ledger.force_residual_rel(),
        "not_converged_windows": ledger.not_converged,
        "halved_windows": ledger.halved,
        "contact_iterations": ledger.contact_iterations,
        "contact_residual_max": ledger.contact_residual_max,
    });
    if let Some(points) = ledger.points() {
        for (term, joules) in points.terms.iter().zip(&points.values) {
            value[format!("points_{}_j", term.name)] = json!(joules);
        }
    }
    value
}

impl ParticipantSummary {
    fn value(&self) -> Value {
        let mut value = json!({ "kind": self.kind, "pid": self.pid });
        if let Some(energy) = &self.energy {
            let terms: Map<String, Value> = energy
                .terms
                .iter()
                .zip(&energy.values)
                .map(|(term, joules)| (format!("{}_j", term.name), json!(joules)))
                .collect();
            value["energy"] = Value::Object(terms);
            value["energy_balance_rel"] = json!(energy.balance_rel());
        }
        if let Some(farewell) = &self.farewell {
            let outcome = &farewell.outcome;
            value["steps"] = json!(outcome.steps);
            value["cpu_s"] = json!(farewell.cpu_s);
            value["solve_wall_s"] = json!(farewell.solve_wall_s);
            value["setup_wall_s"] = json!(farewell.setup_wall_s);
            value["wait_s"] = json!(farewell.wait_s);
            value["work"] = json!(outcome.work);
            let work: f64 = outcome.work.values().sum();
            if work > 0.0 {
                value["ns_per_work"] = json!(1e9 * farewell.solve_wall_s / work);
            }
            value["peak_rss_bytes"] = json!(farewell.peak_rss_bytes);
            value["warnings"] = json!(outcome.warnings);
        }
        value
    }
}
