//! The two sides of the bench as participants of the real coupler: an elastic bar that is stepped element by element, and
//! masses on the wall. Spacing, element mass and element stiffness are one.

use nalgebra::{DMatrix, DVector};
use protocol::{
    Backing, Capabilities, Description, Followed, Node, NodeError, Outcome, Surface, WallAnswer,
    Window,
};

use crate::couple::predict::response::{Lead, Response, matrix_power};
use crate::couple::predict::wall::{Masses, Motion, Wall};

/// An elastic bar of unit elements, held at its far end, coupled at the other; explicit steps without damping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bar {
    /// Elements.
    pub elements: usize,
    /// Step (s), 1 being the stability limit.
    pub step_s: f64,
}

/// The end node has the half mass of its one element.
const END_MASS_KG: f64 = 0.5;

/// Displacements (m) and velocities (m/s) of the free nodes.
#[derive(Clone, Debug, PartialEq)]
struct State {
    u: Vec<f64>,
    v: Vec<f64>,
}

impl Bar {
    /// Stability limit of the step (s): omega_max is 2 for unit masses and springs.
    pub const LIMIT_S: f64 = 1.0;

    /// First period (s): omega_1 = 2 sin(pi / (4 n)).
    pub fn first_period_s(&self) -> f64 {
        let angle = std::f64::consts::PI / (4 * self.elements) as f64;
        std::f64::consts::PI / angle.sin()
    }

    /// The window of `substeps` steps as a matrix: one step for each unit state, then squared up.
    pub fn response(&self, substeps: u32) -> Response {
        let n = self.elements;
        let size = 2 * n + 1;
        let mut step = DMatrix::identity(size, size);
        for column in 0..size {
            let unit = |index: usize| if index == column { 1.0 } else { 0.0 };
            let mut state = State {
                u: (0..n).map(unit).collect(),
                v: (n..2 * n).map(unit).collect(),
            };
            self.run(&mut state, unit(2 * n), 1);
            let moved = state.u.iter().chain(&state.v);
            for (row, value) in moved.enumerate() {
                step[(row, column)] = *value;
            }
        }
        let window = matrix_power(&step, substeps);
        let mut place = DVector::zeros(2 * n);
        place[n - 1] = 1.0;
        Response {
            carry: window.view((0, 0), (2 * n, 2 * n)).into_owned(),
            push: window.column(2 * n).rows(0, 2 * n).into_owned(),
            place,
            lead: self.lead(substeps),
        }
    }

    /// The same along a velocity: one step for each unit state and for a unit acceleration of the end.
    fn lead(&self, substeps: u32) -> Lead {
        let n = self.elements;
        let size = 2 * n + 1;
        let mut step = DMatrix::identity(size, size);
        for column in 0..size {
            let unit = |index: usize| if index == column { 1.0 } else { 0.0 };
            let mut state = State {
                u: (0..n).map(unit).collect(),
                v: (n..2 * n).map(unit).collect(),
            };
            self.led(&mut state, unit(2 * n), 1);
            let moved = state.u.iter().chain(&state.v);
            for (row, value) in moved.enumerate() {
                step[(row, column)] = *value;
            }
        }
        let mut pull = DVector::zeros(2 * n);
        pull[n - 1] = 1.0;
        if n > 1 {
            pull[n - 2] = -1.0;
        }
        Lead::new(step, substeps, END_MASS_KG, pull)
    }

    fn accelerations(&self, u: &[f64], force: f64) -> Vec<f64> {
        let n = self.elements;
        (0..n)
            .map(|i| {
                let left = if i > 0 { u[i - 1] } else { 0.0 };
                match i + 1 < n {
                    true => left + u[i + 1] - 2.0 * u[i],
                    false => (left - u[i] + force) / END_MASS_KG,
                }
            })
            .collect()
    }

    /// Steps under a constant force on the end.
    fn run(&self, state: &mut State, force: f64, substeps: u32) {
        self.steps(state, substeps, |u| self.accelerations(u, force));
    }

    /// Steps with a constant acceleration of the end; returns the force that this takes after them (N), and its work (J).
    fn led(&self, state: &mut State, acceleration: f64, substeps: u32) -> (f64, f64) {
        let end = self.elements - 1;
        let (mut force, mut place, mut work) = (0.0, state.u[end], 0.0);
        self.steps(state, substeps, |u| {
            let mut a = self.accelerations(u, 0.0);
            let new = END_MASS_KG * (acceleration - a[end]);
            work += 0.5 * (force + new) * (u[end] - place);
            (force, place) = (new, u[end]);
            a[end] = acceleration;
            a
        });
        (force, work)
    }

    fn steps(
        &self,
        state: &mut State,
        substeps: u32,
        mut accelerations: impl FnMut(&[f64]) -> Vec<f64>,
    ) {
        let h = self.step_s;
        let mut a = accelerations(&state.u);
        for _ in 0..substeps {
            for (u, (v, a)) in state.u.iter_mut().zip(state.v.iter().zip(&a)) {
                *u += h * v + 0.5 * h * h * a;
            }
            let next = accelerations(&state.u);
            for (v, (old, new)) in state.v.iter_mut().zip(a.iter().zip(&next)) {
                *v += 0.5 * h * (old + new);
            }
            a = next;
        }
    }
}

/// The bar as a participant.
pub struct BarNode {
    bar: Bar,
    committed: State,
    trial: State,
}

impl BarNode {
    /// A bar at rest.
    pub fn new(bar: Bar) -> BarNode {
        let rest = State {
            u: vec![0.0; bar.elements],
            v: vec![0.0; bar.elements],
        };
        BarNode {
            bar,
            committed: rest.clone(),
            trial: rest,
        }
    }
}

fn end_of(set: &str, mass_kg: f64) -> Result<Surface, NodeError> {
    match set {
        "end" => Ok(Surface {
            x_m: vec![0.0],
            y_m: vec![0.0],
            mass_kg: vec![mass_kg],
            radius_m: vec![0.0],
            length_m: vec![1.0],
        }),
        other => Err(NodeError::configuration(format!("no set `{other}`"))),
    }
}

impl Node for BarNode {
    fn describe(&self) -> Description {
        Description {
            kind: "bar".into(),
            capabilities: Capabilities {
                checkpoint: true,
                advance: true,
                columns: true,
                follow: true,
                ..Capabilities::default()
            },
            step_s: Some(self.bar.step_s),
            step_limit_s: Some(Bar::LIMIT_S),
            step_limit_name: "stability limit 2/omega_max".into(),
            first_period_s: Some(self.bar.first_period_s()),
            sets: vec!["end".into()],
            ..Description::default()
        }
    }

    fn couple(&mut self, set: &str) -> Result<Surface, NodeError> {
        end_of(set, END_MASS_KG)
    }

    fn select(&mut self, _points: &[usize]) -> Result<(), NodeError> {
        Ok(())
    }

    fn columns(&mut self, substeps: u32) -> Result<Vec<f64>, NodeError> {
        let mut state = BarNode::new(self.bar).committed;
        self.bar.run(&mut state, 1.0, substeps);
        Ok(vec![state.u[self.bar.elements - 1], 0.0, 0.0, 0.0])
    }

    fn advance(&mut self, window: &Window, force: &[f64]) -> Result<Vec<f64>, NodeError> {
        self.trial.clone_from(&self.committed);
        self.bar.run(&mut self.trial, force[0], window.substeps);
        let end = self.bar.elements - 1;
        Ok(vec![self.trial.u[end] - self.committed.u[end], 0.0])
    }

    fn impedance(&mut self, substeps: u32) -> Result<Vec<f64>, NodeError> {
        let mut state = BarNode::new(self.bar).committed;
        let window_s = self.bar.step_s * f64::from(substeps);
        let (force, _) = self.bar.led(&mut state, 1.0 / window_s, substeps);
        Ok(vec![force, 0.0, 0.0, 0.0])
    }

    fn follow(&mut self, window: &Window, velocity: &[f64]) -> Result<Followed, NodeError> {
        self.trial.clone_from(&self.committed);
        let end = self.bar.elements - 1;
        let window_s = self.bar.step_s * f64::from(window.substeps);
        let acceleration = (velocity[0] - self.committed.v[end]) / window_s;
        let (force, work) = self.bar.led(&mut self.trial, acceleration, window.substeps);
        let increment = self.trial.u[end] - self.committed.u[end];
        Ok(Followed {
            force: vec![force, 0.0],
            increment: vec![increment, 0.0],
            work: vec![work, 0.0],
        })
    }

    fn commit(&mut self, _window: &Window, _displacement: &[f64]) -> Result<Vec<f64>, NodeError> {
        self.committed.clone_from(&self.trial);
        Ok(Vec::new())
    }

    fn finish(&mut self) -> Result<Outcome, NodeError> {
        Ok(Outcome::default())
    }
}

/// The masses as a participant; they start with 1 m/s.
pub struct BodyNode {
    backing: Backing,
    window_s: f64,
    compliance: f64,
    place: f64,
    committed: Masses,
    trial: Masses,
}

impl BodyNode {
    /// Masses on their way.
    pub fn new(backing: Backing) -> BodyNode {
        let start = BodyNode::start();
        BodyNode {
            backing,
            window_s: 0.0,
            compliance: 0.0,
            place: 0.0,
            committed: start,
            trial: start,
        }
    }

    /// Both masses with 1 m/s.
    pub fn start() -> Masses {
        Masses {
            glued_velocity: 1.0,
            place: 0.0,
            velocity: 1.0,
        }
    }
}

impl Node for BodyNode {
    fn describe(&self) -> Description {
        Description {
            kind: "body".into(),
            capabilities: Capabilities {
                checkpoint: true,
                compliant_wall: true,
                ..Capabilities::default()
            },
            backing: Some(self.backing),
            sets: vec!["end".into()],
            ..Description::default()
        }
    }

    fn couple(&mut self, set: &str) -> Result<Surface, NodeError> {
        end_of(set, 0.0)
    }

    fn select(&mut self, _points: &[usize]) -> Result<(), NodeError> {
        Ok(())
    }

    fn wall(&mut self, window_s: f64, compliance: &[f64]) -> Result<(), NodeError> {
        (self.window_s, self.compliance) = (window_s, compliance[0]);
        Ok(())
    }

    fn solve(&mut self, _window: &Window, free_velocity: &[f64]) -> Result<WallAnswer, NodeError> {
        let motion = Motion {
            free: free_velocity[0],
            compliance: self.compliance,
        };
        let wall = Wall::new(&self.backing, self.window_s);
        let solved = wall.window(&self.committed, self.place, motion);
        self.trial = solved.masses;
        Ok(WallAnswer {
            force: vec![solved.force, 0.0],
            velocity: vec![solved.masses.glued_velocity, free_velocity[1]],
            iterations: 1,
            residual: 0.0,
            converged: true,
        })
    }

    fn commit(&mut self, _window: &Window, displacement: &[f64]) -> Result<Vec<f64>, NodeError> {
        self.committed = self.trial;
        self.place = displacement[0];
        Ok(Vec::new())
    }

    fn finish(&mut self) -> Result<Outcome, NodeError> {
        Ok(Outcome::default())
    }
}
