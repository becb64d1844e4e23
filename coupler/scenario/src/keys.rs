//! The keys of a scenario: who takes part, who talks to whom, and how.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use scenes::listing::About;
use scheme::keys::Interface;

use crate::plausible::Plausible;

/// Longest deadline (s): a year.
const LONGEST_WAIT: f64 = 3.2e7;

/// A whole scenario, as resolved from the file and `--set`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Description of the scene for its readers.
    pub about: Option<About>,
    /// Keys common to all participants.
    pub run: RunKeys,
    /// The solvers.
    pub participant: Vec<Participant>,
    /// Joints between them; without any, the one participant runs alone.
    #[serde(default)]
    pub interface: Vec<Interface>,
}

impl Scenario {
    /// The way in which the frames of a participant travel.
    pub fn transport(&self, participant: &Participant) -> TransportKind {
        participant.transport.unwrap_or(self.run.transport)
    }

    /// Lets participants on other hosts run on this one: what a run comes to does not depend on it.
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

    /// Label that the exchange with one participant is recorded under.
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

/// Label that the exchange with a participant is recorded under. A participant on several interfaces exchanges all of them in
/// one frame: the frame carries the index of the first, and the names of all.
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
    /// Shipped scene that this one is a copy of: in which keys it differs is told with each run.
    pub derived_from: Option<String>,
    /// Seed of everything random.
    #[serde(default)]
    pub seed: u64,
    /// Out-of-plane thickness (m), positive.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub thickness_m: f64,
    /// Way in which frames travel.
    #[serde(default)]
    pub transport: TransportKind,
    /// End of the run (s); by default the longest load history of a participant.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub end_s: Option<f64>,
    /// Files that are written, and their cadence.
    #[serde(default)]
    pub output: Output,
    /// Windows between two checkpoints, 0 for none; by default 1000, and five minutes at most, where all participants can be resumed.
    pub checkpoint_every_windows: Option<u64>,
    /// Checkpoints that are kept, at least 1; the oldest goes.
    #[serde(default = "default_checkpoints")]
    #[schemars(range(min = 1))]
    pub checkpoints_kept: u64,
    /// Longest waits.
    #[serde(default)]
    pub deadlines: Deadlines,
    /// Endpoints by which participants on other hosts reach the coordinator.
    #[serde(default)]
    pub remote: RemoteKeys,
    /// Bounds of the checks of plausibility.
    #[serde(default)]
    pub plausible: Plausible,
}

/// One more than the latest: a disk may lose that.
fn default_checkpoints() -> u64 {
    2
}

/// Ways in which frames travel between the coordinator and its participants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TransportKind {
    /// One process a participant, iceoryx2 shared memory.
    #[default]
    Shm,
    /// One thread a participant, inside the coordinator's process.
    Channel,
    /// One process a participant, here or on another host, over zenoh: for a program that is built with the feature `zenoh`.
    Zenoh,
}

/// Endpoints by which participants on other hosts reach the coordinator.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RemoteKeys {
    /// Endpoint that the coordinator listens at, protocol/host:port with the protocol quic or, on loopback, tcp, and port 0 for any. By
    /// default quic at the name of this host inside a job of Slurm, and on loopback elsewhere.
    pub listen: Option<String>,
    /// The endpoint by which participants reach it, where that is another one.
    pub connect: Option<String>,
}

/// Files that are written, and their cadence.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// Windows between two rows of `signals.csv`.
    #[schemars(range(min = 1))]
    pub signals_every_windows: u64,
    /// Windows between two flushes of `exchange.mcap`: a killed writer loses at most so many.
    #[schemars(range(min = 1))]
    pub flush_every_windows: u64,
    /// Write `exchange.mcap`.
    pub exchange: bool,
    /// Own steps in a report of a solver that runs alone.
    #[schemars(range(min = 1))]
    pub alone_steps: u32,
    /// Time between two snapshots of the fields within a phase of the load, from its start on (s); only at the ends of phases
    /// when absent.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub fields_every_s: Option<f64>,
    /// Write fields, at the ends of phases and of the run at least, and the tables beside them.
    pub fields: bool,
    /// Files that the fields of a run have once it is over: one of VTK XML a part and moment, or one of VTKHDF a part, for which the program
    /// is built with the feature `vtkhdf`.
    pub fields_format: FieldsFormat,
}

/// Files of the fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FieldsFormat {
    /// One file of VTK XML a part and moment.
    #[default]
    VtkXml,
    /// One file of VTKHDF a part.
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

/// Longest waits (s). They are far longer than any answer that we have measured, so that only
/// a participant that has really stopped runs into them. At most a year each.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Deadlines {
    /// Wait for a participant's greeting after its launch, sample preparation included.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = LONGEST_WAIT))]
    pub setup_s: f64,
    /// Wait for one answer during the run.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = LONGEST_WAIT))]
    pub answer_s: f64,
    /// Wait of a participant for its next request, before it ends itself.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = LONGEST_WAIT))]
    pub idle_s: f64,
    /// Wait without any sign of life from a participant on another host, or from the coordinator.
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
    /// Program and arguments of a foreign participant; by default `thirdbody node <kind>`.
    #[schemars(length(min = 1))]
    pub command: Option<Vec<String>>,
    /// Way in which its frames travel; by default that of the run.
    pub transport: Option<TransportKind>,
    /// Program and arguments that start its command on another host, for instance `ssh host`; `{host}` stands for a host of the job inside
    /// one of Slurm, the next for each participant. For the transport `zenoh`.
    #[schemars(length(min = 1))]
    pub launch: Option<Vec<String>>,
    /// The solver's own keys.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub config: toml::Table,
}
