//! The start of participants, each in a process or a thread of its own.

use std::path::PathBuf;
use std::process::Command;
use std::thread;

use protocol::link::channel;
use protocol::link::shm::{self, ShmLink, WaitMode};
use protocol::{PROTOCOL_VERSION, Session, Setting, Transport, serve};

use super::peer::{Life, Peer};
use super::process::{require_program, spawn};
use super::registry::Registry;
use crate::error::Error;
use crate::rundir::RunDir;
use crate::scenario::load::Loaded;
use crate::scenario::{Participant, TransportKind};

/// The run, as every launch needs it.
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
    /// Its folder.
    pub rundir: &'a RunDir,
}

/// The files of a run in shared memory; removed when dropped, whatever ended the run.
pub struct SharedMemory {
    root: PathBuf,
    prefix: String,
}

impl Drop for SharedMemory {
    fn drop(&mut self) {
        // Nothing more can be done about what cannot be removed; the next run tries again.
        let _ = shm::remove_run(&self.root, &self.prefix);
    }
}

impl Launcher<'_> {
    /// Makes the run's own place in shared memory, after removing what dead coordinators of this user left.
    pub fn shared_memory(&self) -> SharedMemory {
        let root = shm::run_root();
        let _ = shm::remove_dead_runs(&root);
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
        let mut command = self.command(participant)?;
        let child = spawn(&mut command, &session, &self.rundir.logs())?;
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

    /// The shipped solvers are served by this very program; a foreign program is started through `exec-child`,
    /// which ties its life to the coordinator's before handing over.
    fn command(&self, participant: &Participant) -> Result<Command, Error> {
        let mut command = Command::new(&self.program);
        match &participant.command {
            None => {
                self.registry.find(participant)?;
                command.args(["node", &participant.kind]);
            }
            Some(words) => {
                require_program(&participant.name, &words[0])?;
                command.args(["exec-child", "--"]).args(words);
            }
        }
        Ok(command)
    }

    /// The session that this participant is told before the first frame.
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

/// The setting that is common to all participants of a scenario, without a run directory.
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
