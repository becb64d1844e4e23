//! Starts participants, each in its own process or thread.

use std::path::PathBuf;
use std::process::Command;
use std::thread;

use protocol::link::channel;
use protocol::link::shm::{ShmLink, WaitMode};
use protocol::session::{SESSION_VARIABLE, STANDARD_INPUT};
use protocol::{Link, LinkError, PROTOCOL_VERSION, Session, Setting, Transport, serve};

use super::communicator::Peers;
use super::network::{Hosts, Network};
use super::peer::{OtherEnd, Peer};
use super::process::{SharedMemory, require_open_files, require_program, spawn};
use super::registry::Registry;
use super::watch::Watch;
use runs::identity::build;
use runs::run_dir::RunDir;
use scenario::error::{Error, Refusal, Result};
use scenario::keys::{Participant, TransportKind};
use scenario::load::{Loaded, absolute};

/// The data of a run for a launch.
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

impl Launcher<'_> {
    /// Starts participants of the scenario, each in its process or thread. The calling thread spawns the children and
    /// must outlive them: the system signals a child to end when its parent thread ends.
    pub fn start(&self, participants: &[Participant], watch: Watch) -> Result<Peers> {
        let memory = SharedMemory::new(self.run_id);
        let scenario = &self.loaded.scenario;
        let over = |kind| {
            let own = participants
                .iter()
                .filter(|p| scenario.transport(p) == kind);
            own.count()
        };
        if over(TransportKind::Shm) > 0 {
            require_open_files(participants.len())?;
        }
        let remote = over(TransportKind::Zenoh);
        let network = (remote > 0).then(|| Network::listen(self.loaded, self.run_id, remote));
        let network = network.transpose()?;
        let mut hosts = Hosts::default();
        let processes = scenario.participant.len() + 1;
        let wait = WaitMode::Auto { processes };
        let mut peers = Vec::new();
        for participant in participants {
            let name = &participant.name;
            let unconnected = |error: LinkError| Error::Protocol {
                peer: name.clone(),
                phase: "at its launch".into(),
                why: error.to_string(),
            };
            let (link, other_end) = match scenario.transport(participant) {
                TransportKind::Shm => {
                    let (root, prefix) = (memory.root.clone(), memory.prefix.clone());
                    let command = self.command(participant)?;
                    // Our end is complete before the process begins, so that we do not wait for parts that a killed
                    // process left unfinished.
                    let link = ShmLink::coordinator(&root, &prefix, name, wait);
                    let link: Box<dyn Link> = Box::new(link.map_err(unconnected)?);
                    let transport = Transport::Shm { root, prefix };
                    (link, self.start_process(participant, command, transport)?)
                }
                TransportKind::Zenoh => {
                    let network = network.as_ref().expect("it is made for this one");
                    // The coordinator listens before the participant can send.
                    let link = network.link(name).map_err(unconnected)?;
                    let transport = network.transport(name, &absolute(self.rundir.path()));
                    let command = self.command_elsewhere(participant, &mut hosts)?;
                    (link, self.start_process(participant, command, transport)?)
                }
                TransportKind::Channel if participant.command.is_some() => {
                    let problem = "has a command of its own and cannot run inside the coordinator: set run.transport = \"shm\"";
                    return Err(Refusal::participant(name, problem).into());
                }
                TransportKind::Channel => self.start_thread(participant)?,
            };
            peers.push(Peer::new(name, link, other_end));
        }
        if let Some(network) = &network {
            let endpoint = network.endpoint();
            self.rundir.note(&format!("listens at {endpoint}"));
        }
        let memory = Some(memory);
        let mut peers = Peers::new(peers, memory, self.run_id, scenario, watch);
        peers.network = network;
        Ok(peers)
    }

    fn start_process(
        &self,
        participant: &Participant,
        command: Command,
        transport: Transport,
    ) -> Result<OtherEnd> {
        let (name, kind) = (&participant.name, &participant.kind);
        let session = self.session(participant, transport);
        let logs = absolute(&self.rundir.logs());
        let child = spawn(command, &session, &logs)?;
        let note = format!("participant `{name}` ({kind}) pid {}", child.id());
        self.rundir.note(&note);
        Ok(OtherEnd::Process(child))
    }

    fn start_thread(&self, participant: &Participant) -> Result<(Box<dyn Link>, OtherEnd)> {
        let build = self.registry.find(participant)?.build;
        let session = self.session(participant, Transport::Channel);
        let (ours, mut theirs) = channel::pair();
        let name = participant.name.clone();
        let what = format!("starting participant `{name}`");
        let thread = thread::Builder::new()
            .name(name)
            .spawn(move || serve(&session, &mut theirs, build).map_err(|error| error.to_string()))
            .map_err(Error::input(what))?;
        Ok((Box::new(ours), OtherEnd::Thread(Some(thread))))
    }

    /// This program itself serves the built-in solvers. A foreign program starts through `exec-child`, which ties its
    /// life to the coordinator's and then runs it.
    fn command(&self, participant: &Participant) -> Result<Command> {
        let mut command = Command::new(&self.program);
        match &participant.command {
            None => {
                self.registry.find(participant)?;
                command.args(["node", &participant.kind]);
            }
            Some(words) => {
                require_program(&participant.name, &words[0], &self.loaded.folder)?;
                command.args(["exec-child", "--"]).args(words);
                command.current_dir(&self.loaded.folder);
            }
        }
        Ok(command)
    }

    /// The same behind a launcher, which only passes its input on.
    fn command_elsewhere(&self, participant: &Participant, hosts: &mut Hosts) -> Result<Command> {
        let Some(launch) = &participant.launch else {
            return self.command(participant);
        };
        let mut command = Command::new(&self.program);
        command.args(["exec-child", "--pass-session", "--"]);
        command.args(hosts.filled_in(&participant.name, launch)?);
        command.args(["env", &format!("{SESSION_VARIABLE}={STANDARD_INPUT}")]);
        match &participant.command {
            None => {
                self.registry.find(participant)?;
                // The host may have another program at the same path.
                let words = ["node", &participant.kind, "--build", build().hash];
                command.arg(&self.program).args(words)
            }
            Some(words) => command.args(words),
        };
        command.current_dir(&self.loaded.folder);
        Ok(command)
    }

    /// The session that this participant gets before the first frame.
    pub fn session(&self, participant: &Participant, transport: Transport) -> Session {
        let fields = self.loaded.scenario.run.output.fields;
        // The bits of a sample depend on its recipe and on the code that prepared it.
        let cache = self.registry.cache.as_ref();
        Session {
            protocol: PROTOCOL_VERSION,
            run_id: self.run_id,
            scenario_hash: self.loaded.hash.clone(),
            coordinator_pid: std::process::id(),
            setting: Setting {
                fields: fields.then(|| absolute(&self.rundir.fields())),
                cache: cache.map(|folder| folder.join(format!("samples-{}", build().hash))),
                ..setting(self.loaded, participant, self.threads)
            },
            transport,
            idle_deadline_s: self.loaded.scenario.run.deadlines.idle_s,
            config: config_value(participant),
        }
    }
}

/// A participant's setting without a run directory.
pub fn setting(loaded: &Loaded, participant: &Participant, threads: usize) -> Setting {
    let run = &loaded.scenario.run;
    Setting {
        participant: participant.name.clone(),
        seed: run.seed,
        thickness_m: run.thickness_m,
        threads,
        fields: None,
        cache: None,
    }
}

/// The participant's own keys as the value that its solver reads.
pub fn config_value(participant: &Participant) -> serde_json::Value {
    serde_json::to_value(&participant.config).expect("TOML tables have text keys")
}
