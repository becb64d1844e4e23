//! A handshake without a run: participants are started, asked what they are, and let go.

use std::path::PathBuf;

use super::conversation::Conversation;
use super::course::courses;
use super::handshake;
use super::join::join;
use super::run::fresh_run_id;
use super::volume;
use crate::error::Error;
use crate::launch::{Launcher, Peer, Registry, Watch};
use crate::rundir::{RunDir, Scratch};
use crate::scenario::TransportKind;
use crate::scenario::load::Loaded;

/// Whom to greet, and with what.
pub struct Greeting<'a> {
    /// The scenario.
    pub loaded: &'a Loaded,
    /// Shipped solvers.
    pub registry: &'a Registry,
    /// The program whose `node` verb serves them where a participant is foreign.
    pub program: PathBuf,
    /// Threads of each participant.
    pub threads: usize,
}

impl Greeting<'_> {
    /// What is foreseen of the scenario's interface, line by line. No window is run.
    pub fn foresee(&self) -> Result<Vec<String>, Error> {
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
        let memory = launcher.shared_memory();
        let peers: Result<Vec<Peer>, Error> = loaded
            .scenario
            .participant
            .iter()
            .map(|participant| launcher.start(participant, &memory))
            .collect();
        let deadlines = &loaded.scenario.run.deadlines;
        let labels = loaded.scenario.labels();
        let mut conversation =
            Conversation::new(peers?, run_id, labels, deadlines, Watch::default(), None);
        let greeted = handshake::greet(&mut conversation, &loaded, run_id)?;
        let scenario = &loaded.scenario;
        let groups = join(&mut conversation, scenario, &greeted)?;
        let mut courses = courses(scenario, &greeted, groups)?;
        let volume = volume::coupled(scenario, &greeted, &courses);
        let mut lines = Vec::new();
        for course in &mut courses {
            let coupling = &mut course.coupling;
            for (index, prediction) in coupling.foresee(&mut conversation, &greeted)? {
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
            let bytes = volume.bytes(self.loaded.resolved.len(), output.flush_every_windows);
            lines.push(volume::line(&volume, bytes));
        }
        Ok(lines)
    }
}
