//! The body as a participant of a coupled run.

mod checkpoint;
mod report;
mod request;

use std::collections::BTreeMap;
use std::path::PathBuf;

use protocol::{
    Capabilities, Description, Node, NodeError, Outcome, Reaction, Setting, Surface, Window,
};
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::config::{Config, Start};
use crate::error::FemError;
use crate::integrate::{Integrator, State};
use crate::interface::{self, Interface};
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
}

impl Node for FemNode {
    fn describe(&self) -> Description {
        let forces = ["interface_force_x_n", "interface_force_y_n"];
        Description {
            kind: "fem".into(),
            software: format!("fem-node {}", env!("CARGO_PKG_VERSION")),
            capabilities: Capabilities {
                rollback: true,
                advance: self.wheel.is_none(),
                columns: self.wheel.is_none(),
                compliant_boundary: false,
                prescribed_velocity: self.may_follow().is_ok(),
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

    fn prescribe_velocity(
        &mut self,
        window: &Window,
        velocity: &[f64],
    ) -> Result<Reaction, NodeError> {
        Ok(self.try_follow(window, velocity)?)
    }

    fn commit(&mut self, window: &Window, displacement: &[f64]) -> Result<Vec<f64>, NodeError> {
        Ok(self.try_commit(window, displacement)?)
    }

    fn advance_alone(&mut self, window: &Window) -> Result<Vec<f64>, NodeError> {
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
