//! Starting participants and keeping watch over them.
//!
//! - [`registry`]: the solvers that the binary ships;
//! - [`peer`]: one participant, its connection and its life;
//! - [`process`]: a participant in a process of its own.

use std::path::PathBuf;
use std::thread;
use std::time::Duration;

use protocol::link::channel;
use protocol::link::shm::{self, ShmLink, WaitMode};
use protocol::{PROTOCOL_VERSION, Session, Setting, Transport, serve};

pub mod peer;
pub mod process;
pub mod registry;

pub use peer::{Life, Peer, Watch};
pub use registry::{Registry, Solver};

use crate::error::Error;
use crate::rundir::RunDir;
use crate::scenario::load::Loaded;
use crate::scenario::{Participant, TransportKind};

/// What every launch needs to know about the run.
pub struct Launcher<'a> {
    /// The scenario.
    pub loaded: &'a Loaded,
    /// Shipped solvers.
    pub registry: &'a Registry,
    /// The program whose `node` verb serves shipped solvers.
    pub program: PathBuf,
    /// Identity of the run.
    pub run_id: u64,
    /// Threads of each participant.
    pub threads: usize,
    /// Where it writes.
    pub rundir: &'a RunDir,
}

/// What a run leaves in shared memory; removed when dropped, whatever ended the run.
pub struct SharedMemory {
    root: PathBuf,
    prefix: String,
}

impl Drop for SharedMemory {
    fn drop(&mut self) {
        // Nothing more can be done about what cannot be removed; the next run tries again.
        let _ = shm::sweep(&self.root, &self.prefix);
    }
}

impl Launcher<'_> {
    /// Makes the run's own place in shared memory, after removing what dead coordinators of this user left.
    pub fn shared_memory(&self) -> SharedMemory {
        let root = shm::run_root();
        let _ = shm::sweep_dead(&root);
        SharedMemory {
            root,
            prefix: shm::run_prefix(std::process::id(), self.run_id),
        }
    }

    /// Starts one participant. Children are spawned by the calling thread, which must outlive them: a child is
    /// told to end when the thread that spawned it ends.
    pub fn start(&self, participant: &Participant, memory: &SharedMemory) -> Result<Peer, Error> {
        match self.loaded.scenario.run.transport {
            TransportKind::Shm => self.start_process(participant, memory),
            TransportKind::Channel if participant.command.is_some() => {
                Err(Error::Refused(format!(
                    "participant `{}` has a command of its own and cannot run inside the coordinator: set run.transport = \"shm\"",
                    participant.name
                )))
            }
            TransportKind::Channel => self.start_thread(participant),
        }
    }

    fn start_process(
        &self,
        participant: &Participant,
        memory: &SharedMemory,
    ) -> Result<Peer, Error> {
        let transport = Transport::Shm {
            root: memory.root.clone(),
            prefix: memory.prefix.clone(),
        };
        let session = self.session(participant, transport);
        let wait = WaitMode::Auto {
            processes: self.loaded.scenario.participant.len() + 1,
        };
        let link = ShmLink::coordinator(&memory.root, &memory.prefix, &participant.name, wait)
            .map_err(|error| Error::Protocol {
                peer: participant.name.clone(),
                phase: "before its launch".into(),
                why: error.to_string(),
            })?;
        let child = process::spawn(self, participant, &session)?;
        Ok(Peer::new(
            &participant.name,
            Box::new(link),
            Life::Process(child),
        ))
    }

    fn start_thread(&self, participant: &Participant) -> Result<Peer, Error> {
        let solver = self.registry.find(participant)?;
        let session = self.session(participant, Transport::Channel);
        let (ours, mut theirs) = channel::pair();
        let build = solver.build;
        let thread = thread::Builder::new()
            .name(participant.name.clone())
            .spawn(move || serve(&session, &mut theirs, build).map_err(|error| error.to_string()))
            .map_err(Error::input(format!(
                "starting participant `{}`",
                participant.name
            )))?;
        Ok(Peer::new(
            &participant.name,
            Box::new(ours),
            Life::Thread(thread),
        ))
    }

    /// What this participant is told before the first frame.
    pub fn session(&self, participant: &Participant, transport: Transport) -> Session {
        Session {
            protocol: PROTOCOL_VERSION,
            run_id: self.run_id,
            scenario_hash: self.loaded.hash.clone(),
            coordinator_pid: std::process::id(),
            setting: self.setting(participant),
            transport,
            idle_deadline_s: self.loaded.scenario.run.deadlines.idle_s,
            config: config_value(participant),
        }
    }

    fn setting(&self, participant: &Participant) -> Setting {
        Setting {
            fields: Some(self.rundir.fields()),
            ..setting(self.loaded, participant, self.threads)
        }
    }
}

/// What is common to all participants of a scenario, without a run directory.
pub fn setting(loaded: &Loaded, participant: &Participant, threads: usize) -> Setting {
    let run = &loaded.scenario.run;
    Setting {
        participant: participant.name.clone(),
        seed: run.seed,
        thickness_m: run.thickness_m,
        threads,
        fields: None,
    }
}

/// The participant's own keys as the value that its solver reads.
pub fn config_value(participant: &Participant) -> serde_json::Value {
    serde_json::to_value(&participant.config).expect("TOML tables have text keys")
}

/// How long a participant that was asked to end may take before it is killed.
pub(crate) const GRACE: Duration = Duration::from_millis(1000);
