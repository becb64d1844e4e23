//! One coupling window: m steps from the committed state under a constant interface force or a prescribed velocity.
//!
//! - `committed`: the accepted state;
//! - `extent`: the part of the body that a window computes, and its input;
//! - `region`: the part that a changed force can have reached;
//! - `start`: the fields at the start of a piece;
//! - `team`: the threads;
//! - `works`: work of the applied forces, reactions;
//! - `piece`, `partition`: a window in pieces, each on its own thread.

pub(crate) mod committed;
pub(crate) mod extent;
mod partition;
mod piece;
mod region;
mod start;
pub(crate) mod team;
pub(crate) mod works;

use fem_kernel::element::layout::Layout;
use fem_kernel::integrate::fields::StepFields;
use fem_kernel::integrate::integrator::Integrator;
use fem_kernel::integrate::region::{Region, RingRecord};
use fem_kernel::integrate::state::NodalState;
use fem_kernel::integrate::tally::{Tally, kinetic_energy};
use fem_kernel::interface::prescribed_velocity::PrescribedVelocity;
use fem_kernel::material::nonlinear::NonlinearLaw;
use fem_kernel::wheel::run::WheelRun;
use fem_kernel::wheel::upper_row::UpperRow;
use protocol::larger;

use crate::interface::window::committed::Committed;
use crate::model::Model;
use crate::model::boundary::Traction;
use crate::model::heat::HeatState;
use crate::output::ledger::Ledger;
use crate::output::probe::{HoldRecord, hold_record};

use extent::{BodyWindow, Extent, WindowInput};
use partition::Partition;
use region::Regions;
use team::Team;
use works::Works;

/// Steps between two checks of the kinetic energy: a check costs a tenth of a step.
const CHECK_EVERY: u64 = 20;

/// Ratio of kinetic to supplied energy above which a run has diverged. The kinetic energy of a stable run never exceeds the supplied energy: W - dU -
/// dK - D is the numerical loss, which only the (b h^2/4) d(a M a) of a force that sets in can make negative. One check may see that, two in a row do
/// not. 1 % above the stability limit the energy of the fastest mode grows 1.3 to 1.7-fold in a step.
pub(crate) const EXCESS: f64 = 10.0;

/// Kinetic energy far above the supplied energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EnergyExcess {
    /// Own steps since the start of the run.
    pub(crate) step: u64,
    /// Kinetic energy (J).
    pub(crate) kinetic: f64,
    /// Work of all forces and the energy stored at the start (J).
    pub(crate) supplied: f64,
}

/// The state at the end of a window, kept apart from the committed state until the window is accepted.
#[derive(Clone, Debug, Default)]
pub(crate) struct WindowRun {
    /// The fields at the end of the window.
    pub(crate) fields: StepFields,
    /// The wheel at the end of the window.
    pub(crate) wheel: Option<WheelRun>,
    /// Temperatures at the end of the window.
    pub(crate) heat: HeatState,
    /// Record of the moment before the wheel starts to move sideways, if it lies in the window.
    pub(crate) hold_record: Option<HoldRecord>,
    /// Energy excess that showed divergence; the window stopped there.
    pub(crate) excess: Option<EnergyExcess>,
    /// Step of the last check with an excess.
    suspected: Option<u64>,
    /// Strain energy at the start of the run (J).
    start_strain: f64,
    /// Kinetic energy at the start of the run (J).
    start_kinetic: f64,
    /// Largest energy supplied so far (J): energy that comes back still counts.
    supplied: f64,
    tally: Tally,
    pub(crate) works: Works,
    regions: Regions,
    record: RingRecord,
    /// Increments in the ring of a region, under a law with history.
    increments: Vec<f64>,
    /// Nodal forces (N) of the thermal stresses, as of [`NodalState::thermal`].
    swelling: [Vec<f64>; 2],
    /// Pieces for the threads.
    pub(crate) partition: Partition,
    pub(crate) velocity: Option<PrescribedVelocity>,
}

impl WindowRun {
    /// For a run that begins in this state.
    pub(crate) fn new(model: &Model, start: &NodalState) -> WindowRun {
        let body = &model.body;
        let at_rest = StepFields::at_rest(body, None, model.dissipates());
        let fields = StepFields {
            state: start.clone(),
            ..at_rest
        };
        let mut tally = Tally::sized(body.layout);
        tally.all(body, &fields);
        let at_start = tally.total();
        WindowRun {
            start_strain: 0.5 * at_start.strain,
            start_kinetic: 0.5 * at_start.kinetic,
            wheel: model.wheel.as_ref().map(WheelRun::new),
            fields,
            tally,
            works: Works::new(model),
            ..WindowRun::default()
        }
    }

    /// Runs the window from the committed state: the whole body, or the part that has changed since the last run of the same window. Uses the threads
    /// of the team where that pays. Returns the number of computed element steps.
    pub(crate) fn run(
        &mut self,
        model: &Model,
        (integrator, team): (&mut Integrator, &Team),
        committed: &mut Committed,
        input: &WindowInput,
    ) -> u64 {
        let extent = &self.regions.extent(model, committed.steps, input);
        let threads = team.pool.current_num_threads();
        let is_cut = self
            .partition
            .takes(model, committed, (input, extent), threads);
        if !is_cut {
            self.partition.catch_up(&mut committed.state);
        }
        let window = BodyWindow {
            model,
            committed,
            input,
        };
        if is_cut {
            (self.excess, self.velocity) = (None, None);
            self.partition.run(team, window, extent, &mut self.tally);
        } else {
            let strips = integrator.strips();
            let mut steps = || self.run_steps(window, integrator, extent);
            // Waking the other threads for a part of the body costs more than they would save.
            let done = if strips > 1 && !extent.is_part() {
                team.pool.install(steps)
            } else {
                steps()
            };
            if done < input.substeps {
                return model.mesh.elements() as u64 * u64::from(done);
            }
        }
        let kinetic = 0.5 * self.tally.total().kinetic;
        let end = window.committed.steps + u64::from(input.substeps);
        self.check_energy(window, end, kinetic);
        match extent {
            Extent::Part(region) => region.element_steps,
            _ => model.mesh.elements() as u64 * u64::from(input.substeps),
        }
    }

    /// Displacement of a component since the start of the window (m), which began in this state.
    pub(crate) fn moved(&self, model: &Model, start: &NodalState, index: usize) -> f64 {
        match self.partition.held() {
            Some(pieces) => pieces.moved(model.body.layout, index),
            None => self.fields.state.u[index] - start.u[index],
        }
    }

    /// Makes the end of the last window the committed state, for a body without wheel. While the state stays in pieces, `state` has only the motion
    /// of some rows of nodes, until [`catch_up`](Partition::catch_up).
    pub(crate) fn accept(&mut self, state: &mut NodalState, rows: &[usize]) {
        if !self.partition.accept(state, rows) {
            // The next window begins with the committed state.
            std::mem::swap(state, &mut self.fields.state);
        }
        self.forget();
    }

    /// Forgets all runs: the committed state comes from elsewhere.
    pub(crate) fn restart(&mut self) {
        self.forget();
        self.partition.forget();
    }

    /// Runs the window or a part, step by step; returns the number of steps done.
    fn run_steps(
        &mut self,
        window: BodyWindow,
        integrator: &mut Integrator,
        extent: &Extent,
    ) -> u32 {
        let (model, input) = (window.model, window.input);
        if let Extent::Part(region) = extent {
            self.begin_part(window, region);
        } else {
            self.begin(window);
        }
        self.works.begin(&self.fields, extent);
        for k in 1..=input.substeps {
            let step = window.committed.steps + u64::from(k) - 1;
            self.step(window, integrator, extent, (k, step));
            self.record_hold(model, step + 1);
            if warms_in_steps(model, input) {
                self.warm((model, input), step + 1, k == input.substeps);
            }
            let checks = !extent.is_part() && k < input.substeps;
            if checks && (step + 1).is_multiple_of(CHECK_EVERY) {
                let kinetic = kinetic_energy(&model.body, &self.fields.state.v);
                self.check_energy(window, step + 1, kinetic);
            }
            if self.excess.is_some() {
                self.regions.forget();
                return k;
            }
        }
        let (body, tally) = (&model.body, &mut self.tally);
        match extent {
            Extent::Part(region) => tally.again(body, &self.fields, &region.blocks),
            _ => tally.all(body, &self.fields),
        }
        input.substeps
    }

    /// Step `k` of the window, the `step`th of the run, over the whole body or a part.
    fn step(
        &mut self,
        window: BodyWindow,
        integrator: &mut Integrator,
        extent: &Extent,
        (k, step): (u32, u64),
    ) {
        let (model, input) = (window.model, window.input);
        let body = &model.body;
        self.works.move_to(model, &mut self.fields.state, step, k);
        self.set_load(model, input, step + 1, false);
        self.swell(model);
        integrator.rule.damping = model.damping_over(step);
        let rows = [0, body.layout.node_rows];
        let wheel = model.wheel.as_ref().zip(self.wheel.as_mut());
        let (fields, record) = (&mut self.fields, &mut self.record);
        match extent {
            Extent::Whole => integrator.step(body, fields, rows, wheel),
            Extent::Recorded(region) => {
                let ring = &region.rings[k as usize - 1];
                record.record_start(ring, &model.scheme, fields);
                integrator.step(body, fields, rows, wheel);
            }
            Extent::Part(region) => {
                let ring = &region.rings[k as usize - 1];
                record.read(ring, fields, &mut self.increments);
                let front = &region.fronts[k as usize - 1];
                let part = (front, self.increments.as_slice());
                integrator.step_part(body, fields, part);
            }
        }
        if let Some(velocity) = &mut self.velocity {
            let share = f64::from(k) / f64::from(input.substeps);
            velocity.step(body, &integrator.rule, fields, share);
        }
        self.works.settle(model, &mut fields.state, step, k);
        if let Extent::Recorded(region) = extent {
            record.record_end(&region.rings[k as usize - 1], fields);
        }
        self.works.add(model, fields, step, k);
    }

    /// Takes the losses up to the end of `step` as heat, and lets it pass every few steps.
    fn warm(&mut self, (model, input): (&Model, &WindowInput), step: u64, last: bool) {
        let Some(heat) = &model.heat else {
            return;
        };
        let run = &mut self.heat;
        let passes = step.is_multiple_of(heat.every);
        if passes || last {
            run.yield_to(heat, &self.fields.dissipated.plastic);
        }
        if passes {
            let time = heat.every as f64 * model.scheme.step;
            match &self.wheel {
                Some(wheel) => run.advance(heat, wheel.state.rubbed(), time),
                None => run.advance(heat, (&[], std::iter::empty()), time),
            }
            model.warm(run, &mut self.fields.state);
            if model.expands() {
                self.swelling[1] = model.thermal_forces(&self.fields.state.thermal[1]);
                self.set_load(model, input, step, true);
            }
        }
    }

    /// Counts the work of the thermal stresses over the coming step, whose increment is known.
    fn swell(&mut self, model: &Model) {
        let (state, [before, now]) = (&mut self.fields.state, &mut self.swelling);
        let b = model.scheme.damping;
        let each = (0..now.len()).map(|k| {
            let force = (1.0 - b) * before[k] + b * now[k];
            force * model.scheme.increment(state.v[k], state.a[k])
        });
        self.works.applied += each.sum::<f64>();
        if before != now {
            before.clone_from(now);
            state.thermal[0] = state.thermal[1].clone();
        }
    }

    #[cfg(test)]
    fn repeats_a_part(&self) -> bool {
        self.regions.is_recorded()
    }

    /// Forgets the last run.
    pub(crate) fn forget(&mut self) {
        self.regions.forget();
    }

    /// Compares the kinetic energy with the energy supplied up to the end of `step`.
    fn check_energy(&mut self, window: BodyWindow, step: u64, kinetic: f64) {
        let before = &window.committed.ledger;
        let wheel = self.wheel.as_ref().map_or(0.0, |run| {
            run.state.energies.load + run.state.energies.drive
        });
        let body = before.interface_work + before.applied_work + before.drive_work;
        let interface = self.force_work(window);
        let own = self.works.applied + self.works.drive;
        let work = body + interface + self.reaction_work() + own;
        self.supplied = larger(self.supplied, work + wheel);
        let supplied = self.supplied + self.start_strain + self.start_kinetic;
        if kinetic <= EXCESS * supplied {
            self.suspected = None;
            return;
        }
        let again = self.suspected.is_some_and(|before| before < step);
        // NaN needs no second check.
        if again || !kinetic.is_finite() {
            self.excess = Some(EnergyExcess {
                step,
                kinetic,
                supplied,
            });
        }
        self.suspected = self.suspected.filter(|_| again).or(Some(step));
    }

    /// Work of the interface force since the start of the window (J).
    fn force_work(&self, window: BodyWindow) -> f64 {
        let (model, start) = (window.model, &window.committed.state);
        let forces = window.input.interface.iter();
        forces
            .map(|(index, force)| force * self.moved(model, start, *index))
            .sum()
    }

    /// Work of the reactions to a prescribed velocity since the start of the window (J).
    fn reaction_work(&self) -> f64 {
        let velocity = self.velocity.as_ref();
        velocity.map_or(0.0, |velocity| velocity.work.iter().sum())
    }

    /// The committed state under the forces of the window. Interface forces jump from one window to the next, so the accelerations are computed anew.
    /// The wheel's forces jump only at the start of a run that does not begin in equilibrium.
    fn begin(&mut self, window: BodyWindow) {
        let BodyWindow {
            model,
            committed,
            input,
        } = window;
        self.partition.is_run = false;
        self.excess = None;
        self.fields.dissipated.clear();
        self.record.clear();
        self.hold_record = None;
        if warms_in_steps(model, input) {
            self.heat.restore(&committed.heat);
        }
        let [before, now] = &committed.state.thermal;
        // Without a wheel the accelerations are computed anew.
        let before = if model.wheel.is_some() { before } else { now };
        self.swelling = [before, now].map(|thermal| model.thermal_forces(thermal));
        self.set_load(model, input, committed.steps, true);
        let damping = model.damping_at(committed.steps);
        if let (Some(run), Some(wheel)) = (&mut self.wheel, &committed.wheel) {
            run.restore(wheel);
            self.fields.state.resume(&committed.state);
            if committed.steps == 0 && !wheel.is_touching() {
                self.open_contact(model, damping);
            }
        } else {
            self.fields.state.restore(&committed.state);
            self.fields.accelerate(&model.body, damping);
        }
        let window_s = model.scheme.step * f64::from(input.substeps);
        let (body, state, ends) = (&model.body, &mut self.fields.state, &input.velocity);
        self.velocity =
            (!ends.is_empty()).then(|| PrescribedVelocity::start(body, state, ends, window_s));
        self.tally.begin(body, &state.a);
        self.record_hold(model, committed.steps);
    }

    /// The start of the window where it differs from the recorded run: on the exchanged nodes and their neighbours.
    fn begin_part(&mut self, window: BodyWindow, region: &Region) {
        let (model, committed) = (window.model, window.committed);
        let (body, damping) = (&model.body, model.damping_at(committed.steps));
        self.record.rewind();
        self.set_load(model, window.input, committed.steps, true);
        region.begin(&mut self.fields, (body, damping), &committed.state);
        let start = (&committed.state, &self.fields.load, damping);
        self.tally.begin_again(body, &region.sources, start);
    }

    /// The contact forces at the start of the run, and the accelerations under them.
    fn open_contact(&mut self, model: &Model, damping: f64) {
        let (Some(wheel), Some(run)) = (&model.wheel, &mut self.wheel) else {
            return;
        };
        let body = &model.body;
        self.fields.accelerate(body, damping);
        let (state, load) = (&mut self.fields.state, self.fields.load.row(0));
        let upper = body.layout.row(0);
        let row = UpperRow {
            u: &state.u[upper.clone()],
            v: &state.v[upper.clone()],
            a: &state.a[upper.clone()],
            force: &state.force[upper.clone()],
            load,
            inverse_mass: &body.inverse_mass[upper.clone()],
        };
        run.open(wheel, &row);
        let accelerations = &mut state.a[upper];
        let forces = run.load.iter().zip(load);
        let nodes = accelerations.iter_mut().zip(&body.inverse_mass);
        for ((a, w), (all, applied)) in nodes.zip(forces) {
            *a += w * (all - applied);
        }
        body.layout.repeat_period(accelerations);
    }

    /// Records the state at the end of `step` if the wheel moves sideways from then on.
    fn record_hold(&mut self, model: &Model, step: u64) {
        let (Some(wheel), Some(run)) = (&model.wheel, &self.wheel) else {
            return;
        };
        if step == wheel.motion_step {
            self.hold_record = Some(hold_record(model, &self.fields.state, wheel, &run.state));
        }
    }

    /// The ledger at the end of the window, from the committed ledger at its start.
    pub(crate) fn close(&self, window: BodyWindow) -> Ledger {
        let (model, before) = (window.model, &window.committed.ledger);
        let (b, h) = (model.scheme.damping, model.scheme.step);
        let sums = self.tally.total();
        let d_product = sums.inertia - self.tally.starts.iter().sum::<f64>();
        let loss = (b - 0.5) * sums.numerical - 0.25 * b * h * h * d_product;
        let wheel = self.wheel.as_ref().map(|run| &run.state);
        let correction = model.law.as_ref();
        let correction = correction.map_or(0.0, |law| self.energy_correction(model, law));
        let interface = before.interface_work + self.force_work(window);
        Ledger {
            interface_work: interface + self.reaction_work(),
            applied_work: before.applied_work + self.works.applied,
            strain: 0.5 * sums.strain + correction - self.start_strain,
            kinetic: 0.5 * sums.kinetic - self.start_kinetic,
            mass_damping: before.mass_damping + sums.mass_damping,
            stiffness_damping: before.stiffness_damping + sums.stiffness_damping,
            numerical: before.numerical + loss,
            wheel: wheel.map_or(Default::default(), |wheel| wheel.energies),
            wheel_kinetic: (model.wheel.as_ref().zip(wheel))
                .map_or(0.0, |(wheel, state)| state.kinetic(wheel)),
            drive_work: before.drive_work + self.works.drive,
            plastic: before.plastic + self.fields.dissipated.plastic.iter().sum::<f64>(),
        }
    }

    /// Stored energy at the end of the window less u F(u) / 2 (J).
    fn energy_correction(&self, model: &Model, law: &NonlinearLaw) -> f64 {
        let (body, state) = (&model.body, &self.fields.state);
        match self.partition.held() {
            // No piece has a law with history.
            Some(pieces) => body.energy_correction(law, &pieces.displacements(body.layout), &[]),
            None => body.energy_correction(law, &state.u, &state.history),
        }
    }

    /// Displacements at the end of the window (m).
    pub(crate) fn displacements(&self, layout: Layout) -> Vec<f64> {
        let held = self.partition.held();
        held.map_or_else(
            || self.fields.state.u.to_vec(),
            |held| held.displacements(layout),
        )
    }

    /// The displacement farthest from zero (m), NaN if any displacement is NaN.
    pub(crate) fn largest_displacement(&self) -> f64 {
        self.tally.total().farthest
    }

    /// Interface force and tractions at the end of a step; at the start of a window from scratch.
    fn set_load(&mut self, model: &Model, input: &WindowInput, step: u64, from_scratch: bool) {
        let factor = |t: &Traction, step: u64| t.factor(step as f64 * model.scheme.step);
        let same = |t: &Traction| factor(t, step) == factor(t, step - 1);
        if !from_scratch && model.tractions.iter().all(same) {
            return;
        }
        let load = &mut self.fields.load;
        load.clear();
        let thermal = self.swelling[1].iter().enumerate();
        for (index, force) in thermal.filter(|(_, force)| **force != 0.0) {
            load.add(index, *force);
        }
        for (index, force) in &input.interface {
            load.add(*index, *force);
        }
        for traction in &model.tractions {
            let factor = factor(traction, step);
            for (index, force) in &traction.forces {
                load.add(*index, factor * force);
            }
        }
    }
}

/// True where the steps of a window heat the body: under its own wheel, or where it yields or expands alone. No such window runs in pieces, or in part.
pub(crate) fn warms_in_steps(model: &Model, input: &WindowInput) -> bool {
    let feels = model.plastic().is_some() || model.expands();
    model.wheel.is_some() || (feels && input.interface.is_empty())
}

#[cfg(test)]
mod tests;
