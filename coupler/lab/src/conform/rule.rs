//! The rules, and the outcomes of their tests.

use std::fmt;

use serde::Serialize;

use scenario::error::Error;

/// A rule that a participant must keep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rule {
    /// It greets the coordinator with a valid description of itself.
    Greeting,
    /// Its surfaces are valid: finite positions, non-negative masses, positive lengths.
    Surface,
    /// It joins the other side of its interfaces: surfaces of the same shape face each other at the same position.
    Joins,
    /// Each answer has the right kind and length, comes in order and repeats the header of its request.
    Frames,
    /// Answers are finite numbers.
    Finite,
    /// It neither ends nor falls silent before its farewell.
    Lives,
    /// Two launches answer with the same bits for any number of threads.
    SameBits,
    /// A repeated window gets an answer with the same bits.
    Repeats,
    /// A window gets an answer with the same bits after a request under another load.
    Rollback,
    /// An early `Advance` changes nothing, whether it is used or discarded.
    Early,
    /// Answers are increments of the window, not displacements since the start.
    Increments,
    /// A window of 2 m substeps ends where two windows of m substeps end.
    Substeps,
    /// A continuum moves with the force; a layer resists a motion.
    Passive,
    /// Points that are not selected bear no load, and the others answer as if all were selected.
    Select,
    /// Columns are the answers to unit forces at the start.
    Columns,
    /// It follows prescribed velocities linearly, under the forces of the impedance.
    Velocity,
    /// The points of a boundary move with v = a + W p.
    Boundary,
    /// A solve that reports convergence has a residual within the solver's tolerance.
    Convergence,
    /// Heat warms it, and flows from hot to cold.
    Heat,
    /// A report has the announced values, all finite.
    Report,
    /// The work of the interface is the sum of force times increment.
    Work,
    /// Work is stored and dissipated as the ledger says.
    Balance,
    /// Writing fields does not change the state.
    Snapshot,
    /// A new launch that continues from a checkpoint answers with the same bits.
    Checkpoint,
    /// It advances without an interface.
    Alone,
    /// The farewell counts the steps, and its hash differs if states differ.
    Farewell,
    /// Reported times fit into the time between launch and end.
    Times,
    /// It answers an invalid request with a `Fault` and then ends.
    Faults,
    /// It ends on SIGTERM, and after its farewell.
    Shutdown,
}

impl fmt::Display for Rule {
    /// The name that serde writes.
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        self.serialize(formatter)
    }
}

/// Outcome of a test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RuleVerdict {
    /// It was tested and holds.
    Holds,
    /// It was tested and does not hold.
    Broken,
    /// The participant does not offer the capability.
    NotOffered,
    /// It could not be tested.
    NotTested,
}

/// A row of the table.
#[derive(Clone, Debug, Serialize)]
pub struct ConformRow {
    /// The rule.
    pub rule: Rule,
    /// Outcome.
    pub verdict: RuleVerdict,
    /// The compared values, or the reason.
    pub why: String,
}

/// Outcome of a test: the compared values if the rule holds.
pub type RuleFinding = Result<String, Stop>;

/// Reason why a test does not confirm its rule.
#[derive(Debug)]
pub enum Stop {
    /// The rule does not hold, or was not tested.
    Verdict(RuleVerdict, String),
    /// The participant, or the test itself, failed.
    Failed(Error),
}

impl From<Error> for Stop {
    fn from(error: Error) -> Stop {
        Stop::Failed(error)
    }
}

/// The rule is broken.
pub fn broken<T>(why: impl Into<String>) -> Result<T, Stop> {
    Err(Stop::Verdict(RuleVerdict::Broken, why.into()))
}

/// The rule could not be tested.
pub fn not_tested<T>(why: impl Into<String>) -> Result<T, Stop> {
    Err(Stop::Verdict(RuleVerdict::NotTested, why.into()))
}

/// Ends the test if the participant does not offer the capability of the rule.
pub fn offered(offers: bool, otherwise: &str) -> Result<(), Stop> {
    let stop = || Stop::Verdict(RuleVerdict::NotOffered, otherwise.into());
    offers.then_some(()).ok_or_else(stop)
}

/// Holds if the value is at most the bound.
pub fn within(what: &str, value: f64, bound: f64) -> RuleFinding {
    let values = format!("{what}: {value:.2e}, bound {bound:.0e}");
    if exceeds(value, bound) {
        return broken(values);
    }
    Ok(values)
}

/// True above the bound, and for NaN.
pub fn exceeds(value: f64, bound: f64) -> bool {
    value.is_nan() || value > bound
}
