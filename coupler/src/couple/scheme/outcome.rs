//! What a window comes to, on its way from the answers of all sides to what stands.

use protocol::Window;
use serde::{Deserialize, Serialize};

/// What came of trying a window.
#[derive(Clone, Debug)]
pub enum Attempt {
    /// It stands, and is everybody's state.
    Standing(Standing),
    /// It did not converge, and the scenario wants it halved. Nothing has changed.
    Halve,
}

/// What a window that stands left behind.
#[derive(Clone, Debug, Default)]
pub struct Standing {
    /// Interfaces of the group, by their index in the scenario, and what the coupler saw of each.
    pub signals: Vec<(usize, InterfaceSignals)>,
    /// Participants of the group and what each reported.
    pub reports: Vec<(usize, Vec<f64>)>,
}

/// What the coupler sees of an interface in a window that stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InterfaceSignals {
    /// Repeats beyond the first run.
    pub repeats: u32,
    /// Gap over the mean node spacing.
    pub gap_rel: f64,
    /// Sum of the forces on the continuum's nodes (N).
    pub force_n: [f64; 2],
    /// The part of it that presses on the continuum's surface (N).
    pub pressing_n: f64,
}

/// The answers of all walls of a group.
pub(super) struct Answer {
    /// Force of the grains on the wall at each glued point (N).
    pub(super) force: Vec<f64>,
    /// Velocity of each glued point at the end of the window (m/s).
    pub(super) velocity: Vec<f64>,
    /// What each wall said of its contact solve.
    pub(super) solves: Vec<Solve>,
}

/// What a wall says of its contact solve.
pub(super) struct Solve {
    pub(super) iterations: u64,
    pub(super) residual: f64,
    pub(super) converged: bool,
}

/// A window that all sides may make their state.
pub(super) struct Solved {
    pub(super) window: Window,
    /// How far the nodes went, as the walls were told (m).
    pub(super) increment: Vec<f64>,
    /// How far the continua would have them go under the forces of the walls (m): the increment, where they went under
    /// these.
    pub(super) wanted: Vec<f64>,
    /// Work on the continua by component (J).
    pub(super) work: Vec<f64>,
    /// Velocity of the nodes at the end (m/s), where the scheme prescribes it.
    pub(super) velocity: Option<Vec<f64>>,
    /// What of the forces on the points their own masses take (N), where they have any.
    pub(super) inertia: Vec<f64>,
    /// Force that the answers give, of the window as far as it is known (N).
    pub(super) lambda: Vec<f64>,
    pub(super) answer: Answer,
    /// Why it should not stand, if so.
    pub(super) faults: Vec<Fault>,
}

/// Why a window should not stand.
pub(super) struct Fault {
    /// The interface, as a place in the group.
    pub(super) patch: usize,
    pub(super) why: String,
}

/// Work of a force that is constant in the window, by component (J).
pub(super) fn work(force: &[f64], increment: &[f64]) -> Vec<f64> {
    let pairs = force.iter().zip(increment);
    pairs.map(|(force, du)| force * du).collect()
}
