//! Rules by name, and the outcome of each.

use std::fmt;

use serde::Serialize;

use scenario::error::Error;

/// A rule that a participant must keep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rule {
    /// It welcomes the coordinator, and what it says of itself can be.
    Greeting,
    /// Its surfaces can be: finite places, masses that are not negative, lengths above zero.
    Surface,
    /// It joins the other side of its interfaces: surfaces of one shape that face each other at one position.
    Joins,
    /// Each answer has the kind and length that are due, comes in its turn and repeats the header of its request.
    Frames,
    /// Answers are finite numbers.
    Finite,
    /// It neither ends nor falls silent before its farewell.
    Lives,
    /// Two launches answer with the same bits, whatever their number of threads.
    SameBits,
    /// A window that is asked for again is answered with the same bits.
    Repeats,
    /// A window that is asked for under another load first is answered with the same bits.
    Rollback,
    /// An `Advance` that comes early changes nothing, whether it is used or discarded.
    Early,
    /// Answers are increments of the window, not displacements since the start.
    Increments,
    /// A window of 2 m substeps comes to where two of m come to.
    Substeps,
    /// A continuum moves with the force; a layer resists a motion.
    Passive,
    /// Points that are not selected bear nothing, and the others answer as they do among all.
    Select,
    /// Columns are the answers to unit forces at the start.
    Columns,
    /// Prescribed velocities are followed in a straight line, under the forces of the impedance.
    Velocity,
    /// The points of a boundary go at v = a + W p.
    Boundary,
    /// A solve that says it converged has a residual within the solver's tolerance.
    Convergence,
    /// A report has the values that were announced, all of them numbers.
    Report,
    /// The work of the interface is the sum of force times increment.
    Work,
    /// Work goes where the ledger says.
    Balance,
    /// Fields are written without changing the state.
    Snapshot,
    /// A new launch that goes on from a checkpoint answers with the same bits.
    Checkpoint,
    /// It advances without an interface.
    Alone,
    /// The farewell counts the steps, and its hash differs where states differ.
    Farewell,
    /// Times fit the time between launch and end, as seen from outside.
    Times,
    /// A request that cannot be followed is answered with a `Fault`, after which it ends.
    Faults,
    /// It ends when it is asked to, and after its farewell.
    Shutdown,
}

impl fmt::Display for Rule {
    /// Its name, the one that serde writes.
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        self.serialize(formatter)
    }
}

/// Outcome of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RuleVerdict {
    /// It was tried and holds.
    Holds,
    /// It was tried and does not hold.
    Broken,
    /// The participant says that it does not offer this.
    NotOffered,
    /// It could not be tried.
    NotTested,
}

/// A row of the table.
#[derive(Clone, Debug, Serialize)]
pub struct ConformRow {
    /// The rule.
    pub rule: Rule,
    /// Outcome.
    pub verdict: RuleVerdict,
    /// The values that were compared, or the reason.
    pub why: String,
}

/// Outcome of a trial: the values that were compared, where the rule holds.
pub type RuleFinding = Result<String, Stop>;

/// Why a trial ends without saying that its rule holds.
#[derive(Debug)]
pub enum Stop {
    /// The rule does not hold, or was not tried.
    Verdict(RuleVerdict, String),
    /// The participant, or the trial itself, failed.
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

/// The rule could not be tried.
pub fn not_tested<T>(why: impl Into<String>) -> Result<T, Stop> {
    Err(Stop::Verdict(RuleVerdict::NotTested, why.into()))
}

/// Ends the trial where the participant does not offer what the rule is about.
pub fn offered(offers: bool, otherwise: &str) -> Result<(), Stop> {
    let stop = || Stop::Verdict(RuleVerdict::NotOffered, otherwise.into());
    offers.then_some(()).ok_or_else(stop)
}

/// Holds if the value is at most the bound.
pub fn within(what: &str, value: f64, bound: f64) -> RuleFinding {
    let said = format!("{what}: {value:.2e}, bound {bound:.0e}");
    if exceeds(value, bound) {
        return broken(said);
    }
    Ok(said)
}

/// True above the bound, and for what is no number.
pub fn exceeds(value: f64, bound: f64) -> bool {
    value.is_nan() || value > bound
}
