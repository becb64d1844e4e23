//! The solver as the coupler sees it: the requests of trait [`Node`], and the types of its answers.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::cause::{Cause, FaultCode, lenient};
use crate::finding::Finding;

/// A solver, seen from the coupler. Vectors over the exchanged points hold two components a point,
/// `(x0, y0, x1, y1, ...)`, in SI units.
///
/// A node that is coupled on several sets keeps their points one set after the other, in the order of the
/// [`Node::couple`] calls. Between two commits every request starts again from the last committed state,
/// so the coupler can repeat a window as often as it wants.
pub trait Node: Send {
    /// Describes the node: its kind, its step, its capabilities and its reports.
    fn describe(&self) -> Description;

    /// Couples a named set and returns its points. A set of a continuum that carries several layers is coupled once for each layer:
    /// [`Node::select`] gives each layer its own points.
    fn couple(&mut self, set: &str) -> Result<Surface, NodeError>;

    /// Restricts the exchange to these points of all coupled sets; forces on all others are zero.
    fn select(&mut self, points: &[usize]) -> Result<(), NodeError>;

    /// Condensed compliance C (m/N) of a first window like this one: column j holds the displacement
    /// increments of all exchanged components after a run from rest under a unit force in component j.
    /// Square, column by column.
    fn columns(&mut self, window: &Window) -> Result<Vec<f64>, NodeError> {
        let _ = window;
        Err(NodeError::unsupported("columns of its compliance"))
    }

    /// Announces windows of length `window_s` (s) and the compliance W_g (1/kg) of the boundary that carries the
    /// glued points: v_g = a_g + W_g p, with p the impulses (N s) on them. Square, column by column.
    fn set_boundary(&mut self, window_s: f64, compliance: &[f64]) -> Result<(), NodeError> {
        let _ = (window_s, compliance);
        Err(NodeError::unsupported("a compliant wall"))
    }

    /// Runs a window under a constant interface force (N) and returns the displacement increments (m).
    fn advance(&mut self, window: &Window, force: &[f64]) -> Result<Vec<f64>, NodeError> {
        let _ = (window, force);
        Err(NodeError::unsupported(
            "a window under a given interface force",
        ))
    }

    /// Impedance D (kg/s) of a first window like this one: column j holds the reactions of all exchanged components
    /// at the end of a run from rest in which the velocity of component j grows linearly to one and all others
    /// are held. A component that cannot move has zeros in its row and column. Square, column by column.
    fn impedance(&mut self, window: &Window) -> Result<Vec<f64>, NodeError> {
        let _ = window;
        Err(NodeError::unsupported("columns of its impedance"))
    }

    /// Runs a window in which the velocity of each exchanged component changes linearly from its present value to
    /// `velocity` (m/s). Returns the forces that this takes, the displacements and the work.
    fn prescribe_velocity(
        &mut self,
        window: &Window,
        velocity: &[f64],
    ) -> Result<Reaction, NodeError> {
        let _ = (window, velocity);
        Err(NodeError::unsupported("a window along a given velocity"))
    }

    /// Solves a window with glued points that obey v_g = a_g + W_g p, `free_velocity` being a_g (m/s).
    fn solve(
        &mut self,
        window: &Window,
        free_velocity: &[f64],
    ) -> Result<BoundaryAnswer, NodeError> {
        let _ = (window, free_velocity);
        Err(NodeError::unsupported("a window on a compliant wall"))
    }

    /// Makes the last answer for this window the state. `displacement` holds the total displacement (m) of the
    /// exchanged points if the coupler dictates it (glued points), otherwise it is empty. Returns the values of
    /// [`Description::signals`], then the values of [`Description::ledger`].
    fn commit(&mut self, window: &Window, displacement: &[f64]) -> Result<Vec<f64>, NodeError>;

    /// Takes the heat (J) that has entered at each exchanged point since the last call, one number a point, and returns their temperatures (K). It
    /// comes between two windows, after a [`Node::commit`].
    fn take_heat(&mut self, window: &Window, heat: &[f64]) -> Result<Vec<f64>, NodeError> {
        let _ = (window, heat);
        Err(NodeError::unsupported("heat through its surface"))
    }

    /// Takes the temperatures (K) of the body at each glued point, one number a point. Returns the heat (J) that has left there since the last call, one
    /// number a point, and then the heat per kelvin (J/K): what a body colder by 1 K would have taken more from grains of the same temperatures.
    fn take_temperatures(
        &mut self,
        window: &Window,
        temperature: &[f64],
    ) -> Result<Vec<f64>, NodeError> {
        let _ = (window, temperature);
        Err(NodeError::unsupported("heat into its boundary"))
    }

    /// Advances alone by [`Window::substeps`] own steps, without interface, and commits. Returns what
    /// [`Node::commit`] returns.
    fn advance_alone(&mut self, window: &Window) -> Result<Vec<f64>, NodeError> {
        let _ = window;
        Err(NodeError::unsupported("running without an interface"))
    }

    /// The part of the committed state that can change a later bit or a result, as bytes that only this node reads.
    /// It excludes data built from the configuration and the handshake. Offered by [`Capabilities::resume`].
    fn checkpoint(&mut self) -> Result<Vec<u8>, NodeError> {
        Err(NodeError::unsupported("a checkpoint of its state"))
    }

    /// Makes the state of an earlier [`Node::checkpoint`] the committed one. The node was built from the same
    /// configuration, possibly with another number of threads, and has been through the same handshake.
    fn restore(&mut self, state: &[u8]) -> Result<(), NodeError> {
        let _ = state;
        Err(NodeError::unsupported(
            "a return to a checkpoint of its state",
        ))
    }

    /// Writes the fields of the committed state into [`crate::Setting::fields`], as `<participant>-<name>.vtu` or `.vtp`.
    fn snapshot(&mut self, name: &str) -> Result<(), NodeError> {
        let _ = name;
        Ok(())
    }

    /// Ends the run: results, work done and a hash of the whole state.
    fn finish(&mut self) -> Result<Outcome, NodeError>;
}

/// One coupling window. Time is counted in whole explicit steps, so that two windows never differ by rounding.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Window {
    /// Index from 0.
    pub index: u64,
    /// Repeat from 0.
    pub iteration: u32,
    /// Explicit steps since the start of the run at `t0_s`.
    pub step: u64,
    /// Explicit steps in the window.
    pub substeps: u32,
    /// Start (s).
    pub t0_s: f64,
    /// End (s).
    pub t1_s: f64,
}

/// A node's description of itself at the handshake.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Description {
    /// `fem`, `dem`, or the name of a foreign solver.
    pub kind: String,
    /// Name and version of the software.
    pub software: String,
    /// Requests that it can answer.
    pub capabilities: Capabilities,
    /// Its own step (s); absent if it takes the window as its step.
    pub step_s: Option<f64>,
    /// The most steps of one request when it runs alone, if its steps take long.
    #[serde(default)]
    pub steps_at_once: Option<u32>,
    /// The longest step, or for a node without own step the longest window, that it accepts (s).
    pub step_limit_s: Option<f64>,
    /// Name of the bound `step_limit_s`.
    pub step_limit_name: String,
    /// Steps, or windows of a node without own step, above which its results lose accuracy.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub accuracy_limits: Vec<AccuracyLimit>,
    /// End of its own load history (s).
    pub end_s: Option<f64>,
    /// Named parts of its load history, in order.
    pub phases: Vec<Phase>,
    /// The time (s) at which each of these keys has taken effect: the end of a ramp, a hold or a motion, the last change of a table,
    /// the first grain of a feed. A run that ends earlier leaves the key without effect, and its user gets a warning.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub moments: BTreeMap<String, f64>,
    /// Sets that an interface can name.
    pub sets: Vec<String>,
    /// Names of the signals of each report, unit in the name.
    pub signals: Vec<String>,
    /// The terms of its energy ledger, cumulative from the start (J).
    pub ledger: Vec<Term>,
    /// Advice to the user before a long run.
    pub warnings: Vec<String>,
    /// First period of a continuum at a coupled set (s), for the prediction of stability and accuracy.
    #[serde(default)]
    pub first_period_s: Option<f64>,
    /// Inertia behind the points of a solver on a compliant boundary, for the prediction of stability.
    #[serde(default, rename = "backing")]
    pub boundary_inertia: Option<BoundaryInertia>,
    /// Tolerance of a solver that iterates.
    #[serde(default)]
    pub tolerance: Option<Tolerance>,
    /// Masses of the points of a set (kg) of a solver on a compliant boundary, in the order of its [`Surface`], by the name
    /// of the set. The solver's equations do not use them, so points without mass there may have one here: a coupler
    /// needs it to push them by a force. A set that is missing has no such masses.
    #[serde(default)]
    pub point_mass_kg: BTreeMap<String, Vec<f64>>,
    /// Positions on the smooth surface (m) that the points of a set represent, in the order of its [`Surface`], by the name of the
    /// set: the points of a rough row lie off that surface. Points of a missing set represent their own positions.
    #[serde(default)]
    pub smooth_m: BTreeMap<String, Vec<[f64; 2]>>,
    /// Mean outward unit normal of each set: two coupled sets face each other. A missing set is not checked.
    #[serde(default)]
    pub outward: BTreeMap<String, [f64; 2]>,
    /// True for a continuum whose distant points follow a change of force one window late: two windows are then not one of twice the length.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub late_far_field: bool,
    /// Period of each set along x (m), by the name of the set: a body that leaves it at one end comes back at the other, and its
    /// [`Surface`] has no point twice. Two coupled sets have the same period; a missing set has ends.
    #[serde(default)]
    pub period_m: BTreeMap<String, f64>,
    /// The prepared sample that it starts from, if any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prepared_sample: Option<PreparedSample>,
}

/// The longest step that resolves a part of a node's physics.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AccuracyLimit {
    /// Name of the bound, and the quantity that it bounds.
    pub name: String,
    /// The step (s).
    pub limit_s: f64,
}

/// Origin of a sample that is made, always the same, from a recipe and a seed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PreparedSample {
    /// blake3 of the recipe, in hexadecimal.
    pub hash: String,
    /// True if it was read from [`Setting::cache`](crate::Setting::cache) and not made anew.
    pub from_cache: bool,
}

/// Residual to which a solver iterates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tolerance {
    /// Its key inside `config`.
    pub key: String,
    /// Relative residual.
    pub value: f64,
}

/// Mass and stiffness behind the points of a coupled set, per point: they decide how strongly the set resists
/// an imposed motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BoundaryInertia {
    /// Mass of a point itself (kg); zero for glued disks.
    pub glued_mass_kg: f64,
    /// Mass that can move behind it (kg).
    pub mass_kg: f64,
    /// Stiffness of the contacts between the two masses (N/m); absent if they are rigidly joined.
    pub stiffness_n_per_m: Option<f64>,
    /// Weight theta of the time scheme: the velocity of a window is theta v(end) + (1 - theta) v(start).
    pub theta: f64,
    /// True if a point can separate from the mass behind it, and then resists with its own mass only; false for a program that
    /// does not know this key.
    #[serde(default)]
    pub may_part: bool,
}

/// Requests that a node can answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Capabilities {
    /// A window can be repeated: requests between two commits restart from the last committed state.
    #[serde(rename = "checkpoint")]
    pub rollback: bool,
    /// [`Node::advance`].
    pub advance: bool,
    /// [`Node::columns`].
    pub columns: bool,
    /// [`Node::set_boundary`] and [`Node::solve`].
    pub compliant_boundary: bool,
    /// [`Node::set_boundary`] and [`Node::solve`] for zero compliance only; false for a program that does not know this key, and
    /// without effect if `compliant_boundary` is true.
    #[serde(default)]
    pub rigid_boundary: bool,
    /// [`Node::prescribe_velocity`] and [`Node::impedance`]; false for a program that does not know this key.
    #[serde(default, rename = "follow")]
    pub prescribed_velocity: bool,
    /// [`Node::advance_alone`].
    pub alone: bool,
    /// [`Node::checkpoint`] and [`Node::restore`]; false for a program that does not know this key.
    #[serde(default)]
    pub resume: bool,
    /// [`Node::take_heat`] of a continuum, [`Node::take_temperatures`] of a layer; left out where false.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub heat: bool,
}

impl Capabilities {
    /// True if the coupler can prescribe the motion of its points.
    pub fn motion_driven(&self) -> bool {
        self.compliant_boundary || self.rigid_boundary
    }
}

/// A named part of a load history, for instance `ramp`, `hold` or `cycling`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Phase {
    /// Its name.
    pub name: String,
    /// Start (s).
    pub t0_s: f64,
    /// End (s).
    pub t1_s: f64,
    /// True if results are sampled in it: its last half gives `interface_force_n`, its end `profile.csv`. At most one phase of
    /// a load history has this flag.
    #[serde(default)]
    pub sampled: bool,
    /// True if the report has a picture of its end.
    #[serde(default)]
    pub picture: bool,
}

/// A term of the energy ledger.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Term {
    /// Its name, for instance `kinetic`.
    pub name: String,
    /// Its role in the balance W - dE - D.
    pub role: Role,
}

/// Role of a ledger term in the balance `work - stored - dissipated = 0`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Work done on the node through its interface, W.
    InterfaceWork,
    /// Work done on the node by its own loads and drives, W.
    Work,
    /// Energy stored since the start, E.
    Stored,
    /// Energy dissipated, D.
    Dissipated,
    /// No part of the balance: while no other term reaches it, all are rounding.
    Rounding,
}

/// The points of a coupled set, one entry of each vector per point.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Reference positions (m).
    pub x_m: Vec<f64>,
    /// Reference positions (m).
    pub y_m: Vec<f64>,
    /// Lumped masses (kg); zero for glued disks.
    pub mass_kg: Vec<f64>,
    /// Radii (m); zero for nodes of a mesh.
    pub radius_m: Vec<f64>,
    /// Tributary lengths (m).
    pub length_m: Vec<f64>,
}

impl Surface {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.x_m.len()
    }

    /// True if there is no point at all.
    pub fn is_empty(&self) -> bool {
        self.x_m.is_empty()
    }

    /// Rows of (x, y, mass, radius, length), as the `Surface` frame carries them.
    pub fn to_rows(&self) -> Vec<f64> {
        let columns = self.columns();
        let rows = (0..self.len()).flat_map(|row| columns.map(|column| column[row]));
        rows.collect()
    }

    /// Its columns (x, y, mass, radius, length).
    pub fn columns(&self) -> [&Vec<f64>; 5] {
        let Surface {
            x_m,
            y_m,
            mass_kg,
            radius_m,
            length_m,
        } = self;
        [x_m, y_m, mass_kg, radius_m, length_m]
    }

    /// The reverse of [`Surface::columns`].
    pub fn of_columns([x_m, y_m, mass_kg, radius_m, length_m]: [Vec<f64>; 5]) -> Surface {
        Surface {
            x_m,
            y_m,
            mass_kg,
            radius_m,
            length_m,
        }
    }

    /// The reverse of [`Surface::to_rows`]; `None` if the rows are incomplete.
    pub fn from_rows(rows: &[f64]) -> Option<Surface> {
        if !rows.len().is_multiple_of(5) {
            return None;
        }
        let column = |k: usize| rows.chunks_exact(5).map(|row| row[k]).collect();
        Some(Surface::of_columns([0, 1, 2, 3, 4].map(column)))
    }
}

/// Answer of a node on a compliant boundary.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BoundaryAnswer {
    /// Force of the node on the boundary at each glued point (N), mean over the window.
    pub force: Vec<f64>,
    /// Velocity of each glued point at the end of the window (m/s).
    pub velocity: Vec<f64>,
    /// Iterations of the contact solver.
    pub iterations: u64,
    /// True natural-map residual of the contact problem, relative.
    pub residual: f64,
    /// True if the residual is within the node's own tolerance.
    pub converged: bool,
}

/// Answer of a node whose velocity was prescribed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reaction {
    /// Force on the node at the end of the window (N), by component; zero for a component that cannot move.
    pub force: Vec<f64>,
    /// Displacement increments over the window (m).
    pub increment: Vec<f64>,
    /// Work of the forces over the window (J), by component: the forces vary within the window.
    pub work: Vec<f64>,
}

/// Results of a run from one node.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Own steps done, repeats included.
    pub steps: u64,
    /// Work done by its kind, for instance `element_steps`. Times are divided by the sum of the entries.
    pub work: BTreeMap<String, f64>,
    /// Results by name, unit in the name.
    pub results: BTreeMap<String, f64>,
    /// blake3 of every number that can change a later bit, in hexadecimal.
    pub state_hash: String,
    /// Advice to the user about the quality of the results.
    #[serde(default)]
    pub warnings: Vec<String>,
    /// Implausible values.
    #[serde(default)]
    pub findings: Vec<Finding>,
    /// The load that leaves through the coupled sets while results are sampled, if this node knows one.
    #[serde(default)]
    pub held_load: Option<HeldLoad>,
}

/// A load that presses on a node's coupled sets in the last half of its sampled phase, when all is at rest. The
/// interfaces must carry it then.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HeldLoad {
    /// The load that the scenario asks for (N), downwards.
    pub wanted_n: f64,
    /// Mean of the force that the load exerts (N), downwards.
    pub mean_n: f64,
}

impl Outcome {
    /// Omits results that are NaN or infinite, with a warning each: text cannot carry them, and one bad mean must
    /// not cost a whole run.
    pub fn with_finite_results(mut self) -> Outcome {
        let warnings = &mut self.warnings;
        self.results.retain(|name, value| {
            if !value.is_finite() {
                warnings.push(format!("the result {name} is {value} and is left out"));
            }
            value.is_finite()
        });
        self
    }
}

/// A node cannot answer a request.
#[derive(Clone, Debug, Error, PartialEq, Serialize, Deserialize)]
#[error("{message}")]
pub struct NodeError {
    /// Kind of the fault.
    pub code: FaultCode,
    /// Its cause, if a more specific one than the fault is known.
    #[serde(
        default,
        deserialize_with = "lenient",
        skip_serializing_if = "Option::is_none"
    )]
    pub cause: Option<Cause>,
    /// The fault, its place, its cause, and advice.
    pub message: String,
}

impl NodeError {
    /// The solution diverged or a solver did not converge.
    pub fn diverged(message: impl Into<String>) -> NodeError {
        NodeError::new(FaultCode::Diverged, message)
    }

    /// The scenario or the request cannot be followed.
    pub fn configuration(message: impl Into<String>) -> NodeError {
        NodeError::new(FaultCode::Configuration, message)
    }

    /// A frame that does not belong here.
    pub fn protocol(message: impl Into<String>) -> NodeError {
        NodeError::new(FaultCode::Protocol, message)
    }

    fn new(code: FaultCode, message: impl Into<String>) -> NodeError {
        NodeError {
            code,
            cause: None,
            message: message.into(),
        }
    }

    /// An error of this cause; its fault follows.
    pub fn of(cause: Cause, message: impl Into<String>) -> NodeError {
        NodeError {
            cause: Some(cause),
            ..NodeError::new(cause.fault(), message)
        }
    }

    /// Its cause, or the general one of its fault if no specific cause is known.
    pub fn cause(&self) -> Cause {
        let closer = self.cause.filter(|cause| cause.fault() == self.code);
        closer.unwrap_or(Cause::general(self.code))
    }

    fn unsupported(what: &str) -> NodeError {
        NodeError::of(
            Cause::NotOffered,
            format!(
                "this participant does not offer {what}: choose another scheme or another participant"
            ),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_cause_and_one_of_another_fault_are_the_general_one() {
        let cause_of = |cause: &str| {
            let text = format!(r#"{{"code": "diverged", "message": "m"{cause}}}"#);
            let error: NodeError = serde_json::from_str(&text).expect("a fault");
            error.cause()
        };
        let specific = cause_of(r#", "cause": "contact-too-wide""#);
        assert_eq!(specific, Cause::ContactTooWide);
        assert_eq!(cause_of(""), Cause::Diverged);
        assert_eq!(
            cause_of(r#", "cause": "of-a-later-release""#),
            Cause::Diverged
        );
        assert_eq!(cause_of(r#", "cause": "unknown-key""#), Cause::Diverged);
    }

    #[test]
    fn a_result_that_is_nan_is_omitted_without_an_error() {
        let results = [("a_m", 1.0), ("b_n", f64::NAN), ("c_pa", f64::INFINITY)];
        let outcome = Outcome {
            steps: 1,
            work: BTreeMap::new(),
            results: results.map(|(name, value)| (name.into(), value)).into(),
            ..Outcome::default()
        };
        let sent = outcome.with_finite_results();
        assert_eq!(sent.results, BTreeMap::from([("a_m".into(), 1.0)]));
        assert!(
            sent.warnings[0].contains("b_n is NaN"),
            "{:?}",
            sent.warnings
        );
        assert!(sent.warnings[1].contains("c_pa"), "{:?}", sent.warnings);
        let text = serde_json::to_string(&sent).expect("numbers");
        assert_eq!(
            serde_json::from_str::<Outcome>(&text).expect("numbers"),
            sent
        );
    }
}
