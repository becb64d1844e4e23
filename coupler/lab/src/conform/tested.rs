//! The tested participant, with the sets and windows from its scenario.

use std::cell::{Cell, OnceCell};
use std::path::PathBuf;

use nalgebra::DMatrix;
use protocol::Description;

use coordinator::participants::handshake::{Greeted, greet};
use coordinator::participants::{Launcher, Peers, Registry, Watch};
use coordinator::run::session::fresh_run_id;
use kit::scratch::Scratch;
use runs::run_dir::RunDir;
use scenario::error::{Error, Refusal};
use scenario::keys::{Participant, Scenario};
use scenario::load::Loaded;
use scheme::clock::Clock;
use scheme::error::Unfit;
use scheme::join::step_of;
use scheme::keys::Interface;

/// Options of the tests.
pub struct ConformOptions<'a> {
    /// Shipped solvers.
    pub registry: &'a Registry,
    /// The program whose `node` verb serves them.
    pub program: PathBuf,
    /// Signals that end the tests.
    pub watch: Watch,
    /// Names of the rules to test, in addition to greeting and surface; empty for all.
    pub only: Vec<String>,
}

/// Participants of a scenario, launched one at a time.
pub struct ScenarioLauncher<'a> {
    loaded: &'a Loaded,
    options: &'a ConformOptions<'a>,
    scratch: Scratch,
    launched: Cell<u64>,
}

impl<'a> ScenarioLauncher<'a> {
    /// The launcher of a scenario's participants.
    pub fn new(loaded: &'a Loaded, options: &'a ConformOptions<'a>) -> ScenarioLauncher<'a> {
        ScenarioLauncher {
            loaded,
            options,
            scratch: Scratch::new("conform", fresh_run_id()),
            launched: Cell::new(0),
        }
    }

    /// The scenario.
    pub fn scenario(&self) -> &'a Scenario {
        &self.loaded.scenario
    }

    /// Launches and greets a participant.
    pub fn launch(
        &self,
        participant: &Participant,
        threads: usize,
    ) -> Result<(Peers, Greeted), Error> {
        let (peers, greeted) = self.launch_all(std::slice::from_ref(participant), threads)?;
        let only = greeted.into_iter().next().expect("one was launched");
        Ok((peers, only))
    }

    /// Launches and greets participants.
    pub fn launch_all(
        &self,
        participants: &[Participant],
        threads: usize,
    ) -> Result<(Peers, Vec<Greeted>), Error> {
        let run_id = fresh_run_id();
        let folder = self.scratch.path().join(self.launched.get().to_string());
        self.launched.set(self.launched.get() + 1);
        let launcher = Launcher {
            loaded: self.loaded,
            registry: self.options.registry,
            program: self.options.program.clone(),
            run_id,
            threads,
            rundir: &RunDir::create(Some(&folder), &self.scenario().run.name, run_id)?,
        };
        let mut peers = launcher.start(participants, self.options.watch.clone())?;
        let greeted = greet(&mut peers, self.loaded, run_id)?;
        Ok((peers, greeted))
    }
}

/// The role of the participant in a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// It receives forces and answers with motion.
    ForceDriven,
    /// It receives the motion of its points and answers with forces.
    MotionDriven,
    /// It runs alone.
    Alone,
}

impl Part {
    /// The role of a participant that is joined with others.
    pub fn joined(description: &Description) -> Part {
        if description.capabilities.advance {
            return Part::ForceDriven;
        }
        Part::MotionDriven
    }
}

/// The tested participant.
#[derive(Clone)]
pub struct TestedParticipant<'a> {
    /// Launcher of the participant.
    pub launcher: &'a ScenarioLauncher<'a>,
    /// Its entry in the scenario.
    pub participant: &'a Participant,
    /// Its description of itself.
    pub description: Description,
    /// Its role.
    pub part: Part,
    /// Its sets that interfaces name, in order.
    pub sets: Vec<String>,
    /// Its windows.
    pub clock: Clock,
    /// Compliance (1/kg) of the boundary in its launches, once the layer's stiffness is known; rigid before.
    pub boundary: OnceCell<DMatrix<f64>>,
}

impl<'a> TestedParticipant<'a> {
    /// The participant with this description of itself.
    pub fn new(
        launcher: &'a ScenarioLauncher<'a>,
        participant: &'a Participant,
        description: Description,
    ) -> Result<TestedParticipant<'a>, Error> {
        let scenario = launcher.scenario();
        let own = |interface: &&Interface| interface.participants().contains(&&*participant.name);
        let interfaces: Vec<&Interface> = scenario.interface.iter().filter(own).collect();
        let (part, clock) = match interfaces.first() {
            None => {
                let problem = "has no step of its own, so there is no window to test it with";
                let missing = || Refusal::participant(&participant.name, problem);
                let clock = Clock {
                    step_s: description.step_s.ok_or_else(missing)?,
                    substeps: scenario.run.output.alone_steps,
                };
                (Part::Alone, clock)
            }
            Some(interface) => {
                let part = Part::joined(&description);
                let step_s = match part {
                    Part::MotionDriven => step_of_other_side(launcher, interface, participant)?,
                    _ => step_of(interface, &participant.name, description.step_s)?,
                };
                let substeps = interface.substeps();
                (part, Clock { step_s, substeps })
            }
        };
        let sets = interfaces.iter().flat_map(|interface| &interface.between);
        let sets = sets.filter_map(|side| side.split_once('.'));
        let sets = sets.filter(|(name, _)| *name == participant.name);
        Ok(TestedParticipant {
            launcher,
            participant,
            part,
            sets: sets.map(|(_, set)| set.to_string()).collect(),
            clock,
            description,
            boundary: OnceCell::new(),
        })
    }
}

/// The step of the continuum that a motion-driven participant is joined with; launches the continuum to get it.
fn step_of_other_side(
    launcher: &ScenarioLauncher,
    interface: &Interface,
    participant: &Participant,
) -> Result<f64, Error> {
    let mut all = launcher.scenario().participant.iter();
    let names = interface.participants();
    let other = all.find(|other| other.name != participant.name && names.contains(&&*other.name));
    let alone = || Refusal::from(Unfit::interface(&interface.name, "joins one participant"));
    let other = other.ok_or_else(alone)?;
    let (_, greeted) = launcher.launch(other, 1)?;
    Ok(step_of(interface, &other.name, greeted.description.step_s)?)
}
