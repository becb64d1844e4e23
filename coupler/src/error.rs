//! What can end a run, and the exit code it has.

use miette::{Diagnostic, NamedSource, SourceSpan};
use thiserror::Error;

use crate::log::LogError;

/// A problem of the scenario: what, where in the file, and what to do.
#[derive(Debug, Error, Diagnostic)]
#[error("{key}: {problem}")]
pub struct ScenarioError {
    /// Full dotted path of the key.
    pub key: String,
    /// What is wrong.
    pub problem: String,
    /// What to do.
    #[help]
    pub help: Option<String>,
    /// The file, for the excerpt.
    #[source_code]
    pub source_file: Option<NamedSource<String>>,
    /// Where in the file.
    #[label("here")]
    pub span: Option<SourceSpan>,
}

/// Everything that can end a run early.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum Error {
    #[error("{0}")]
    Scenario(Box<ScenarioError>),
    #[error("{0}")]
    Refused(String),
    #[error("{0}")]
    NotConverged(String),
    #[error("{0}")]
    Diverged(String),
    /// A participant answered something that is not a number and can be asked again.
    #[error("{0}")]
    NotFinite(String),
    #[error("lost participant `{peer}` {phase}: {why}")]
    PeerLost {
        peer: String,
        phase: String,
        why: String,
    },
    #[error(
        "participant `{peer}` did not answer within {seconds:.1} s {phase}: {state}; see logs/{peer}.log, or raise run.deadlines.{key}"
    )]
    Deadline {
        peer: String,
        phase: String,
        seconds: f64,
        state: String,
        key: &'static str,
    },
    #[error("participant `{peer}` {phase}: {why}")]
    Protocol {
        peer: String,
        phase: String,
        why: String,
    },
    #[error("exchange log: {0}")]
    Log(#[from] LogError),
    #[error("{what}: {source}")]
    Io {
        what: String,
        source: std::io::Error,
    },
    #[error("interrupted by signal {signal}; the valid part of the run is kept")]
    Interrupted { signal: i32 },
}

impl Error {
    /// Shorthand for input and output errors.
    pub fn io(what: impl Into<String>) -> impl FnOnce(std::io::Error) -> Error {
        let what = what.into();
        move |source| Error::Io { what, source }
    }

    /// The exit code of the contract.
    pub fn exit_code(&self) -> i32 {
        match self {
            Error::Scenario(_) | Error::Refused(_) | Error::Io { .. } => 2,
            Error::NotConverged(_) | Error::Diverged(_) | Error::NotFinite(_) => 3,
            Error::PeerLost { .. } | Error::Protocol { .. } => 4,
            Error::Deadline { .. } => 5,
            Error::Log(_) => 6,
            Error::Interrupted { signal } => 128 + signal,
        }
    }

    /// The status word of summary.json.
    pub fn status(&self) -> &'static str {
        match self {
            Error::Scenario(_) | Error::Refused(_) => "refused",
            Error::NotConverged(_) => "not_converged",
            Error::Diverged(_) | Error::NotFinite(_) => "diverged",
            Error::PeerLost { .. } => "peer_lost",
            Error::Protocol { .. } => "protocol",
            Error::Deadline { .. } => "deadline",
            Error::Log(_) | Error::Io { .. } => "output_failed",
            Error::Interrupted { .. } => "interrupted",
        }
    }
}
