//! A run, from the launch to the farewells.

use std::hash::{BuildHasher, RandomState};
use std::path::{Path, PathBuf};
use std::time::{Instant, SystemTime};

use protocol::serve::Farewell;
use protocol::{Finding, Kind};
use serde_json::{Value, json};

use super::check::check;
use super::checkpoint::RestartPoint;
use super::log_volume::{self, Repeats};
use super::outputs::Outputs;
use super::position::RunPosition;
use super::time_loop::{
    GroupRun, describe, each_window, end_s, groups_at_start, position, reached_s,
};
use crate::cost::memory::{forget_peak, own_cpu_s};
use crate::events::{Listener, RunEvent};
use crate::output::Progress;
use crate::participants::farewell::read_farewell;
use crate::participants::handshake::{self, Greeted};
use crate::participants::journal::Journal;
use crate::participants::launch::Launcher;
use crate::participants::recorded::Recorded;
use crate::participants::remote::Remote;
use crate::participants::{Communicator, Peers, Registry, Watch};
use crate::summary::Summary;
use exchange_log::timing::{TIMING, TimingLog};
use exchange_log::{Exchange, Provenance, Recorder, Volume};
use runs::plausible;
use runs::run_dir::{RunDir, free_bytes, manifest};
use runs::signals::SIGNALS;
use runs::warning::{ADVICE, Warning};
use runs::written::{add_tables, field_hashes};
use scenario::error::{Error, Refusal, Result};
use scenario::load::Loaded;
use scheme::clock::Clock;
use scheme::join::join;
use scheme::predict::inputs::foresee;
use scheme::predict::prediction::{Bound, LEAST_MARGIN};
use scheme::window::AcceptedWindow;

kit::findings! {
    /// Wall-clock times of requests could not be written; the run continues without them.
    ///
    /// - Why: the disk of the run directory is full or not writable.
    /// - Do: nothing for the results, but `thirdbody export --trace` has no times of this run. Make room for the next
    ///   run.
    TIMING_LOG = "timing_log";
    /// Another program sent messages on a connection between hosts; they were dropped, without effect on the run.
    ///
    /// - Why: others can reach the port, a participant of another run was started with its session, or a certificate or
    ///   password does not match. Messages without the signature of the run are dropped.
    /// - Do: check the address in the text, listen at an address that fewer can reach (`run.remote.listen`), and take
    ///   `quic`, which refuses connections without a certificate of the run.
    STRANGER = "stranger";
    /// The log will not fit on the disk if windows take all allowed repeats.
    ///
    /// - Why: a small disk, or a long run.
    /// - Do: make room, or write no log: `run.output.exchange = false`.
    LOG_SPACE = "log_space";
    /// Windows are long compared with the first period of the continuum.
    ///
    /// - Why: the value is a quarter of that period over the window. Waves cross the body within a window, but the
    ///   force on it is constant in the window: the run is stable but no longer accurate.
    /// - Do: lower `interface.<name>.substeps`, or run again with half of them and compare (the book,
    ///   `concepts/windows-and-substeps`).
    LONG_WINDOW = "long_window";
}

/// Options of a run, in addition to the scenario.
#[derive(Clone)]
pub struct RunOptions<'a> {
    /// The run directory; by default a new folder below `runs/`.
    pub out: Option<&'a Path>,
    /// Threads of each participant.
    pub threads: usize,
    /// Shipped solvers.
    pub registry: &'a Registry,
    /// The program whose `node` verb serves shipped solvers.
    pub program: PathBuf,
    /// Signals that end the run.
    pub watch: Watch,
    /// Receives the events of the run.
    pub listener: Listener,
    /// Any warning makes the run suspect.
    pub strict: bool,
    /// The run ends in an orderly way as soon as its cost is predicted.
    pub dry_run: bool,
    /// The budget by which its setting was chosen.
    pub budget: Option<RunBudget>,
}

impl<'a> RunOptions<'a> {
    /// One thread for each participant, no listener, and no signal that ends the run.
    pub fn quiet(out: Option<&'a Path>, registry: &'a Registry, program: &Path) -> RunOptions<'a> {
        RunOptions {
            out,
            threads: 1,
            registry,
            program: program.to_path_buf(),
            watch: Watch::default(),
            listener: Listener::default(),
            strict: false,
            dry_run: false,
            budget: None,
        }
    }
}

/// Text of the warning about windows that are long compared with the first period of the continuum.
const LONG_WINDOW_TEXT: &str = "a window is longer than a quarter of the continuum's first period: the run is stable, but it does not resolve forces within a window, and results depend on the length of the window; take fewer substeps, or compare with half of them";

/// A budget by which the setting of a run was chosen.
#[derive(Clone, Debug, Default)]
pub struct RunBudget {
    /// The chosen setting and its expected error or time: `budget` of summary.json.
    pub told: Value,
    /// Allowed wall-clock time (s).
    pub wall_s: Option<f64>,
}

/// The end of a run; the summary is in the run directory too.
pub struct Ended {
    /// The run directory.
    pub path: PathBuf,
    /// Content of summary.json.
    pub summary: Summary,
    /// Reason of an early end.
    pub error: Option<Error>,
}

/// Runs a scenario. An error before the start of participants is returned directly. From then on the run directory
/// keeps the valid part, and the error is part of [`Ended`].
pub fn run(loaded: &Loaded, options: &RunOptions) -> Result<Ended> {
    run_from(loaded, options, None)
}

/// Continues a scenario from a checkpoint of another run, in a new run directory. It ends as if that run had not been
/// cut off.
pub fn run_from(
    loaded: &Loaded,
    options: &RunOptions,
    restart: Option<&RestartPoint>,
) -> Result<Ended> {
    let launch = |launcher: &Launcher| {
        let participants = &launcher.loaded.scenario.participant;
        launcher.start(participants, options.watch.clone())
    };
    run_among(loaded, options, restart, &launch)
}

/// A way to start the participants of a run.
pub type LaunchAll<'a> = &'a dyn Fn(&Launcher) -> Result<Peers>;

/// The same with participants that are started in another way.
pub fn run_among(
    loaded: &Loaded,
    options: &RunOptions,
    restart: Option<&RestartPoint>,
    launch: LaunchAll,
) -> Result<Ended> {
    let start = Instant::now();
    let start_cpu_s = own_cpu_s();
    forget_peak();
    let warnings = check(loaded, options.registry, options.threads)?;
    let run_id = fresh_run_id();
    let rundir = RunDir::create(options.out, &loaded.scenario.run.name, run_id)?;
    let resumed = restart.map(|restart| {
        let window = restart.checkpoint.position.windows;
        json!({ "checkpoint": restart.path, "window": window })
    });
    let manifest = manifest(loaded, run_id, options.threads, resumed);
    // A folder with a scenario is a run, which needs the manifest to be resumed.
    rundir.write("manifest.json", &manifest)?;
    rundir.write("scenario.toml", &loaded.resolved)?;
    let pid = std::process::id();
    rundir.note(&format!("coordinator pid {pid}, run {run_id:016x}"));
    if let Some(restart) = restart {
        rundir.note(&format!("goes on from {}", restart.path.display()));
    }
    let mut session = RunSession {
        start,
        loaded,
        options,
        rundir: &rundir,
        run_id,
        manifest,
        restart,
        launch,
        summary: Summary::new(&loaded.scenario.run.name, &loaded.hash),
    };
    session.warn(warnings);
    let error = session.run().err();
    options.listener.report(&RunEvent::Ended);
    let mut summary = session.summary;
    // The entry of signals.csv is known already: it describes the written rows, not the rows read back.
    add_tables(rundir.path(), &mut summary.tables);
    if let Some(fields) = &mut summary.fields {
        fields.blake3 = field_hashes(rundir.path());
    }
    let wall_s = start.elapsed().as_secs_f64();
    summary.coordinator(start_cpu_s);
    if let Some(budget) = &options.budget {
        summary.budget = Some(budget.told.clone());
        let over = budget.wall_s.filter(|limit| wall_s > *limit);
        let over = over.map(|limit| Warning::over_budget(wall_s, limit));
        summary.warnings.extend(over);
    }
    summary.end(wall_s, error.as_ref(), options.strict);
    rundir.write_summary(&summary.to_json())?;
    rundir.note(&match &error {
        None => summary.status.to_string(),
        Some(error) => format!("ended early: {error}"),
    });
    Ok(Ended {
        path: rundir.path().to_path_buf(),
        summary,
        error,
    })
}

/// Identifies the run; no result depends on it.
pub fn fresh_run_id() -> u64 {
    RandomState::new().hash_one((std::process::id(), SystemTime::now()))
}

struct RunSession<'a> {
    start: Instant,
    loaded: &'a Loaded,
    options: &'a RunOptions<'a>,
    rundir: &'a RunDir,
    run_id: u64,
    manifest: String,
    restart: Option<&'a RestartPoint>,
    launch: LaunchAll<'a>,
    summary: Summary,
}

impl RunSession<'_> {
    /// Starts the participants, runs the exchange, and closes the log in any case.
    fn run(&mut self) -> Result<()> {
        let launcher = Launcher {
            loaded: self.loaded,
            registry: self.options.registry,
            program: self.options.program.clone(),
            run_id: self.run_id,
            threads: self.options.threads,
            rundir: self.rundir,
        };
        let peers = (self.launch)(&launcher)?;
        let journal = Journal::new(self.recorder()?);
        let mut recorded = Recorded::new(peers, journal, self.timing_log()?);
        let result = self.converse(&mut recorded);
        for (about, tried) in recorded.peers.strangers() {
            let text = format!("messages of another program were dropped: {tried}");
            self.warn([Warning::advice(&STRANGER, &about, text)]);
        }
        recorded.close_times();
        let untimed = recorded.untimed.take();
        self.warn(untimed.map(|why| Warning::advice(&TIMING_LOG, TIMING, why)));
        let closed = recorded.journal.close();
        if let Ok(closed) = &closed {
            let wall_s = self.start.elapsed().as_secs_f64();
            self.summary.close(closed, wall_s);
        }
        result.and(closed.map(|_| ()))
    }

    fn recorder(&self) -> Result<Option<Recorder>> {
        let output = &self.loaded.scenario.run.output;
        let provenance = Provenance {
            scenario_toml: self.loaded.resolved.clone(),
            manifest_json: self.manifest.clone(),
            run_id: self.run_id,
        };
        let path = self.rundir.path().join("exchange.mcap");
        let create = || Recorder::create(&path, &provenance, output.flush_every_windows);
        Ok(output.exchange.then(create).transpose()?)
    }

    fn timing_log(&self) -> Result<Option<TimingLog>> {
        let scenario = &self.loaded.scenario;
        let names: Vec<&str> = scenario.participant.iter().map(|p| &*p.name).collect();
        let path = self.rundir.path().join(TIMING);
        let create = || TimingLog::create(&path, &names);
        Ok(scenario.run.output.exchange.then(create).transpose()?)
    }

    /// The whole exchange: greeting, state of a resumed run, windows, farewell, judgement.
    fn converse(&mut self, recorded: &mut Recorded) -> Result<()> {
        let scenario = &self.loaded.scenario;
        let greeted = self.greet(recorded)?;
        let descriptions = greeted.iter().map(|greeted| &greeted.description);
        let end_s = end_s(scenario, &greeted)?;
        self.summary.end_s = Some(end_s);
        let (missed, no_hold) = plausible::unreached(scenario, descriptions, end_s);
        self.warn(missed);
        let mut outputs = self.outputs(recorded, &greeted)?;
        let result = if scenario.interface.is_empty() {
            self.alone(recorded, &greeted, &mut outputs)
        } else {
            self.coupled(recorded, &greeted, &mut outputs)
        };
        self.end_outputs(recorded, &mut outputs, result)?;
        self.part(recorded, &outputs)?;
        let results = &mut self.summary.results;
        results.retain(|name, _| !(no_hold && plausible::of_hold(name)));
        self.judge(&outputs)?;
        #[cfg(feature = "vtkhdf")]
        if !self.options.dry_run {
            outputs.fields.gather(&mut self.summary.fields)?;
        }
        Ok(())
    }

    /// Greets the participants and keeps their descriptions.
    fn greet(&mut self, recorded: &mut Recorded) -> Result<Vec<Greeted>> {
        let scenario = &self.loaded.scenario;
        let names: Vec<&str> = scenario.participant.iter().map(|p| &*p.name).collect();
        self.options.listener.report(&RunEvent::Prepare {
            run: &scenario.run.name,
            participants: &names,
        });
        recorded.peers.listener = self.options.listener.clone();
        let greeted = handshake::greet(recorded, self.loaded, self.run_id)?;
        let pairs = scenario.participant.iter().zip(&greeted);
        for (peer, (participant, greeted)) in pairs.enumerate() {
            let (name, description) = (&participant.name, &greeted.description);
            let twice = participant.command.is_some() && description.capabilities.rollback;
            recorded.peers.peer(peer).twice = twice;
            let (software, pid) = (&description.software, greeted.pid);
            let host = match &*greeted.host {
                "" => String::new(),
                host => format!(" on host `{host}`"),
            };
            let note = format!("participant `{name}` is {software} in process {pid}{host}");
            self.rundir.note(&note);
            self.advise(name, &description.warnings);
        }
        self.summary.greet(scenario, &greeted);
        Ok(greeted)
    }

    /// The output files of the run; for a resumed run with its earlier output.
    fn outputs<'a>(
        &mut self,
        recorded: &mut Recorded,
        greeted: &'a [Greeted],
    ) -> Result<Outputs<'a>>
    where
        Self: 'a,
    {
        let mut outputs = Outputs::new(self.rundir, self.loaded, greeted)?;
        outputs.progress = Progress::new(self.options.listener.clone());
        outputs.dry_run = self.options.dry_run;
        if outputs.keeper.writes() {
            recorded.peers.watch.let_windows_end();
        }
        if let Some(restart) = self.restart {
            restart.check(self.loaded, greeted)?;
            let handshake = self.carry_over(recorded, &mut outputs, restart)?;
            if !self.loaded.scenario.interface.is_empty() {
                recorded.repeat_handshake(handshake);
            }
        }
        Ok(outputs)
    }

    /// Closes the files after the last window, also after an error.
    fn end_outputs(
        &mut self,
        recorded: &Recorded,
        outputs: &mut Outputs,
        result: Result<()>,
    ) -> Result<()> {
        self.summary.energies(&outputs.energies());
        self.summary.far(recorded.peers.far());
        self.summary.interface_works();
        let fields = outputs.fields.summary();
        let fields = fields.map(|fields| self.summary.fields = fields);
        let signals = outputs.signals.finish()?;
        self.summary.tables.insert(SIGNALS.into(), signals);
        // The reason of an early end comes before the error of an unreadable file.
        result.and(fields)
    }

    /// Asks the participants to end, and keeps their findings.
    fn part(&mut self, recorded: &mut Recorded, outputs: &Outputs) -> Result<()> {
        let communicator: &mut dyn Communicator = recorded;
        let kinds = (Kind::Finish, Kind::Finished);
        let farewells: Vec<Farewell> = communicator.ask_all(kinds, &[], read_farewell)?;
        recorded.record_own_times(&farewells);
        let run_wall_s = self.start.elapsed().as_secs_f64();
        let awaited = recorded.peers.awaited();
        for (participant, farewell) in self.loaded.scenario.participant.iter().zip(&farewells) {
            let (name, outcome) = (&participant.name, &farewell.outcome);
            let findings = outcome.findings.iter().cloned();
            self.warn(findings.map(|finding| Warning::of(name, finding)));
            self.advise(name, &outcome.warnings);
        }
        let summary = &mut self.summary;
        summary.spent(&outputs.pace, &farewells, &awaited, run_wall_s);
        summary.farewell(farewells);
        Ok(())
    }

    /// Judges forces, energies and joints at the end.
    ///
    /// # Errors
    /// A participant contradicts itself.
    fn judge(&mut self, outputs: &Outputs) -> Result<()> {
        let bounds = &self.loaded.scenario.run.plausible;
        let mut judged = self.summary.judged(bounds, &outputs.state.sampled.down_n());
        // A warning from during the run says more than one about the end.
        let known = &self.summary.warnings;
        judged.retain(|new| {
            let same = |old: &Warning| old.code == new.code && old.about == new.about;
            !known.iter().any(same)
        });
        let proven = plausible::refuse_contradiction(&judged);
        self.warn(judged);
        proven
    }

    /// Copies the log and the outputs of the resumed run. Once its checkpoint is copied, this run directory can be
    /// resumed as well. Returns the messages of the logged handshake.
    fn carry_over(
        &mut self,
        recorded: &mut Recorded,
        outputs: &mut Outputs,
        restart: &RestartPoint,
    ) -> Result<Vec<Exchange>> {
        let state = &restart.checkpoint;
        let journal = &mut recorded.journal;
        let log = restart.run.join("exchange.mcap");
        let handshake = journal.carry_over(&log, state.log_blocks)?;
        outputs.carry_over(restart)?;
        journal.sync()?;
        restart.adopt(self.rundir)?;
        self.summary.sim_time_s = state.position.t_s;
        self.summary.windows = state.position.windows;
        Ok(handshake)
    }

    /// Runs the windows of coupled solvers to the end.
    fn coupled(
        &mut self,
        recorded: &mut Recorded,
        greeted: &[Greeted],
        outputs: &mut Outputs,
    ) -> Result<()> {
        let scenario = &self.loaded.scenario;
        let joined = join(&mut Remote::new(recorded, greeted), &scenario.interface)?;
        recorded.end_handshake()?;
        let mut groups = groups_at_start(scenario, greeted, joined)?;
        for group in &groups {
            self.rundir.note(&describe(group));
            let joined = group.coupling.group();
            for patch in &joined.patches {
                let peer = joined.force_driven[patch.force_driven].peer;
                let name = &scenario.participant[peer].name;
                let continuum = (name.as_str(), &greeted[peer].description);
                let bounds = &scenario.run.plausible;
                self.warn(plausible::joined(bounds, joined, patch, continuum));
            }
        }
        let volume = |repeats| log_volume::coupled(scenario, greeted, &groups, repeats);
        self.foresee_log([Repeats::Least, Repeats::Most].map(volume))?;
        match self.restart {
            // The log of the resumed run has the prediction and its requests.
            Some(restart) => restart.restore(&mut recorded.peers, greeted, &mut groups)?,
            None => self.predict(recorded, greeted, &mut groups, outputs)?,
        }
        let (t_s, end_s) = (reached_s(&groups), end_s(scenario, greeted)?);
        let all = groups.iter().map(GroupRun::windows).sum();
        self.summary.warned_before = Some(self.summary.warnings.len());
        outputs.begin(&recorded.peers, self.start, [t_s, end_s], all);
        let seen = |recorded: &mut Recorded, groups: &[GroupRun], window: &_, accepted| {
            let position = position(groups);
            self.summary.sim_time_s = position.t_s;
            outputs.add(recorded, groups, window, accepted, position.t_s)?;
            self.warn(outputs.warnings());
            self.warn(std::mem::take(&mut recorded.peers.found));
            outputs.pause(recorded, groups, position)
        };
        let result = each_window(recorded, greeted, &mut groups, seen);
        self.warn(std::mem::take(&mut recorded.peers.found));
        let couplings = groups.iter().map(|group| &group.coupling);
        self.summary.interfaces(couplings);
        result?;
        outputs.finish(recorded, &groups, &mut self.summary)
    }

    /// Notes the stability predicted from the handshake, and refuses a scheme that is predicted to fail.
    fn predict(
        &mut self,
        recorded: &mut Recorded,
        greeted: &[Greeted],
        groups: &mut [GroupRun],
        outputs: &mut Outputs,
    ) -> Result<()> {
        let remote = &mut Remote::new(recorded, greeted);
        let mut predicted = Vec::new();
        for coupling in groups.iter_mut().map(|group| &mut group.coupling) {
            let foreseen = foresee(coupling, remote)?;
            // They are known by now, and are not requested again.
            let columns = coupling.columns(remote)?.unwrap_or_default();
            for (side, columns) in columns.iter().enumerate() {
                let peer = coupling.group().force_driven[side].peer;
                let explicit = greeted[peer].description.step_limit_s.is_some();
                let own: Vec<f64> = columns.diagonal().iter().copied().collect();
                let finding = plausible::told_mass(coupling.group(), side, &own, explicit);
                let name = &self.loaded.scenario.participant[peer].name;
                outputs.keep_finding(name, finding);
            }
            for (index, prediction) in foreseen {
                let interface = &self.loaded.scenario.interface[index];
                let (name, group) = (&interface.name, coupling.group());
                for line in prediction.lines() {
                    self.rundir.note(&format!("interface `{name}`: {line}"));
                }
                let mut bounds = prediction.bounds.iter();
                let long = bounds.find(|bound| bound.is_long_window());
                let long = long.map(|bound| Finding {
                    code: LONG_WINDOW.code.into(),
                    text: LONG_WINDOW_TEXT.into(),
                    value: bound.margin,
                    bound: LEAST_MARGIN,
                    suspect: false,
                });
                let points = &group.points;
                // A bare surface has points without a disk.
                let bare = points.radius_m.iter().filter(|r| **r == 0.0).count();
                self.summary.foreseen.push(format!(
                    "interface {name}: windows of {:.4e} s, {} nodes with {} columns, {} glued points and {bare} of bare surfaces in its group, whose compliance takes {:.1e} bytes",
                    group.clock.window_s(),
                    group.nodes.len(),
                    2 * group.nodes.len(),
                    points.len() - bare,
                    (8 * 4 * points.len() * points.len()) as f64
                ));
                self.summary.foreseen.extend(prediction.lines());
                let stability = &mut self.summary.stability;
                stability.push((name.clone(), prediction.clone()));
                predicted.push((interface, prediction));
                outputs.keep_finding(name, long);
            }
        }
        // A resumed run has them from its checkpoint.
        self.warn(outputs.warnings());
        let mut predicted = predicted.iter();
        predicted.try_for_each(|(interface, prediction)| Ok(prediction.refuse(interface)?))
    }

    /// Runs the windows of a solver without an interface.
    fn alone(
        &mut self,
        recorded: &mut Recorded,
        greeted: &[Greeted],
        outputs: &mut Outputs,
    ) -> Result<()> {
        let scenario = &self.loaded.scenario;
        let description = &greeted[0].description;
        let name = &scenario.participant[0].name;
        let refuse = |problem: String| Refusal::participant(name, problem);
        if !description.capabilities.alone {
            return Err(refuse("cannot run without an interface".into()).into());
        }
        let missing =
            || format!("has no step of its own: give participant.{name}.config.time.step_s");
        let step_s = description.step_s.ok_or_else(|| refuse(missing()))?;
        let bounds = Bound::of_accuracy(&description.accuracy_limits, step_s);
        let foreseen = &mut self.summary.foreseen;
        foreseen.extend(bounds.map(|bound| format!("step of {step_s:.4e} s:{}", bound.line())));
        let at_once = description.steps_at_once.unwrap_or(u32::MAX).max(1);
        let clock = Clock {
            step_s,
            substeps: scenario.run.output.alone_steps.min(at_once),
        };
        let end = clock.steps_until(end_s(scenario, greeted)?)?;
        let volume = log_volume::alone(scenario, description, &clock, end);
        self.foresee_log([volume; 2])?;
        let mut start = 0;
        if let Some(restart) = self.restart {
            restart.restore(&mut recorded.peers, greeted, &mut [])?;
            start = restart.checkpoint.position.windows;
        }
        let [start_s, end_s] =
            [start * u64::from(clock.substeps), end].map(|s| s as f64 * clock.step_s);
        let windows = end.div_ceil(clock.substeps.into());
        self.summary.warned_before = Some(self.summary.warnings.len());
        outputs.begin(&recorded.peers, self.start, [start_s, end_s], windows);
        for index in start..windows {
            let step = index * u64::from(clock.substeps);
            let window = clock.window(index, step, clock.substeps_before(step, end));
            let communicator: &mut dyn Communicator = recorded;
            let kinds = (Kind::AdvanceAlone, Kind::Report);
            let report = communicator.ask(0, kinds, &window, &[])?.payload;
            communicator.end_window(index)?;
            let accepted = AcceptedWindow {
                reports: vec![(0, report)],
                ..AcceptedWindow::default()
            };
            outputs.add(communicator, &[], &window, accepted, window.t1_s)?;
            self.warn(outputs.warnings());
            self.summary.windows = index + 1;
            self.summary.sim_time_s = window.t1_s;
            let position = RunPosition {
                windows: index + 1,
                t_s: window.t1_s,
                groups: Vec::new(),
                over: step + u64::from(window.substeps) >= end,
            };
            if outputs.pause(recorded, &[], position)?.is_break() {
                break;
            }
        }
        outputs.finish(recorded, &[], &mut self.summary)
    }

    /// Notes the predicted length of the log, with the fewest and the most repeats, and refuses a log that does not fit
    /// on the disk.
    fn foresee_log(&mut self, volumes: [Volume; 2]) -> Result<()> {
        let output = &self.loaded.scenario.run.output;
        if !output.exchange {
            return Ok(());
        }
        let texts = self.loaded.resolved.len() + self.manifest.len();
        let [least, most] = volumes.map(|v| v.bytes(texts, output.flush_every_windows));
        let line = log_volume::line(&volumes[0], least, most);
        self.rundir.note(&line);
        self.summary.foreseen.push(line);
        self.summary.log_predicted_bytes = Some([least, most]);
        // A dry run writes little, and in another place than the run will.
        let free = free_bytes(self.rundir.path());
        let free = free.filter(|_| !self.options.dry_run);
        let log = self.rundir.path().join("exchange.mcap");
        log_volume::require_space(least, free, &log)?;
        if let Err(error) = log_volume::require_space(most, free, &log) {
            let text = error.to_string();
            self.warn([Warning::advice(&LOG_SPACE, "run.output.exchange", text)]);
        }
        Ok(())
    }

    /// Reports and keeps a participant's advice.
    fn advise(&mut self, participant: &str, texts: &[String]) {
        let advice = texts.iter();
        self.warn(advice.map(|text| Warning::advice(&ADVICE, participant, text)));
    }

    /// Reports and keeps warnings, each once: a participant may repeat a warning of `check`.
    fn warn(&mut self, warnings: impl IntoIterator<Item = Warning>) {
        for warning in warnings {
            if self.summary.warnings.contains(&warning) {
                continue;
            }
            self.rundir.note(&warning.line());
            self.options.listener.report(&RunEvent::Warning(&warning));
            self.summary.warnings.push(warning);
        }
    }
}
