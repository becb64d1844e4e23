//! Windows and matrices that a coupler asks for.

use protocol::{Reaction, Window};

use super::FemNode;
use crate::compliance::{compliance, impedance};
use crate::error::FemError;
use crate::interface::Condensed;
use crate::window::Request;

impl FemNode {
    pub(super) fn try_advance(
        &mut self,
        window: &Window,
        force: &[f64],
    ) -> Result<Vec<f64>, FemError> {
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

    pub(super) fn try_follow(
        &mut self,
        window: &Window,
        velocity: &[f64],
    ) -> Result<Reaction, FemError> {
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
        Ok(Reaction {
            force: force.to_vec(),
            work: work.to_vec(),
            increment: self.increments(),
        })
    }

    /// A velocity is followed by a body that is linear and bears no wheel of its own.
    pub(super) fn may_follow(&self) -> Result<(), FemError> {
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

    pub(super) fn try_columns(&mut self, substeps: u32) -> Result<Vec<f64>, FemError> {
        self.condensed(Condensed::Compliance, substeps)
    }

    pub(super) fn try_impedance(&mut self, substeps: u32) -> Result<Vec<f64>, FemError> {
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
