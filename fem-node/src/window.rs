//! One coupling window: m steps from the committed state under a constant interface force.

use crate::boundary::Traction;
use crate::element::Body;
use crate::follow::Ramp;
use crate::integrate::{Damping, Integrator, Load, RowSums, State, UpperRow};
use crate::ledger::Ledger;
use crate::model::Model;
use crate::probe::{self, Held};
use crate::wheel::{WheelRun, WheelState};

/// Steps between two looks at the kinetic energy: a look costs a tenth of a step.
const LOOK_EVERY: u64 = 20;

/// Kinetic energy over all energy that was supplied, from which on a run has diverged. The scheme never lets the kinetic
/// energy of a stable run beyond what was supplied: W - dU - dK - D is the numerical loss, and that can be negative only
/// by the (b h^2/4) d(a M a) of a force that sets in: one look may see that, two in a row do not. 1 % beyond the stability
/// limit the energy of the fastest mode grows 1.3 to 1.7-fold in a step.
const OVERDRAWN: f64 = 10.0;

/// A body that moves with more energy than it was given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Overdraft {
    /// Own steps since the start of the run.
    pub(crate) step: u64,
    /// Kinetic energy (J).
    pub(crate) kinetic: f64,
    /// Work of all forces and what was stored at the start (J).
    pub(crate) supplied: f64,
}

/// What a window is run under.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Request {
    /// Own steps since the start of the run.
    pub(crate) start: u64,
    /// Own steps to do.
    pub(crate) substeps: u32,
    /// Interface force by component (N), held constant.
    pub(crate) interface: Vec<(usize, f64)>,
    /// Velocity by component (m/s) that is reached at the end of the window, in a straight line.
    pub(crate) follow: Vec<(usize, f64)>,
}

/// The state that a window leads to, kept apart from the committed one until it is accepted.
#[derive(Clone, Debug)]
pub(crate) struct WindowRun {
    /// The state at the end of the window.
    pub(crate) state: State,
    /// The wheel at the end of the window.
    pub(crate) wheel: Option<WheelRun>,
    /// Results of the moment before the wheel starts to move sideways, if it lies in the window.
    pub(crate) held: Option<Held>,
    /// Where the run was found to have diverged; the steps after it were not done.
    pub(crate) overdraft: Option<Overdraft>,
    /// The last look that saw too much.
    suspect: Option<u64>,
    /// Strain energy at the start of the run (J).
    start_strain: f64,
    /// Kinetic energy at the start of the run (J).
    start_kinetic: f64,
    /// The most that was supplied so far: what comes back is not forgotten (J).
    supplied: f64,
    load: Load,
    sums: Vec<RowSums>,
    applied_work: f64,
    drive_work: f64,
    /// Of a window along a given velocity.
    ramp: Option<Ramp>,
    /// a M a at the start of the window, under its own force (W).
    start_product: f64,
}

impl WindowRun {
    /// For a run that begins in this state.
    pub(crate) fn new(model: &Model, start: &State) -> WindowRun {
        let body = &model.body;
        WindowRun {
            start_strain: strain_energy(start),
            start_kinetic: 0.5 * inertia_product(body, &start.v),
            supplied: 0.0,
            overdraft: None,
            suspect: None,
            wheel: model.wheel.as_ref().map(WheelRun::new),
            held: None,
            state: State::at_rest_under(body, model.law.as_ref()),
            load: Load::none(body),
            sums: vec![RowSums::default(); body.layout().node_rows()],
            applied_work: 0.0,
            drive_work: 0.0,
            ramp: None,
            start_product: 0.0,
        }
    }

    /// Runs the window from `committed`, whose ledger is `before`.
    pub(crate) fn run(
        &mut self,
        model: &Model,
        integrator: &mut Integrator,
        committed: (&State, Option<&WheelState>),
        before: &Ledger,
        request: &Request,
    ) {
        self.overdraft = None;
        self.sums.fill(RowSums::default());
        self.applied_work = 0.0;
        self.drive_work = 0.0;
        self.held = None;
        self.begin(model, committed, request);
        let window_s = model.scheme.step * f64::from(request.substeps);
        let follows = !request.follow.is_empty();
        self.ramp =
            follows.then(|| Ramp::start(&model.body, &mut self.state, &request.follow, window_s));
        self.start_product = inertia_product(&model.body, &self.state.a);
        self.hold(model, request.start);
        let displacements = |state: &State| {
            let forces = model.tractions.iter().flat_map(|traction| &traction.forces);
            forces
                .map(|(index, _)| state.u[*index])
                .collect::<Vec<f64>>()
        };
        let mut last = displacements(&self.state);
        for k in 0..request.substeps {
            let step = request.start + u64::from(k);
            let reactions = self.drive(model, step);
            self.set_load(model, request, k + 1);
            integrator.damping = Damping {
                start: model.damping_at(step),
                end: model.damping_at(step + 1),
            };
            let wheel = model.wheel.as_ref().zip(self.wheel.as_mut());
            integrator.step(
                &model.body,
                &mut self.state,
                &self.load,
                &mut self.sums,
                wheel,
            );
            if let Some(ramp) = &mut self.ramp {
                let share = f64::from(k + 1) / f64::from(request.substeps);
                let (state, sums) = (&mut self.state, &mut self.sums[0]);
                ramp.step(&model.body, &integrator.rule(), state, sums, share);
            }
            self.drive_work += self.driven(model, step, &reactions);
            let after = displacements(&self.state);
            self.applied_work += applied_work(model, step, &last, &after);
            last = after;
            self.hold(model, step + 1);
            if (step + 1).is_multiple_of(LOOK_EVERY) || k + 1 == request.substeps {
                self.look(model, (committed.0, before), request, step + 1);
            }
            if self.overdraft.is_some() {
                return;
            }
        }
    }

    /// Compares the kinetic energy with all energy that was supplied up to the end of `step`.
    fn look(
        &mut self,
        model: &Model,
        (start, before): (&State, &Ledger),
        request: &Request,
        step: u64,
    ) {
        let moved = |index: usize| self.state.u[index] - start.u[index];
        let forces = request.interface.iter();
        let interface: f64 = forces.map(|(index, force)| force * moved(*index)).sum();
        let followed = self.ramp.as_ref().map_or(0.0, Ramp::total_work);
        let wheel = self.wheel.as_ref().map_or(0.0, |run| {
            run.state.energies.load + run.state.energies.drive
        });
        let body = before.interface_work + before.applied_work + before.drive_work;
        let work = body + interface + followed + self.applied_work + self.drive_work + wheel;
        self.supplied = self.supplied.max(work);
        let supplied = self.supplied + self.start_strain + self.start_kinetic;
        let kinetic = 0.5 * inertia_product(&model.body, &self.state.v);
        if kinetic <= OVERDRAWN * supplied {
            self.suspect = None;
            return;
        }
        let again = self.suspect.is_some_and(|before| before < step);
        // A number that is none needs no second look.
        if again || !kinetic.is_finite() {
            self.overdraft = Some(Overdraft {
                step,
                kinetic,
                supplied,
            });
        }
        self.suspect = self.suspect.filter(|before| *before < step).or(Some(step));
    }

    /// The committed state under the forces of the window. Interface forces jump from one window to the next, so that
    /// the accelerations are computed anew; those of the wheel do not, except from nothing at the start of a run that
    /// does not begin in equilibrium.
    fn begin(
        &mut self,
        model: &Model,
        (state, wheel): (&State, Option<&WheelState>),
        request: &Request,
    ) {
        self.set_load(model, request, 0);
        let damping = model.damping_at(request.start);
        let (Some(run), Some(wheel)) = (&mut self.wheel, wheel) else {
            self.state.restore(state);
            self.state.accelerate(&model.body, damping, &self.load);
            return;
        };
        run.restore(wheel);
        self.state.resume(state);
        if request.start == 0 && !wheel.touches_body() {
            self.open(model, damping);
        }
    }

    /// The contact forces at the start of the run, and the accelerations under them.
    fn open(&mut self, model: &Model, damping: f64) {
        let (Some(wheel), Some(run)) = (&model.wheel, &mut self.wheel) else {
            return;
        };
        let (body, state) = (&model.body, &mut self.state);
        state.accelerate(body, damping, &self.load);
        let upper = body.layout().row(0);
        let row = UpperRow {
            u: &state.u[upper.clone()],
            v: &state.v[upper.clone()],
            a: &state.a[upper.clone()],
            force: &state.force[upper.clone()],
            load: self.load.upper_row(),
            inverse_mass: &body.inverse_mass[upper.clone()],
        };
        run.open(wheel, &row);
        let pushes = run.load().iter().zip(self.load.upper_row());
        for ((a, w), (all, applied)) in state.a[upper.clone()]
            .iter_mut()
            .zip(&body.inverse_mass[upper])
            .zip(pushes)
        {
            *a += w * (all - applied);
        }
        body.layout().spread(&mut state.a[body.layout().row(0)]);
    }

    /// Takes note of the state at the end of `step` if the wheel moves sideways from then on.
    fn hold(&mut self, model: &Model, step: u64) {
        let (Some(wheel), Some(run)) = (&model.wheel, &self.wheel) else {
            return;
        };
        if step == wheel.motion_step() {
            self.held = Some(probe::held(model, &self.state, (wheel, &run.state)));
        }
    }

    /// The ledger at the end of the window, given that of its start.
    pub(crate) fn close(
        &self,
        model: &Model,
        committed: (&State, &Ledger),
        request: &Request,
    ) -> Ledger {
        let (start, before) = committed;
        let (b, h) = (model.scheme.damping, model.scheme.step);
        let sum = |term: fn(&RowSums) -> f64| self.sums.iter().map(term).sum::<f64>();
        let plastic = sum(|row| row.plastic);
        let interface = request.interface.iter();
        let work = interface.map(|(index, force)| force * (self.state.u[*index] - start.u[*index]));
        let d_product = inertia_product(&model.body, &self.state.a) - self.start_product;
        let loss = (b - 0.5) * sum(|row| row.rotation) - 0.25 * b * h * h * d_product;
        let wheel = self.wheel.as_ref().map(|run| &run.state);
        let energies = wheel.map_or(Default::default(), |wheel| wheel.energies);
        let kinetic = model.wheel.as_ref().zip(wheel);
        let State { u, history, .. } = &self.state;
        let beyond = |law| model.body.energy_beyond(law, u, history);
        let beyond = model.law.as_ref().map_or(0.0, beyond);
        Ledger {
            interface_work: before.interface_work
                + work.sum::<f64>()
                + self.ramp.as_ref().map_or(0.0, Ramp::total_work),
            applied_work: before.applied_work + self.applied_work,
            strain: strain_energy(&self.state) + beyond - self.start_strain,
            kinetic: 0.5 * inertia_product(&model.body, &self.state.v),
            mass_damping: before.mass_damping + sum(|row| row.damping),
            stiffness_damping: before.stiffness_damping + sum(|row| row.resistance),
            numerical: before.numerical + loss,
            wheel: energies,
            wheel_kinetic: kinetic.map_or(0.0, |(wheel, state)| state.kinetic(wheel)),
            drive_work: before.drive_work + self.drive_work,
            plastic: before.plastic + plastic,
        }
    }

    /// Sets the rates that take the prescribed components where they are at the end of the step that begins at
    /// `step`. Returns what the drives exert on them now (N).
    fn drive(&mut self, model: &Model, step: u64) -> Vec<f64> {
        let h = model.scheme.step;
        for drive in &model.drives {
            let place = drive.place((step + 1) as f64 * h);
            for (index, value) in &drive.components {
                self.state.v[*index] = (place * value - self.state.u[*index]) / h;
                self.state.a[*index] = 0.0;
            }
        }
        self.reactions(model)
    }

    /// Work of the drives over the step that began at `step`; the components take on their velocities after it.
    fn driven(&mut self, model: &Model, step: u64, before: &[f64]) -> f64 {
        let (b, h) = (model.scheme.damping, model.scheme.step);
        let after = self.reactions(model);
        let mut reactions = before.iter().zip(&after);
        let mut work = 0.0;
        for drive in &model.drives {
            let [start, end] = [step, step + 1].map(|step| step as f64 * h);
            let (moved, speed) = (drive.place(end) - drive.place(start), drive.speed(end));
            for (index, value) in &drive.components {
                let (old, new) = reactions.next().expect("one for each component");
                work += ((1.0 - b) * old + b * new) * moved * value;
                self.state.v[*index] = speed * value;
                self.state.a[*index] = 0.0;
            }
        }
        work
    }

    /// F(u) + d - f in the prescribed components, drive after drive (N).
    fn reactions(&self, model: &Model) -> Vec<f64> {
        let components = model.drives.iter().flat_map(|drive| &drive.components);
        components
            .map(|(index, _)| {
                let resistance = self.state.resistance.get(*index).unwrap_or(&0.0);
                self.state.force[*index] + resistance - self.load.at(*index)
            })
            .collect()
    }

    /// Of a window along a given velocity: the forces (N) on its components at the end, and their works (J).
    pub(crate) fn reaction(&self) -> Option<(&[f64], &[f64])> {
        let ramp = self.ramp.as_ref()?;
        Some((&ramp.force, &ramp.work))
    }

    /// The displacement that is farthest from zero, not a number if any is not.
    pub(crate) fn largest_displacement(&self) -> f64 {
        let farther = |far: f64, u: &f64| match far.is_nan() || u.abs() <= far {
            true => far,
            false => u.abs(),
        };
        self.state.u.iter().fold(0.0, farther)
    }

    /// Interface force and tractions at the end of step `k` of the window, k = 0 being its start.
    fn set_load(&mut self, model: &Model, request: &Request, k: u32) {
        let time = |step: u64| step as f64 * model.scheme.step;
        let now = request.start + u64::from(k);
        let share = |traction: &Traction, step: u64| traction.share(time(step));
        let same = |t: &Traction| share(t, now) == share(t, now - 1);
        if k > 0 && model.tractions.iter().all(same) {
            return;
        }
        self.load.clear();
        for (index, force) in &request.interface {
            self.load.add(*index, *force);
        }
        for traction in &model.tractions {
            let share = share(traction, now);
            for (index, force) in &traction.forces {
                self.load.add(*index, share * force);
            }
        }
    }
}

/// [(1-b) f + b f'] du of the tractions over the step that begins at `step`.
fn applied_work(model: &Model, step: u64, before: &[f64], after: &[f64]) -> f64 {
    let (b, h) = (model.scheme.damping, model.scheme.step);
    let mut increments = before.iter().zip(after).map(|(old, new)| new - old);
    let of_traction = |traction: &Traction| {
        let start = traction.share(step as f64 * h);
        let end = traction.share((step + 1) as f64 * h);
        let full: f64 = traction
            .forces
            .iter()
            .zip(&mut increments)
            .map(|((_, force), du)| force * du)
            .sum();
        ((1.0 - b) * start + b * end) * full
    };
    model.tractions.iter().map(of_traction).sum()
}

/// x M x
fn inertia_product(body: &Body, x: &[f64]) -> f64 {
    body.mass.iter().zip(x).map(|(m, x)| m * x * x).sum()
}

/// u F(u) / 2, exact for linear elasticity.
fn strain_energy(state: &State) -> f64 {
    0.5 * dot(&state.u, &state.force)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
