//! `summary.json`, schema `thirdbody.summary/1`.

use std::collections::BTreeMap;

use protocol::busy::BusyTimes;
use protocol::serve::Farewell;
use protocol::{Finding, HeldLoad, Phase, Role};
use serde::{Serialize, Serializer};
use serde_json::{Map, Value, json};

use crate::cost::account::TimeAccount;
use crate::cost::memory::{own_cpu_s, peak_bytes};
use crate::cost::prediction::Pace;
use crate::output::sample::load_history;
use crate::participants::handshake::Greeted;
use crate::participants::journal::Closed;
use crate::participants::peer::Far;
use runs::collection::FieldsSummary;
use runs::plausible::{self, InterfaceWorks};
use runs::warning::Warning;
use runs::written::Written;
use scenario::error::{CHECK_FAILED, Error};
use scenario::keys::Scenario;
use scenario::plausible::Plausible;
use scheme::coupling::Coupling;
use scheme::keys::CouplingScheme;
use scheme::ledger::{EnergySums, InterfaceLedger, ParticipantLedger, ratio};
use scheme::predict::prediction::StabilityPrediction;

mod spent;

use spent::Spent;

kit::results! {
    /// # Quality of the solution
    /// - `energy_balance_rel`: Relative energy error: work minus stored and dissipated energy, over the absolute values
    ///   of all work terms.
    /// - `interface_nodes`: Nodes of the coupled surfaces.
    /// - `interface_points`: Points glued to the nodes of the coupled surfaces.
}

/// Outcome of a run: the file, field by field. Fields that a run did not reach (as it ended early) are left out.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Summary {
    schema: &'static str,
    scenario: String,
    /// The word for its end.
    pub status: &'static str,
    /// The exit code of the run.
    pub exit_code: i32,
    message: String,
    /// Code of the error that ended it; `thirdbody explain CODE` prints cause and remedy.
    #[serde(skip_serializing_if = "Option::is_none")]
    code: Option<&'static str>,
    /// Accepted simulated time (s).
    pub sim_time_s: f64,
    wall_s: f64,
    /// Parts of `wall_s`, and its prediction.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub spent: Option<Spent>,
    /// The budget by which the setting was chosen, if any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub budget: Option<Value>,
    /// Accepted windows.
    pub windows: u64,
    /// Warnings about values and keys, in the order in which they were found.
    pub warnings: Vec<Warning>,
    #[serde(serialize_with = "by_name")]
    participants: Vec<(String, ParticipantSummary)>,
    /// This process, including the coupler. Participants in its threads share its processor time and memory.
    #[serde(skip_serializing_if = "Option::is_none")]
    coordinator: Option<Value>,
    /// Results by name, unit in the name.
    pub results: BTreeMap<String, f64>,
    hashes: Hashes,
    /// Size, rows and hash of each table.
    pub tables: BTreeMap<String, Written>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    phases: Vec<Phase>,
    #[serde(skip_serializing_if = "Option::is_none")]
    log: Option<LogSummary>,
    /// The fields, if they are written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fields: Option<FieldsSummary>,
    #[serde(skip_serializing_if = "Option::is_none")]
    repeats_mean: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    coupling: Option<InterfaceSummary>,
    #[serde(serialize_with = "by_name", skip_serializing_if = "Vec::is_empty")]
    interfaces: Vec<(String, InterfaceSummary)>,
    /// Stability of the interfaces, as predicted after the handshake.
    #[serde(serialize_with = "by_name", skip_serializing_if = "Vec::is_empty")]
    pub stability: Vec<(String, StabilityPrediction)>,
    /// End of the windows (s), known after the handshake.
    #[serde(skip)]
    pub end_s: Option<f64>,
    /// Number of warnings before the first window; absent if no window began.
    #[serde(skip)]
    pub warned_before: Option<usize>,
    /// Lines about stability and log, from before the first window.
    #[serde(skip)]
    pub foreseen: Vec<String>,
    /// Predicted size of the log (bytes) after the handshake, with the fewest and the most repeats.
    #[serde(skip)]
    pub log_predicted_bytes: Option<[u64; 2]>,
    /// Energies of points with their own masses, of all interfaces.
    #[serde(skip)]
    points: Option<ParticipantLedger>,
    /// The participants that each interface of `interfaces` joins.
    #[serde(skip)]
    joins: Vec<Join>,
    /// Interfaces that are meant to fail: staggered, with `unsafe_window`.
    #[serde(skip)]
    shown_to_fail: Vec<String>,
    /// Loads held by participants.
    #[serde(skip)]
    held: Vec<Option<HeldLoad>>,
}

/// The participants that an interface joins, and its index in the scenario and in `interfaces`, which is ordered by
/// groups.
#[derive(Clone, Copy, Debug)]
struct Join {
    index: usize,
    entry: usize,
    continuum: usize,
    motion_driven: usize,
}

#[derive(Clone, Debug, Default, Serialize)]
struct Hashes {
    scenario: String,
    exchange: Option<String>,
    state: Option<String>,
}

#[derive(Clone, Debug, Default, Serialize)]
struct ParticipantSummary {
    kind: String,
    pid: u32,
    /// Its host, the round-trip time, and the number of round trips for which the coordinator waited in windows; for a
    /// participant that may be on another host.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    far: Option<Far>,
    /// Hash of the recipe of its prepared sample, and whether the sample came from the cache.
    #[serde(skip_serializing_if = "Option::is_none")]
    prepared_sample_hash: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    prepared_from_cache: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    energy: Option<Map<String, Value>>,
    /// False for a participant whose energies cannot be judged; absent otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    ledger: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    energy_balance_rel: Option<f64>,
    /// Difference between the reported and the exchanged work at its interfaces.
    #[serde(skip_serializing_if = "Option::is_none")]
    interface_work_rel: Option<f64>,
    /// Work done on it through its interfaces, by its ledger (J).
    #[serde(skip)]
    through_j: Option<f64>,
    /// Its own figures at the end.
    #[serde(flatten)]
    work: Map<String, Value>,
}

#[derive(Clone, Debug, Serialize)]
struct InterfaceSummary {
    gap_max_rel: f64,
    energy_defect_rel: f64,
    force_residual_rel: f64,
    not_converged_windows: u64,
    halved_windows: u64,
    contact_iterations: u64,
    contact_residual_max: f64,
    #[serde(skip)]
    ledger: InterfaceLedger,
    /// Energies of points with their own masses.
    #[serde(flatten)]
    points: Map<String, Value>,
    #[serde(skip_serializing_if = "Option::is_none")]
    wall_s: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    share: Option<f64>,
    /// The time of the windows, by the process at work; `wall_s` is the time without a participant at work.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    account: Option<TimeAccount>,
}

/// `wall_s` is the run's time for the log, `share` its fraction of the wall-clock time. The time of the writing thread
/// and of the hash, which needs no log, come in addition.
#[derive(Clone, Debug, Serialize)]
struct LogSummary {
    bytes: u64,
    predicted_bytes: Option<u64>,
    /// Size if every window takes all allowed repeats, if that is more.
    #[serde(skip_serializing_if = "Option::is_none")]
    predicted_max_bytes: Option<u64>,
    messages: u64,
    wall_s: f64,
    share: f64,
    writer_wall_s: f64,
    hash_wall_s: f64,
}

impl Summary {
    /// The warnings before the first window: geometry, masses and keys are known by then.
    pub fn foreseen_warnings(&self) -> &[Warning] {
        &self.warnings[..self.warned_before.unwrap_or(self.warnings.len())]
    }

    /// The summary of a run that has not started.
    pub fn new(scenario: &str, scenario_hash: &str) -> Summary {
        Summary {
            schema: "thirdbody.summary/1",
            scenario: scenario.to_string(),
            hashes: Hashes {
                scenario: scenario_hash.to_string(),
                ..Hashes::default()
            },
            ..Summary::default()
        }
    }

    /// Enters the participants that answered.
    pub fn greet(&mut self, scenario: &Scenario, greeted: &[Greeted]) {
        self.phases = load_history(greeted.iter().map(|greeted| &greeted.description));
        for (participant, greeted) in scenario.participant.iter().zip(greeted) {
            let prepared = greeted.description.prepared_sample.as_ref();
            let summary = ParticipantSummary {
                kind: greeted.description.kind.clone(),
                pid: greeted.pid,
                prepared_sample_hash: prepared.map(|sample| sample.hash.clone()),
                prepared_from_cache: prepared.map(|sample| sample.from_cache),
                ..ParticipantSummary::default()
            };
            self.participants.push((participant.name.clone(), summary));
        }
        let naive = scenario.interface.iter().filter(|interface| {
            interface.unsafe_window
                && matches!(interface.scheme(), CouplingScheme::Staggered { .. })
        });
        self.shown_to_fail = naive.map(|interface| interface.name.clone()).collect();
    }

    /// Enters the participants on other hosts.
    pub fn far<'a>(&mut self, all: impl Iterator<Item = &'a Option<Far>>) {
        for ((_, participant), far) in self.participants.iter_mut().zip(all) {
            participant.far.clone_from(far);
        }
    }

    /// Enters the ledgers of the interfaces of all groups.
    pub fn interfaces<'a>(&mut self, couplings: impl Iterator<Item = &'a Coupling>) {
        let mut all = InterfaceLedger::default();
        let (mut nodes, mut points) = (0, 0);
        for coupling in couplings {
            let group = coupling.group();
            nodes += group.nodes.len();
            points += group.points.len();
            let patches = group.patches.iter().zip(&coupling.ledgers);
            for (index, (patch, ledger)) in patches.enumerate() {
                all.merge(ledger, index > 0);
                self.joins.push(Join {
                    index: patch.index,
                    entry: self.interfaces.len(),
                    continuum: group.force_driven[patch.force_driven].peer,
                    motion_driven: group.motion_driven[patch.motion_driven].peer,
                });
                let summary = InterfaceSummary::of(ledger);
                self.interfaces.push((patch.name.clone(), summary));
            }
        }
        self.windows = all.windows;
        self.repeats_mean = Some(all.repeats_mean());
        self.coupling = Some(InterfaceSummary::of(&all));
        self.points = all.points();
        let counts = [("interface_nodes", nodes), ("interface_points", points)];
        let counts = counts.map(|(name, count)| (name.to_string(), count as f64));
        self.results.extend(counts);
    }

    /// Enters the latest energies of all participants; points with their own masses count as one more.
    pub fn energies(&mut self, energies: &[ParticipantLedger]) {
        for ((_, participant), energy) in self.participants.iter_mut().zip(energies) {
            if energy.terms.is_empty() {
                participant.ledger = Some(false);
                continue;
            }
            participant.energy = Some(joules("", energy));
            let has_work = energy.terms.iter().any(|t| t.role == Role::InterfaceWork);
            participant.through_j = has_work.then(|| energy.sums().through_j);
            participant.energy_balance_rel = Some(energy.sums().balance_rel());
        }
        if energies.iter().any(|energy| energy.terms.is_empty()) {
            return;
        }
        let all = energies.iter().chain(&self.points);
        let total = EnergySums::together(all.map(ParticipantLedger::sums));
        let balance = total.balance_rel();
        self.results.insert("energy_balance_rel".into(), balance);
    }

    /// Enters the cost of this process since it had used this processor time (s).
    pub fn coordinator(&mut self, since_cpu_s: f64) {
        self.coordinator = Some(json!({
            "pid": std::process::id(),
            "cpu_s": own_cpu_s() - since_cpu_s,
            "peak_rss_bytes": peak_bytes(&[]),
        }));
    }

    /// Enters the farewells of the participants. A result of several participants gets the participant's name in front.
    pub fn farewell(&mut self, farewells: Vec<Farewell>) {
        let mut state = blake3::Hasher::new();
        let names = farewells.iter().flat_map(|of| of.outcome.results.keys());
        let names: Vec<String> = names.cloned().collect();
        for ((name, participant), farewell) in self.participants.iter_mut().zip(farewells) {
            let outcome = farewell.outcome;
            self.held.push(outcome.held_load);
            state.update(name.as_bytes());
            state.update(outcome.state_hash.as_bytes());
            for (of, value) in outcome.results {
                let alone = names.iter().filter(|other| **other == of).count() == 1;
                let of = if alone { of } else { format!("{name}.{of}") };
                self.results.insert(of, value);
            }
            let work: f64 = outcome.work.values().sum();
            participant.work = known(json!({
                "steps": outcome.steps,
                "cpu_s": farewell.cpu_s,
                "solve_wall_s": farewell.solve_wall_s,
                "setup_wall_s": farewell.setup_wall_s,
                "wait_s": farewell.wait_s,
                "work": outcome.work,
                "ns_per_work": (work > 0.0).then(|| 1e9 * farewell.solve_wall_s / work),
                "peak_rss_bytes": farewell.peak_rss_bytes,
                "state_hash": outcome.state_hash,
                "warnings": outcome.warnings,
            }));
        }
        self.hashes.state = Some(state.finalize().to_hex().to_string());
    }

    /// Enters the cost of a run, `run_wall_s` after its start; `awaited` are the times in which it waited for each
    /// participant.
    pub fn spent(
        &mut self,
        pace: &Pace,
        farewells: &[Farewell],
        awaited: &[BusyTimes],
        run_wall_s: f64,
    ) {
        self.spent = Spent::of(pace);
        if let (Some(coupling), Some(stretch_ns)) = (&mut self.coupling, pace.stretch_ns()) {
            let busy: Vec<BusyTimes> = farewells.iter().map(|of| of.busy.clone()).collect();
            let account = TimeAccount::of(stretch_ns, &busy, awaited);
            let wall_s = account.own_wall_s + account.wait_s;
            coupling.wall_s = Some(wall_s);
            coupling.share = Some(ratio(wall_s, run_wall_s));
            coupling.account = Some(account);
        }
    }

    /// Enters the finished journal, at this time (s) after the start of the run.
    pub fn close(&mut self, closed: &Closed, closed_wall_s: f64) {
        self.hashes.exchange = Some(closed.hash.clone());
        let [least, most] = [0, 1].map(|end| self.log_predicted_bytes.map(|bytes| bytes[end]));
        self.log = closed.log.map(|log| {
            let wall_s = log.caller_wall.as_secs_f64();
            LogSummary {
                bytes: log.bytes,
                predicted_bytes: least,
                predicted_max_bytes: most.filter(|_| most > least),
                messages: log.messages,
                wall_s,
                share: ratio(wall_s, closed_wall_s),
                writer_wall_s: log.writer_wall.as_secs_f64(),
                hash_wall_s: closed.hash_wall.as_secs_f64(),
            }
        });
    }

    /// Warnings about forces, energies and joints. `through_n` is the mean force that pushes the continuum down at each
    /// interface of the scenario while results are sampled (N).
    pub fn judged(&self, bounds: &Plausible, through_n: &[Option<f64>]) -> Vec<Warning> {
        let mut found = Vec::new();
        let mut add = |about: &str, finding: Option<Finding>| {
            found.extend(finding.map(|finding| Warning::of(about, finding)));
        };
        let balance = |balance: f64| plausible::energy_balance(bounds, balance);
        let held = |(load, through)| plausible::force_balance(bounds, load, through);
        let works = |works| plausible::interface_work(bounds, works);
        for (peer, (name, participant)) in self.participants.iter().enumerate() {
            add(name, participant.energy_balance_rel.and_then(balance));
            let load = self.held.get(peer).copied().flatten();
            let through = self.joins.iter().map(|join| join.force_of(peer, through_n));
            let through: Option<f64> = through.flatten().reduce(|sum, force| sum + force);
            add(name, load.zip(through).and_then(held));
            add(name, self.works_of(peer).and_then(works));
        }
        for (name, interface) in &self.interfaces {
            let energy = interface.energy_defect_rel;
            let judged = plausible::interface_energy(bounds, energy);
            add(name, judged.filter(|_| !self.shown_to_fail.contains(name)));
            add(name, plausible::gap(bounds, interface.gap_max_rel));
            let silent = interface.ledger.force_max_n == 0.0;
            let windows = interface.ledger.windows;
            add(name, plausible::no_force(windows).filter(|_| silent));
            let accepted = interface.not_converged_windows;
            let judged = plausible::not_converged(bounds, accepted, self.windows);
            add(name, judged);
        }
        let total = self.results.get("energy_balance_rel").copied();
        let total = total.filter(|_| self.participants.len() > 1);
        add("run", total.and_then(balance));
        found
    }

    /// Work done on a participant through its interfaces, if it reports this work.
    fn works_of(&self, peer: usize) -> Option<InterfaceWorks> {
        let reported_j = self.participants[peer].1.through_j?;
        let of = |join: &Join| {
            let ledger = &self.interfaces.get(join.entry)?.1.ledger;
            // Points with their own masses move between the exchanged velocities.
            let seen_j = if peer == join.continuum {
                ledger.work_j
            } else if peer == join.motion_driven && ledger.points().is_none() {
                -ledger.boundary_work_j
            } else {
                return None;
            };
            Some([seen_j, ledger.energy_j])
        };
        let each = self.joins.iter().filter_map(of);
        let [seen_j, size_j] = each.reduce(|sum, one| [sum[0] + one[0], sum[1] + one[1]])?;
        Some(InterfaceWorks {
            reported_j,
            seen_j,
            size_j,
        })
    }

    /// Enters the difference between reported and exchanged work at the interfaces of each participant.
    pub fn interface_works(&mut self) {
        for peer in 0..self.participants.len() {
            let works = self.works_of(peer);
            self.participants[peer].1.interface_work_rel = works.map(|works| works.apart_rel());
        }
    }

    /// Enters the end of the run; `strict` makes any warning suspect.
    pub fn end(&mut self, wall_s: f64, error: Option<&Error>, strict: bool) {
        let suspect = |warning: &Warning| strict || warning.suspect;
        let (code, status) = match self.warnings.iter().any(suspect) {
            true => (CHECK_FAILED, "suspect"),
            false => (0, "completed"),
        };
        self.wall_s = wall_s;
        if let Some(spent) = &mut self.spent {
            spent.end(wall_s, self.windows);
        }
        self.status = error.map_or(status, Error::status);
        self.exit_code = error.map_or(code, Error::exit_code);
        self.message = error.map_or_else(String::new, ToString::to_string);
        self.code = error.map(|error| error.code().word());
    }

    /// The text of summary.json.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("plain data always serialises")
    }

    /// summary.json as a value.
    pub fn value(&self) -> Value {
        serde_json::to_value(self).expect("plain data always serialises")
    }
}

impl Join {
    /// The mean force that leaves a participant downwards at this joint (N): a layer pushes its continuum, which pushes
    /// back.
    fn force_of(&self, peer: usize, through_n: &[Option<f64>]) -> Option<f64> {
        let force = through_n.get(self.index).copied().flatten()?;
        match peer {
            _ if peer == self.motion_driven => Some(force),
            _ if peer == self.continuum => Some(-force),
            _ => None,
        }
    }
}

impl InterfaceSummary {
    fn of(ledger: &InterfaceLedger) -> InterfaceSummary {
        let points = ledger.points().unwrap_or_default();
        InterfaceSummary {
            gap_max_rel: ledger.gap_max_rel,
            energy_defect_rel: ledger.energy_defect_rel(),
            force_residual_rel: ledger.force_residual_rel(),
            not_converged_windows: ledger.not_converged,
            halved_windows: ledger.halved,
            contact_iterations: ledger.contact_iterations,
            contact_residual_max: ledger.contact_residual_max,
            ledger: ledger.clone(),
            points: joules("points_", &points),
            wall_s: None,
            share: None,
            account: None,
        }
    }
}

/// The values of a ledger (J) by the names of its terms.
fn joules(prefix: &str, ledger: &ParticipantLedger) -> Map<String, Value> {
    let terms = ledger.terms.iter().zip(&ledger.values);
    let terms = terms.map(|(term, joules)| (format!("{prefix}{}_j", term.name), (*joules).into()));
    terms.collect()
}

/// Serialises named values as one object, in their order.
fn by_name<T: Serialize, S: Serializer>(named: &[(String, T)], out: S) -> Result<S::Ok, S::Error> {
    out.collect_map(named.iter().map(|(name, value)| (name, value)))
}

/// The entries of an object that are not null.
pub fn known(object: Value) -> Map<String, Value> {
    let Value::Object(keys) = object else {
        return Map::new();
    };
    let known = keys.into_iter().filter(|(_, value)| !value.is_null());
    known.collect()
}

#[cfg(test)]
mod tests;
