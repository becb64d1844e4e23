//! The solver as a participant of a run.
//!
//! In reading order:
//! - [`interface`]: the glued rows that a coupler moves;
//! - [`dem`]: the participant's data, and a step of them;
//! - `forces`, `maps`, `report`, `request`, `checkpoint`: what it reports, writes, answers and keeps.

pub mod dem;
mod forces;
pub mod interface;
mod maps;
mod report;
mod request;

use std::collections::BTreeMap;

use dem_kernel::contact::boundary::CompliantBoundary;
use dem_kernel::step::StepSummary;
use dem_kernel::step::state::GrainState;
use kit::ConfigError;
use protocol::checkpoint::{pack, unpack};
use protocol::{
    BoundaryAnswer, Capabilities, Cause, Description, Node, NodeError, Outcome, Surface, Tolerance,
    Window,
};

use crate::config::solver::OnNotConverged;
use crate::error::DemError;
use crate::measure::flow::Flow;
use crate::measure::{snapshot, wheel_contacts};
use crate::setup::bounds::StepBounds;
use dem::{Dem, Progress};
use request::{refuse_misfit, request, require_numbers};

/// Steps times disks that take some seconds.
const DISK_STEPS: usize = 2_000_000;
/// Disks of a sample whose steps need not be counted.
const FEW_DISKS: usize = 40_000;

/// Most steps of one answer: 27 for the 73 000 disks of the paper's rail, each of which may take a tenth of a second.
fn steps_at_once(disks: usize) -> Option<u32> {
    (disks > FEW_DISKS).then(|| (DISK_STEPS / disks).max(1) as u32)
}

impl Node for Dem {
    fn describe(&self) -> Description {
        let (glued, program) = (self.bodies.boundary_points() > 0, self.program.as_ref());
        Description {
            kind: "dem".into(),
            software: concat!("thirdbody dem-node ", env!("CARGO_PKG_VERSION")).into(),
            capabilities: Capabilities {
                rollback: true,
                compliant_boundary: glued,
                alone: self.time.own_step.is_some(),
                resume: true,
                heat: glued && self.bodies.heat.is_some(),
                ..Capabilities::default()
            },
            step_s: self.time.own_step,
            steps_at_once: steps_at_once(self.bodies.disks()),
            step_limit_s: self.time.bounds.limit(),
            step_limit_name: StepBounds::NAME.into(),
            accuracy_limits: self.time.stiffness.limits(),
            end_s: self.time.end,
            phases: program.map_or_else(Vec::new, |program| program.phases()),
            moments: self.moments.clone(),
            sets: interface::sets(&self.bodies),
            signals: self.signal_names(),
            ledger: self.ledger_terms(),
            warnings: self.warnings.clone(),
            boundary_inertia: glued.then(|| self.boundary_inertia()),
            tolerance: Some(Tolerance {
                key: "solver.tolerance".into(),
                value: self.solver.tolerance,
            }),
            point_mass_kg: interface::masses(&self.bodies, self.time.mass_per_area),
            outward: interface::outward(&self.bodies),
            period_m: interface::periods(&self.bodies),
            smooth_m: self.sample.cut_lines.map_or_else(BTreeMap::new, |lines| {
                interface::smooth(&self.bodies, lines)
            }),
            prepared_sample: self.sample.prepared_sample.clone(),
            ..Description::default()
        }
    }

    fn couple(&mut self, set: &str) -> Result<Surface, NodeError> {
        let mut interface = self.interface.clone();
        let surface = interface.couple(&self.bodies, &self.setting.participant, set)?;
        self.refuse_when_coupled()?;
        self.interface = interface;
        Ok(surface)
    }

    fn select(&mut self, points: &[usize]) -> Result<(), NodeError> {
        if points.iter().copied().eq(0..self.interface.disks.len()) {
            return Ok(());
        }
        Err(NodeError::configuration(format!(
            "all {} glued disks move with the wall, {} of them were selected: select all",
            self.interface.disks.len(),
            points.len()
        )))
    }

    fn set_boundary(&mut self, window_s: f64, compliance: &[f64]) -> Result<(), NodeError> {
        if !(window_s > 0.0 && window_s.is_finite()) {
            return Ok(request(format!(
                "windows of {window_s} s cannot be solved"
            ))?);
        }
        for warning in self.time.bounds.assess(window_s)? {
            if !self.warnings.contains(&warning) {
                self.warnings.push(warning);
            }
        }
        refuse_misfit(self.interface.disks.len(), compliance)?;
        let glued = self.bodies.boundary_points();
        let compliance = self.interface.scatter_square(compliance, glued);
        self.stepper.problem.boundary = CompliantBoundary::compliant(glued, compliance);
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
        let points = self.bodies.boundary_points();
        let free_velocity = self.interface.scatter(free_velocity, points);
        self.trial.clone_from(&self.progress.state);
        let summary = self.advance([window.t0_s, window.t1_s], step, &free_velocity, true)?;
        self.pending = Some((*window, summary));
        let boundary = &self.stepper.problem.boundary;
        let impulse = self.interface.gather(&boundary.impulse);
        Ok(BoundaryAnswer {
            force: impulse.iter().map(|p| p / step).collect(),
            velocity: self.interface.gather(&boundary.velocity),
            iterations: summary.convergence.iterations as u64,
            residual: summary.convergence.residual,
            converged: summary.convergence.converged,
        })
    }

    fn commit(&mut self, window: &Window, displacement: &[f64]) -> Result<Vec<f64>, NodeError> {
        let solved = self
            .pending
            .take_if(|(solved, _)| solved.index == window.index);
        let Some((_, summary)) = solved else {
            return Ok(request(format!(
                "window {} is committed but was not solved",
                window.index
            ))?);
        };
        if displacement.len() != 2 * self.interface.disks.len() {
            return Ok(request(format!(
                "the commit of window {} brings {} displacements for {} glued disks of two components",
                window.index,
                displacement.len(),
                self.interface.disks.len()
            ))?);
        }
        require_numbers("a displacement of a glued disk", window, displacement)?;
        std::mem::swap(&mut self.progress.state, &mut self.trial);
        let bodies = &self.bodies;
        let points = bodies.boundary_points();
        let displacement = self.interface.scatter(displacement, points);
        let state = &mut self.progress.state;
        let glued = state.centres[bodies.free..bodies.first_face()].iter_mut();
        let both = glued.chain(&mut state.surface);
        let both = both.zip(bodies.reference.iter().chain(&bodies.surface.points));
        for ((centre, reference), u) in both.zip(displacement.chunks_exact(2)) {
            *centre = [reference[0] + u[0], reference[1] + u[1]];
        }
        state.worn.lower(&mut state.surface);
        state.carry_surface(bodies);
        self.record(window.t0_s, window.t1_s, &summary);
        Ok(self.report(&summary))
    }

    fn take_temperatures(
        &mut self,
        window: &Window,
        temperature: &[f64],
    ) -> Result<Vec<f64>, NodeError> {
        let bodies = &self.bodies;
        let disks = &self.interface.disks;
        let law = bodies.heat.as_ref();
        let Some(law) = law.filter(|_| temperature.len() == disks.len()) else {
            return Ok(request(format!(
                "window {} brings {} temperatures for {} glued disks, and `heat` must be given",
                window.index,
                temperature.len(),
                disks.len()
            ))?);
        };
        let mut coupled = self.interface.names(bodies);
        if let Some(name) = coupled.find(|name| law.held_by_name(name).is_some()) {
            let why = format!(
                "heat.held_k.{name} or heat.half_spaces.{name} is given, and the interface gives the temperatures of the {name}: remove it"
            );
            return Err(NodeError::of(Cause::ConflictingKeys, why));
        }
        require_numbers("a temperature of a glued disk", window, temperature)?;
        let rises = temperature.iter().map(|kelvins| kelvins - law.start);
        let rises: Vec<f64> = rises.collect();
        let state = &mut self.progress.state;
        self.stepper
            .end_heat(state, bodies)
            .map_err(DemError::Kernel)?;
        Ok(state.heat.exchange(bodies, disks, &rises))
    }

    fn advance_alone(&mut self, window: &Window) -> Result<Vec<f64>, NodeError> {
        let step = self.time.own_step.ok_or_else(|| {
            ConfigError::new(
                "time.step_s",
                "a run without interface needs a step of its own",
            )
            .because(Cause::MissingKey)
        })?;
        if !self.interface.disks.is_empty() {
            return Ok(request("a coupled participant cannot advance alone")?);
        }
        let fixed = vec![0.0; 2 * self.bodies.boundary_points()];
        let mut summary = StepSummary::default();
        for index in window.step..window.step + u64::from(window.substeps) {
            // Times are multiples of the step: no rounding builds up.
            let (start, end) = (index as f64 * step, (index + 1) as f64 * step);
            summary = self.advance([start, end], step, &fixed, false)?;
            let stops = self.solver.on_not_converged == OnNotConverged::Stop;
            if stops && !summary.convergence.converged {
                return Err(NodeError::from(self.not_converged(window, &summary)));
            }
            self.record(start, end, &summary);
        }
        Ok(self.report(&summary))
    }

    /// Packs everything that windows have changed, with the hash of the state: data unpacked into the wrong fields has another hash.
    fn checkpoint(&mut self) -> Result<Vec<u8>, NodeError> {
        pack(&(&self.progress, self.progress.hash()))
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), NodeError> {
        let (progress, hash): (Progress, String) = unpack(state)?;
        let counts = |state: &GrainState| {
            [
                state.centres.len(),
                state.velocities.len(),
                state.glued_velocity.len(),
                state.clusters.len(),
            ]
        };
        let refuse = |why: &str| {
            Err(NodeError::of(
                Cause::CheckpointUnusable,
                format!(
                    "the checkpoint is not of these grains: {why}; resume with the build and the scenario that wrote it"
                ),
            ))
        };
        if counts(&progress.state) != counts(&self.progress.state) {
            return refuse("their number differs");
        }
        let tracked = |progress: &Progress| progress.flow.as_ref().map(Flow::count);
        if tracked(&progress) != tracked(&self.progress) {
            return refuse("its flows belong to other grains");
        }
        if progress.hash() != hash {
            return refuse("the hash of their numbers differs");
        }
        self.progress = progress;
        self.pending = None;
        Ok(())
    }

    fn snapshot(&mut self, name: &str) -> Result<(), NodeError> {
        if let Some(folder) = &self.setting.fields {
            let scene = snapshot::parts::FieldScene {
                bodies: &self.bodies,
                state: &self.progress.state,
                flow: self.progress.flow.as_ref(),
                start: &self.sample.start,
                thickness: self.setting.thickness_m,
            };
            let stem = format!("{}-{name}", self.setting.participant);
            snapshot::write(folder, &stem, &scene)?;
            let traction = wheel_contacts::traction_csv(scene.bodies, scene.state, scene.thickness);
            if let Some(text) = traction.filter(|_| self.bodies.wheel().is_some()) {
                snapshot::write_text(&folder.join(format!("{stem}-profile.csv")), &text)?;
            }
        }
        self.write_maps()?;
        Ok(())
    }

    fn finish(&mut self) -> Result<Outcome, NodeError> {
        self.write_maps()?;
        let state_hash = self.progress.hash();
        self.stepper
            .end_heat(&mut self.progress.state, &self.bodies)
            .map_err(DemError::Kernel)?;
        let (run, iterations) = (self.finished_run(), self.progress.contact_iterations);
        Ok(Outcome {
            steps: self.progress.steps,
            work: BTreeMap::from([("contact_iterations".into(), iterations)]),
            results: self.results(),
            state_hash,
            warnings: self.maps_advice(),
            findings: run.findings(),
            held_load: run.held_load(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_samples_answer_after_few_steps() {
        let steps = [300, 40_000, 73_823, 10_000_000].map(steps_at_once);
        assert_eq!(steps, [None, None, Some(27), Some(1)]);
    }
}
