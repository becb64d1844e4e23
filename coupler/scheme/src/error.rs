//! Errors that end a window or prevent the join of interfaces.

use std::error::Error as StdError;

use thiserror::Error;

use crate::keys::Interface;

/// Reasons why a scheme cannot continue.
#[derive(Debug, Error)]
pub enum SchemeError {
    /// Interfaces or participants that do not fit each other or the scheme.
    #[error(transparent)]
    Unfit(#[from] Unfit),
    /// A window that did not converge, with the remedy.
    #[error("{0}")]
    NotConverged(String),
    /// A participant answered NaN or infinity, and can be asked again.
    #[error("{0}")]
    NotFinite(String),
    /// The reason why a participant did not answer, from the layer that communicates with it.
    #[error("{0}")]
    Participant(Box<dyn StdError + Send + Sync>),
}

/// Result of an operation that a scheme or a participant may fail at.
pub type Result<T, E = SchemeError> = std::result::Result<T, E>;

/// Interfaces, participants and keys that do not fit together.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum Unfit {
    #[error("{0}")]
    NoInverse(String),
    #[error("interface `{interface}` between {} and {}: {why}", between[0], between[1])]
    Geometry {
        interface: String,
        between: [String; 2],
        why: String,
    },
    #[error("participant `{participant}` {problem}")]
    Participant {
        participant: String,
        problem: String,
    },
    #[error("{key} {problem}")]
    Key { key: String, problem: String },
    #[error("interface `{interface}`: {problem}")]
    Interface { interface: String, problem: String },
    #[error(
        "interface `{interface}`: participant `{participant}` has no set `{set}`: name one of its sets in interface.{interface}.between, {known}"
    )]
    UnknownSet {
        interface: String,
        participant: String,
        set: String,
        known: String,
    },
    #[error("interface `{interface}`: {problem}")]
    SetTwice { interface: String, problem: String },
    #[error("interface `{interface}`: {problem}")]
    WindowTooLong { interface: String, problem: String },
    #[error(
        "interface `{interface}` joins {} and {}: it needs one participant that advances under forces and one that stands on a compliant wall", between[0], between[1]
    )]
    Roles {
        interface: String,
        between: [String; 2],
    },
    #[error(
        "interfaces `{}` and `{}` are connected but have windows of {} and {}: choose substeps and time.step_s with the same product",
        interfaces[0], interfaces[1], windows[0], windows[1]
    )]
    Windows {
        interfaces: [String; 2],
        windows: [String; 2],
    },
    #[error(
        "interface `{interface}`: scheme {scheme} with {substeps} substeps is predicted to be unstable{bound}: a disturbance grows by a factor of {growth:.3} a window; {cure}, or set interface.{interface}.unsafe_window = true to watch it fail"
    )]
    Unstable {
        interface: String,
        scheme: String,
        substeps: u32,
        /// The violated bound, if it has a name.
        bound: String,
        growth: f64,
        /// Remedy.
        cure: &'static str,
    },
    #[error(
        "the run would need {steps:.1e} steps of {step_s:.3e} s to reach its end at {end_s:.3e} s; the limit is {most:.0e}: check run.end_s, time.step_s, and the load history (wheel.ramp_s, wheel.hold_s, wheel.cycles, wheel.frequency_hz, or time.end_s)"
    )]
    TooManySteps {
        steps: f64,
        step_s: f64,
        end_s: f64,
        most: f64,
    },
}

impl Unfit {
    /// A participant that cannot do its part. `problem` continues a sentence that begins with its name.
    pub fn participant(participant: &str, problem: impl Into<String>) -> Unfit {
        Unfit::Participant {
            participant: participant.into(),
            problem: problem.into(),
        }
    }

    /// An interface that cannot be built.
    pub fn interface(interface: &str, problem: impl Into<String>) -> Unfit {
        Unfit::Interface {
            interface: interface.into(),
            problem: problem.into(),
        }
    }

    /// A key of the scenario that does not fit the participants' descriptions. `problem` continues a sentence that
    /// begins with the key.
    pub fn key(key: impl Into<String>, problem: impl Into<String>) -> Unfit {
        let (key, problem) = (key.into(), problem.into());
        Unfit::Key { key, problem }
    }

    /// The same for a key of an interface.
    pub fn interface_key(interface: &Interface, key: &str, problem: impl Into<String>) -> Unfit {
        Unfit::key(format!("interface.{}.{key}", interface.name), problem)
    }
}
