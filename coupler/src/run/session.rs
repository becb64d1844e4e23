//! A run from the launch to the farewells.

use std::path::{Path, PathBuf};
use std::time::Instant;

use protocol::serve::Farewell;
use protocol::{Kind, Window};

use super::checkpoint::{Keeper, RestartPoint};
use super::log_volume;
use super::outputs::Outputs;
use super::position::Position;
use super::time_loop::{
    GroupRun, describe, each_window, end_s, groups_at_start, position, reached_s,
};
use crate::error::Error;
use crate::log::{Exchange, Provenance, Recorder, Volume};
use crate::participants::handshake::{self, Greeted};
use crate::participants::journal::Journal;
use crate::participants::launch::{Launcher, config_value, setting};
use crate::participants::process::require_program;
use crate::participants::recorded::Recorded;
use crate::participants::rehearsed::Rehearsed;
use crate::participants::remote::Remote;
use crate::participants::{Communicator, Peers, Registry, Watch};
use crate::rundir::{Resumed, RunDir, manifest};
use crate::scenario::load::Loaded;
use crate::scheme::clock::Clock;
use crate::scheme::group::Group;
use crate::scheme::join::join;
use crate::scheme::predict::inputs::foresee;
use crate::summary::{Costs, Summary};

/// How to run, beside the scenario.
pub struct Options<'a> {
    /// Place of the run directory; by default a new folder below `runs/`.
    pub out: Option<&'a Path>,
    /// Threads of each participant.
    pub threads: usize,
    /// Shipped solvers.
    pub registry: &'a Registry,
    /// The program whose `node` verb serves shipped solvers.
    pub program: PathBuf,
    /// Signals that end the run.
    pub watch: Watch,
    /// Whether to show progress on stderr.
    pub progress: bool,
}

/// How a run ended; the summary is in the run directory too.
pub struct Ended {
    /// Where everything lies.
    pub path: PathBuf,
    /// What summary.json says.
    pub summary: Summary,
    /// Why it ended early, if it did.
    pub error: Option<Error>,
}

/// Checks a scenario as far as that goes without starting anything; returns what the user should know.
pub fn check(loaded: &Loaded, registry: &Registry, threads: usize) -> Result<Vec<String>, Error> {
    let mut warnings = Vec::new();
    for participant in &loaded.scenario.participant {
        if let Some(command) = &participant.command {
            require_program(&participant.name, &command[0])?;
            continue;
        }
        let solver = registry.find(participant)?;
        let found = (solver.check)(
            &config_value(participant),
            &setting(loaded, participant, threads),
        )
        .map_err(|error| {
            loaded.source.error(
                &format!("participant.{}.config.{}", participant.name, error.key),
                error,
            )
        })?;
        warnings.extend(
            found
                .into_iter()
                .map(|warning| format!("participant `{}`: {warning}", participant.name)),
        );
    }
    for interface in &loaded.scenario.interface {
        let scheme = toml::Value::try_from(interface.scheme.word()).expect("it is a word");
        warnings.extend(interface.given.unused().into_iter().map(|key| {
            format!(
                "interface.{}.{key} means nothing for scheme = {scheme} and is not used",
                interface.name
            )
        }));
    }
    Ok(warnings)
}

/// Runs a scenario. An error before anything was started is returned as such; from then on the run directory
/// keeps what was valid, and the error is part of [`Ended`].
pub fn run(loaded: &Loaded, options: &Options) -> Result<Ended, Error> {
    go_on(loaded, options, None)
}

/// The same, going on from a checkpoint of another run of the same scenario, in a run directory of its own: it ends as
/// if that run had never been cut off.
pub fn go_on(
    loaded: &Loaded,
    options: &Options,
    restart: Option<&RestartPoint>,
) -> Result<Ended, Error> {
    let start = Instant::now();
    let warnings = check(loaded, options.registry, options.threads)?;
    let run_id = fresh_run_id();
    let rundir = RunDir::create(options.out, &loaded.scenario.run.name, run_id)?;
    let resumed = restart.map(|restart| Resumed {
        checkpoint: &restart.path,
        window: restart.checkpoint.position.windows,
    });
    let manifest = manifest(loaded, run_id, options.threads, resumed);
    rundir.write("scenario.toml", &loaded.resolved)?;
    rundir.write("manifest.json", &manifest)?;
    rundir.note(&format!(
        "coordinator pid {}, run {run_id:016x}",
        std::process::id()
    ));
    if let Some(restart) = restart {
        rundir.note(&format!("goes on from {}", restart.path.display()));
    }
    for warning in &warnings {
        rundir.note(&format!("warning: {warning}"));
    }
    let mut session = RunSession {
        loaded,
        options,
        rundir: &rundir,
        run_id,
        manifest,
        restart,
        summary: Summary::new(&loaded.scenario.run.name, &loaded.hash),
    };
    let error = session.all(start).err();
    let mut summary = session.summary;
    summary.end(start.elapsed().as_secs_f64(), error.as_ref());
    rundir.write("summary.json", &summary.to_json())?;
    rundir.note(&match &error {
        None => "completed".to_string(),
        Some(error) => format!("ended early: {error}"),
    });
    Ok(Ended {
        path: rundir.path().to_path_buf(),
        summary,
        error,
    })
}

/// Tells runs apart; it takes no part in any result.
pub fn fresh_run_id() -> u64 {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&std::process::id().to_le_bytes());
    let now = std::time::SystemTime::now()
        .duration_since(std::time::UNIX_EPOCH)
        .map_or(0, |since| since.as_nanos());
    hasher.update(&now.to_le_bytes());
    hasher.update(format!("{:?}", std::thread::current().id()).as_bytes());
    let mut bytes = [0; 8];
    bytes.copy_from_slice(&hasher.finalize().as_bytes()[..8]);
    u64::from_le_bytes(bytes)
}

struct RunSession<'a> {
    loaded: &'a Loaded,
    options: &'a Options<'a>,
    rundir: &'a RunDir,
    run_id: u64,
    manifest: String,
    restart: Option<&'a RestartPoint>,
    summary: Summary,
}

impl RunSession<'_> {
    fn all(&mut self, start: Instant) -> Result<(), Error> {
        let launcher = Launcher {
            loaded: self.loaded,
            registry: self.options.registry,
            program: self.options.program.clone(),
            run_id: self.run_id,
            threads: self.options.threads,
            rundir: self.rundir,
        };
        // Declared before the peers, so that participants end before their shared memory is swept.
        let memory = launcher.shared_memory();
        let scenario = &self.loaded.scenario;
        let mut peers = Vec::new();
        for participant in &scenario.participant {
            let peer = launcher.start(participant, &memory)?;
            if let Some(pid) = peer.pid() {
                self.rundir.note(&format!(
                    "participant `{}` ({}) pid {pid}",
                    participant.name, participant.kind
                ));
            }
            peers.push(peer);
        }
        let mut peers = Peers::new(
            peers,
            self.run_id,
            scenario.labels(),
            &scenario.run.deadlines,
            self.options.watch.clone(),
        );
        peers.pipelined = true;
        let journal = Journal::new(self.recorder()?);
        let mut recorded = Recorded { peers, journal };
        let result = self.converse(&mut recorded, start);
        let closed = recorded.journal.close();
        if let Ok(closed) = &closed {
            self.summary.close(closed, start.elapsed().as_secs_f64());
        }
        result.and(closed.map(|_| ()))
    }

    fn recorder(&self) -> Result<Option<Recorder>, Error> {
        let output = &self.loaded.scenario.run.output;
        if !output.exchange {
            return Ok(None);
        }
        let provenance = Provenance {
            scenario_toml: self.loaded.resolved.clone(),
            manifest_json: self.manifest.clone(),
            run_id: self.run_id,
        };
        let path = self.rundir.path().join("exchange.mcap");
        Ok(Some(Recorder::create(
            &path,
            &provenance,
            output.flush_every_windows,
        )?))
    }

    fn converse(&mut self, recorded: &mut Recorded, start: Instant) -> Result<(), Error> {
        let greeted = handshake::greet(recorded, self.loaded, self.run_id)?;
        let scenario = &self.loaded.scenario;
        for (participant, greeted) in scenario.participant.iter().zip(&greeted) {
            self.rundir.note(&format!(
                "participant `{}` is {} in process {}",
                participant.name, greeted.description.software, greeted.pid
            ));
            for warning in &greeted.description.warnings {
                self.rundir.note(&format!(
                    "warning: participant `{}`: {warning}",
                    participant.name
                ));
            }
        }
        self.summary.greet(scenario, &greeted);
        let talking = Instant::now();
        let mut outputs = Outputs::new((self.rundir, scenario), &greeted, self.options.progress)?;
        let keeper = Keeper::new(self.rundir, self.loaded, &greeted)?;
        if keeper.writes() {
            recorded.peers.watch.let_windows_end();
        }
        let mut logged = Vec::new();
        if let Some(restart) = self.restart {
            restart.check(self.loaded, &greeted)?;
            logged = self.carry_over(recorded, &mut outputs, restart)?;
        }
        let result = if scenario.interface.is_empty() {
            self.alone(recorded, &greeted, &mut outputs, &keeper)
        } else {
            self.coupled(recorded, &greeted, logged, &mut outputs, &keeper)
        };
        self.summary.energies(&outputs.energies);
        outputs.signals.finish()?;
        result?;
        let farewells = farewells(recorded)?;
        for (participant, farewell) in scenario.participant.iter().zip(&farewells) {
            for warning in &farewell.outcome.warnings {
                self.rundir.note(&format!(
                    "warning: participant `{}`: {warning}",
                    participant.name
                ));
            }
        }
        let costs = Costs {
            talk_wall_s: talking.elapsed().as_secs_f64(),
            run_wall_s: start.elapsed().as_secs_f64(),
        };
        self.summary.farewell(&farewells, &costs);
        Ok(())
    }

    /// Takes over the log and the outputs of the run that is gone on with. From the adoption of its checkpoint on, this run
    /// directory can be resumed as well. Returns the messages of the logged handshake.
    fn carry_over(
        &mut self,
        recorded: &mut Recorded,
        outputs: &mut Outputs,
        restart: &RestartPoint,
    ) -> Result<Vec<Exchange>, Error> {
        let state = &restart.checkpoint;
        let journal = &mut recorded.journal;
        let handshake = journal.carry_over(&restart.log(), state.log_blocks)?;
        outputs.carry_over(restart)?;
        journal.sync()?;
        restart.adopt(self.rundir)?;
        self.summary.sim_time_s = state.position.t_s;
        self.summary.windows = state.position.windows;
        Ok(handshake)
    }

    /// Joins the interfaces. A resumed run must say just what the log already holds.
    fn join(
        &self,
        recorded: &mut Recorded,
        greeted: &[Greeted],
        logged: Vec<Exchange>,
    ) -> Result<Vec<Group>, Error> {
        let scenario = &self.loaded.scenario;
        if self.restart.is_none() {
            let groups = join(&mut Remote::new(recorded, greeted), scenario)?;
            recorded.end_window(0)?;
            return Ok(groups);
        }
        let mut rehearsed = Rehearsed::new(&mut recorded.peers, logged);
        let groups = join(&mut Remote::new(&mut rehearsed, greeted), scenario)?;
        rehearsed.finish()?;
        Ok(groups)
    }

    fn coupled(
        &mut self,
        recorded: &mut Recorded,
        greeted: &[Greeted],
        logged: Vec<Exchange>,
        outputs: &mut Outputs,
        keeper: &Keeper,
    ) -> Result<(), Error> {
        let scenario = &self.loaded.scenario;
        let joined = self.join(recorded, greeted, logged)?;
        let mut groups = groups_at_start(scenario, greeted, joined)?;
        for group in &groups {
            self.rundir.note(&describe(group));
        }
        self.note_log_volume(&log_volume::coupled(scenario, greeted, &groups));
        match self.restart {
            // The prediction, and what was asked for it, is in the log that is gone on with.
            Some(restart) => restart.restore(&mut recorded.peers, greeted, &mut groups)?,
            None => self.predict(recorded, greeted, &mut groups)?,
        }
        outputs.expect(groups[0].steps_done(), groups[0].end);
        let summary = &mut self.summary;
        summary.interfaces(groups.iter().map(|group| &group.coupling));
        each_window(recorded, greeted, &mut groups, |recorded, groups, done| {
            summary.interfaces(groups.iter().map(|group| &group.coupling));
            let Some((window, accepted)) = done else {
                return Ok(());
            };
            summary.sim_time_s = reached_s(groups);
            outputs.add_coupled(recorded, groups, window, accepted)?;
            outputs.pause(recorded, keeper, groups, position(groups))
        })?;
        outputs.finish(recorded, summary)
    }

    /// Notes the predicted length of the log.
    fn note_log_volume(&mut self, volume: &Volume) {
        let output = &self.loaded.scenario.run.output;
        if output.exchange {
            let texts = self.loaded.resolved.len() + self.manifest.len();
            let bytes = volume.bytes(texts, output.flush_every_windows);
            self.rundir.note(&log_volume::line(volume, bytes));
            self.summary.log_predicted_bytes = Some(bytes);
        }
    }

    /// Notes the stability that the handshake predicts, and refuses a scheme that is predicted to fail.
    fn predict(
        &self,
        recorded: &mut Recorded,
        greeted: &[Greeted],
        groups: &mut [GroupRun],
    ) -> Result<(), Error> {
        let remote = &mut Remote::new(recorded, greeted);
        for group in groups {
            for (index, prediction) in foresee(&mut group.coupling, remote)? {
                let interface = &self.loaded.scenario.interface[index];
                for line in prediction.lines() {
                    self.rundir
                        .note(&format!("interface `{}`: {line}", interface.name));
                }
                prediction.refuse(interface)?;
            }
        }
        Ok(())
    }

    fn alone(
        &mut self,
        recorded: &mut Recorded,
        greeted: &[Greeted],
        outputs: &mut Outputs,
        keeper: &Keeper,
    ) -> Result<(), Error> {
        let description = &greeted[0].description;
        let name = recorded.peers.name(0).to_string();
        if !description.capabilities.alone {
            return Err(Error::Refused(format!(
                "participant `{name}` cannot run without an interface"
            )));
        }
        let step_s = description.step_s.ok_or_else(|| {
            Error::Refused(format!("participant `{name}` has no step of its own: give participant.{name}.config.time.step_s"))
        })?;
        let clock = Clock {
            step_s,
            substeps: self.loaded.scenario.run.output.alone_steps,
        };
        let end = clock.steps_until(end_s(&self.loaded.scenario, greeted)?)?;
        let scenario = &self.loaded.scenario;
        self.note_log_volume(&log_volume::alone(scenario, description, &clock, end));
        let mut start = 0;
        if let Some(restart) = self.restart {
            restart.restore(&mut recorded.peers, greeted, &mut [])?;
            start = restart.checkpoint.position.windows;
        }
        outputs.expect(start * u64::from(clock.substeps), end);
        for index in start..end.div_ceil(clock.substeps.into()) {
            let step = index * u64::from(clock.substeps);
            let window = clock.window(index, step, clock.substeps_before(step, end));
            let communicator: &mut dyn Communicator = recorded;
            let kinds = (Kind::AdvanceAlone, Kind::Report);
            let report = communicator.ask(0, kinds, &window, Vec::new())?;
            communicator.end_window(index)?;
            outputs.add_alone(communicator, &window, report)?;
            self.summary.windows = index + 1;
            self.summary.sim_time_s = window.t1_s;
            let position = Position {
                windows: index + 1,
                t_s: window.t1_s,
                groups: Vec::new(),
                over: step + u64::from(window.substeps) >= end,
            };
            outputs.pause(recorded, keeper, &[], position)?;
        }
        outputs.finish(recorded, &mut self.summary)
    }
}

fn farewells(communicator: &mut dyn Communicator) -> Result<Vec<Farewell>, Error> {
    let count = communicator.peers().count();
    for peer in 0..count {
        communicator.tell(peer, Kind::Finish, &Window::default(), Vec::new())?;
    }
    (0..count)
        .map(|peer| {
            let frame = communicator.receive(peer, Kind::Finished)?;
            frame
                .text()
                .map_err(|error| error.to_string())
                .and_then(|text| serde_json::from_str(&text).map_err(|error| error.to_string()))
                .map_err(|why| {
                    let why = format!("sent an outcome that cannot be read: {why}");
                    communicator.peers().protocol_error(peer, why)
                })
        })
        .collect()
}
