//! Everything that can end a window or keep interfaces from being joined.

use std::error::Error as StdError;

use thiserror::Error;

use crate::keys::Interface;

/// Reasons for which a scheme cannot go on.
#[derive(Debug, Error)]
pub enum SchemeError {
    /// Interfaces or participants that do not fit each other or the scheme.
    #[error(transparent)]
    Unfit(#[from] Unfit),
    /// A window that did not converge, and what closes its gap.
    #[error("{0}")]
    NotConverged(String),
    /// A participant answered something that is not a number and can be asked again.
    #[error("{0}")]
    NotFinite(String),
    /// The reason for which a participant did not answer, from the layer that speaks to it.
    #[error("{0}")]
    Participant(Box<dyn StdError + Send + Sync>),
}

/// Result of what a scheme or a participant may fail at.
pub type Result<T, E = SchemeError> = std::result::Result<T, E>;

/// Interfaces, participants and keys that do not go together.
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
        "interface `{interface}` joins {} and {}: it takes one participant that advances under forces and one that stands on a compliant wall", between[0], between[1]
    )]
    Roles {
        interface: String,
        between: [String; 2],
    },
    #[error(
        "interfaces `{}` and `{}` are connected but have windows of {} and {}: give substeps and time.step_s with the same product",
        interfaces[0], interfaces[1], windows[0], windows[1]
    )]
    Windows {
        interfaces: [String; 2],
        windows: [String; 2],
    },
    #[error(
        "interface `{interface}`: scheme {scheme} with {substeps} substeps is predicted to be unstable{bound}: a disturbance grows {growth:.3}-fold a window; {cure}, or set interface.{interface}.unsafe_window = true to see it fail"
    )]
    Unstable {
        interface: String,
        scheme: String,
        substeps: u32,
        /// The bound that is broken, if it has a name.
        bound: String,
        growth: f64,
        /// Remedy.
        cure: &'static str,
    },
    #[error(
        "the run would take {steps:.1e} steps of {step_s:.3e} s until it ends at {end_s:.3e} s, more than {most:.0e}: check run.end_s, time.step_s, and the load history (wheel.ramp_s, wheel.hold_s, wheel.cycles, wheel.frequency_hz, or time.end_s)"
    )]
    TooManySteps {
        steps: f64,
        step_s: f64,
        end_s: f64,
        most: f64,
    },
}

impl Unfit {
    /// A participant that cannot do its part; the problem goes on from its name.
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

    /// A key of the scenario that does not fit what the participants said; the problem goes on from it.
    pub fn key(key: impl Into<String>, problem: impl Into<String>) -> Unfit {
        let (key, problem) = (key.into(), problem.into());
        Unfit::Key { key, problem }
    }

    /// The same of a key of an interface.
    pub fn interface_key(interface: &Interface, key: &str, problem: impl Into<String>) -> Unfit {
        Unfit::key(format!("interface.{}.{key}", interface.name), problem)
    }
}
