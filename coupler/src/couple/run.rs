//! The loop over all windows, from the launch to the farewells.

use std::path::{Path, PathBuf};
use std::time::Instant;

use protocol::serve::Farewell;
use protocol::{Kind, Phase, Window};

use super::clock::Clock;
use super::conversation::Conversation;
use super::handshake::{self, Greeted};
use super::ledger::EnergyLedger;
use super::scheme::{Attempt, Coupling, Standing};
use crate::error::Error;
use crate::launch::{Launcher, Registry, Watch, config_value, process, setting};
use crate::log::{Provenance, Recorder};
use crate::output::{HoldMeans, Progress, SignalsFile, profile};
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
    let start = Instant::now();
    let warnings = check(loaded, options.registry, options.threads)?;
    let run_id = fresh_run_id();
    let rundir = RunDir::create(options.out, &loaded.scenario.run.name, run_id)?;
    let manifest = manifest(loaded, run_id, options.threads);
    rundir.write("scenario.toml", &loaded.resolved)?;
    rundir.write("manifest.json", &manifest)?;
    rundir.note(&format!(
        "coordinator pid {}, run {run_id:016x}",
        std::process::id()
    ));
    for warning in &warnings {
        rundir.note(&format!("warning: {warning}"));
    }
    let mut session = RunSession {
        loaded,
        options,
        rundir: &rundir,
        run_id,
        manifest,
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
        let name = scenario
            .interface
            .first()
            .map_or("alone", |interface| interface.name.as_str());
        let mut conversation = Conversation::new(
            peers,
            self.run_id,
            name,
            &scenario.run.deadlines,
            self.options.watch.clone(),
            self.recorder()?,
        );
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
        let result = match scenario.interface.first() {
            Some(_) => self.coupled(conversation, &greeted, &mut outputs),
            None => self.alone(conversation, &greeted, &mut outputs),
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

    fn coupled(
        &mut self,
        conversation: &mut Conversation,
        greeted: &[Greeted],
        outputs: &mut Outputs,
    ) -> Result<(), Error> {
        let interface = &self.loaded.scenario.interface[0];
        let joined = handshake::join(conversation, interface, greeted)?;
        conversation.end_window(0)?;
        let clock = joined.clock;
        let end = clock.steps_until(end_s(&self.loaded.scenario, greeted)?);
        self.rundir.note(&format!(
            "{} windows of {:.4e} s ({} steps of {:.4e} s), {} nodes, {} glued points",
            end.div_ceil(clock.substeps.into()),
            clock.window_s(),
            clock.substeps,
            clock.step_s,
            joined.nodes.len(),
            joined.points.len()
        ));
        let (continuum, wall) = (joined.continuum, joined.wall);
        let mut coupling = Coupling::new(interface, joined);
        outputs.expect(end);
        let summary = &mut self.summary;
        each_window(
            conversation,
            &mut coupling,
            end,
            |conversation, coupling, window, standing| {
                summary.interface(&coupling.ledger, coupling.joined());
                let Some(standing) = standing else {
                    return Ok(());
                };
                let mut reports = vec![Vec::new(), Vec::new()];
                reports[continuum] = standing.continuum_report.clone();
                reports[wall] = standing.wall_report.clone();
                summary.sim_time_s = window.t1_s;
                outputs.add(conversation, window, &reports, Some((coupling, standing)))
            },
        )?;
        outputs.finish(conversation, summary)
    }

    fn alone(
        &mut self,
        conversation: &mut Conversation,
        greeted: &[Greeted],
        outputs: &mut Outputs,
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
        outputs.expect(end);
        for index in 0..end.div_ceil(clock.substeps.into()) {
            let step = index * u64::from(clock.substeps);
            let window = clock.window(index, step, clock.substeps_before(step, end));
            let report = conversation.ask(0, Kind::March, Kind::Report, &window, Vec::new())?;
            conversation.end_window(index)?;
            outputs.add(conversation, &window, &[report], None)?;
            self.summary.windows = index + 1;
            self.summary.sim_time_s = window.t1_s;
        }
        outputs.finish(conversation, &mut self.summary)
    }
}

/// All windows until step `end`, halved where the scheme asks for it. `seen` is told of each window that stands, and
/// once, without one, when a window failed.
fn each_window<F>(
    conversation: &mut Conversation,
    coupling: &mut Coupling,
    end: u64,
    mut seen: F,
) -> Result<(), Error>
where
    F: FnMut(&mut Conversation, &Coupling, &Window, Option<&Standing>) -> Result<(), Error>,
{
    let clock = coupling.joined().clock;
    // What is left of a halved window, to be done before the next full one.
    let mut rest: Option<u32> = None;
    let (mut index, mut step) = (0, 0);
    while step < end {
        let substeps = rest
            .take()
            .unwrap_or_else(|| clock.substeps_before(step, end));
        let mut window = clock.window(index, step, substeps);
        let standing = loop {
            match coupling.window(conversation, window) {
                Ok(Attempt::Standing(standing)) => break standing,
                Ok(Attempt::Halve) => {
                    rest = Some(rest.unwrap_or(0) + window.substeps / 2);
                    window = clock.window(index, step, window.substeps.div_ceil(2));
                }
                Err(error) => {
                    seen(conversation, coupling, &window, None)?;
                    return Err(error);
                }
            }
        };
        seen(conversation, coupling, &window, Some(&standing))?;
        index += 1;
        step += u64::from(window.substeps);
    }
    Ok(())
}

/// The whole coupled conversation without outputs: what a replay of the coupler runs against tapes.
pub fn windows(
    conversation: &mut Conversation,
    scenario: &Scenario,
    greeted: &[Greeted],
) -> Result<(), Error> {
    let Some(interface) = scenario.interface.first() else {
        return Err(Error::Refused(
            "a solver that ran alone has no coupler to replay".into(),
        ));
    };
    let joined = handshake::join(conversation, interface, greeted)?;
    let end = joined.clock.steps_until(end_s(scenario, greeted)?);
    let mut coupling = Coupling::new(interface, joined);
    each_window(conversation, &mut coupling, end, |_, _, _, _| Ok(()))
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
    energies: Vec<EnergyLedger>,
    signals: SignalsFile,
    hold: HoldMeans,
    progress: Progress,
    snapshots_taken: usize,
}

impl<'a> Outputs<'a> {
    fn new(session: &RunSession<'a>, greeted: &[Greeted]) -> Result<Outputs<'a>, Error> {
        let scenario = &session.loaded.scenario;
        let coupled = !scenario.interface.is_empty();
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
            hold: HoldMeans::new(&phases),
            phases,
            signal_counts: descriptions
                .iter()
                .map(|description| description.signals.len())
                .collect(),
            energies,
            signals: SignalsFile::create(session.rundir, names, &descriptions, coupled)?,
            progress: Progress::new(&scenario.run.name, session.options.progress),
            snapshots_taken: 0,
        })
    }

    fn expect(&mut self, steps: u64) {
        self.progress.expect(steps);
    }

    fn add(
        &mut self,
        conversation: &mut Conversation,
        window: &Window,
        reports: &[Vec<f64>],
        coupled: Option<(&Coupling, &Standing)>,
    ) -> Result<(), Error> {
        for (peer, report) in reports.iter().enumerate() {
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
        }
        if let Some((coupling, _)) = coupled {
            self.hold.add(window, coupling);
        }
        if window.index.is_multiple_of(self.signals_every) {
            self.signals.row(window, reports, coupled)?;
        }
        self.phase_ends(conversation, window, coupled.map(|(coupling, _)| coupling))?;
        self.progress.show(window);
        Ok(())
    }

    /// At the end of each phase the participants write their fields; at the end of the hold the interface
    /// traction is kept as well.
    fn phase_ends(
        &mut self,
        conversation: &mut Conversation,
        window: &Window,
        coupling: Option<&Coupling>,
    ) -> Result<(), Error> {
        let passed = |phase: &Phase| window.t1_s >= phase.t1_s * (1.0 - 1e-9);
        while self.phases.get(self.snapshots_taken).is_some_and(passed) {
            let name = self.phases[self.snapshots_taken].name.clone();
            self.snapshots_taken += 1;
            snapshot(conversation, &name)?;
            if coupling.is_none() && name == "hold" {
                profile::adopt(self.rundir)?;
            }
            if let (Some(coupling), "hold") = (coupling, name.as_str()) {
                self.rundir
                    .write("profile.csv", &profile::csv(coupling, self.thickness_m))?;
                self.hold.keep_profile(coupling, self.thickness_m);
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
        self.progress.done();
        for (name, value) in self.hold.results() {
            summary.results.insert(name, value);
        }
        Ok(())
    }
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
