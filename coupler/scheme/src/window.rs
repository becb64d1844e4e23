//! The answers of all sides in a window, and the solved window.

use protocol::Window;
use serde::{Deserialize, Serialize};

/// Outcome of an attempt at a window.
#[derive(Clone, Debug)]
pub enum Attempt {
    /// The window is accepted and is the state of all sides.
    Accepted(AcceptedWindow),
    /// The window did not converge, and the scenario wants it halved. No state has changed.
    Halve,
}

/// An accepted window, as the outputs see it.
#[derive(Clone, Debug, Default)]
pub struct AcceptedWindow {
    /// Interfaces of the group by their index in the scenario, with the signals of each.
    pub signals: Vec<(usize, InterfaceSignals)>,
    /// Participants of the group, with the report of each.
    pub reports: Vec<(usize, Vec<f64>)>,
}

/// Signals of an interface in an accepted window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InterfaceSignals {
    /// Repeats beyond the first run.
    pub repeats: u32,
    /// Gap over the mean node spacing.
    pub gap_rel: f64,
    /// Sum of the forces on the continuum's nodes by the answers (N).
    pub force_n: [f64; 2],
    /// The component that presses on the continuum's surface (N).
    pub pressing_n: f64,
}

/// State of a group's interfaces after an accepted window, by component.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InterfaceState {
    /// Motion of the glued points in the window (m), for schemes that use it one window late.
    pub last_motion: Vec<f64>,
    /// Force on the exchanged nodes (N) in the window.
    pub lambda: Vec<f64>,
    /// Velocity of the exchanged nodes (m/s) at its end, if the scheme prescribes it.
    pub velocity: Vec<f64>,
    /// Total displacement of the exchanged nodes (m), as sent to the motion-driven participants.
    pub displacement: Vec<f64>,
}

impl InterfaceState {
    /// At rest and unloaded.
    pub fn at_rest(nodes: usize, points: usize) -> InterfaceState {
        InterfaceState {
            last_motion: vec![0.0; 2 * points],
            lambda: vec![0.0; 2 * nodes],
            velocity: vec![0.0; 2 * nodes],
            displacement: vec![0.0; 2 * nodes],
        }
    }

    /// Length of each vector.
    pub fn lengths(&self) -> [usize; 4] {
        [
            self.last_motion.len(),
            self.lambda.len(),
            self.velocity.len(),
            self.displacement.len(),
        ]
    }
}

/// Answers of all motion-driven participants of a group.
#[derive(Clone, Debug, Default)]
pub struct Answer {
    /// Force F_g of the grains on the boundary at each glued point (N).
    pub force: Vec<f64>,
    /// Velocity v_g of each glued point at the end of the window (m/s).
    pub velocity: Vec<f64>,
    /// Quality of the contact solve of each participant.
    pub solves: Vec<Solve>,
}

/// Quality of a contact solve.
#[derive(Clone, Copy, Debug)]
pub struct Solve {
    /// Iterations of the contact solver.
    pub iterations: u64,
    /// True residual, relative.
    pub residual: f64,
    /// True if the residual is within the solver's own tolerance.
    pub converged: bool,
}

/// A window that all sides may make their state.
#[derive(Clone, Debug)]
pub struct SolvedWindow {
    /// The window with its last repeat.
    pub window: Window,
    /// Increments of the nodes (m), as sent to the motion-driven participants.
    pub increment: Vec<f64>,
    /// Increments of the force-driven participants under the forces of the others (m); equal to `increment` if they ran
    /// under these forces.
    pub wanted: Vec<f64>,
    /// Force that the force-driven participants bore (N): the constant force of their window or, along a prescribed
    /// velocity, their own force at its end. It differs from `lambda` in schemes that use the answers late.
    pub borne: Vec<f64>,
    /// Work of that force on them by component (J), over the whole window.
    pub work: Vec<f64>,
    /// Velocity of the nodes at the end (m/s), if the scheme prescribes it.
    pub velocity: Option<Vec<f64>>,
    /// Part of the forces on the points that their own masses take (N), if they have masses.
    pub inertia: Vec<f64>,
    /// Force on the nodes by the answers (N), with which the next window begins.
    pub lambda: Vec<f64>,
    /// The answers of the motion-driven participants.
    pub answer: Answer,
    /// Reasons against accepting it.
    pub faults: Vec<WindowFault>,
}

impl SolvedWindow {
    /// A window under a constant force: `acting` gives the increments, and the answers give `lambda`.
    pub fn under_constant_force(
        window: Window,
        acting: &[f64],
        increment: Vec<f64>,
        lambda: Vec<f64>,
        answer: Answer,
        faults: Vec<WindowFault>,
    ) -> SolvedWindow {
        let pairs = acting.iter().zip(&increment);
        SolvedWindow {
            window,
            wanted: increment.clone(),
            borne: acting.to_vec(),
            work: pairs.map(|(force, du)| force * du).collect(),
            increment,
            velocity: None,
            inertia: Vec::new(),
            lambda,
            answer,
            faults,
        }
    }
}

/// A reason against accepting a window.
#[derive(Clone, Debug)]
pub struct WindowFault {
    /// The interface, as an index into the group's patches.
    pub patch: usize,
    /// The reason, for the user.
    pub why: String,
}

/// Judgement of a window after a repeat.
#[derive(Clone, Debug, Default)]
pub struct WindowVerdict {
    /// Contact solves that ran out of iterations.
    pub starved: Vec<WindowFault>,
    /// Interfaces whose gap is above their tolerance.
    pub open: Vec<WindowFault>,
}

impl WindowVerdict {
    /// True if another repeat could close a gap; after a solve that ran out of iterations it cannot.
    pub fn wants_repeat(&self) -> bool {
        !self.open.is_empty() && self.starved.is_empty()
    }

    /// The reasons against accepting the window.
    pub fn faults(self) -> Vec<WindowFault> {
        if self.starved.is_empty() {
            self.open
        } else {
            self.starved
        }
    }
}
