//! Everything that can end a run or a verb, with its exit code.

use std::fmt::Display;
use std::io;

use miette::{Diagnostic, NamedSource, SourceSpan};
use protocol::{FaultCode, NodeError, WithCure};
use thiserror::Error;

use crate::log::LogError;

mod refusal;

pub use refusal::{Refusal, WindowOf};

/// A problem of the scenario: what, where in the file, and what to do.
#[derive(Debug, Error, Diagnostic)]
#[error("{key}: {problem}")]
pub struct ScenarioError {
    /// Full dotted path of the key.
    pub key: String,
    /// The problem with its value.
    pub problem: String,
    /// A proposal.
    #[help]
    pub help: Option<String>,
    /// The file, for the excerpt.
    #[source_code]
    pub source_file: Option<NamedSource<String>>,
    /// Place in the file.
    #[label("here")]
    pub span: Option<SourceSpan>,
}

/// Everything that can end a run early.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum Error {
    #[error("{0}")]
    Scenario(Box<ScenarioError>),
    #[error(transparent)]
    Refused(#[from] Refusal),
    #[error("{0}")]
    NotConverged(String),
    #[error("{0}")]
    Diverged(String),
    /// A participant answered something that is not a number and can be asked again.
    #[error("{0}")]
    NotFinite(String),
    /// Contradiction between the answers of a participant and its ledger.
    #[error("{0}")]
    Inconsistent(String),
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
    /// A file that cannot be read, or a process that cannot be started.
    #[error("{what}: {}", WithCure(.source))]
    Input { what: String, source: io::Error },
    /// A file that cannot be written.
    #[error("{what}: {}", WithCure(.source))]
    Output { what: String, source: io::Error },
    #[error("interrupted by signal {signal}; the valid part of the run is kept")]
    Interrupted { signal: i32 },
}

/// Exit code of a log that is damaged inside.
pub const DAMAGED: i32 = 6;

/// Exit code of a check that failed, and of a run whose results are not to be trusted.
pub const CHECK_FAILED: i32 = 8;

impl Error {
    /// Error of something that cannot be read or started, in front of what the system says.
    pub fn input(what: impl Display) -> impl FnOnce(io::Error) -> Error {
        move |source| Error::Input {
            what: what.to_string(),
            source,
        }
    }

    /// Error of something that cannot be written, in front of what the system says.
    pub fn output(what: impl Display) -> impl FnOnce(io::Error) -> Error {
        move |source| Error::Output {
            what: what.to_string(),
            source,
        }
    }

    /// A fault that a participant reported, at this point of the exchange.
    pub fn of_participant(peer: &str, phase: &str, error: NodeError) -> Error {
        let what = format!("participant `{peer}` {phase}");
        match error.code {
            FaultCode::Configuration => Error::from(Refusal::Fault {
                participant: peer.into(),
                asked: phase.into(),
                message: error.message,
            }),
            FaultCode::Diverged => Error::Diverged(format!("{what}: {}", error.message)),
            FaultCode::Protocol => Error::Protocol {
                peer: peer.into(),
                phase: phase.into(),
                why: error.message,
            },
            FaultCode::Output => Error::Output {
                what,
                source: io::Error::other(error.message),
            },
        }
    }

    /// The exit code of the contract.
    pub fn exit_code(&self) -> i32 {
        self.ending().0
    }

    /// The status word of summary.json.
    pub fn status(&self) -> &'static str {
        self.ending().1
    }

    fn ending(&self) -> (i32, &'static str) {
        match self {
            Error::Scenario(_) | Error::Refused(_) => (2, "refused"),
            Error::Input { .. } | Error::Log(LogError::Read { .. }) => (2, "refused"),
            Error::NotConverged(_) => (3, "not_converged"),
            Error::Diverged(_) | Error::NotFinite(_) => (3, "diverged"),
            Error::Inconsistent(_) => (3, "inconsistent"),
            Error::PeerLost { .. } => (4, "peer_lost"),
            Error::Protocol { .. } => (4, "protocol"),
            Error::Deadline { .. } => (5, "deadline"),
            Error::Log(LogError::NotALog { .. } | LogError::Damaged { .. }) => {
                (DAMAGED, "log_corrupt")
            }
            Error::Output { .. } | Error::Log(_) => (9, "output_failed"),
            Error::Interrupted { signal } => (128 + signal, "interrupted"),
        }
    }
}
