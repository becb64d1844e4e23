//! The body's own rigid wheel: vertical motion under its load, prescribed sideways motion, contact with the upper
//! edge, all in the step of the body.
//!
//! At t_n the internal forces are known and the contact forces r_n are not. They follow from what they must bring
//! about one step later (forward-increment Lagrange multipliers: Carpenter, Taylor, Katona 1991; the paper's eqs
//! 11-15, corrected). With the scheme of [`crate::integrate`], c the mass damping,
//!
//! ```text
//! u_free = u_n + h v_free + h^2/2 a_free            v_free, a_free: v_n and a_n without contact forces
//! w      = h^2 (b + 1/2) M^-1 / (1 + b h c)         what a force at t_n moves until t_n+1
//! g(u_free) + (H* w H) r >= 0,  r >= 0, complementary;  Coulomb's law on the slip from t_n to t_n+1
//! ```
//!
//! The factor is h^2 (b+1/2) and not h^2 because the force enters u_n+1 both through a_n and through v_n. With h^2
//! the pressures stay right, but every node slides for ever and friction carries next to nothing.

mod contact;
mod flat;
mod journal;
mod program;
mod round;
#[cfg(test)]
mod tests;

use serde::{Deserialize, Serialize};

use crate::config::{ContactConfig, WheelConfig};
use crate::element::Body;
use crate::error::FemError;
use crate::integrate::{Damping, Scheme, UpperRow};
use crate::mesh::{Edge, Mesh};

pub(crate) use contact::{Status, Touch};
pub(crate) use journal::{Journal, SIGNALS};
pub use program::Program;

use contact::{Increment, Problem};

/// What does not change about the wheel during a run.
#[derive(Clone, Debug)]
pub struct Wheel {
    /// Load and motion over time.
    pub program: Program,
    mass: f64,
    /// Of the face (m); 0 = flat.
    radius: f64,
    friction: f64,
    friction_while_loading: bool,
    start_damping: f64,
    /// Positions of the nodes of the upper edge (m).
    points: Vec<[f64; 2]>,
    /// Where y components begin in a row of nodes.
    stride: usize,
    /// Lowest point of the face when it just touches the undeformed body (m).
    first_height: f64,
    /// The last step that ends before the sideways motion starts.
    motion_step: u64,
    step: f64,
}

impl Wheel {
    /// The wheel of a scenario, touching the undeformed body.
    pub fn new(
        (config, contact): (&WheelConfig, &ContactConfig),
        (mesh, body): (&Mesh, &Body),
        step: f64,
        start_damping: f64,
    ) -> Wheel {
        let (nodes, _) = mesh.surface(Edge::Top);
        let points: Vec<[f64; 2]> = nodes.iter().map(|n| mesh.point(n[0], n[1])).collect();
        let program = Program::new(config);
        Wheel {
            mass: config.mass_kg,
            radius: config.radius_m,
            friction: contact.friction,
            friction_while_loading: contact.friction_while_loading,
            start_damping,
            first_height: contact::first_height(config.radius_m, &points),
            points,
            stride: body.layout().stride(),
            // The margin keeps a start that is a multiple of the step up to rounding from moving by one step.
            motion_step: (program.motion_start() / step + 1e-6) as u64,
            program,
            step,
        }
    }

    /// The last step that ends before the sideways motion starts.
    pub(crate) fn motion_step(&self) -> u64 {
        self.motion_step
    }

    /// Mass damping that is added at the end of a step (1/s).
    pub(crate) fn damping_at(&self, step: u64) -> f64 {
        match step <= self.motion_step {
            true => self.start_damping,
            false => 0.0,
        }
    }

    fn friction_at(&self, step: u64) -> f64 {
        match self.friction_while_loading || step >= self.motion_step {
            true => self.friction,
            false => 0.0,
        }
    }

    fn load_at(&self, step: u64) -> f64 {
        self.program.load_at(step as f64 * self.step)
    }

    fn drive_at(&self, step: u64) -> f64 {
        self.program.drive_at(step as f64 * self.step)
    }
}

/// Cumulative energies of the wheel and its contact since the start (J); the formulas stand where they are
/// added.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Energies {
    /// Work of the load.
    pub load: f64,
    /// Work of the sideways drive.
    pub drive: f64,
    /// Dissipated by friction.
    pub friction: f64,
    /// Dissipated where nodes close and open.
    pub impact: f64,
    /// Dissipated by the damping of the start phase, the wheel's part.
    pub mass_damping: f64,
    /// Dissipated by the scheme, the wheel's part.
    pub numerical: f64,
}

/// Everything about the wheel that a step changes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct WheelState {
    /// Lowest point of the face (m).
    pub(crate) height: f64,
    /// Upwards (m/s).
    pub(crate) velocity: f64,
    /// Upwards (m/s2).
    pub(crate) acceleration: f64,
    /// Contact of each node of the upper edge.
    pub(crate) touches: Vec<Touch>,
    pub(crate) energies: Energies,
    pub(crate) journal: Journal,
    /// Own steps since the start.
    step: u64,
}

impl WheelState {
    pub(crate) fn at_rest(wheel: &Wheel) -> WheelState {
        WheelState {
            height: wheel.first_height,
            velocity: 0.0,
            acceleration: 0.0,
            touches: vec![Touch::default(); wheel.points.len()],
            energies: Energies::default(),
            journal: Journal::default(),
            step: 0,
        }
    }

    /// Resting on a body in equilibrium, by this much below the place where it first touched (m).
    pub(crate) fn resting(wheel: &Wheel, approach: f64, touches: Vec<Touch>) -> WheelState {
        WheelState {
            height: wheel.first_height - approach,
            touches,
            ..WheelState::at_rest(wheel)
        }
    }

    /// Whether it touches anything.
    pub(crate) fn touches_body(&self) -> bool {
        self.touches.iter().any(Touch::closed)
    }

    pub(crate) fn kinetic(&self, wheel: &Wheel) -> f64 {
        0.5 * wheel.mass * self.velocity * self.velocity
    }

    /// Force of the body on the wheel (N).
    pub(crate) fn force(&self) -> [f64; 2] {
        contact::on_wheel(&self.touches)
    }

    /// How far the wheel has sunk since it touched the body (m).
    pub(crate) fn approach(&self, wheel: &Wheel) -> f64 {
        wheel.first_height - self.height
    }

    /// The values of [`SIGNALS`].
    pub(crate) fn signals(&self, wheel: &Wheel) -> [f64; SIGNALS.len()] {
        let t = self.step as f64 * wheel.step;
        let [ft, fn_] = self.force();
        let count = contact::count(&self.touches);
        [
            wheel.program.drive_at(t),
            self.height,
            wheel.program.speed_at(t),
            fn_,
            ft,
            count.sliding_pct(),
            count.closed() as f64,
        ]
    }

    /// Every number that can change a later bit.
    pub(crate) fn numbers(&self) -> Vec<f64> {
        let e = &self.energies;
        let mut numbers = vec![self.height, self.velocity, self.acceleration];
        numbers.extend([
            e.load,
            e.drive,
            e.friction,
            e.impact,
            e.mass_damping,
            e.numerical,
        ]);
        for touch in &self.touches {
            numbers.extend(touch.normal);
            numbers.extend(touch.friction);
        }
        numbers
    }
}

/// Steps the wheel along with the body.
#[derive(Clone, Debug)]
pub(crate) struct WheelRun {
    pub(crate) state: WheelState,
    /// What went wrong in a step; the steps after it mean nothing.
    pub(crate) failed: Option<FemError>,
    problem: Problem,
    /// All forces on the upper row, x then y components (N).
    load: Vec<f64>,
    old: Vec<Touch>,
}

impl WheelRun {
    pub(crate) fn new(wheel: &Wheel) -> WheelRun {
        WheelRun {
            state: WheelState::at_rest(wheel),
            failed: None,
            problem: Problem::new(&wheel.points),
            load: vec![0.0; 2 * wheel.stride],
            old: vec![Touch::default(); wheel.points.len()],
        }
    }

    /// Starts from the state at the start of a window.
    pub(crate) fn restore(&mut self, start: &WheelState) {
        self.state.clone_from(start);
        self.failed = None;
    }

    /// Forces on the upper row, those of the contact included (N).
    pub(crate) fn load(&self) -> &[f64] {
        &self.load
    }

    /// The contact forces at the start of the run, where v is given: w = h^2/2 M^-1, and
    /// u_free = u + h v + h^2/2 a with the acceleration a without contact.
    pub(crate) fn open(&mut self, wheel: &Wheel, row: &UpperRow) {
        let h = wheel.step;
        let weight = 0.5 * h * h;
        let places = (0..wheel.points.len()).map(|k| [k, wheel.stride + k]);
        for (node, at) in self.problem.nodes.iter_mut().zip(places) {
            node.now = at.map(|at| row.u[at]);
            node.free = at.map(|at| row.u[at] + h * row.v[at] + weight * row.a[at]);
            node.weight = at.map(|at| weight * row.inverse_mass[at]);
        }
        let state = &mut self.state;
        let drag = wheel.damping_at(state.step) * state.velocity;
        state.acceleration = -wheel.load_at(state.step) / wheel.mass - drag;
        let free_height = state.height + h * state.velocity + weight * state.acceleration;
        self.solve(wheel, free_height, weight);
        self.state.acceleration += self.state.force()[1] / wheel.mass;
        self.apply(wheel, row.load);
    }

    /// The end of a step: contact forces, motion of the wheel, energies. `row` holds the new u and F(u), the old
    /// v and a.
    pub(crate) fn close(
        &mut self,
        wheel: &Wheel,
        (scheme, damping): (&Scheme, Damping),
        row: &UpperRow,
    ) {
        let (h, b) = (scheme.step, scheme.damping);
        let (before, rates) = (
            self.state.step,
            [self.state.velocity, self.state.acceleration],
        );
        let sunk = h * rates[0] + 0.5 * h * h * rates[1];
        self.state.step += 1;
        self.state.height += sunk;
        self.old.copy_from_slice(&self.state.touches);

        let body = Newmark::new(h, b, damping.end);
        let places = (0..wheel.points.len()).map(|k| [k, wheel.stride + k]);
        for (node, at) in self.problem.nodes.iter_mut().zip(places) {
            node.now = at.map(|at| row.u[at]);
            node.free = at.map(|at| {
                let push = row.inverse_mass[at] * (row.load[at] - row.force[at]);
                body.next(row.u[at], [row.v[at], row.a[at]], push)
            });
            node.weight = at.map(|at| body.weight() * row.inverse_mass[at]);
        }
        let own = Newmark::new(h, b, wheel.damping_at(self.state.step));
        let push = -wheel.load_at(self.state.step) / wheel.mass;
        let free_height = own.next(self.state.height, rates, push);
        self.solve(wheel, free_height, own.weight());

        let push = push + self.state.force()[1] / wheel.mass;
        [self.state.velocity, self.state.acceleration] = own.rates(rates, push);
        let drive = wheel.drive_at(self.state.step) - wheel.drive_at(before);
        let moved = Moved {
            wheel: [drive, sunk],
            rates,
            row,
        };
        let drive_work = self.add_energies(wheel, scheme, &moved);
        let state = &mut self.state;
        state
            .journal
            .record(wheel, &state.touches, state.step, drive_work);
        self.apply(wheel, row.load);
    }

    /// Energies of the step, f standing for (1-b) f_n + b f_n+1, dX for the motion of the wheel, T and N for the
    /// friction and normal forces on the nodes:
    ///
    /// ```text
    /// load      -F dY                               drive    sum (N + T)_x dD
    /// friction  -sum T (du - dX)                    impact   -sum N (du - dX)
    /// damping   [(1-b) c_n v_n + b c_n+1 v_n+1] m dY
    /// numerical -(b-1/2) b h^2/2 m da^2 - (b h^2/4) m d(a^2)
    /// ```
    ///
    /// Returns the work of the drive.
    fn add_energies(&mut self, wheel: &Wheel, scheme: &Scheme, moved: &Moved) -> f64 {
        let (h, b, m) = (scheme.step, scheme.damping, wheel.mass);
        let mean = |old: f64, new: f64| (1.0 - b) * old + b * new;
        let [mut drive, mut friction, mut impact] = [0.0; 3];
        let pairs = self.old.iter().zip(&self.state.touches).enumerate();
        for (k, (old, new)) in pairs.filter(|(_, (old, new))| old.closed() || new.closed()) {
            for (component, at) in [k, wheel.stride + k].into_iter().enumerate() {
                let du = h * moved.row.v[at] + 0.5 * h * h * moved.row.a[at];
                let apart = du - moved.wheel[component];
                let normal = mean(old.normal[component], new.normal[component]);
                let tangential = mean(old.friction[component], new.friction[component]);
                friction -= tangential * apart;
                impact -= normal * apart;
                if component == 0 {
                    drive += (normal + tangential) * moved.wheel[0];
                }
            }
        }
        let state = &mut self.state;
        let step = state.step;
        let [velocity, acceleration] = moved.rates;
        let (da, sum) = (
            state.acceleration - acceleration,
            state.acceleration + acceleration,
        );
        let drag = mean(
            wheel.damping_at(step - 1) * velocity,
            wheel.damping_at(step) * state.velocity,
        );
        let energies = &mut state.energies;
        energies.load -= mean(wheel.load_at(step - 1), wheel.load_at(step)) * moved.wheel[1];
        energies.drive += drive;
        energies.friction += friction;
        energies.impact += impact;
        energies.mass_damping += drag * m * moved.wheel[1];
        energies.numerical -= 0.25 * b * h * h * m * da * ((2.0 * b - 1.0) * da + sum);
        drive
    }

    fn solve(&mut self, wheel: &Wheel, free_height: f64, weight: f64) {
        let step = self.state.step;
        let drive = [step, step + 1].map(|step| wheel.drive_at(step));
        let increment = Increment {
            height: self.state.height,
            free_height,
            weight: weight / wheel.mass,
            drive,
            friction: wheel.friction_at(step),
        };
        let solved = self
            .problem
            .solve(wheel.radius, &increment, &mut self.state.touches);
        if let Err(unsolved) = solved
            && self.failed.is_none()
        {
            self.failed = Some(FemError::Contact {
                step,
                time_s: step as f64 * wheel.step,
                sweeps: unsolved.sweeps,
                residual: unsolved.residual,
            });
        }
    }

    /// All forces of the upper row: those applied and those of the contact.
    fn apply(&mut self, wheel: &Wheel, applied: &[f64]) {
        self.load.copy_from_slice(applied);
        for (k, touch) in self.state.touches.iter().enumerate() {
            for (component, at) in [k, wheel.stride + k].into_iter().enumerate() {
                self.load[at] += touch.normal[component] + touch.friction[component];
            }
        }
    }
}

/// Motion of wheel and upper row over a step.
struct Moved<'a> {
    wheel: [f64; 2],
    /// Velocity and acceleration of the wheel at the start of the step.
    rates: [f64; 2],
    row: &'a UpperRow<'a>,
}

/// The scheme of [`crate::integrate`] for one component: from the end of a step to that of the next.
#[derive(Clone, Copy)]
struct Newmark {
    h: f64,
    b: f64,
    c: f64,
}

impl Newmark {
    fn new(h: f64, b: f64, c: f64) -> Newmark {
        Newmark { h, b, c }
    }

    /// v' and a' of v and a, `push` being force over mass at the end of the step.
    fn rates(self, [v, a]: [f64; 2], push: f64) -> [f64; 2] {
        let Newmark { h, b, c } = self;
        let undamped = v + h * ((1.0 - b) * a + b * push);
        let a_new = push - c / (1.0 + b * h * c) * undamped;
        [v + h * ((1.0 - b) * a + b * a_new), a_new]
    }

    /// Where the step after this one leads from u', while the force stays as it is.
    fn next(self, u: f64, rates: [f64; 2], push: f64) -> f64 {
        let [v, a] = self.rates(rates, push);
        u + (self.h * v + 0.5 * self.h * self.h * a)
    }

    /// Displacement after the next step for each unit of `push` added.
    fn weight(self) -> f64 {
        let Newmark { h, b, c } = self;
        h * h * (b + 0.5) / (1.0 + b * h * c)
    }
}
