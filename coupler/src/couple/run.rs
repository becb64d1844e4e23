//! The loop over all windows, from the launch to the farewells.

use std::path::{Path, PathBuf};
use std::time::Instant;

use protocol::serve::Farewell;
use protocol::{Kind, Phase, Window};

use super::clock::Clock;
use super::conversation::Conversation;
use super::group::Group;
use super::handshake::{self, Greeted};
use super::join::join;
use super::ledger::EnergyLedger;
use super::scheme::{Attempt, Coupling, InterfaceSignals, Standing};
use crate::checkpoint::{Checkpoint, Keeper, Origin, Place, Position};
use crate::error::Error;
use crate::launch::{Launcher, Registry, Watch, config_value, process, setting};
use crate::log::{Provenance, Recorder};
use crate::output::collection::{self, Moment};
use crate::output::{HoldMeans, OutputState, Progress, SignalsFile, profile};
use crate::rundir::{RunDir, manifest};
use crate::scenario::{Loaded, Scenario};
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
    let manifest = manifest(loaded, run_id, options.threads, origin);
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
        self.summary.exchange_hash = closed.as_ref().ok().cloned();
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
        let mut outputs = Outputs::new(self, &greeted)?;
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
        let end = clock.steps_until(end_s(&self.loaded.scenario, greeted)?);
        let mut start = 0;
        if let Some(origin) = self.origin {
            origin.restore(conversation, &mut [])?;
            start = origin.checkpoint.position.windows;
        }
        outputs.expect(start * u64::from(clock.substeps), end);
        for index in start..end.div_ceil(clock.substeps.into()) {
            let step = index * u64::from(clock.substeps);
            let window = clock.window(index, step, clock.substeps_before(step, end));
            let report = conversation.ask(0, Kind::March, Kind::Report, &window, Vec::new())?;
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

/// A group of interfaces on its way through time.
pub struct Course {
    /// Its coupling.
    pub coupling: Coupling,
    /// Steps of its clock to do.
    pub end: u64,
    /// Steps done.
    pub step: u64,
    /// Windows done.
    pub index: u64,
    /// What is left of a halved window, to be done before the next full one.
    rest: Option<u32>,
}

impl Position {
    /// Where groups stand that have come so far.
    fn of(courses: &[Course]) -> Position {
        Position {
            windows: courses.iter().map(|course| course.index).sum(),
            t_s: reached_s(courses),
            courses: courses.iter().map(Course::place).collect(),
            over: courses.iter().all(|course| course.next().is_none()),
        }
    }
}

impl Course {
    /// Where it goes on.
    fn place(&self) -> Place {
        Place {
            window: self.index,
            step: self.step,
            rest: self.rest,
        }
    }

    /// Puts it where a checkpoint left off.
    pub fn go_to(&mut self, place: &Place) {
        self.index = place.window;
        self.step = place.step;
        self.rest = place.rest;
    }

    /// Time that stands (s).
    pub fn reached_s(&self) -> f64 {
        self.step as f64 * self.coupling.group().clock.step_s
    }

    /// The next window, unless all are done.
    fn next(&self) -> Option<Window> {
        let clock = self.coupling.group().clock;
        window_from(&clock, (self.index, self.step), self.end, self.rest)
    }

    /// Does its next window, or as much of it as the scheme lets stand.
    fn advance(
        &mut self,
        conversation: &mut Conversation,
        mut window: Window,
    ) -> Result<(Window, Standing), Error> {
        self.rest = None;
        let clock = self.coupling.group().clock;
        let standing = loop {
            let (end, rest) = (self.end, self.rest);
            let following = |done: &Window| {
                let step = done.step + u64::from(done.substeps);
                window_from(&clock, (done.index + 1, step), end, rest)
            };
            match self.coupling.window(conversation, window, following)? {
                Attempt::Standing(standing) => break standing,
                Attempt::Halve => {
                    self.rest = Some(self.rest.unwrap_or(0) + window.substeps / 2);
                    window = clock.window(self.index, self.step, window.substeps.div_ceil(2));
                }
            }
        };
        self.index += 1;
        self.step += u64::from(window.substeps);
        Ok((window, standing))
    }
}

/// The window that begins here: what is left of a halved one, else a full one or what the end leaves of it.
fn window_from(
    clock: &Clock,
    (index, step): (u64, u64),
    end: u64,
    rest: Option<u32>,
) -> Option<Window> {
    let substeps = || clock.substeps_before(step, end);
    (step < end).then(|| clock.window(index, step, rest.unwrap_or_else(substeps)))
}

/// Time up to which all groups stand (s).
fn reached_s(courses: &[Course]) -> f64 {
    courses
        .iter()
        .map(Course::reached_s)
        .fold(f64::INFINITY, f64::min)
}

/// All groups at their start.
fn courses(
    scenario: &Scenario,
    greeted: &[Greeted],
    groups: Vec<Group>,
) -> Result<Vec<Course>, Error> {
    let end_s = end_s(scenario, greeted)?;
    let rules = scenario.groups();
    Ok(groups
        .into_iter()
        .zip(rules)
        .map(|(group, members)| Course {
            end: group.clock.steps_until(end_s),
            coupling: Coupling::new(&scenario.interface[members[0]], group),
            step: 0,
            index: 0,
            rest: None,
        })
        .collect())
}

fn describe(course: &Course) -> String {
    let group = course.coupling.group();
    let clock = group.clock;
    format!(
        "{} windows of {:.4e} s ({} steps of {:.4e} s), {} nodes, {} glued points",
        course.end.div_ceil(clock.substeps.into()),
        clock.window_s(),
        clock.substeps,
        clock.step_s,
        group.nodes.len(),
        group.points.len()
    )
}

/// All windows of all groups until their end, in the order in which the windows end; windows are halved where the
/// scheme asks for it. `seen` is told of each window that stands, and once, without one, when a window failed.
fn each_window<F>(
    conversation: &mut Conversation,
    courses: &mut [Course],
    mut seen: F,
) -> Result<(), Error>
where
    F: FnMut(&mut Conversation, &[Course], Option<(&Window, &Standing)>) -> Result<(), Error>,
{
    while let Some((index, window)) = earliest(courses) {
        match courses[index].advance(conversation, window) {
            Ok((window, standing)) => seen(conversation, courses, Some((&window, &standing)))?,
            Err(error) => {
                seen(conversation, courses, None)?;
                return Err(error);
            }
        }
    }
    Ok(())
}

/// The group whose next window ends first, of equal ones the first.
fn earliest(courses: &[Course]) -> Option<(usize, Window)> {
    let next = courses.iter().enumerate();
    next.filter_map(|(index, course)| course.next().map(|window| (index, window)))
        .min_by(|(_, a), (_, b)| a.t1_s.total_cmp(&b.t1_s))
}

/// The whole coupled conversation without outputs: what a replay of the coupler runs against tapes.
pub fn windows(
    conversation: &mut Conversation,
    scenario: &Scenario,
    greeted: &[Greeted],
    from: Option<&Origin>,
) -> Result<(), Error> {
    if scenario.interface.is_empty() {
        return Err(Error::Refused(
            "a solver that ran alone has no coupler to replay".into(),
        ));
    }
    let groups = join(conversation, scenario, greeted)?;
    let mut courses = courses(scenario, greeted, groups)?;
    match from {
        Some(origin) => origin.place(&mut courses)?,
        None => {
            for course in &mut courses {
                course.coupling.foresee(conversation, greeted)?;
            }
        }
    }
    each_window(conversation, &mut courses, |_, _, _| Ok(()))
}

/// `run.end_s`, or the end of the longest load history.
fn end_s(scenario: &Scenario, greeted: &[Greeted]) -> Result<f64, Error> {
    let longest = greeted
        .iter()
        .filter_map(|greeted| greeted.description.end_s)
        .fold(None, |longest: Option<f64>, end| {
            Some(longest.map_or(end, |l| l.max(end)))
        });
    scenario.run.end_s.or(longest).ok_or_else(|| {
        Error::Refused("no participant has a load history that ends: give run.end_s".into())
    })
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

/// Everything that is written while windows pass.
struct Outputs<'a> {
    rundir: &'a RunDir,
    thickness_m: f64,
    signals_every: u64,
    phases: Vec<Phase>,
    signal_counts: Vec<usize>,
    /// The latest report of each participant; empty before its first.
    reports: Vec<Vec<f64>>,
    /// The latest signals of each interface.
    interfaces: Vec<InterfaceSignals>,
    energies: Vec<EnergyLedger>,
    signals: SignalsFile,
    hold: HoldMeans,
    progress: Progress,
    snapshots_taken: usize,
}

impl<'a> Outputs<'a> {
    fn new(session: &RunSession<'a>, greeted: &[Greeted]) -> Result<Outputs<'a>, Error> {
        let scenario = &session.loaded.scenario;
        let phases = greeted
            .iter()
            .map(|greeted| greeted.description.phases.clone())
            .find(|phases| !phases.is_empty())
            .unwrap_or_default();
        let energies = greeted
            .iter()
            .map(|greeted| EnergyLedger {
                terms: greeted.description.ledger.clone(),
                values: vec![0.0; greeted.description.ledger.len()],
            })
            .collect();
        let names = scenario
            .participant
            .iter()
            .map(|participant| participant.name.as_str());
        let descriptions: Vec<_> = greeted.iter().map(|greeted| &greeted.description).collect();
        Ok(Outputs {
            rundir: session.rundir,
            thickness_m: scenario.run.thickness_m,
            signals_every: scenario.run.output.signals_every_windows,
            hold: HoldMeans::new(&phases, &scenario.interface),
            phases,
            reports: vec![Vec::new(); greeted.len()],
            interfaces: vec![InterfaceSignals::default(); scenario.interface.len()],
            signal_counts: descriptions
                .iter()
                .map(|description| description.signals.len())
                .collect(),
            energies,
            signals: SignalsFile::create(
                session.rundir,
                names,
                &descriptions,
                &scenario.interface,
            )?,
            progress: Progress::new(&scenario.run.name, session.options.progress),
            snapshots_taken: 0,
        })
    }

    fn expect(&mut self, done: u64, steps: u64) {
        self.progress.expect(done, steps);
    }

    /// Takes over what the run wrote that is gone on with.
    fn carry_over(&mut self, origin: &Origin) -> Result<(), Error> {
        let state = &origin.checkpoint.outputs;
        for (energies, values) in self.energies.iter_mut().zip(&state.energies) {
            energies.values.clone_from(values);
        }
        self.reports.clone_from(&state.reports);
        self.interfaces.clone_from(&state.interfaces);
        self.hold = state.hold.clone();
        self.snapshots_taken = state.snapshots_taken;
        let signals = origin.run.join("signals.csv");
        self.signals.carry_over(&signals, state.signals_bytes)?;
        self.signals.sync()?;
        origin.copy_fields(self.rundir, &self.phases)
    }

    /// Between two windows: writes a checkpoint if one is due, and ends the run if it was interrupted.
    fn pause(
        &mut self,
        conversation: &mut Conversation,
        keeper: &Keeper,
        courses: &[Course],
        position: Position,
    ) -> Result<(), Error> {
        let interrupted = conversation.watch.interrupted();
        if keeper.due(&position, interrupted.is_some()) {
            let outputs = self.state()?;
            keeper.write(conversation, |nodes, log_blocks| Checkpoint {
                position,
                log_blocks,
                nodes,
                couplings: courses.iter().map(|c| c.coupling.state()).collect(),
                outputs,
            })?;
        }
        interrupted.map_or(Ok(()), Err)
    }

    fn state(&mut self) -> Result<OutputState, Error> {
        Ok(OutputState {
            energies: self.energies.iter().map(|e| e.values.clone()).collect(),
            reports: self.reports.clone(),
            interfaces: self.interfaces.clone(),
            hold: self.hold.clone(),
            snapshots_taken: self.snapshots_taken,
            signals_bytes: self.signals.sync()?,
        })
    }

    fn add_alone(
        &mut self,
        conversation: &mut Conversation,
        window: &Window,
        report: Vec<f64>,
    ) -> Result<(), Error> {
        self.keep(conversation, 0, report)?;
        if window.index.is_multiple_of(self.signals_every) {
            self.signals.row(window.t1_s, &self.reports, &[])?;
        }
        let (rundir, mut held) = (self.rundir, false);
        self.phase_ends(conversation, window.t1_s, |name| held |= name == "hold")?;
        if held {
            profile::adopt(rundir)?;
        }
        self.progress.show(window);
        Ok(())
    }

    fn add_coupled(
        &mut self,
        conversation: &mut Conversation,
        courses: &[Course],
        window: &Window,
        standing: &Standing,
    ) -> Result<(), Error> {
        for (peer, report) in &standing.reports {
            self.keep(conversation, *peer, report.clone())?;
        }
        for (interface, signals) in &standing.signals {
            self.interfaces[*interface] = *signals;
        }
        self.hold.add(window, standing);
        let due = window.index.is_multiple_of(self.signals_every);
        if due && last_at(courses, window.t1_s) && self.reports.iter().all(|r| !r.is_empty()) {
            self.signals
                .row(window.t1_s, &self.reports, &self.interfaces)?;
        }
        let (mut held, thickness_m) = (false, self.thickness_m);
        self.phase_ends(conversation, reached_s(courses), |name| {
            held |= name == "hold"
        })?;
        if held {
            for (name, text) in profiles(courses, thickness_m) {
                self.rundir.write(&name, &text)?;
            }
            let couplings = courses.iter().map(|course| &course.coupling);
            self.hold.keep_profiles(couplings, thickness_m);
        }
        self.progress.show(window);
        Ok(())
    }

    /// Keeps what a participant reported, if it is as long as was announced.
    fn keep(
        &mut self,
        conversation: &Conversation,
        peer: usize,
        report: Vec<f64>,
    ) -> Result<(), Error> {
        let due = self.signal_counts[peer] + self.energies[peer].terms.len();
        if report.len() != due {
            return Err(conversation.peers[peer].protocol(format!(
                "reported {} numbers where its description announced {due}",
                report.len()
            )));
        }
        self.energies[peer]
            .values
            .copy_from_slice(&report[self.signal_counts[peer]..]);
        self.reports[peer] = report;
        Ok(())
    }

    /// At the end of each phase the participants write their fields; `passed` is told its name.
    fn phase_ends(
        &mut self,
        conversation: &mut Conversation,
        time_s: f64,
        mut passed: impl FnMut(&str),
    ) -> Result<(), Error> {
        let over = |phase: &Phase| time_s >= phase.t1_s * (1.0 - 1e-9);
        while self.phases.get(self.snapshots_taken).is_some_and(over) {
            let name = self.phases[self.snapshots_taken].name.clone();
            self.snapshots_taken += 1;
            snapshot(conversation, &name)?;
            self.collect(conversation, None)?;
            passed(&name);
        }
        Ok(())
    }

    /// Writes `fields/<participant>.pvd` of the snapshots so far, that of the end included if it is taken.
    fn collect(&self, conversation: &Conversation, end_s: Option<f64>) -> Result<(), Error> {
        let moment = |name: &str, time_s| Moment {
            name: name.into(),
            time_s,
        };
        let passed = self.phases[..self.snapshots_taken].iter();
        let mut moments: Vec<Moment> = passed.map(|p| moment(&p.name, p.t1_s)).collect();
        moments.extend(end_s.map(|time_s| moment("end", time_s)));
        for peer in &conversation.peers {
            if let Some(text) = collection::pvd(&self.rundir.fields(), peer.name(), &moments) {
                self.rundir
                    .write(&format!("fields/{}.pvd", peer.name()), &text)?;
            }
        }
        Ok(())
    }

    fn finish(
        &mut self,
        conversation: &mut Conversation,
        summary: &mut Summary,
    ) -> Result<(), Error> {
        snapshot(conversation, "end")?;
        self.collect(conversation, Some(summary.sim_time_s))?;
        self.progress.done();
        for (name, value) in self.hold.results() {
            summary.results.insert(name, value);
        }
        Ok(())
    }
}

/// Whether no group has a window to do that ends at this time.
fn last_at(courses: &[Course], time_s: f64) -> bool {
    let later = |window: Window| window.t1_s > time_s * (1.0 + 1e-9);
    courses.iter().all(|course| course.next().is_none_or(later))
}

/// The traction of each interface: name and text of its file.
fn profiles(courses: &[Course], thickness_m: f64) -> Vec<(String, String)> {
    let patches = courses.iter().flat_map(|course| {
        let coupling = &course.coupling;
        let patches = coupling.group().patches.iter();
        patches.map(move |patch| (patch, profile::csv(coupling, patch, thickness_m)))
    });
    let mut files: Vec<(String, String)> = patches
        .map(|(patch, text)| (format!("profile-{}.csv", patch.name), text))
        .collect();
    if let [(name, _)] = files.as_mut_slice() {
        *name = "profile.csv".into();
    }
    files
}

fn snapshot(conversation: &mut Conversation, name: &str) -> Result<(), Error> {
    for peer in 0..conversation.peers.len() {
        conversation.tell_text(peer, Kind::Snapshot, name)?;
    }
    for peer in 0..conversation.peers.len() {
        conversation.hear(peer, Kind::Saved)?;
    }
    Ok(())
}
