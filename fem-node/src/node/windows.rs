//! Windows and condensed matrices that a coupler asks for.

use fem_kernel::element::body::Body;
use fem_kernel::material::nonlinear::NonlinearLaw;
use fem_kernel::pack::largest;
use fem_kernel::scheme::NewmarkScheme;
use protocol::Window;

use super::fem_node::FemNode;
use crate::error::FemError;
use crate::interface::window::EnergyExcess;
use crate::interface::window::extent::WindowInput;
use crate::model::Model;

/// Displacement of a body that turns, over its larger extent: twice the diagonal of a square.
const MOST_TURNED: f64 = 3.0;

impl FemNode {
    /// A body accepts a prescribed velocity if it is linear and has no wheel of its own.
    pub(super) fn takes_velocity(&self) -> Result<(), FemError> {
        match (&self.model.wheel, &self.model.law) {
            (None, None) => Ok(()),
            _ => Err(FemError::NoPrescribedVelocity),
        }
    }

    /// The exchanged components, each with its number in a request.
    pub(super) fn paired(
        &mut self,
        window: &Window,
        quantity: ExchangedQuantity,
        numbers: &[f64],
    ) -> Result<Vec<(usize, f64)>, FemError> {
        self.pending = None;
        let components = &self.interface.components;
        quantity.admit(window, numbers, components.len())?;
        let numbers = numbers.iter().copied();
        Ok(components.iter().copied().zip(numbers).collect())
    }

    /// Runs a window from the committed state.
    pub(super) fn try_window(
        &mut self,
        window: &Window,
        mut input: WindowInput,
    ) -> Result<(), FemError> {
        if window.substeps == 0 {
            return Err(FemError::NoSteps);
        }
        input.substeps = window.substeps;
        let (model, integrator) = (&self.model, &mut self.integrator);
        let (run, committed) = (&mut self.run, &mut self.committed);
        let done = run.run(model, (integrator, &self.team), committed, &input);
        self.committed.element_steps += done;
        self.committed.steps_done += u64::from(window.substeps);
        self.check_divergence(window)?;
        if let Some(failed) = self.run.wheel.as_mut().and_then(|run| run.failed.take()) {
            return Err(failed.into());
        }
        self.pending = Some((window.index, input));
        Ok(())
    }

    /// Displacement increments of the exchanged components over the last window.
    pub(super) fn increments(&self) -> Vec<f64> {
        let (model, start) = (&self.model, &self.committed.state);
        let moved = |index: &usize| self.run.moved(model, start, *index);
        self.interface.components.iter().map(moved).collect()
    }

    /// Refuses a diverging run long before the numbers overflow: in small strain no displacement comes near the size of the body. In half a turn the
    /// ends of a body move by twice their distance.
    fn check_divergence(&self, window: &Window) -> Result<(), FemError> {
        let far = self.farthest();
        if let Some(found) = self.run.excess {
            return Err(gained(&self.model, window, found));
        }
        let turns = self.model.law == Some(NonlinearLaw::Corotational);
        let most = if turns { MOST_TURNED } else { 1.0 };
        if far < most * self.model.size {
            return Ok(());
        }
        let steps = self.committed.steps + u64::from(window.substeps);
        Err(diverged(&self.model, window, steps, far))
    }

    /// The largest displacement (m). A body may fly or be carried without limit: beyond its own size, the displacement of its first node is
    /// subtracted.
    fn farthest(&self) -> f64 {
        let (mesh, layout) = (&self.model.mesh, self.model.body.layout);
        let far = self.run.largest_displacement();
        if far < self.model.size {
            return far;
        }
        let u = self.run.displacements(layout);
        let of = |node| [0, 1].map(|k| u[layout.index(node, k)] - u[layout.index([0, 0], k)]);
        largest(mesh.nodes().flat_map(of).map(f64::abs))
    }

    /// Condensed matrix of a window of `substeps` over the exchanged components; computed once.
    pub(super) fn condensed(
        &mut self,
        what: &'static str,
        compute: fn(&Body, NewmarkScheme, &[usize], u32) -> Vec<f64>,
        substeps: u32,
    ) -> Result<Vec<f64>, FemError> {
        if substeps == 0 {
            return Err(FemError::NoSteps);
        }
        let (model, components) = (&self.model, &self.interface.components);
        let known = self.interface.condensed.entry((what, substeps));
        let columns = known.or_insert_with(|| {
            self.committed.column_steps += u64::from(substeps) * components.len() as u64;
            self.team
                .pool
                .install(|| compute(&model.body, model.scheme, components, substeps))
        });
        if columns.iter().all(|c| c.is_finite()) {
            return Ok(columns.to_vec());
        }
        Err(FemError::DivergedColumns {
            what,
            substeps,
            step_s: self.model.scheme.step,
            limit_s: self.model.step_limit,
        })
    }
}

/// The error of a displacement (m) beyond the size of the body after this number of steps.
pub(super) fn diverged(
    model: &Model,
    window: &Window,
    steps: u64,
    displacement_m: f64,
) -> FemError {
    FemError::Diverged {
        window: window.index,
        iteration: window.iteration,
        time_s: steps as f64 * model.scheme.step,
        displacement_m,
        step_s: model.scheme.step,
        limit_s: model.step_limit,
    }
}

/// The error of kinetic energy that no force supplied.
pub(super) fn gained(model: &Model, window: &Window, found: EnergyExcess) -> FemError {
    FemError::EnergyExcess {
        window: window.index,
        iteration: window.iteration,
        step: found.step,
        time_s: found.step as f64 * model.scheme.step,
        kinetic_j: found.kinetic,
        supplied_j: found.supplied,
        step_s: model.scheme.step,
        limit_s: model.step_limit,
    }
}

/// Quantity in a request for each exchanged component, and its unit.
#[derive(Clone, Copy)]
pub(super) struct ExchangedQuantity(&'static str, &'static str);

impl ExchangedQuantity {
    /// Refuses numbers that are not finite, or of another count.
    pub(super) fn admit(
        self,
        window: &Window,
        numbers: &[f64],
        expected: usize,
    ) -> Result<(), FemError> {
        if numbers.len() != expected {
            return Err(FemError::GivenLength {
                window: window.index,
                what: self.0,
                given: numbers.len(),
                expected,
            });
        }
        let at = numbers.iter().position(|number| !number.is_finite());
        at.map_or(Ok(()), |at| {
            Err(FemError::GivenNotFinite {
                window: window.index,
                iteration: window.iteration,
                point: at / 2,
                component: if at % 2 == 0 { 'x' } else { 'y' },
                what: self.0,
                number: numbers[at],
                unit: self.1,
            })
        })
    }
}

pub(super) const FORCE: ExchangedQuantity = ExchangedQuantity("force", "N");

pub(super) const VELOCITY: ExchangedQuantity = ExchangedQuantity("velocity", "m/s");
