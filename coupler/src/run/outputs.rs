//! The outputs of accepted windows: signals, fields, tractions, checkpoints, progress.

use protocol::{Kind, Phase, Window};

use super::checkpoint::{Checkpoint, Keeper, RestartPoint};
use super::position::Position;
use super::time_loop::{GroupRun, reached_s};
use crate::error::Error;
use crate::output::collection::{self, Moment};
use crate::output::{HoldMeans, OutputState, Progress, SignalsFile, profile};
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
    hold: HoldMeans,
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
            rundir,
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
        self.hold = state.hold.clone();
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
            hold: self.hold.clone(),
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
        let (rundir, mut held) = (self.rundir, false);
        self.phase_ends(communicator, window.t1_s, |name| held |= name == "hold")?;
        if held {
            profile::adopt(rundir)?;
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
        }
        self.hold.add(window, accepted);
        let due = window.index.is_multiple_of(self.signals_every);
        if due && last_at(groups, window.t1_s) && self.reports.iter().all(|r| !r.is_empty()) {
            self.signals
                .row(window.t1_s, &self.reports, &self.interfaces)?;
        }
        let (mut held, thickness_m) = (false, self.thickness_m);
        self.phase_ends(communicator, reached_s(groups), |name| {
            held |= name == "hold"
        })?;
        if held {
            for (name, text) in profiles(groups, thickness_m) {
                self.rundir.write(&name, &text)?;
            }
            let couplings = groups.iter().map(|group| &group.coupling);
            self.hold.keep_profiles(couplings, thickness_m);
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

    /// At the end of each phase the participants write their fields; `passed` is told its name.
    fn phase_ends(
        &mut self,
        communicator: &mut dyn Communicator,
        time_s: f64,
        mut passed: impl FnMut(&str),
    ) -> Result<(), Error> {
        let over = |phase: &Phase| time_s >= phase.t1_s * (1.0 - 1e-9);
        while self.phases.get(self.snapshots_taken).is_some_and(over) {
            let name = self.phases[self.snapshots_taken].name.clone();
            self.snapshots_taken += 1;
            snapshot(communicator, &name)?;
            self.collect(communicator, None)?;
            passed(&name);
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
        for (name, value) in self.hold.results() {
            summary.results.insert(name, value);
        }
        Ok(())
    }
}

/// Whether no group has a window to do that ends at this time.
fn last_at(groups: &[GroupRun], time_s: f64) -> bool {
    let later = |window: Window| window.t1_s > time_s * (1.0 + 1e-9);
    groups.iter().all(|group| group.next().is_none_or(later))
}

/// The traction of each interface: name and text of its file.
fn profiles(groups: &[GroupRun], thickness_m: f64) -> Vec<(String, String)> {
    let patches = groups.iter().flat_map(|group| {
        let coupling = &group.coupling;
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
