//! Rules by name, and the outcome of each.

use serde::Serialize;

/// A rule that a participant must keep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// It welcomes the coordinator, and what it says of itself can be.
    Greeting,
    /// Its surfaces can be: finite places, masses that are not negative, lengths above zero.
    Surface,
    /// It joins the other side of its interfaces: surfaces of one shape that face each other, in one place.
    Joins,
    /// Each answer has the kind and length that are due, comes in its turn and repeats the header of its request.
    Frames,
    /// Answers are finite numbers.
    Finite,
    /// It neither ends nor falls silent before its farewell.
    Lives,
    /// Two lives answer with the same bits, whatever their number of threads.
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
    /// A new life that takes up a checkpoint goes on with the same bits.
    Checkpoint,
    /// It advances without an interface.
    Alone,
    /// The farewell counts the steps, and its hash tells states apart.
    Farewell,
    /// Times are of the life that was seen from outside.
    Times,
    /// A request that cannot be followed is answered with a `Fault`, after which it ends.
    Faults,
    /// It ends when it is asked to, and after its farewell.
    Shutdown,
}

impl Rule {
    /// Its name.
    pub fn word(self) -> &'static str {
        match self {
            Rule::Greeting => "greeting",
            Rule::Surface => "surface",
            Rule::Joins => "joins",
            Rule::Frames => "frames",
            Rule::Finite => "finite",
            Rule::Lives => "lives",
            Rule::SameBits => "same-bits",
            Rule::Repeats => "repeats",
            Rule::Rollback => "rollback",
            Rule::Early => "early",
            Rule::Increments => "increments",
            Rule::Substeps => "substeps",
            Rule::Passive => "passive",
            Rule::Select => "select",
            Rule::Columns => "columns",
            Rule::Velocity => "velocity",
            Rule::Boundary => "boundary",
            Rule::Convergence => "convergence",
            Rule::Report => "report",
            Rule::Work => "work",
            Rule::Balance => "balance",
            Rule::Snapshot => "snapshot",
            Rule::Checkpoint => "checkpoint",
            Rule::Alone => "alone",
            Rule::Farewell => "farewell",
            Rule::Times => "times",
            Rule::Faults => "faults",
            Rule::Shutdown => "shutdown",
        }
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
    /// Name of the rule.
    pub rule: &'static str,
    /// Outcome.
    pub verdict: RuleVerdict,
    /// The values that were compared, or the reason.
    pub why: String,
}

/// Outcome of a trial, and the reason.
pub type Finding = (RuleVerdict, String);

/// The rule holds.
pub fn holds(why: impl Into<String>) -> Finding {
    (RuleVerdict::Holds, why.into())
}

/// The rule is broken.
pub fn broken(why: impl Into<String>) -> Finding {
    (RuleVerdict::Broken, why.into())
}

/// The participant does not offer what the rule is about.
pub fn not_offered(why: impl Into<String>) -> Finding {
    (RuleVerdict::NotOffered, why.into())
}

/// The rule could not be tried.
pub fn not_tested(why: impl Into<String>) -> Finding {
    (RuleVerdict::NotTested, why.into())
}

/// Holds if the value is at most the bound.
pub fn within(what: &str, value: f64, bound: f64) -> Finding {
    let said = format!("{what}: {value:.2e}, bound {bound:.0e}");
    if exceeds(value, bound) {
        broken(said)
    } else {
        holds(said)
    }
}

/// True above the bound, and for what is no number.
pub fn exceeds(value: f64, bound: f64) -> bool {
    value.is_nan() || value > bound
}
