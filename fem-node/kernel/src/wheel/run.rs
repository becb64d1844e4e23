//! Steps of the wheel with the body.

use super::flat;
use super::newmark::Newmark;
use super::node_contact::NodeContact;
use super::problem::{NodeMotion, WheelStep};
use super::rigid::Wheel;
use super::round::{RoundFace, SWEEPS_MAX};
use super::state::WheelState;
use crate::error::KernelError;
use crate::scheme::{NewmarkScheme, Rule};
use crate::wheel::rolled::rolled_piece;
use crate::wheel::upper_row::UpperRow;
use kit::rolled::RolledPiece;

/// Steps the wheel with the body.
#[derive(Clone, Debug, Default)]
pub struct WheelRun {
    /// Wheel and contact at the end of the last step.
    pub state: WheelState,
    /// Failure of a step; later steps are meaningless.
    pub failed: Option<KernelError>,
    nodes: Vec<NodeMotion>,
    sweeps: RoundFace,
    /// Applied and contact forces on the upper row, x then y components (N).
    pub load: Vec<f64>,
    old: Vec<NodeContact>,
}

impl WheelRun {
    /// Buffers for a wheel at rest.
    pub fn new(wheel: &Wheel) -> WheelRun {
        let still = |point: &[f64; 2]| NodeMotion {
            point: *point,
            ..NodeMotion::default()
        };
        WheelRun {
            state: WheelState::at_rest(wheel),
            nodes: wheel.points.iter().map(still).collect(),
            load: vec![0.0; 2 * wheel.stride],
            old: vec![NodeContact::default(); wheel.points.len()],
            ..WheelRun::default()
        }
    }

    /// Starts from the state at the start of a window.
    pub fn restore(&mut self, start: &WheelState) {
        self.state.clone_from(start);
        self.failed = None;
    }

    /// The contact forces at the start of the run, where v is given: w = h^2/2 M^-1, and
    /// u_free = u + h v + h^2/2 a with the acceleration a without contact.
    pub fn open(&mut self, wheel: &Wheel, row: &UpperRow) {
        let h = wheel.step;
        let weight = 0.5 * h * h;
        let indices = (0..wheel.points.len()).map(|k| [k, wheel.stride + k]);
        for (node, at) in self.nodes.iter_mut().zip(indices) {
            node.now = at.map(|at| row.u[at]);
            node.free = at.map(|at| row.u[at] + h * row.v[at] + weight * row.a[at]);
            node.weight = at.map(|at| weight * row.inverse_mass[at]);
        }
        let state = &mut self.state;
        let drag = wheel.damping_at(state.step) * state.velocity;
        state.acceleration = -wheel.load_at(state.step) / wheel.numbers.mass - drag;
        let free_height = state.height + h * state.velocity + weight * state.acceleration;
        let turn = state.free_turn(wheel, Newmark::new(h, 0.5, 0.0));
        self.solve(wheel, [free_height, weight], turn);
        self.state.acceleration += self.state.force()[1] / wheel.numbers.mass;
        self.state.spin_on(wheel, Newmark::new(h, 0.5, 0.0));
        self.apply(wheel, row.load);
    }

    /// Ends a step: contact forces, motion of the wheel, energies. `row` holds the new u and F(u), the old
    /// v and a.
    pub(crate) fn close(&mut self, wheel: &Wheel, rule: &Rule, row: &UpperRow) {
        let scheme = &rule.scheme;
        let (h, b) = (scheme.step, scheme.damping);
        let before = self.state.step;
        let rates = [self.state.velocity, self.state.acceleration];
        let sunk = h * rates[0] + 0.5 * h * h * rates[1];
        let spin = self.state.spin;
        let free_turn = h * spin[0] + 0.5 * h * h * spin[1];
        let turned = wheel.turn_over(before).unwrap_or(free_turn);
        self.state.step += 1;
        self.state.height += sunk;
        self.old.copy_from_slice(&self.state.contacts);

        let body = Newmark::new(h, b, rule.damping.end);
        let indices = (0..wheel.points.len()).map(|k| [k, wheel.stride + k]);
        for (node, at) in self.nodes.iter_mut().zip(indices) {
            node.now = at.map(|at| row.u[at]);
            node.free = at.map(|at| {
                let push = row.inverse_mass[at] * (row.load[at] - row.force[at]);
                body.next(row.u[at], [row.v[at], row.a[at]], push)
            });
            node.weight = at.map(|at| body.weight() * row.inverse_mass[at]);
        }
        let own = Newmark::new(h, b, wheel.damping_at(self.state.step));
        let push = -wheel.load_at(self.state.step) / wheel.numbers.mass;
        let free_height = own.next(self.state.height, rates, push);
        let undamped = Newmark::new(h, b, 0.0);
        let turn = self.state.free_turn(wheel, undamped);
        self.solve(wheel, [free_height, own.weight()], turn);
        self.state.spin_on(wheel, undamped);

        let push = push + self.state.force()[1] / wheel.numbers.mass;
        [self.state.velocity, self.state.acceleration] = own.rates(rates, push);
        let lateral = wheel.lateral_at(self.state.step) - wheel.lateral_at(before);
        let moved = StepMotion {
            wheel: [lateral, sunk],
            turned,
            rates,
            spin,
            row,
        };
        let slid = self.state.energies.friction;
        let drive_work = self.add_energies(wheel, scheme, &moved);
        self.record_rolling(wheel, turned, self.state.energies.friction - slid);
        let state = &mut self.state;
        state
            .statistics
            .record(wheel, &state.contacts, state.step, drive_work);
        let t = state.step as f64 * wheel.step;
        let drift = &mut state.statistics.drift;
        drift.record(&wheel.program, t, state.height);
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
    /// On a round face the path of a node along the face is a chord between two normals, N (du - dX) = r_n dg + remainder: impacts take -r_n dg, with
    /// the gap g. The remainder is numerical. The normals lead by a step, so that it is -(b + 1/2) N V^2 h/R a second for a wheel that rolls.
    ///
    /// A face that turns by R dphi moves by -R dphi t more: friction takes -sum r_t R dphi, which the drive gives. A wheel that spins freely has it
    /// from its kinetic energy, and gives -T R dphi to its brake.
    ///
    /// Returns the work of the drive.
    pub(crate) fn add_energies(
        &mut self,
        wheel: &Wheel,
        scheme: &NewmarkScheme,
        moved: &StepMotion,
    ) -> f64 {
        let (h, b, m) = (scheme.step, scheme.damping, wheel.numbers.mass);
        let mean = |old: f64, new: f64| (1.0 - b) * old + b * new;
        let [mut drive, mut friction, mut impact, mut chords] = [0.0; 4];
        let lowest = [wheel.lateral_at(self.state.step), self.state.height];
        let pairs = self.old.iter().zip(&self.state.contacts).enumerate();
        for (k, (old, new)) in pairs.filter(|(_, (old, new))| old.closed() || new.closed()) {
            let mut passed = [0.0; 2];
            let (before, slid) = (impact, friction);
            for (component, at) in [k, wheel.stride + k].into_iter().enumerate() {
                let du = h * moved.row.v[at] + 0.5 * h * h * moved.row.a[at];
                let apart = du - moved.wheel[component];
                let normal = mean(old.normal[component], new.normal[component]);
                let tangential = mean(old.friction[component], new.friction[component]);
                friction -= tangential * apart;
                impact -= normal * apart;
                passed[component] = apart;
                if component == 0 {
                    drive += (normal + tangential) * moved.wheel[0];
                }
            }
            if wheel.numbers.radius > 0.0 {
                let node = &self.nodes[k];
                let end = [0, 1].map(|c| node.point[c] + node.now[c] - lowest[c]);
                let start = [0, 1].map(|c| end[c] - passed[c]);
                let closed = wheel.gap(start) - wheel.gap(end);
                let taken = mean(old.pressing(), new.pressing()) * closed;
                chords += impact - before - taken;
                impact = before + taken;
            }
            if moved.turned != 0.0 {
                let rolled_off = mean(old.dragging(), new.dragging()) * moved.turned;
                friction -= rolled_off;
                drive -= rolled_off;
            }
            self.state.slid[k] += friction - slid;
        }
        let state = &mut self.state;
        let step = state.step;
        let [velocity, acceleration] = moved.rates;
        let da = state.acceleration - acceleration;
        let sum = state.acceleration + acceleration;
        let [from, to] = [step - 1, step].map(|step| wheel.damping_at(step));
        let drag = mean(from * velocity, to * state.velocity);
        let energies = &mut state.energies;
        energies.load -= mean(wheel.load_at(step - 1), wheel.load_at(step)) * moved.wheel[1];
        energies.drive += drive;
        energies.friction += friction;
        energies.impact += impact;
        energies.numerical += chords;
        energies.mass_damping += drag * m * moved.wheel[1];
        energies.numerical -= 0.25 * b * h * h * m * da * ((2.0 * b - 1.0) * da + sum);
        let brakes = [step - 1, step].map(|step| wheel.spin(step));
        if let [Some([mass, from]), Some([_, to])] = brakes
            && step > wheel.motion_step
        {
            let (da, sum) = (state.spin[1] - moved.spin[1], state.spin[1] + moved.spin[1]);
            let rolled_off = self.old.iter().zip(&state.contacts);
            let rolled_off = rolled_off.map(|(old, new)| mean(old.dragging(), new.dragging()));
            let given = rolled_off.sum::<f64>() - mean(from, to);
            energies.drive += given * moved.turned;
            energies.numerical -= 0.25 * b * h * h * mass * da * ((2.0 * b - 1.0) * da + sum);
        }
        drive
    }

    /// Adds the step, in which the face has turned and slip has dissipated this much (m, J), to the record of a rolling wheel.
    fn record_rolling(&mut self, wheel: &Wheel, turned: f64, dissipated: f64) {
        let Some(rolling) = &wheel.program.rolling else {
            return;
        };
        let [from, to] = [self.state.step - 1, self.state.step].map(|step| wheel.rolled_at(step));
        if to <= from {
            return;
        }
        let (contacts, radius) = (&self.state.contacts, wheel.numbers.radius);
        let piece = rolled_piece(contacts, &wheel.areas, radius, rolling);
        let piece = RolledPiece {
            way: to - from,
            turned: rolling.direction() * turned,
            dissipated,
            ..piece
        };
        self.state.rolled.add(rolling, &piece);
    }

    /// Solves for the contact forces: [free height, weight] of the wheel, and [free turn, weight] of its face.
    fn solve(&mut self, wheel: &Wheel, [free_height, weight]: [f64; 2], turn: [f64; 2]) {
        let step = self.state.step;
        let lateral = [step, step + 1].map(|step| wheel.lateral_at(step));
        let increment = WheelStep {
            height: self.state.height,
            free_height,
            weight: weight / wheel.numbers.mass,
            lateral,
            turn: turn[0],
            turn_weight: turn[1],
            period: wheel.period,
            friction: wheel.friction_at(step),
        };
        let contacts = &mut self.state.contacts;
        if wheel.numbers.radius == 0.0 {
            return flat::solve(&self.nodes, &increment, contacts);
        }
        let solved = self
            .sweeps
            .solve(&self.nodes, wheel.numbers.radius, &increment, contacts);
        if let Err(residual) = solved
            && self.failed.is_none()
        {
            self.failed = Some(KernelError::Contact {
                step,
                time_s: step as f64 * wheel.step,
                sweeps: SWEEPS_MAX,
                residual,
            });
        }
    }

    /// Adds the contact forces to the forces applied on the upper row.
    fn apply(&mut self, wheel: &Wheel, applied: &[f64]) {
        self.load.copy_from_slice(applied);
        for (k, contact) in self.state.contacts.iter().enumerate() {
            for (component, at) in [k, wheel.stride + k].into_iter().enumerate() {
                self.load[at] += contact.normal[component] + contact.friction[component];
            }
        }
    }
}

/// Motion of wheel and upper row over a step.
pub(crate) struct StepMotion<'a> {
    /// Increments of the wheel, sideways and upwards (m).
    wheel: [f64; 2],
    /// Length of the face that has rolled off, towards +x (m).
    turned: f64,
    /// Velocity and acceleration of the wheel at the start of the step.
    rates: [f64; 2],
    /// Velocity and acceleration of a face that spins freely, at the start of the step.
    spin: [f64; 2],
    row: &'a UpperRow<'a>,
}
