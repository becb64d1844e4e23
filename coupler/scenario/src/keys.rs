//! The keys of a scenario: the participants, the interfaces between them, and the run.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use scenes::listing::About;
use scheme::keys::Interface;

use crate::plausible::Plausible;

/// Longest deadline (s): one year.
const LONGEST_WAIT: f64 = 3.2e7;

/// A whole scenario, resolved from the file and `--set`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Description of the scene for its readers.
    pub about: Option<About>,
    /// Keys common to all participants.
    pub run: RunKeys,
    /// The solvers.
    pub participant: Vec<Participant>,
    /// Interfaces that join them; a single participant without an interface runs alone.
    #[serde(default)]
    pub interface: Vec<Interface>,
}

impl Scenario {
    /// The transport of a participant's frames.
    pub fn transport(&self, participant: &Participant) -> TransportKind {
        participant.transport.unwrap_or(self.run.transport)
    }

    /// Moves participants from other hosts to this one; the results of a run do not depend on the host.
    pub fn bring_here(&mut self) {
        let elsewhere = TransportKind::Zenoh;
        if self.run.transport == elsewhere {
            self.run.transport = TransportKind::Shm;
        }
        for participant in &mut self.participant {
            participant.transport = participant.transport.filter(|own| *own != elsewhere);
            participant.launch = None;
        }
    }

    /// Label for recording the exchange with one participant.
    pub fn label(&self, participant: &str) -> Label {
        let joins = |interface: &Interface| interface.participants().contains(&participant);
        let own = self.interface.iter().filter(|interface| joins(interface));
        let names: Vec<&str> = own.map(|interface| interface.name.as_str()).collect();
        let first = self.interface.iter().position(joins);
        Label {
            interface: first.unwrap_or(0) as u32,
            name: first.map_or("alone".into(), |_| names.join("+")),
        }
    }
}

/// Label for recording the exchange with a participant. A participant on several interfaces exchanges all of them in
/// one frame, which carries the index of the first and the names of all.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// Index of the participant's first interface.
    pub interface: u32,
    /// Names of its interfaces, joined by `+`; `alone` for a participant without any.
    pub name: String,
}

/// Keys common to all participants.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RunKeys {
    /// Name of the run, a plain file name.
    pub name: String,
    /// Shipped scene that this scenario is a copy of; manifest and report of each run list the keys in which they
    /// differ.
    pub derived_from: Option<String>,
    /// Seed of everything random.
    #[serde(default)]
    pub seed: u64,
    /// Out-of-plane thickness (m), positive.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub thickness_m: f64,
    /// Transport between the coordinator and its participants.
    #[serde(default)]
    pub transport: TransportKind,
    /// End of the run (s); when absent, the end of the longest load history of a participant.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub end_s: Option<f64>,
    /// Output files and their cadence.
    #[serde(default)]
    pub output: Output,
    /// Windows between two checkpoints, 0 for none. When absent, a run whose participants can all be resumed writes one
    /// every 1000 windows, and at least every five minutes.
    pub checkpoint_every_windows: Option<u64>,
    /// Number of checkpoints that are kept, at least 1; older ones are removed.
    #[serde(default = "default_checkpoints")]
    #[schemars(range(min = 1))]
    pub checkpoints_kept: u64,
    /// Longest waiting times.
    #[serde(default)]
    pub deadlines: Deadlines,
    /// Endpoints for participants on other hosts.
    #[serde(default)]
    pub remote: RemoteKeys,
    /// Bounds of the plausibility checks.
    #[serde(default)]
    pub plausible: Plausible,
}

/// One more than the latest, which a disk may lose.
fn default_checkpoints() -> u64 {
    2
}

/// Transport of frames between the coordinator and its participants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TransportKind {
    /// One process for each participant, over iceoryx2 shared memory.
    #[default]
    Shm,
    /// One thread for each participant, inside the coordinator's process.
    Channel,
    /// One process for each participant, here or on another host, over zenoh; needs a program built with the feature
    /// `zenoh`.
    Zenoh,
}

/// Endpoints for participants on other hosts.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RemoteKeys {
    /// Endpoint at which the coordinator listens, as protocol/host:port. The protocol is quic or, on loopback, tcp;
    /// port 0 takes any free port. When absent, it is quic at the name of this host inside a Slurm job, and quic on
    /// loopback elsewhere.
    pub listen: Option<String>,
    /// Endpoint at which participants reach the coordinator, if it differs from `listen`.
    pub connect: Option<String>,
}

/// Output files and their cadence.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// Windows between two rows of `signals.csv`.
    #[schemars(range(min = 1))]
    pub signals_every_windows: u64,
    /// Windows between two flushes of `exchange.mcap`; a killed writer loses at most this many.
    #[schemars(range(min = 1))]
    pub flush_every_windows: u64,
    /// Write the exchange log `exchange.mcap`, which replay and resume need.
    pub exchange: bool,
    /// Solver steps between two reports of a solver that runs alone.
    #[schemars(range(min = 1))]
    pub alone_steps: u32,
    /// Time between two snapshots of the fields within a phase of the load (s), counted from the start of each phase;
    /// at most 10 000 snapshots in a phase. When absent, fields are written only at the ends of the phases and of the
    /// run.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub fields_every_s: Option<f64>,
    /// Write fields, at least at the ends of the phases and of the run, and the tables that solvers write with them,
    /// `fields/<participant>-<moment>-profile.csv`.
    pub fields: bool,
    /// Format of the fields when the run is over: one VTK XML file for each part and moment, or one VTKHDF file for
    /// each part, which needs a program built with the feature `vtkhdf`.
    pub fields_format: FieldsFormat,
}

/// Format of the field files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FieldsFormat {
    /// One VTK XML file for each part and moment.
    #[default]
    VtkXml,
    /// One VTKHDF file for each part.
    Vtkhdf,
}

impl Default for Output {
    fn default() -> Output {
        Output {
            signals_every_windows: 1,
            flush_every_windows: 100,
            exchange: true,
            alone_steps: 100,
            fields_every_s: None,
            fields: true,
            fields_format: FieldsFormat::default(),
        }
    }
}

/// Longest waiting times (s), at most a year each. The defaults are far longer than any answer that we have measured,
/// so that only a participant that has really stopped exceeds them.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Deadlines {
    /// Longest wait for a participant's greeting after its launch (s), including the preparation of its sample.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = LONGEST_WAIT))]
    pub setup_s: f64,
    /// Longest wait for one answer during the run (s).
    #[schemars(extend("exclusiveMinimum" = 0), range(max = LONGEST_WAIT))]
    pub answer_s: f64,
    /// Longest wait of a participant for its next request (s), after which it ends itself.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = LONGEST_WAIT))]
    pub idle_s: f64,
    /// Longest wait without a sign of life from a participant on another host, or from the coordinator (s).
    #[schemars(extend("exclusiveMinimum" = 0), range(max = LONGEST_WAIT))]
    pub link_s: f64,
}

impl Default for Deadlines {
    fn default() -> Deadlines {
        Deadlines {
            setup_s: 300.0,
            answer_s: 60.0,
            idle_s: 600.0,
            link_s: 30.0,
        }
    }
}

/// One solver of the scenario.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Participant {
    /// Its name, a plain file name; messages and logs use it.
    pub name: String,
    /// `fem`, `dem`, or the kind of a foreign program.
    pub kind: String,
    /// Program and arguments of a foreign participant; when absent, `thirdbody node <kind>`.
    #[schemars(length(min = 1))]
    pub command: Option<Vec<String>>,
    /// Transport of its frames; when absent, `run.transport`.
    pub transport: Option<TransportKind>,
    /// Program and arguments that start its command on another host, for instance `ssh host`, with the transport
    /// `zenoh`. Inside a Slurm job `{host}` stands for a host of the job, the next one for each participant.
    #[schemars(length(min = 1))]
    pub launch: Option<Vec<String>>,
    /// The solver's own keys.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub config: toml::Table,
}
