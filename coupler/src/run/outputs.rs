//! The outputs of accepted windows: signals, fields, tractions, checkpoints, progress.

use protocol::{Kind, Phase, Window};

use super::checkpoint::{Checkpoint, Keeper, RestartPoint};
use super::position::Position;
use super::time_loop::{GroupRun, reached_s};
use crate::error::Error;
use crate::output::collection::{self, Moment};
use crate::output::profile::{self, LoadedNodes, Traction};
use crate::output::sample::load_history;
use crate::output::{OutputState, Progress, SampledMeans, SignalsFile};
use crate::participants::Communicator;
use crate::participants::handshake::Greeted;
use crate::participants::recorded::Recorded;
use crate::rundir::RunDir;
use crate::scenario::Scenario;
use crate::scheme::ledger::EnergyLedger;
use crate::scheme::window::{AcceptedWindow, InterfaceSignals};
use crate::summary::Summary;

/// Everything that is written while windows pass.
pub struct Outputs<'a> {
    rundir: &'a RunDir,
    thickness_m: f64,
    signals_every: u64,
    phases: Vec<Phase>,
    signal_counts: Vec<usize>,
    /// The latest report of each participant; empty before its first.
    reports: Vec<Vec<f64>>,
    /// The latest signals of each interface.
    interfaces: Vec<InterfaceSignals>,
    pub energies: Vec<EnergyLedger>,
    pub signals: SignalsFile,
    sampled: SampledMeans,
    progress: Progress,
    snapshots_taken: usize,
}

impl<'a> Outputs<'a> {
    /// Nothing yet, of participants that were greeted; `progress` shows it on stderr.
    pub fn new(
        (rundir, scenario): (&'a RunDir, &Scenario),
        greeted: &[Greeted],
        progress: bool,
    ) -> Result<Outputs<'a>, Error> {
        let phases = load_history(greeted.iter().map(|greeted| &greeted.description));
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
            rundir,
            thickness_m: scenario.run.thickness_m,
            signals_every: scenario.run.output.signals_every_windows,
            sampled: SampledMeans::new(&phases, &scenario.interface),
            phases,
            reports: vec![Vec::new(); greeted.len()],
            interfaces: vec![InterfaceSignals::default(); scenario.interface.len()],
            signal_counts: descriptions
                .iter()
                .map(|description| description.signals.len())
                .collect(),
            energies,
            signals: SignalsFile::create(rundir, names, &descriptions, &scenario.interface)?,
            progress: Progress::new(&scenario.run.name, progress),
            snapshots_taken: 0,
        })
    }

    pub fn expect(&mut self, done: u64, steps: u64) {
        self.progress.expect(done, steps);
    }

    /// Takes over what the run wrote that is gone on with.
    pub fn carry_over(&mut self, restart: &RestartPoint) -> Result<(), Error> {
        let state = &restart.checkpoint.outputs;
        for (energies, values) in self.energies.iter_mut().zip(&state.energies) {
            energies.values.clone_from(values);
        }
        self.reports.clone_from(&state.reports);
        self.interfaces.clone_from(&state.interfaces);
        self.sampled = state.sampled.clone();
        self.snapshots_taken = state.snapshots_taken;
        let signals = restart.run.join("signals.csv");
        self.signals.carry_over(&signals, state.signals_bytes)?;
        self.signals.sync()?;
        restart.copy_fields(self.rundir, &self.phases)
    }

    /// Between two windows: writes a checkpoint if one is due, and ends the run if it was interrupted.
    pub fn pause(
        &mut self,
        recorded: &mut Recorded,
        keeper: &Keeper,
        groups: &[GroupRun],
        position: Position,
    ) -> Result<(), Error> {
        let interrupted = recorded.peers.watch.interrupted();
        if keeper.due(&position, interrupted.is_some()) {
            let outputs = self.state()?;
            keeper.write(recorded, |nodes, log_blocks| Checkpoint {
                position,
                log_blocks,
                nodes,
                couplings: groups.iter().map(|group| group.coupling.state()).collect(),
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
            sampled: self.sampled.clone(),
            snapshots_taken: self.snapshots_taken,
            signals_bytes: self.signals.sync()?,
        })
    }

    pub fn add_alone(
        &mut self,
        communicator: &mut dyn Communicator,
        window: &Window,
        report: Vec<f64>,
    ) -> Result<(), Error> {
        self.keep(communicator, 0, report)?;
        if window.index.is_multiple_of(self.signals_every) {
            self.signals.row(window.t1_s, &self.reports, &[])?;
        }
        if let Some(phase) = self.phase_ends(communicator, window.t1_s)? {
            profile::adopt(self.rundir, &phase.name)?;
        }
        self.progress.show(window);
        Ok(())
    }

    pub fn add_coupled(
        &mut self,
        communicator: &mut dyn Communicator,
        groups: &[GroupRun],
        window: &Window,
        accepted: &AcceptedWindow,
    ) -> Result<(), Error> {
        for (peer, report) in &accepted.reports {
            self.keep(communicator, *peer, report.clone())?;
        }
        for (interface, signals) in &accepted.signals {
            self.interfaces[*interface] = *signals;
            self.sampled.add(window, *interface, signals.pressing_n);
        }
        let due = window.index.is_multiple_of(self.signals_every);
        if due && last_at(groups, window.t1_s) && self.reports.iter().all(|r| !r.is_empty()) {
            self.signals
                .row(window.t1_s, &self.reports, &self.interfaces)?;
        }
        if self.phase_ends(communicator, reached_s(groups))?.is_some() {
            self.write_profiles(groups)?;
        }
        self.progress.show(window);
        Ok(())
    }

    /// Keeps what a participant reported, if it is as long as was announced.
    fn keep(
        &mut self,
        communicator: &dyn Communicator,
        peer: usize,
        report: Vec<f64>,
    ) -> Result<(), Error> {
        let due = self.signal_counts[peer] + self.energies[peer].terms.len();
        if report.len() != due {
            return Err(communicator.peers().protocol_error(
                peer,
                format!(
                    "reported {} numbers where its description announced {due}",
                    report.len()
                ),
            ));
        }
        self.energies[peer]
            .values
            .copy_from_slice(&report[self.signal_counts[peer]..]);
        self.reports[peer] = report;
        Ok(())
    }

    /// Has the participants write their fields at the end of each phase; returns the sampled one if it is among those
    /// that ended.
    fn phase_ends(
        &mut self,
        communicator: &mut dyn Communicator,
        time_s: f64,
    ) -> Result<Option<Phase>, Error> {
        let over = |phase: &&Phase| time_s >= phase.t1_s * (1.0 - 1e-9);
        let mut sampled = None;
        while let Some(phase) = self.phases.get(self.snapshots_taken).filter(over).cloned() {
            self.snapshots_taken += 1;
            snapshot(communicator, &phase.name)?;
            self.collect(communicator, None)?;
            sampled = sampled.or(Some(phase).filter(|phase| phase.sampled));
        }
        Ok(sampled)
    }

    /// Writes and keeps the traction of each interface in its last accepted window.
    fn write_profiles(&mut self, groups: &[GroupRun]) -> Result<(), Error> {
        let only = self.interfaces.len() == 1;
        for coupling in groups.iter().map(|group| &group.coupling) {
            let group = coupling.group();
            for patch in &group.patches {
                let loaded = LoadedNodes {
                    nodes: &group.nodes,
                    own: patch.nodes.clone(),
                    force: &coupling.state.lambda,
                    outward_y: patch.outward_y,
                };
                let traction = Traction::of(loaded, self.thickness_m);
                let name = if only {
                    "profile.csv".into()
                } else {
                    format!("profile-{}.csv", patch.name)
                };
                self.rundir.write(&name, &traction.csv())?;
                self.sampled.keep_traction(patch.index, traction);
            }
        }
        Ok(())
    }

    /// Writes `fields/<participant>.pvd` of the snapshots so far, that of the end included if it is taken.
    fn collect(&self, communicator: &dyn Communicator, end_s: Option<f64>) -> Result<(), Error> {
        let moment = |name: &str, time_s| Moment {
            name: name.into(),
            time_s,
        };
        let passed = self.phases[..self.snapshots_taken].iter();
        let mut moments: Vec<Moment> = passed.map(|p| moment(&p.name, p.t1_s)).collect();
        moments.extend(end_s.map(|time_s| moment("end", time_s)));
        let peers = communicator.peers();
        for name in (0..peers.count()).map(|peer| peers.name(peer)) {
            if let Some(text) = collection::pvd(&self.rundir.fields(), name, &moments) {
                self.rundir.write(&format!("fields/{name}.pvd"), &text)?;
            }
        }
        Ok(())
    }

    pub fn finish(
        &mut self,
        communicator: &mut dyn Communicator,
        summary: &mut Summary,
    ) -> Result<(), Error> {
        snapshot(communicator, "end")?;
        self.collect(communicator, Some(summary.sim_time_s))?;
        self.progress.done();
        summary.results.extend(self.sampled.results());
        Ok(())
    }
}

/// Whether no group has a window to do that ends at this time.
fn last_at(groups: &[GroupRun], time_s: f64) -> bool {
    let later = |window: Window| window.t1_s > time_s * (1.0 + 1e-9);
    groups.iter().all(|group| group.next().is_none_or(later))
}

fn snapshot(communicator: &mut dyn Communicator, name: &str) -> Result<(), Error> {
    let count = communicator.peers().count();
    for peer in 0..count {
        communicator.tell_text(peer, Kind::Snapshot, name)?;
    }
    for peer in 0..count {
        communicator.receive(peer, Kind::Saved)?;
    }
    Ok(())
}
