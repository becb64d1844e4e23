//! A handshake without a run: participants are started, asked what they are, and let go.

use std::path::PathBuf;

use super::log_volume::{self, Repeats};
use super::session::fresh_run_id;
use super::time_loop::groups_at_start;
use crate::error::Error;
use crate::participants::remote::Remote;
use crate::participants::{Launcher, Registry, Watch, handshake};
use crate::rundir::{RunDir, Scratch};
use crate::scenario::TransportKind;
use crate::scenario::load::Loaded;
use crate::scheme::join::join;
use crate::scheme::predict::inputs::foresee;

/// The participants to greet, and the means.
pub struct Forecast<'a> {
    /// The scenario.
    pub loaded: &'a Loaded,
    /// Shipped solvers.
    pub registry: &'a Registry,
    /// The program whose `node` verb serves them where a participant is foreign.
    pub program: PathBuf,
    /// Threads of each participant.
    pub threads: usize,
}

impl Forecast<'_> {
    /// The predictions for the scenario's interfaces, line by line. No window is run.
    pub fn lines(&self) -> Result<Vec<String>, Error> {
        let mut loaded = self.loaded.clone();
        let participants = &loaded.scenario.participant;
        // Shipped solvers need no process to be asked; the scenario's hash stays the same.
        if participants.iter().all(|p| p.command.is_none()) {
            loaded.scenario.run.transport = TransportKind::Channel;
        }
        let run_id = fresh_run_id();
        let scratch = Scratch::new("check", run_id);
        let rundir = RunDir::create(Some(scratch.path()), "check", run_id)?;
        let launcher = Launcher {
            loaded: &loaded,
            registry: self.registry,
            program: self.program.clone(),
            run_id,
            threads: self.threads,
            rundir: &rundir,
        };
        let mut peers = launcher.start(&loaded.scenario.participant, Watch::default())?;
        let greeted = handshake::greet(&mut peers, &loaded, run_id)?;
        let scenario = &loaded.scenario;
        let remote = &mut Remote::new(&mut peers, &greeted);
        let mut groups = groups_at_start(scenario, &greeted, join(remote, scenario)?)?;
        let volumes = [Repeats::Least, Repeats::Most]
            .map(|repeats| log_volume::coupled(scenario, &greeted, &groups, repeats));
        let mut lines = Vec::new();
        for coupling in groups.iter_mut().map(|group| &mut group.coupling) {
            for (index, prediction) in foresee(coupling, remote)? {
                let group = coupling.group();
                lines.push(format!(
                    "interface {}: windows of {:.4e} s, {} nodes and {} glued points in its group",
                    scenario.interface[index].name,
                    group.clock.window_s(),
                    group.nodes.len(),
                    group.points.len()
                ));
                lines.extend(prediction.lines());
            }
        }
        let output = &self.loaded.scenario.run.output;
        if output.exchange {
            let texts = self.loaded.resolved.len();
            let [least, most] = volumes.map(|v| v.bytes(texts, output.flush_every_windows));
            lines.push(log_volume::line(&volumes[0], least, most));
        }
        Ok(lines)
    }
}
