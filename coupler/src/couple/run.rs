//! A run from the launch to the farewells.

use std::path::{Path, PathBuf};
use std::time::Instant;

use protocol::serve::Farewell;
use protocol::{Kind, Window};

use super::clock::Clock;
use super::conversation::Conversation;
use super::course::{Course, courses, describe, each_window, end_s, reached_s};
use super::handshake::{self, Greeted};
use super::join::join;
use super::outputs::Outputs;
use super::volume;
use crate::checkpoint::{Keeper, Origin, Position};
use crate::error::Error;
use crate::launch::{Launcher, Registry, Watch, config_value, process, setting};
use crate::log::{Provenance, Recorder, Volume};
use crate::rundir::{Resumed, RunDir, manifest};
use crate::scenario::load::Loaded;
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
            process::require_program(&participant.name, &command[0])?;
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
    Ok(warnings)
}

/// Runs a scenario. An error before anything was started is returned as such; from then on the run directory
/// keeps what was valid, and the error is part of [`Ended`].
pub fn run(loaded: &Loaded, options: &Options) -> Result<Ended, Error> {
    go_on(loaded, options, None)
}

/// The same, going on from a checkpoint of another run of the same scenario, in a run directory of its own: it ends as
/// if that run had never been cut off.
pub fn go_on(loaded: &Loaded, options: &Options, origin: Option<&Origin>) -> Result<Ended, Error> {
    let start = Instant::now();
    let warnings = check(loaded, options.registry, options.threads)?;
    let run_id = fresh_run_id();
    let rundir = RunDir::create(options.out, &loaded.scenario.run.name, run_id)?;
    let resumed = origin.map(|origin| Resumed {
        checkpoint: &origin.path,
        window: origin.checkpoint.position.windows,
    });
    let manifest = manifest(loaded, run_id, options.threads, resumed);
    rundir.write("scenario.toml", &loaded.resolved)?;
    rundir.write("manifest.json", &manifest)?;
    rundir.note(&format!(
        "coordinator pid {}, run {run_id:016x}",
        std::process::id()
    ));
    if let Some(origin) = origin {
        rundir.note(&format!("goes on from {}", origin.path.display()));
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
        origin,
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
    origin: Option<&'a Origin>,
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
        // Declared before the conversation, so that participants end before their shared memory is swept.
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
        let mut conversation = Conversation::new(
            peers,
            self.run_id,
            scenario.labels(),
            &scenario.run.deadlines,
            self.options.watch.clone(),
            self.recorder()?,
        );
        conversation.pipeline();
        let result = self.talk(&mut conversation, start);
        let closed = conversation.close();
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

    fn talk(&mut self, conversation: &mut Conversation, start: Instant) -> Result<(), Error> {
        let greeted = handshake::greet(conversation, self.loaded, self.run_id)?;
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
            conversation.watch.let_windows_end();
        }
        if let Some(origin) = self.origin {
            origin.check(self.loaded, &greeted)?;
            self.carry_over(conversation, &mut outputs, origin)?;
        }
        let result = match scenario.interface.is_empty() {
            false => self.coupled(conversation, &greeted, &mut outputs, &keeper),
            true => self.alone(conversation, &greeted, &mut outputs, &keeper),
        };
        self.summary.energies(&outputs.energies);
        outputs.signals.finish()?;
        result?;
        let farewells = farewells(conversation)?;
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

    /// Takes over what the run left that is gone on with. From the adoption of its checkpoint on, this run directory can be
    /// resumed as well.
    fn carry_over(
        &mut self,
        conversation: &mut Conversation,
        outputs: &mut Outputs,
        origin: &Origin,
    ) -> Result<(), Error> {
        let state = &origin.checkpoint;
        let handshake = conversation.carry_over(&origin.log(), state.log_blocks)?;
        outputs.carry_over(origin)?;
        conversation.sync_log()?;
        origin.adopt(self.rundir)?;
        if !self.loaded.scenario.interface.is_empty() {
            conversation.rehearse(handshake);
        }
        self.summary.sim_time_s = state.position.t_s;
        self.summary.windows = state.position.windows;
        Ok(())
    }

    fn coupled(
        &mut self,
        conversation: &mut Conversation,
        greeted: &[Greeted],
        outputs: &mut Outputs,
        keeper: &Keeper,
    ) -> Result<(), Error> {
        let scenario = &self.loaded.scenario;
        let groups = join(conversation, scenario, greeted)?;
        conversation.end_window(0)?;
        let mut courses = courses(scenario, greeted, groups)?;
        for course in &courses {
            self.rundir.note(&describe(course));
        }
        self.foretell_log(&volume::coupled(scenario, greeted, &courses));
        match self.origin {
            // What was foreseen, and asked for it, is in the log that is gone on with.
            Some(origin) => origin.restore(conversation, &mut courses)?,
            None => self.foresee(conversation, greeted, &mut courses)?,
        }
        outputs.expect(courses[0].step, courses[0].end);
        let summary = &mut self.summary;
        summary.interfaces(courses.iter().map(|course| &course.coupling));
        each_window(
            conversation,
            &mut courses,
            |conversation, courses, stage| {
                summary.interfaces(courses.iter().map(|course| &course.coupling));
                let Some((window, standing)) = stage else {
                    return Ok(());
                };
                summary.sim_time_s = reached_s(courses);
                outputs.add_coupled(conversation, courses, window, standing)?;
                outputs.pause(conversation, keeper, courses, Position::of(courses))
            },
        )?;
        outputs.finish(conversation, summary)
    }

    /// Writes down how long the log will be.
    fn foretell_log(&mut self, volume: &Volume) {
        let output = &self.loaded.scenario.run.output;
        if output.exchange {
            let texts = self.loaded.resolved.len() + self.manifest.len();
            let bytes = volume.bytes(texts, output.flush_every_windows);
            self.rundir.note(&volume::line(volume, bytes));
            self.summary.log_predicted_bytes = Some(bytes);
        }
    }

    /// Writes down what the handshake tells of the stability to come, and refuses what cannot go well.
    fn foresee(
        &self,
        conversation: &mut Conversation,
        greeted: &[Greeted],
        courses: &mut [Course],
    ) -> Result<(), Error> {
        for course in courses {
            for (index, prediction) in course.coupling.foresee(conversation, greeted)? {
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
        conversation: &mut Conversation,
        greeted: &[Greeted],
        outputs: &mut Outputs,
        keeper: &Keeper,
    ) -> Result<(), Error> {
        let description = &greeted[0].description;
        let name = conversation.peers[0].name().to_string();
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
        self.foretell_log(&volume::alone(scenario, description, &clock, end));
        let mut start = 0;
        if let Some(origin) = self.origin {
            origin.restore(conversation, &mut [])?;
            start = origin.checkpoint.position.windows;
        }
        outputs.expect(start * u64::from(clock.substeps), end);
        for index in start..end.div_ceil(clock.substeps.into()) {
            let step = index * u64::from(clock.substeps);
            let window = clock.window(index, step, clock.substeps_before(step, end));
            let report =
                conversation.ask(0, Kind::AdvanceAlone, Kind::Report, &window, Vec::new())?;
            conversation.end_window(index)?;
            outputs.add_alone(conversation, &window, report)?;
            self.summary.windows = index + 1;
            self.summary.sim_time_s = window.t1_s;
            let position = Position {
                windows: index + 1,
                t_s: window.t1_s,
                courses: Vec::new(),
                over: step + u64::from(window.substeps) >= end,
            };
            outputs.pause(conversation, keeper, &[], position)?;
        }
        outputs.finish(conversation, &mut self.summary)
    }
}

fn farewells(conversation: &mut Conversation) -> Result<Vec<Farewell>, Error> {
    let count = conversation.peers.len();
    for peer in 0..count {
        conversation.tell(peer, Kind::Finish, &Window::default(), Vec::new())?;
    }
    (0..count)
        .map(|peer| {
            let frame = conversation.hear(peer, Kind::Finished)?;
            frame
                .text()
                .map_err(|error| error.to_string())
                .and_then(|text| serde_json::from_str(&text).map_err(|error| error.to_string()))
                .map_err(|why| {
                    conversation.peers[peer]
                        .protocol(format!("sent an outcome that cannot be read: {why}"))
                })
        })
        .collect()
}
