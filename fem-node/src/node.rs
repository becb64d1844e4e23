//! The body as a participant of a coupled run.

mod checkpoint;
mod report;

use std::collections::BTreeMap;
use std::path::PathBuf;

use protocol::{
    Capabilities, Description, Followed, Node, NodeError, Outcome, Setting, Surface, Window,
};
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::compliance::{compliance, impedance};
use crate::config::{Config, Start};
use crate::error::FemError;
use crate::integrate::{Integrator, State};
use crate::interface::{self, Condensed, Interface};
use crate::ledger::Ledger;
use crate::model::{self, Model};
use crate::probe::{self, Held, PressureMaxima};
use crate::statics::{self, Loads};
use crate::wheel::{self, WheelState};
use crate::window::{Request, WindowRun};
pub(crate) use report::HOLD;

/// An elastic body in explicit dynamics.
///
/// Beside the fields of a snapshot NAME one with a wheel writes `<participant>-NAME-profile.csv`: x_m, pressure_pa,
/// shear_pa, status; that of `hold` belongs to the moment before the wheel starts to move sideways.
pub struct FemNode {
    model: Model,
    participant: String,
    fields: Option<PathBuf>,
    /// Never the global pool: its size would ignore the setting.
    pool: ThreadPool,
    integrator: Integrator,
    interface: Interface,
    committed: State,
    wheel: Option<WheelState>,
    ledger: Ledger,
    /// Own steps since the start, committed.
    steps: u64,
    run: WindowRun,
    /// What the last window was run under, until it is committed.
    pending: Option<(u64, Request)>,
    steps_done: u64,
    column_steps: u64,
    hold: Option<PressureMaxima>,
    /// The same for a body with a wheel, exactly when the wheel starts to move sideways.
    held: Option<Held>,
}

impl FemNode {
    /// Builds the body: at rest and undeformed, or in equilibrium with its wheel.
    pub fn new(config: &Config, setting: &Setting) -> Result<FemNode, FemError> {
        let model = Model::new(config, setting)?;
        let threads = setting.threads.max(1);
        let (committed, wheel) = start_state(&model, config)?;
        let (body, elements) = (&model.body, model.mesh.elements());
        Ok(FemNode {
            participant: setting.participant.clone(),
            fields: setting.fields.clone(),
            pool: start_pool(threads)?,
            integrator: Integrator::new(body, model.scheme, elements, threads)
                .under(body, model.law),
            interface: Interface::default(),
            ledger: Ledger::default(),
            steps: 0,
            run: WindowRun::new(&model, &committed),
            committed,
            wheel,
            pending: None,
            steps_done: 0,
            column_steps: 0,
            hold: None,
            held: None,
            model,
        })
    }

    /// Mesh, body, scheme and loads.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The committed state.
    pub fn state(&self) -> &State {
        &self.committed
    }

    /// Starts from these displacements (m) and velocities (m/s), given for each position; what is held stays where it is.
    /// Only before the first window, and for a linear body without a wheel.
    pub fn set_in_motion(
        &mut self,
        motion: impl Fn([f64; 2]) -> [[f64; 2]; 2],
    ) -> Result<(), FemError> {
        if self.steps > 0 || self.wheel.is_some() || self.model.law.is_some() {
            return Err(FemError::InMotion);
        }
        let (mesh, body) = (&self.model.mesh, &self.model.body);
        let layout = body.layout();
        for [i, j] in mesh.nodes() {
            let [u, v] = motion(mesh.point(i, j));
            for k in 0..2 {
                let index = layout.index([i, j], k);
                if body.inverse_mass[index] > 0.0 {
                    self.committed.u[index] = u[k];
                    self.committed.v[index] = v[k];
                }
            }
        }
        layout.spread(&mut self.committed.u);
        layout.spread(&mut self.committed.v);
        body.internal_force(&self.committed.u, &mut self.committed.force);
        self.run = WindowRun::new(&self.model, &self.committed);
        Ok(())
    }

    /// The energies up to the committed state.
    pub fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    fn try_advance(&mut self, window: &Window, force: &[f64]) -> Result<Vec<f64>, FemError> {
        let interface = self.paired(window, Given::Force, force)?;
        self.try_window(
            window,
            Request {
                interface,
                ..Request::default()
            },
        )?;
        Ok(self.increments())
    }

    fn try_follow(&mut self, window: &Window, velocity: &[f64]) -> Result<Followed, FemError> {
        self.may_follow()?;
        let follow = self.paired(window, Given::Velocity, velocity)?;
        self.try_window(
            window,
            Request {
                follow,
                ..Request::default()
            },
        )?;
        let (force, work) = self.run.reaction().unwrap_or_default();
        Ok(Followed {
            force: force.to_vec(),
            work: work.to_vec(),
            increment: self.increments(),
        })
    }

    /// A velocity is followed by a body that is linear and bears no wheel of its own.
    fn may_follow(&self) -> Result<(), FemError> {
        match (&self.wheel, &self.model.law) {
            (None, None) => Ok(()),
            _ => Err(FemError::CannotFollow),
        }
    }

    /// The exchanged components, each with its number of a request.
    fn paired(
        &mut self,
        window: &Window,
        given: Given,
        numbers: &[f64],
    ) -> Result<Vec<(usize, f64)>, FemError> {
        self.pending = None;
        let components = self.interface.components();
        if numbers.len() != components.len() {
            return Err(FemError::GivenLength {
                window: window.index,
                what: given.word(),
                given: numbers.len(),
                expected: components.len(),
            });
        }
        if let Some(at) = numbers.iter().position(|number| !number.is_finite()) {
            return Err(FemError::GivenNotFinite {
                window: window.index,
                iteration: window.iteration,
                point: at / 2,
                component: if at % 2 == 0 { 'x' } else { 'y' },
                what: given.word(),
                number: numbers[at],
                unit: given.unit(),
            });
        }
        let numbers = numbers.iter().copied();
        Ok(components.iter().copied().zip(numbers).collect())
    }

    /// Runs a window from the committed state; `request` tells under what.
    fn try_window(&mut self, window: &Window, request: Request) -> Result<(), FemError> {
        if window.substeps == 0 {
            return Err(FemError::NoSteps);
        }
        let request = Request {
            start: self.steps,
            substeps: window.substeps,
            ..request
        };
        let (model, integrator) = (&self.model, &mut self.integrator);
        let committed = (&self.committed, self.wheel.as_ref());
        let (run, before) = (&mut self.run, &self.ledger);
        let parallel = integrator.blocks() > 1;
        let mut work = || run.run(model, integrator, committed, before, &request);
        match parallel {
            true => self.pool.install(work),
            false => work(),
        }
        self.steps_done += u64::from(window.substeps);
        self.check_finite(window)?;
        if let Some(failed) = self.run.wheel.as_mut().and_then(|run| run.failed.take()) {
            return Err(failed);
        }
        self.pending = Some((window.index, request));
        Ok(())
    }

    /// Displacement increments of the exchanged components over the last window.
    fn increments(&self) -> Vec<f64> {
        let moved = |index: &usize| self.run.state.u[*index] - self.committed.u[*index];
        self.interface.components().iter().map(moved).collect()
    }

    /// In small strain no displacement comes near the size of the body, so this notices a diverging run long
    /// before the numbers overflow.
    fn check_finite(&self, window: &Window) -> Result<(), FemError> {
        let far = self.run.largest_displacement();
        if let Some(found) = self.run.overdraft {
            return Err(FemError::Overdrawn {
                window: window.index,
                iteration: window.iteration,
                step: found.step,
                time_s: found.step as f64 * self.model.scheme.step,
                kinetic_j: found.kinetic,
                supplied_j: found.supplied,
                step_s: self.model.scheme.step,
                limit_s: self.model.step_limit,
            });
        }
        if far < self.model.size() {
            return Ok(());
        }
        let steps = self.steps + u64::from(window.substeps);
        Err(FemError::Diverged {
            window: window.index,
            iteration: window.iteration,
            time_s: steps as f64 * self.model.scheme.step,
            displacement_m: far,
            step_s: self.model.scheme.step,
            limit_s: self.model.step_limit,
        })
    }

    fn try_commit(&mut self, window: &Window, displacement: &[f64]) -> Result<Vec<f64>, FemError> {
        if !displacement.is_empty() {
            return Err(FemError::Dictated {
                window: window.index,
                count: displacement.len(),
            });
        }
        let request = match self.pending.take() {
            Some((index, request)) if index == window.index => request,
            other => {
                return Err(FemError::NotAdvanced {
                    window: window.index,
                    advanced: other.map(|(index, _)| index),
                });
            }
        };
        self.ledger = self
            .run
            .close(&self.model, (&self.committed, &self.ledger), &request);
        match (&mut self.wheel, &self.run.wheel) {
            (Some(wheel), Some(run)) => {
                self.committed.resume(&self.run.state);
                wheel.clone_from(&run.state);
                self.held = self.run.held.take().or(self.held.take());
            }
            _ => self.committed.restore(&self.run.state),
        }
        self.steps += u64::from(request.substeps);
        Ok(self.report(&request))
    }

    fn try_columns(&mut self, substeps: u32) -> Result<Vec<f64>, FemError> {
        self.condensed(Condensed::Compliance, substeps)
    }

    fn try_impedance(&mut self, substeps: u32) -> Result<Vec<f64>, FemError> {
        self.may_follow()?;
        self.condensed(Condensed::Impedance, substeps)
    }

    /// What a window of `substeps` comes to, seen from the exchanged components; computed once.
    fn condensed(&mut self, what: Condensed, substeps: u32) -> Result<Vec<f64>, FemError> {
        if substeps == 0 {
            return Err(FemError::NoSteps);
        }
        if !self.interface.knows(what, substeps) {
            self.column_steps += u64::from(substeps) * self.interface.components().len() as u64;
        }
        let (model, pool) = (&self.model, &self.pool);
        let compute = match what {
            Condensed::Compliance => compliance,
            Condensed::Impedance => impedance,
        };
        let columns = self.interface.condensed(what, substeps, |components| {
            pool.install(|| compute(model, components, substeps))
        });
        if columns.iter().all(|c| c.is_finite()) {
            return Ok(columns.to_vec());
        }
        Err(FemError::DivergedColumns {
            what: what.word(),
            substeps,
            step_s: self.model.scheme.step,
            limit_s: self.model.step_limit,
        })
    }
}

impl Node for FemNode {
    fn describe(&self) -> Description {
        let forces = ["interface_force_x_n", "interface_force_y_n"];
        Description {
            kind: "fem".into(),
            software: format!("fem-node {}", env!("CARGO_PKG_VERSION")),
            capabilities: Capabilities {
                checkpoint: true,
                advance: self.wheel.is_none(),
                columns: self.wheel.is_none(),
                compliant_wall: false,
                follow: self.may_follow().is_ok(),
                alone: true,
                resume: true,
            },
            step_s: Some(self.model.scheme.step),
            step_limit_s: Some(self.model.step_limit),
            step_limit_name: model::limit_name(self.model.scheme.stiffness_damping).into(),
            end_s: self.model.end,
            phases: self.phases(),
            sets: interface::sets(&self.model),
            signals: probe::surface_names(&self.model)
                .iter()
                .chain(&forces)
                .chain(wheel::SIGNALS.iter().filter(|_| self.wheel.is_some()))
                .map(|name| (*name).into())
                .collect(),
            ledger: self.terms().names(),
            warnings: self.model.warnings.clone(),
            first_period_s: Some(self.model.first_period()),
            ..Description::default()
        }
    }

    fn couple(&mut self, set: &str) -> Result<Surface, NodeError> {
        if self.wheel.is_some() {
            return Err(FemError::CoupledWithWheel { set: set.into() }.into());
        }
        Ok(self.interface.couple(&self.model, set)?)
    }

    fn select(&mut self, points: &[usize]) -> Result<(), NodeError> {
        Ok(self.interface.select(&self.model, points)?)
    }

    fn columns(&mut self, substeps: u32) -> Result<Vec<f64>, NodeError> {
        Ok(self.try_columns(substeps)?)
    }

    fn advance(&mut self, window: &Window, force: &[f64]) -> Result<Vec<f64>, NodeError> {
        Ok(self.try_advance(window, force)?)
    }

    fn impedance(&mut self, substeps: u32) -> Result<Vec<f64>, NodeError> {
        Ok(self.try_impedance(substeps)?)
    }

    fn follow(&mut self, window: &Window, velocity: &[f64]) -> Result<Followed, NodeError> {
        Ok(self.try_follow(window, velocity)?)
    }

    fn commit(&mut self, window: &Window, displacement: &[f64]) -> Result<Vec<f64>, NodeError> {
        Ok(self.try_commit(window, displacement)?)
    }

    fn march(&mut self, window: &Window) -> Result<Vec<f64>, NodeError> {
        let none = vec![0.0; self.interface.components().len()];
        self.advance(window, &none)?;
        self.commit(window, &[])
    }

    fn checkpoint(&mut self) -> Result<Vec<u8>, NodeError> {
        self.write_down()
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), NodeError> {
        self.take_up(state)
    }

    fn snapshot(&mut self, name: &str) -> Result<(), NodeError> {
        Ok(self.try_snapshot(name)?)
    }

    fn finish(&mut self) -> Result<Outcome, NodeError> {
        let elements = self.model.mesh.elements() as f64;
        Ok(Outcome {
            steps: self.steps_done,
            work: BTreeMap::from([
                ("element_steps".into(), elements * self.steps_done as f64),
                (
                    "column_element_steps".into(),
                    elements * self.column_steps as f64,
                ),
            ]),
            results: self.results(),
            state_hash: self.state_hash(),
            warnings: Vec::new(),
        })
    }
}

/// What a request gives for each exchanged component.
#[derive(Clone, Copy)]
enum Given {
    Force,
    Velocity,
}

impl Given {
    fn word(self) -> &'static str {
        match self {
            Given::Force => "force",
            Given::Velocity => "velocity",
        }
    }

    fn unit(self) -> &'static str {
        match self {
            Given::Force => "N",
            Given::Velocity => "m/s",
        }
    }
}

/// The body undeformed and the wheel just touching it, or both in equilibrium under the full load.
fn start_state(model: &Model, config: &Config) -> Result<(State, Option<WheelState>), FemError> {
    let Some(wheel) = model.wheel.as_ref() else {
        return Ok((State::at_rest_under(&model.body, model.law.as_ref()), None));
    };
    if config.start == Start::Ramp {
        return Ok((
            State::at_rest_under(&model.body, model.law.as_ref()),
            Some(WheelState::at_rest(wheel)),
        ));
    }
    let start = statics::equilibrium(model, Loads::new(config).as_ref())?;
    let resting = start
        .contact
        .map(|contact| WheelState::resting(wheel, contact.approach, contact.touches()));
    Ok((start.state, resting))
}

fn start_pool(threads: usize) -> Result<ThreadPool, FemError> {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|error| FemError::Pool {
        threads,
        reason: error.to_string(),
    })
}
