//! One coupling window: m steps from the committed state under a constant interface force or a prescribed velocity.

use protocol::larger;

use crate::boundary::Traction;
use crate::committed::Committed;
use crate::element::Body;
use crate::integrate::{Damping, Integrator, Load, RowEnergies, State, UpperRow};
use crate::ledger::Ledger;
use crate::model::Model;
use crate::pack::largest;
use crate::prescribed_velocity::PrescribedVelocity;
use crate::probe::{HoldRecord, hold_record};
use crate::wheel::WheelRun;

/// Steps between two checks of the kinetic energy: a check costs a tenth of a step.
const CHECK_EVERY: u64 = 20;

/// Kinetic energy over all energy that was supplied, from which on a run has diverged. The scheme never lets the kinetic
/// energy of a stable run beyond what was supplied: W - dU - dK - D is the numerical loss, and that can be negative only
/// by the (b h^2/4) d(a M a) of a force that sets in: one check may see that, two in a row do not. 1 % beyond the stability
/// limit the energy of the fastest mode grows 1.3 to 1.7-fold in a step.
const EXCESS: f64 = 10.0;

/// Kinetic energy far beyond all energy that was supplied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EnergyExcess {
    /// Own steps since the start of the run.
    pub(crate) step: u64,
    /// Kinetic energy (J).
    pub(crate) kinetic: f64,
    /// Work of all forces and the energy stored at the start (J).
    pub(crate) supplied: f64,
}

/// Boundary data of a window.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct WindowInput {
    /// Own steps to do.
    pub(crate) substeps: u32,
    /// Interface force by component (N), held constant.
    pub(crate) interface: Vec<(usize, f64)>,
    /// Velocity by component (m/s) that is reached at the end of the window, in a straight line.
    pub(crate) velocity: Vec<(usize, f64)>,
}

/// The state that a window leads to, kept apart from the committed one until it is accepted.
#[derive(Clone, Debug, Default)]
pub(crate) struct WindowRun {
    /// The state at the end of the window.
    pub(crate) state: State,
    /// The wheel at the end of the window.
    pub(crate) wheel: Option<WheelRun>,
    /// Record of the moment before the wheel starts to move sideways, if it lies in the window.
    pub(crate) hold_record: Option<HoldRecord>,
    /// Excess by which the run was found to have diverged; the steps after it were not done.
    pub(crate) excess: Option<EnergyExcess>,
    /// Step of the last check that saw too much.
    suspected: Option<u64>,
    /// Strain energy at the start of the run (J).
    start_strain: f64,
    /// Kinetic energy at the start of the run (J).
    start_kinetic: f64,
    /// The most that was supplied so far: energy that comes back still counts (J).
    supplied: f64,
    load: Load,
    energies: Vec<RowEnergies>,
    applied_work: f64,
    drive_work: f64,
    pub(crate) velocity: Option<PrescribedVelocity>,
    /// a M a at the start of the window, under its own force (W).
    start_product: f64,
}

impl WindowRun {
    /// For a run that begins in this state.
    pub(crate) fn new(model: &Model, start: &State) -> WindowRun {
        let body = &model.body;
        WindowRun {
            start_strain: strain_energy(start),
            start_kinetic: kinetic_energy(body, start),
            wheel: model.wheel.as_ref().map(WheelRun::new),
            state: State::at_rest_under(body, model.law.as_ref()),
            load: Load::none(body),
            energies: vec![RowEnergies::default(); body.layout.node_rows],
            ..WindowRun::default()
        }
    }

    /// Runs the window from the committed state.
    pub(crate) fn run(
        &mut self,
        model: &Model,
        integrator: &mut Integrator,
        committed: &Committed,
        input: &WindowInput,
    ) {
        self.begin(model, committed, input);
        let rows = [0, model.body.layout.node_rows];
        let mut last = self.loaded_displacements(model);
        for k in 0..input.substeps {
            let step = committed.steps + u64::from(k);
            let reactions = self.prescribe_motion(model, step);
            self.set_load(model, input, step + 1, false);
            integrator.damping = Damping {
                start: model.damping_at(step),
                end: model.damping_at(step + 1),
            };
            let wheel = model.wheel.as_ref().zip(self.wheel.as_mut());
            let (state, energies) = (&mut self.state, &mut self.energies);
            integrator.step(&model.body, state, &self.load, energies, rows, wheel);
            if let Some(velocity) = &mut self.velocity {
                let share = f64::from(k + 1) / f64::from(input.substeps);
                velocity.step(
                    &model.body,
                    &integrator.rule(),
                    state,
                    &mut energies[0],
                    share,
                );
            }
            self.drive_work += self.work_of_motion(model, step, &reactions);
            let now = self.loaded_displacements(model);
            self.applied_work += applied_work(model, step, &last, &now);
            last = now;
            self.record_hold(model, step + 1);
            if (step + 1).is_multiple_of(CHECK_EVERY) || k + 1 == input.substeps {
                self.check_energy(model, committed, input, step + 1);
            }
            if self.excess.is_some() {
                return;
            }
        }
    }

    /// Compares the kinetic energy with all energy that was supplied up to the end of `step`.
    fn check_energy(
        &mut self,
        model: &Model,
        committed: &Committed,
        input: &WindowInput,
        step: u64,
    ) {
        let before = &committed.ledger;
        let wheel = self.wheel.as_ref().map_or(0.0, |run| {
            run.state.energies.load + run.state.energies.drive
        });
        let body = before.interface_work + before.applied_work + before.drive_work;
        let interface = self.force_work(&committed.state, input);
        let work = body + interface + self.reaction_work() + self.applied_work + self.drive_work;
        self.supplied = larger(self.supplied, work + wheel);
        let supplied = self.supplied + self.start_strain + self.start_kinetic;
        let kinetic = kinetic_energy(&model.body, &self.state);
        if kinetic <= EXCESS * supplied {
            self.suspected = None;
            return;
        }
        let again = self.suspected.is_some_and(|before| before < step);
        // What is not a number needs no second check.
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
    fn force_work(&self, start: &State, input: &WindowInput) -> f64 {
        let forces = input.interface.iter();
        forces
            .map(|(index, force)| force * (self.state.u[*index] - start.u[*index]))
            .sum()
    }

    /// Work of the reactions to a prescribed velocity since the start of the window (J).
    fn reaction_work(&self) -> f64 {
        let velocity = self.velocity.as_ref();
        velocity.map_or(0.0, |velocity| velocity.work.iter().sum())
    }

    /// The committed state under the forces of the window. Interface forces jump from one window to the next, so that
    /// the accelerations are computed anew; those of the wheel do not, except from nothing at the start of a run that
    /// does not begin in equilibrium.
    fn begin(&mut self, model: &Model, committed: &Committed, input: &WindowInput) {
        self.excess = None;
        self.energies.fill(RowEnergies::default());
        self.applied_work = 0.0;
        self.drive_work = 0.0;
        self.hold_record = None;
        self.set_load(model, input, committed.steps, true);
        let damping = model.damping_at(committed.steps);
        if let (Some(run), Some(wheel)) = (&mut self.wheel, &committed.wheel) {
            run.restore(wheel);
            self.state.resume(&committed.state);
            if committed.steps == 0 && !wheel.is_touching() {
                self.open_contact(model, damping);
            }
        } else {
            self.state.restore(&committed.state);
            self.state.accelerate(&model.body, damping, &self.load);
        }
        let window_s = model.scheme.step * f64::from(input.substeps);
        self.velocity = (!input.velocity.is_empty()).then(|| {
            PrescribedVelocity::start(&model.body, &mut self.state, &input.velocity, window_s)
        });
        self.start_product = inertia_product(&model.body, &self.state.a);
        self.record_hold(model, committed.steps);
    }

    /// The contact forces at the start of the run, and the accelerations under them.
    fn open_contact(&mut self, model: &Model, damping: f64) {
        let (Some(wheel), Some(run)) = (&model.wheel, &mut self.wheel) else {
            return;
        };
        let (body, state) = (&model.body, &mut self.state);
        state.accelerate(body, damping, &self.load);
        let upper = body.layout.row(0);
        let row = UpperRow {
            u: &state.u[upper.clone()],
            v: &state.v[upper.clone()],
            a: &state.a[upper.clone()],
            force: &state.force[upper.clone()],
            load: self.load.row(0),
            inverse_mass: &body.inverse_mass[upper.clone()],
        };
        run.open(wheel, &row);
        let accelerations = &mut state.a[upper];
        let forces = run.load().iter().zip(self.load.row(0));
        let nodes = accelerations.iter_mut().zip(&body.inverse_mass);
        for ((a, w), (all, applied)) in nodes.zip(forces) {
            *a += w * (all - applied);
        }
        body.layout.repeat_period(accelerations);
    }

    /// Takes note of the state at the end of `step` if the wheel moves sideways from then on.
    fn record_hold(&mut self, model: &Model, step: u64) {
        let (Some(wheel), Some(run)) = (&model.wheel, &self.wheel) else {
            return;
        };
        if step == wheel.motion_step {
            self.hold_record = Some(hold_record(model, &self.state, wheel, &run.state));
        }
    }

    /// The ledger at the end of the window, given the committed one of its start.
    pub(crate) fn close(
        &self,
        model: &Model,
        committed: &Committed,
        input: &WindowInput,
    ) -> Ledger {
        let before = &committed.ledger;
        let (b, h) = (model.scheme.damping, model.scheme.step);
        let sum = |term: fn(&RowEnergies) -> f64| self.energies.iter().map(term).sum::<f64>();
        let d_product = inertia_product(&model.body, &self.state.a) - self.start_product;
        let loss = (b - 0.5) * sum(|row| row.numerical) - 0.25 * b * h * h * d_product;
        let wheel = self.wheel.as_ref().map(|run| &run.state);
        let State { u, history, .. } = &self.state;
        let correction = |law| model.body.energy_correction(law, u, history);
        let correction = model.law.as_ref().map_or(0.0, correction);
        let interface = before.interface_work + self.force_work(&committed.state, input);
        Ledger {
            interface_work: interface + self.reaction_work(),
            applied_work: before.applied_work + self.applied_work,
            strain: strain_energy(&self.state) + correction - self.start_strain,
            kinetic: kinetic_energy(&model.body, &self.state),
            mass_damping: before.mass_damping + sum(|row| row.mass_damping),
            stiffness_damping: before.stiffness_damping + sum(|row| row.stiffness_damping),
            numerical: before.numerical + loss,
            wheel: wheel.map_or(Default::default(), |wheel| wheel.energies),
            wheel_kinetic: (model.wheel.as_ref().zip(wheel))
                .map_or(0.0, |(wheel, state)| state.kinetic(wheel)),
            drive_work: before.drive_work + self.drive_work,
            plastic: before.plastic + sum(|row| row.plastic),
        }
    }

    /// Sets the rates that take the prescribed components to their displacements at the end of the step that begins at
    /// `step`. Returns the forces of the drives now (N).
    fn prescribe_motion(&mut self, model: &Model, step: u64) -> Vec<f64> {
        let h = model.scheme.step;
        for motion in &model.motions {
            let displacement = motion.displacement((step + 1) as f64 * h);
            for (index, value) in &motion.components {
                self.state.v[*index] = (displacement * value - self.state.u[*index]) / h;
                self.state.a[*index] = 0.0;
            }
        }
        self.drive_forces(model)
    }

    /// Work of the drives over the step that began at `step`, [(1-b) r + b r'] du (J); the components take on their
    /// velocities after it.
    fn work_of_motion(&mut self, model: &Model, step: u64, before: &[f64]) -> f64 {
        let (b, h) = (model.scheme.damping, model.scheme.step);
        let after = self.drive_forces(model);
        let mut reactions = before.iter().zip(&after);
        let mut work = 0.0;
        for motion in &model.motions {
            let [start, end] = [step, step + 1].map(|step| step as f64 * h);
            let moved = motion.displacement(end) - motion.displacement(start);
            let velocity = motion.velocity(end);
            for (index, value) in &motion.components {
                let (old, new) = reactions.next().expect("one for each component");
                work += ((1.0 - b) * old + b * new) * moved * value;
                self.state.v[*index] = velocity * value;
                self.state.a[*index] = 0.0;
            }
        }
        work
    }

    /// r = F(u) + d - f in the prescribed components, motion after motion (N).
    pub(crate) fn drive_forces(&self, model: &Model) -> Vec<f64> {
        let components = model.motions.iter().flat_map(|motion| &motion.components);
        components
            .map(|(index, _)| {
                let damping = self.state.damping_force.get(*index).unwrap_or(&0.0);
                self.state.force[*index] + damping - self.load.at(*index)
            })
            .collect()
    }

    /// Displacements of the components under tractions, traction after traction (m).
    fn loaded_displacements(&self, model: &Model) -> Vec<f64> {
        let forces = model.tractions.iter().flat_map(|traction| &traction.forces);
        forces.map(|(index, _)| self.state.u[*index]).collect()
    }

    /// The displacement that is farthest from zero (m), not a number if any is not.
    pub(crate) fn largest_displacement(&self) -> f64 {
        largest(self.state.u.iter().map(|u| u.abs()))
    }

    /// Interface force and tractions at the end of a step; at the start of a window from scratch.
    fn set_load(&mut self, model: &Model, input: &WindowInput, step: u64, from_scratch: bool) {
        let share = |t: &Traction, step: u64| t.ramp.share(step as f64 * model.scheme.step);
        let same = |t: &Traction| share(t, step) == share(t, step - 1);
        if !from_scratch && model.tractions.iter().all(same) {
            return;
        }
        self.load.clear();
        for (index, force) in &input.interface {
            self.load.add(*index, *force);
        }
        for traction in &model.tractions {
            let share = share(traction, step);
            for (index, force) in &traction.forces {
                self.load.add(*index, share * force);
            }
        }
    }
}

/// [(1-b) f + b f'] du of the tractions over the step that begins at `step` (J).
pub(crate) fn applied_work(model: &Model, step: u64, before: &[f64], after: &[f64]) -> f64 {
    let (b, h) = (model.scheme.damping, model.scheme.step);
    let mut increments = before.iter().zip(after).map(|(old, new)| new - old);
    let of_traction = |traction: &Traction| {
        let [start, end] = [step, step + 1].map(|step| traction.ramp.share(step as f64 * h));
        let products = traction.forces.iter().zip(&mut increments);
        let full: f64 = products.map(|((_, force), du)| force * du).sum();
        ((1.0 - b) * start + b * end) * full
    };
    model.tractions.iter().map(of_traction).sum()
}

/// x M x
fn inertia_product(body: &Body, x: &[f64]) -> f64 {
    body.mass.iter().zip(x).map(|(m, x)| m * x * x).sum()
}

/// v M v / 2 (J)
fn kinetic_energy(body: &Body, state: &State) -> f64 {
    0.5 * inertia_product(body, &state.v)
}

/// u F(u) / 2 (J), exact for linear elasticity.
fn strain_energy(state: &State) -> f64 {
    let products = state.u.iter().zip(&state.force).map(|(u, f)| u * f);
    0.5 * products.sum::<f64>()
}
