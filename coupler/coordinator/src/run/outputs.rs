//! The outputs of accepted windows: signals, fields, tractions, checkpoints, progress.

use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use kit::FindingKind;
use protocol::{Description, Finding, Phase, Window};

use super::checkpoint::restart::files_of;
use super::checkpoint::{Checkpoint, Keeper, RestartPoint};
use super::fields::{AT_THE_END, Fields};
use super::position::RunPosition;
use super::time_loop::{GroupRun, end_s};
use crate::cost::prediction::Pace;
use crate::events::{Listener, RunProgress};
use crate::output::progress::ProgressSpan;
use crate::output::sample::load_history;
use crate::output::state::head;
use crate::output::{OutputState, Progress, RunningBalance, SampledMeans};
use crate::participants::handshake::Greeted;
use crate::participants::recorded::Recorded;
use crate::participants::{Communicator, Peers};
use crate::summary::Summary;
use runs::plausible::{self, DISSIPATION, ENERGY_BALANCE, INTERFACE_ENERGY};
use runs::profile::{self, InterfaceTraction};
use runs::run_dir::RunDir;
use runs::signals::{SIGNALS, SignalsFile};
use runs::warning::Warning;
use scenario::error::{Error, Result};
use scenario::keys::{Participant, Scenario};
use scenario::load::Loaded;
use scheme::ledger::{EnergySums, InterfaceLedger, ParticipantLedger};
use scheme::window::{AcceptedWindow, InterfaceSignals};

/// The outputs during the windows of a run.
pub struct Outputs<'a> {
    rundir: &'a RunDir,
    scenario: &'a Scenario,
    descriptions: Vec<&'a Description>,
    names: Vec<&'a str>,
    /// True for a foreign program. Built-in solvers report the losses of their schemes, which may have either sign.
    foreign: Vec<bool>,
    /// Number of the state's findings that are passed on.
    passed_on: usize,
    /// The state for checkpoints. Before a participant's first report, its report is empty and its energies are zero.
    pub state: OutputState,
    /// The file signals.csv.
    pub signals: SignalsFile,
    /// The fields.
    pub fields: Fields<'a>,
    /// The checkpoints.
    pub keeper: Keeper,
    /// Progress for a listener.
    pub progress: Progress,
    /// The load history, for the progress.
    phases: Vec<Phase>,
    /// The cost so far.
    pub pace: Pace,
    /// True for a dry run, which ends once its cost is predicted.
    pub dry_run: bool,
}

/// The phase at a time, and the fraction of it that has passed.
fn phase_at(phases: &[Phase], t_s: f64) -> Option<(String, f64)> {
    let inside = |phase: &&Phase| t_s <= phase.t1_s * (1.0 + 1e-9);
    // The last window may end beyond the last phase.
    let phase = phases.iter().find(inside).or(phases.last())?;
    let part = (t_s - phase.t0_s) / (phase.t1_s - phase.t0_s);
    Some((phase.name.clone(), part.clamp(0.0, 1.0)))
}

impl<'a> Outputs<'a> {
    /// Outputs before the first window, for greeted participants.
    pub fn new(
        rundir: &'a RunDir,
        loaded: &'a Loaded,
        greeted: &'a [Greeted],
    ) -> Result<Outputs<'a>> {
        let scenario = &loaded.scenario;
        let descriptions: Vec<_> = greeted.iter().map(|greeted| &greeted.description).collect();
        let phases = load_history(descriptions.iter().copied());
        let names = scenario.participant.iter().map(|p| p.name.as_str());
        let names: Vec<_> = names.collect();
        let own = scenario.participant.iter();
        let is_foreign =
            |p: &Participant| p.command.is_some() || !["fem", "dem"].contains(&&*p.kind);
        let balances = names.len() + scenario.interface.len() + 1;
        let zeros = |description: &&Description| vec![0.0; description.ledger.len()];
        Ok(Outputs {
            rundir,
            scenario,
            state: OutputState {
                energies: descriptions.iter().map(zeros).collect(),
                reports: vec![Vec::new(); greeted.len()],
                interfaces: vec![InterfaceSignals::default(); scenario.interface.len()],
                sampled: SampledMeans::new(&phases, &scenario.interface),
                balances: vec![RunningBalance::default(); balances],
                losses: vec![RunningBalance::default(); greeted.len()],
                ..OutputState::default()
            },
            fields: Fields::new(rundir, scenario, &descriptions, end_s(scenario, greeted)?)?,
            signals: SignalsFile::create(rundir, &names, &descriptions, &scenario.interface)?,
            names,
            foreign: own.map(is_foreign).collect(),
            passed_on: 0,
            keeper: Keeper::new(rundir, loaded, greeted)?,
            progress: Progress::new(Listener::default()),
            phases,
            descriptions,
            pace: Pace::new(greeted.iter().filter_map(Greeted::local_pid).collect()),
            dry_run: false,
        })
    }

    /// Copies the outputs of the resumed run.
    pub fn carry_over(&mut self, restart: &RestartPoint) -> Result<()> {
        self.state = restart.checkpoint.outputs.clone();
        let signals = restart.run.join(SIGNALS);
        let rows = head(&signals, self.state.signals.bytes);
        let rows = rows.map_err(Error::input(signals.display()))?;
        self.signals.carry_over(&rows)?;
        self.signals.sync()?;
        restart.copy_files(self.rundir)?;
        self.fields.carry_over(&self.state.snapshots_s)
    }

    /// The latest energies of all participants.
    pub fn energies(&self) -> Vec<ParticipantLedger> {
        let all = self.descriptions.iter().zip(self.state.energies.clone());
        let ledger = |(of, values): (&&Description, Vec<f64>)| ParticipantLedger {
            terms: of.ledger.clone(),
            values,
        };
        all.map(ledger).collect()
    }

    /// True if all participants report their energies.
    fn all_report_energies(&self) -> bool {
        let mut all = self.descriptions.iter();
        all.all(|description| !description.ledger.is_empty())
    }

    /// Sums of the latest energies of each participant.
    fn sums(&self) -> Vec<EnergySums> {
        let all = self.descriptions.iter().zip(&self.state.energies);
        all.map(|(description, values)| EnergySums::of(&description.ledger, values))
            .collect()
    }

    /// Between two windows: writes a checkpoint if it is due, and ends the run if it was interrupted or is a dry run
    /// with a prediction.
    pub fn pause(
        &mut self,
        recorded: &mut Recorded,
        groups: &[GroupRun],
        position: RunPosition,
    ) -> Result<ControlFlow<()>> {
        let t_s = position.t_s;
        let interrupted = recorded.peers.watch.interrupted();
        if self.keeper.due(&position, interrupted.is_some()) {
            self.state.signals = self.signals.sync()?;
            self.keeper
                .write(recorded, |nodes, log_blocks| Checkpoint {
                    position,
                    log_blocks,
                    nodes,
                    couplings: groups.iter().map(|group| group.coupling.state()).collect(),
                    outputs: self.state.clone(),
                })?;
        }
        self.pace.see(t_s);
        match interrupted {
            Some(error) => Err(error),
            None if self.dry_run && self.pace.prediction.is_some() => Ok(ControlFlow::Break(())),
            None => Ok(ControlFlow::Continue(())),
        }
    }

    /// Adds an accepted window, after which all groups have reached `reached_s`; a solver that runs alone has no group.
    pub fn add(
        &mut self,
        communicator: &mut dyn Communicator,
        groups: &[GroupRun],
        window: &Window,
        accepted: AcceptedWindow,
        reached_s: f64,
    ) -> Result<()> {
        for (peer, report) in accepted.reports {
            self.keep(communicator, window, peer, report)?;
        }
        self.judge_energies(groups, window.t1_s);
        let state = &mut self.state;
        for (interface, signals) in accepted.signals {
            state.sampled.add(window, interface, &signals);
            state.interfaces[interface] = signals;
        }
        let every = self.scenario.run.output.signals_every_windows;
        let due = window.index.is_multiple_of(every);
        // A participant without signals and ledger reports nothing, by its description.
        let mut reports = self.descriptions.iter().zip(&state.reports);
        let complete = reports
            .all(|(d, report)| !report.is_empty() || (d.signals.is_empty() && d.ledger.is_empty()));
        if due && last_at(groups, window.t1_s) && complete {
            let (reports, interfaces) = (&state.reports, &state.interfaces);
            self.signals.row(window.t1_s, reports, interfaces)?;
        }
        let times_s = &mut self.state.snapshots_s;
        let taken = times_s.len();
        let sampled = self.fields.take(communicator, groups, times_s, reached_s)?;
        match (sampled, groups) {
            (Some(snapshot), []) => profile::adopt(self.rundir, &snapshot.name)?,
            (Some(_), groups) => self.write_profiles(groups)?,
            (None, _) => {}
        }
        if self.keeper.writes() && self.state.snapshots_s.len() > taken {
            let come = &self.fields.snapshot_times[taken..self.state.snapshots_s.len()];
            self.state.files.extend(files_of(self.rundir.path(), come));
        }
        self.show(communicator.peers(), groups, window, reached_s);
        Ok(())
    }

    /// The windows of a run that started at `start` begin now, at the simulated time `from_s` of `end_s`; `windows` is
    /// their total number.
    pub fn begin(
        &mut self,
        peers: &Peers,
        start: Instant,
        [from_s, end_s]: [f64; 2],
        windows: u64,
    ) {
        self.pace.begin(start, from_s, end_s);
        self.progress.begin(ProgressSpan {
            from_s,
            end_s,
            windows,
            at_ns: peers.last_answer_ns(),
            waited_ns: peers.waited_ns(),
        });
    }

    /// Reports the progress of the run, if it is due.
    fn show(&mut self, peers: &Peers, groups: &[GroupRun], window: &Window, reached_s: f64) {
        let now_ns = peers.last_answer_ns();
        let Some(course) = self.progress.due(reached_s, now_ns) else {
            return;
        };
        let state = &self.state;
        let passed_ns = now_ns.saturating_sub(course.at_ns).max(1) as f64;
        let waited = peers.waited_ns().into_iter().zip(&course.waited_ns);
        let shares = waited.map(|(now, then)| (now - then) as f64 / passed_ns);
        let names = self.names.iter().map(|name| name.to_string());
        let done = match groups {
            [] => window.index + 1,
            _ => groups.iter().map(|group| group.at.window).sum(),
        };
        let force_n = |name| self.signal(name);
        let ratio = || Some(force_n("wheel_ft_n")? / force_n("wheel_fn_n")?);
        let run_progress = RunProgress {
            run: self.scenario.run.name.clone(),
            phase: phase_at(&self.phases, reached_s),
            from_s: course.from_s,
            t_s: reached_s,
            end_s: course.end_s,
            window: done,
            windows: course.windows,
            repeats: repeats(&state.interfaces, groups),
            sn_pct: self.signal("sn_pct").filter(|sn| sn.is_finite()),
            traction_ratio: ratio().filter(|ratio: &f64| ratio.is_finite()),
            energy_defect_rel: self.total_balance_rel(groups),
            waited: names.zip(shares).collect(),
            spent_s: 0.0,
            left_s: None,
        };
        self.progress.show(run_progress, now_ns);
    }

    /// The latest value of the first signal of this name.
    fn signal(&self, name: &str) -> Option<f64> {
        let pairs = self.descriptions.iter().zip(&self.state.reports);
        let mut signals = pairs.flat_map(|(own, report)| own.signals.iter().zip(report));
        Some(*signals.find(|(signal, _)| *signal == name)?.1)
    }

    /// The energy balance of all participants together, if all report their energies.
    fn total_balance_rel(&self, groups: &[GroupRun]) -> Option<f64> {
        let ledgers = groups.iter().flat_map(|group| &group.coupling.ledgers);
        let points = EnergySums {
            kept_j: ledgers.map(InterfaceLedger::points_kept_j).sum(),
            ..EnergySums::default()
        };
        let all = self.sums().into_iter().chain([points]);
        let total = EnergySums::together(all).balance_rel();
        Some(total).filter(|total| total.is_finite() && self.all_report_energies())
    }

    /// Keeps a participant's report if it has the described length and its energies are finite. A signal may be NaN, as
    /// a node may have no value yet, but gives a warning.
    fn keep(
        &mut self,
        communicator: &dyn Communicator,
        window: &Window,
        peer: usize,
        report: Vec<f64>,
    ) -> Result<()> {
        let own = self.descriptions[peer];
        let (signals, ledger) = (&own.signals, &own.ledger);
        let (numbers, due) = (report.len(), signals.len() + ledger.len());
        if numbers != due {
            let why = format!("reported {numbers} numbers, but its description announced {due}");
            return Err(communicator.peers().protocol_error(peer, why));
        }
        let (seen, energies) = report.split_at(signals.len());
        let not_finite = |values: &[f64]| values.iter().position(|value| !value.is_finite());
        if let Some(index) = not_finite(energies) {
            return Err(Error::Diverged(format!(
                "participant `{}` reported {} as its energy `{}` at the end of window {} (t = {:.6e} s): it diverged; shorten its step or the window",
                self.names[peer], energies[index], ledger[index].name, window.index, window.t1_s
            )));
        }
        if not_finite(seen).is_some() {
            self.find_odd_signals(peer, seen, window.t1_s);
        }
        self.state.energies[peer].copy_from_slice(&report[signals.len()..]);
        self.state.reports[peer] = report;
        Ok(())
    }

    /// Keeps one finding about each signal that is NaN or infinite.
    fn find_odd_signals(&mut self, peer: usize, seen: &[f64], time_s: f64) {
        let names = &self.descriptions[peer].signals;
        for (index, value) in seen.iter().enumerate() {
            let known = self.state.odd_signals.contains(&[peer, index]);
            if !value.is_finite() && !known {
                self.state.odd_signals.push([peer, index]);
                let finding = plausible::not_a_number(&names[index], *value, time_s);
                self.keep_finding(self.names[peer], finding);
            }
        }
    }

    /// Judges the energies after a window: of each participant, of each interface, and of all together if all report
    /// their energies.
    fn judge_energies(&mut self, groups: &[GroupRun], time_s: f64) {
        let sums = self.sums();
        let bounds = self.scenario.run.plausible.of(&ENERGY_BALANCE);
        for (peer, own) in sums.iter().enumerate() {
            let value = self.state.balances[peer].add(own, bounds);
            self.lost(&ENERGY_BALANCE, self.names[peer], value, time_s);
            let loss = Some(&mut self.state.losses[peer]).filter(|_| self.foreign[peer]);
            let fell = loss.and_then(|loss| loss.add_loss(own, DISSIPATION.bounds[0]));
            // The sums of a participant without a ledger are NaN.
            let fell = fell.filter(|value| value.is_finite());
            let finding = fell.and_then(|value| plausible::dissipation(value, time_s));
            self.keep_finding(self.names[peer], finding);
        }
        let points = self.judge_interfaces(groups, time_s);
        let all_report = self.all_report_energies();
        if let Some(total) = self.state.balances.last_mut().filter(|_| all_report) {
            let sums = EnergySums::together(sums.into_iter().chain([points]));
            let value = total.add(&sums, bounds).filter(|_| self.names.len() > 1);
            self.lost(&ENERGY_BALANCE, "run", value, time_s);
        }
    }

    /// Judges the energy of each interface; returns the energies of points with their own masses.
    fn judge_interfaces(&mut self, groups: &[GroupRun], time_s: f64) -> EnergySums {
        let mut points = EnergySums::default();
        let bounds = self.scenario.run.plausible.of(&INTERFACE_ENERGY);
        for coupling in groups.iter().map(|group| &group.coupling) {
            for (patch, ledger) in coupling.group().patches.iter().zip(&coupling.ledgers) {
                points.kept_j += ledger.points_kept_j();
                let balance = &mut self.state.balances[self.names.len() + patch.index];
                let value = balance.see(ledger.energy_defect_j, ledger.energy_j, bounds.suspect);
                self.lost(&INTERFACE_ENERGY, &patch.name, value, time_s);
            }
        }
        points
    }

    /// Keeps the finding of this check about a balance, if there is one.
    fn lost(&mut self, kind: &FindingKind, about: &str, value: Option<f64>, time_s: f64) {
        let bounds = &self.scenario.run.plausible;
        let finding = value.and_then(|v| plausible::lost_balance(kind, bounds, v, time_s));
        self.keep_finding(about, finding);
    }

    /// Keeps a finding, if there is one, for checkpoints too.
    pub fn keep_finding(&mut self, about: &str, finding: Option<Finding>) {
        let finding = finding.map(|finding| (about.to_string(), finding));
        self.state.findings.extend(finding);
    }

    /// Warnings of new findings, not yet passed on.
    pub fn warnings(&mut self) -> Vec<Warning> {
        let new = &self.state.findings[self.passed_on..];
        self.passed_on = self.state.findings.len();
        let warning = |(about, finding): &(String, Finding)| Warning::of(about, finding.clone());
        let new = new.iter().map(warning);
        new.chain(self.fields.advice.take()).collect()
    }

    /// Writes and keeps the traction of each interface in its last accepted window.
    fn write_profiles(&mut self, groups: &[GroupRun]) -> Result<()> {
        let only = self.state.interfaces.len() == 1;
        for coupling in groups.iter().map(|group| &group.coupling) {
            for patch in &coupling.group().patches {
                let thickness_m = self.scenario.run.thickness_m;
                let traction = InterfaceTraction::of(coupling, patch, thickness_m);
                let name = if only {
                    "profile.csv".into()
                } else {
                    format!("profile-{}.csv", patch.name)
                };
                self.rundir.write(&name, &traction.csv())?;
                self.state.sampled.keep_traction(patch.index, traction);
            }
        }
        Ok(())
    }

    /// Has the fields at the end written, and completes the results.
    pub fn finish(
        &mut self,
        communicator: &mut dyn Communicator,
        groups: &[GroupRun],
        summary: &mut Summary,
    ) -> Result<()> {
        self.pace.end();
        let end_s = summary.sim_time_s;
        self.fields.write(communicator, groups, AT_THE_END, end_s)?;
        let foretold = self.dry_run.then(|| self.fields.foretold(Path::new(".")));
        summary.foreseen.extend(foretold.flatten());
        summary.results.extend(self.state.sampled.results());
        Ok(())
    }
}

/// The most repeats of all interfaces in their last windows, and the largest mean of the groups.
fn repeats(last: &[InterfaceSignals], groups: &[GroupRun]) -> Option<(u32, f64)> {
    let last = last.iter().map(|seen| seen.repeats).max()?;
    let groups = groups.iter();
    let ledgers = groups.filter_map(|group| group.coupling.ledgers.first());
    let means = ledgers.map(InterfaceLedger::repeats_mean);
    Some((last, means.fold(0.0, f64::max)))
}

/// True if no group has another window that ends at this time.
fn last_at(groups: &[GroupRun], time_s: f64) -> bool {
    let later = |window: Window| window.t1_s > time_s * (1.0 + 1e-9);
    groups.iter().all(|group| group.next().is_none_or(later))
}
