//! The solver as a participant of a run.

mod checkpoint;
pub(crate) mod crew;
mod report;
mod request;

use std::collections::BTreeMap;
use std::path::PathBuf;

use protocol::{
    BoundaryAnswer, Capabilities, ConfigError, Description, Node, NodeError, Outcome, Setting,
    Surface, Tolerance, Window,
};

use crate::bodies::Bodies;
use crate::bond;
use crate::bounds::Bounds;
use crate::config::Config;
use crate::error::DemError;
use crate::exchange::{self, Exchange};
use crate::pull::Pull;
use crate::report::{Journal, Moment};
use crate::sample;
use crate::scaling::Scaling;
use crate::setup;
use crate::snapshot;
use crate::state::State;
use crate::step::{Drive, Stepper, Summary};
use crate::wall::Wall;
use crate::wheel::Program;
use crew::Crew;
use report::stored;
use request::{request, require_numbers};

/// A layer or heap of grains, with its wheel and walls, ready to step.
pub struct Dem {
    participant: String,
    fields: Option<PathBuf>,
    thickness: f64,
    /// Of a disk, scaled (kg/m2).
    mass_per_area: f64,
    theta: f64,
    own_step: Option<f64>,
    end: Option<f64>,
    bounds: Bounds,
    crew: Crew,
    bodies: Bodies,
    program: Option<Program>,
    pull: Option<Pull>,
    /// Bonds at the start, and the longest step with a unique end (s).
    born: usize,
    bond_step_limit: Option<f64>,
    solid_fraction: f64,
    /// Where a layer with ends has them (m).
    half_width: Option<f64>,
    scaling: Option<Scaling>,
    warnings: Vec<String>,
    /// The committed state.
    state: State,
    /// The state at the end of the window being solved.
    trial: State,
    stepper: Stepper,
    exchange: Exchange,
    /// Length of the announced windows (s).
    window: Option<f64>,
    /// What `trial` holds, until it is committed.
    pending: Option<Pending>,
    initial_energy: [f64; 4],
    journal: Journal,
    steps: u64,
    contact_iterations: f64,
}

#[derive(Clone, Copy)]
struct Pending {
    window: Window,
    summary: Summary,
}

impl Dem {
    /// Prepares the sample of a configuration and everything around it.
    pub fn new(config: &Config, setting: &Setting) -> Result<Dem, DemError> {
        config.validate()?;
        let bounds = Bounds::new(config);
        let warnings = match config.time.step_s {
            Some(step) => bounds.assess(step)?,
            None => Vec::new(),
        };
        let sample = sample::prepare(config, setting.seed)?;
        let mut bodies = setup::bodies(config, setting.thickness_m, &sample);
        let mut state = State::new(&bodies, &sample.free, &sample.glued);
        if let Some(wheel) = &config.wheel {
            setup::refuse_idle_wheel(&state)?;
            state.wheel.velocity[1] = wheel.vy_m_per_s;
        }
        setup::refuse_rigid_overlaps(&bodies, &state)?;
        let pull = match &config.drive {
            None => None,
            Some(drive) => Some(Pull::new(drive, &bodies, &state)?),
        };
        if let Some(pull) = &pull {
            let [x, y] = pull.velocity(&state);
            bodies.pulled = Some([x, y]);
            state.velocities[0] = [x, y, 0.0];
        }
        let program = config.wheel.as_ref().map(Program::new);
        let mut stepper = Stepper::default();
        stepper.problem.wall = Wall::fixed(bodies.glued());
        Ok(Dem {
            participant: setting.participant.clone(),
            fields: setting.fields.clone(),
            thickness: setting.thickness_m,
            mass_per_area: config.mass_scale * config.density_kg_per_m3 * setting.thickness_m,
            theta: config.time.theta,
            own_step: pull.map(|p| p.step()).or(config.time.step_s),
            end: program
                .map(|p| p.end())
                .or(pull.map(|p| p.end()))
                .or(config.time.end_s),
            bounds,
            crew: Crew::new(setup::criteria(config), setting.threads)?,
            initial_energy: stored(&bodies, &state),
            born: bond::count(&state.bonds),
            bond_step_limit: bond::step_limit(&bodies, &state.bonds),
            pull,
            journal: Journal::new(state.wheel.position[1]),
            trial: state.clone(),
            state,
            bodies,
            program,
            solid_fraction: sample.solid_fraction,
            half_width: config.sample.ends(),
            scaling: Scaling::new(config, &bounds, &sample),
            warnings,
            stepper,
            exchange: Exchange::default(),
            window: None,
            pending: None,
            steps: 0,
            contact_iterations: 0.0,
        })
    }

    /// The committed state.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// What does not change.
    pub fn bodies(&self) -> &Bodies {
        &self.bodies
    }

    fn drive_at<'a>(&self, start: f64, end: f64, free_velocity: &'a [f64]) -> Drive<'a> {
        let step = end - start;
        let loaded = start + self.theta * step;
        Drive {
            step,
            theta: self.theta,
            load: self.program.map_or(0.0, |p| p.load_at(loaded)),
            wheel_x: self.program.map_or(0.0, |p| p.drive_at(end)),
            free_velocity,
        }
    }

    fn count(&mut self, summary: &Summary) {
        self.steps += 1;
        self.contact_iterations += (summary.listed * summary.verdict.iterations) as f64;
    }

    fn record(&mut self, start: f64, end: f64, drive_before: f64, summary: &Summary) {
        let moment = Moment {
            start,
            end,
            drive_work: self.state.accounts.drive - drive_before,
        };
        self.journal
            .record(self.program.as_ref(), &self.state, summary, &moment);
    }
}

impl Node for Dem {
    fn describe(&self) -> Description {
        let glued = self.bodies.glued() > 0;
        Description {
            kind: "dem".into(),
            software: concat!("thirdbody dem-node ", env!("CARGO_PKG_VERSION")).into(),
            capabilities: Capabilities {
                rollback: true,
                compliant_boundary: glued,
                alone: self.own_step.is_some(),
                resume: true,
                ..Capabilities::default()
            },
            step_s: self.own_step,
            step_limit_s: self.bounds.limit(),
            step_limit_name: Bounds::NAME.into(),
            end_s: self.end,
            phases: self.program.map(|p| p.phases()).unwrap_or_default(),
            sets: exchange::sets(&self.bodies),
            signals: self.signal_names(),
            ledger: self.ledger_terms(),
            warnings: self.warnings.clone(),
            boundary_inertia: glued.then(|| self.boundary_inertia()),
            tolerance: Some(Tolerance {
                key: "solver.tolerance".into(),
                value: self.crew.criteria.tolerance,
            }),
            point_mass_kg: exchange::masses(&self.bodies, self.mass_per_area),
            ..Description::default()
        }
    }

    fn couple(&mut self, set: &str) -> Result<Surface, NodeError> {
        let mut exchange = self.exchange.clone();
        let surface = exchange.couple(&self.bodies, &self.participant, set)?;
        self.refuse_when_coupled()?;
        self.exchange = exchange;
        Ok(surface)
    }

    fn select(&mut self, points: &[usize]) -> Result<(), NodeError> {
        if points.iter().copied().eq(0..self.exchange.len()) {
            return Ok(());
        }
        Err(NodeError::configuration(format!(
            "all {} glued disks move with the wall, {} of them were selected: select all",
            self.exchange.len(),
            points.len()
        )))
    }

    fn set_boundary(&mut self, window_s: f64, compliance: &[f64]) -> Result<(), NodeError> {
        if !(window_s > 0.0 && window_s.is_finite()) {
            return Ok(request(format!(
                "windows of {window_s} s cannot be solved"
            ))?);
        }
        for warning in self.bounds.assess(window_s)? {
            if !self.warnings.contains(&warning) {
                self.warnings.push(warning);
            }
        }
        Wall::refuse_misfit(self.exchange.len(), compliance)?;
        let glued = self.bodies.glued();
        let compliance = self.exchange.scatter_square(compliance, glued);
        self.stepper.problem.wall = Wall::compliant(glued, compliance);
        self.window = Some(window_s);
        self.pending = None;
        Ok(())
    }

    fn solve(
        &mut self,
        window: &Window,
        free_velocity: &[f64],
    ) -> Result<BoundaryAnswer, NodeError> {
        let step = self.check_window(window, free_velocity)?;
        let free_velocity = self.exchange.scatter(free_velocity, self.bodies.glued());
        let drive = Drive {
            step,
            ..self.drive_at(window.t0_s, window.t1_s, &free_velocity)
        };
        self.trial.clone_from(&self.state);
        let (stepper, state) = (&mut self.stepper, &mut self.trial);
        let summary = self.crew.advance(stepper, &self.bodies, state, &drive)?;
        self.count(&summary);
        self.pending = Some(Pending {
            window: *window,
            summary,
        });
        let wall = &self.stepper.problem.wall;
        Ok(BoundaryAnswer {
            force: self
                .exchange
                .gather(&wall.impulse)
                .iter()
                .map(|p| p / step)
                .collect(),
            velocity: self.exchange.gather(&wall.velocity),
            iterations: summary.verdict.iterations as u64,
            residual: summary.verdict.residual,
            converged: summary.verdict.converged,
        })
    }

    fn commit(&mut self, window: &Window, displacement: &[f64]) -> Result<Vec<f64>, NodeError> {
        let Some(pending) = self.pending.take_if(|p| p.window.index == window.index) else {
            return Ok(request(format!(
                "window {} is committed but was not solved",
                window.index
            ))?);
        };
        if displacement.len() != 2 * self.exchange.len() {
            return Ok(request(format!(
                "the commit of window {} brings {} displacements for {} glued disks of two components",
                window.index,
                displacement.len(),
                self.exchange.len()
            ))?);
        }
        require_numbers("a displacement of a glued disk", window, displacement)?;
        let drive_before = self.state.accounts.drive;
        std::mem::swap(&mut self.state, &mut self.trial);
        let displacement = self.exchange.scatter(displacement, self.bodies.glued());
        let glued = &mut self.state.centres[self.bodies.free..];
        for ((centre, place), u) in glued
            .iter_mut()
            .zip(&self.bodies.reference)
            .zip(displacement.chunks_exact(2))
        {
            *centre = [place[0] + u[0], place[1] + u[1]];
        }
        self.record(window.t0_s, window.t1_s, drive_before, &pending.summary);
        Ok(self.report(&pending.summary))
    }

    fn advance_alone(&mut self, window: &Window) -> Result<Vec<f64>, NodeError> {
        let step = self.own_step.ok_or_else(|| {
            ConfigError::new(
                "time.step_s",
                "a run without interface needs a step of its own",
            )
        })?;
        if !self.exchange.is_empty() {
            return Ok(request("a coupled participant cannot advance alone")?);
        }
        let fixed = vec![0.0; 2 * self.bodies.glued()];
        let mut summary = Summary::default();
        for index in window.step..window.step + u64::from(window.substeps) {
            // Times are multiples of the step: no rounding builds up.
            let (start, end) = (index as f64 * step, (index + 1) as f64 * step);
            let drive = Drive {
                step,
                ..self.drive_at(start, end, &fixed)
            };
            let drive_before = self.state.accounts.drive;
            let (stepper, state) = (&mut self.stepper, &mut self.state);
            summary = self.crew.advance(stepper, &self.bodies, state, &drive)?;
            self.count(&summary);
            if !summary.verdict.converged {
                return Err(NodeError::from(DemError::NotConverged {
                    window: window.index,
                    residual: summary.verdict.residual,
                    iterations: summary.verdict.iterations,
                    tolerance: self.crew.criteria.tolerance,
                    friction: self.bodies.law.coefficient(),
                }));
            }
            self.record(start, end, drive_before, &summary);
        }
        Ok(self.report(&summary))
    }

    fn checkpoint(&mut self) -> Result<Vec<u8>, NodeError> {
        self.write_down()
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), NodeError> {
        self.take_up(state)
    }

    fn snapshot(&mut self, name: &str) -> Result<(), NodeError> {
        if let Some(folder) = &self.fields {
            let path = folder.join(format!("{}-{name}.vtp", self.participant));
            snapshot::write(&path, &self.bodies, &self.state, self.thickness)?;
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<Outcome, NodeError> {
        Ok(Outcome {
            steps: self.steps,
            work: BTreeMap::from([("contact_iterations".into(), self.contact_iterations)]),
            results: self.results(),
            state_hash: self.state.hash(),
            warnings: self.journal.warnings(
                self.program.as_ref(),
                &self.bodies,
                &self.state,
                self.half_width,
            ),
        })
    }
}
