//! Errors that end a run or a verb, with their exit codes.

use std::fmt::Display;
use std::io;

use miette::{LabeledSpan, MietteDiagnostic, NamedSource, Report, SourceSpan};
use protocol::{Cause, WithCure};
use scenes::kept::KeptError;
use scheme::error::SchemeError;
use thiserror::Error;

use exchange_log::{ExportError, LogError};

mod code;
mod explain;
mod refusal;

pub use code::{Code, DAMAGED};
pub use explain::{Explanation, explanation, explanations};
pub use refusal::Refusal;

/// A problem in the scenario: what it is, where it is in the file, and what to do.
#[derive(Debug, Error)]
#[error("{key}: {problem}")]
pub struct ScenarioError {
    /// Its code.
    pub code: Code,
    /// Full dotted path of the key.
    pub key: String,
    /// The problem, with the value.
    pub problem: String,
    /// A proposed remedy.
    pub help: Option<String>,
    /// The file, for the excerpt.
    pub source_file: Option<NamedSource<String>>,
    /// Position in the file.
    pub span: Option<SourceSpan>,
}

impl ScenarioError {
    /// The report that points into the file.
    pub fn report(self) -> Report {
        let code = format!("error[{}]", self.code.word());
        let label = |span| LabeledSpan::new_with_span(Some("here".into()), span);
        let mut report = MietteDiagnostic::new(self.to_string()).with_code(code);
        report.help = self.help;
        report.labels = self.span.map(|span| vec![label(span)]);
        match self.source_file {
            None => report.into(),
            Some(file) => Report::from(report).with_source_code(file),
        }
    }
}

/// Errors that end a run early.
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
    /// A participant answered NaN or infinity, and can be asked again.
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
    /// A participant reported that it cannot continue.
    #[error("participant `{peer}` {phase}: {message}")]
    Fault {
        peer: String,
        phase: String,
        cause: Cause,
        message: String,
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

/// Result of an operation that a run may fail at.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// A window or interface with which a scheme cannot continue.
impl From<SchemeError> for Error {
    fn from(error: SchemeError) -> Error {
        match error {
            SchemeError::Unfit(unfit) => Refusal::from(unfit).into(),
            SchemeError::NotConverged(why) => Error::NotConverged(why),
            SchemeError::NotFinite(why) => Error::NotFinite(why),
            SchemeError::Participant(error) => *error
                .downcast()
                .expect("participants of a run fail with errors of the coordinator"),
        }
    }
}

/// A scheme only needs to know whether it may ask again, as after NaN or infinity.
impl From<Error> for SchemeError {
    fn from(error: Error) -> SchemeError {
        match error {
            Error::NotFinite(why) => SchemeError::NotFinite(why),
            other => SchemeError::Participant(Box::new(other)),
        }
    }
}

impl From<ExportError> for Error {
    fn from(error: ExportError) -> Error {
        match error {
            ExportError::Log(error) => error.into(),
            ExportError::Write { path, source } => Error::output(path.display())(source),
            ExportError::NoWindow { first, last, has } => {
                let problem = format!("the run has no such window; it has {has}");
                Refusal::argument(format!("--windows {first}..{last}"), problem).into()
            }
        }
    }
}

impl From<KeptError> for Error {
    fn from(error: KeptError) -> Error {
        match error {
            KeptError::NoCache { scene } => {
                let problem = format!(
                    "reads files of its own, for which it needs a cache folder: give --cache DIR, or copy the scene with `thirdbody new {scene}`"
                );
                Refusal::argument(format!("the built-in scene `{scene}`"), problem).into()
            }
            KeptError::Write { path, source } => Error::output(path.display())(source),
        }
    }
}

/// Exit code of a failed check, and of a run whose results are suspect.
pub const CHECK_FAILED: i32 = 8;

impl Error {
    /// An error for something that cannot be read or started, in front of the system's error.
    pub fn input(what: impl Display) -> impl FnOnce(io::Error) -> Error {
        move |source| Error::Input {
            what: what.to_string(),
            source,
        }
    }

    /// An error for something that cannot be written, in front of the system's error.
    pub fn output(what: impl Display) -> impl FnOnce(io::Error) -> Error {
        move |source| Error::Output {
            what: what.to_string(),
            source,
        }
    }

    /// Its code.
    pub fn code(&self) -> Code {
        match self {
            Error::Scenario(error) => error.code,
            Error::Refused(refusal) => refusal.code(),
            Error::NotConverged(_) => Code::NotConverged,
            Error::Diverged(_) => Code::Of(Cause::Diverged),
            Error::NotFinite(_) => Code::NotFinite,
            Error::Inconsistent(_) => Code::Inconsistent,
            Error::PeerLost { .. } => Code::PeerLost,
            Error::Deadline { .. } => Code::DeadlineMissed,
            Error::Protocol { .. } => Code::Of(Cause::ProtocolViolated),
            Error::Fault { cause, .. } => Code::Of(*cause),
            Error::Log(error) => code_of_log(error),
            Error::Input { .. } => Code::InputFailed,
            Error::Output { .. } => Code::Of(Cause::WriteFailed),
            Error::Interrupted { .. } => Code::Interrupted,
        }
    }

    /// The message with its code in front.
    pub fn line(&self) -> String {
        format!("error[{}]: {self}", self.code().word())
    }

    /// The exit code of the contract.
    pub fn exit_code(&self) -> i32 {
        match self {
            // In a participant's own process; the coordinator has received its fault by then.
            Error::Refused(refusal) if refusal.code() != Code::TableDamaged => 2,
            Error::Interrupted { signal } => self.code().exit_code() + signal,
            _ => self.code().exit_code(),
        }
    }

    /// The status word of summary.json.
    pub fn status(&self) -> &'static str {
        match self {
            Error::Refused(_) => "refused",
            _ => self.code().ending().1,
        }
    }
}

fn code_of_log(error: &LogError) -> Code {
    match error {
        LogError::Write { .. } | LogError::Closed { .. } | LogError::TooLong { .. } => {
            Code::Of(Cause::WriteFailed)
        }
        LogError::Stalled { .. } => Code::LogStalled,
        LogError::Read { .. } => Code::InputFailed,
        LogError::NotALog { .. } => Code::NotALog,
        LogError::Damaged { .. } => Code::LogCorrupt,
    }
}
