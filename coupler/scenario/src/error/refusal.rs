//! Reasons to refuse a run or a verb.

use std::fmt::Display;
use std::path::Path;

use protocol::participate::ParticipateError;
use protocol::{Cause, FrameError, ServeError};
use scheme::error::Unfit;
use thiserror::Error;

use super::code::Code;

/// Something that the program cannot accept: an argument, a file, a key of the scenario, or a participant that does not
/// fit.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum Refusal {
    #[error(transparent)]
    Unfit(#[from] Unfit),
    #[error("{0}")]
    Benchmark(String),
    #[error(transparent)]
    NotLaunched(#[from] ParticipateError),
    #[error("the log: {0}")]
    Frame(#[from] FrameError),
    /// Any other: the place that finds the fault writes the text, and no code reads it.
    #[error("{text}")]
    Other { code: Code, text: String },
}

impl Refusal {
    /// Its code.
    pub fn code(&self) -> Code {
        match self {
            Refusal::Unfit(unfit) => code_of_unfit(unfit),
            Refusal::Benchmark(_) => Code::MeasurementFailed,
            Refusal::NotLaunched(error) => code_of_participation(error),
            Refusal::Frame(_) => Code::FileUnfit,
            Refusal::Other { code, .. } => *code,
        }
    }

    /// A refusal with a code of its own.
    pub fn other(code: Code, text: impl Into<String>) -> Refusal {
        let text = text.into();
        Refusal::Other { code, text }
    }

    /// An argument of the command line.
    pub fn argument(argument: impl Display, problem: impl Display) -> Refusal {
        Refusal::other(Code::Usage, format!("{argument}: {problem}"))
    }

    /// A file that does not hold what it should.
    pub fn file(path: impl AsRef<Path>, problem: impl Display) -> Refusal {
        let text = format!("{}: {problem}", path.as_ref().display());
        Refusal::other(Code::FileUnfit, text)
    }

    /// A checkpoint, or a handshake after it, from which a run cannot continue.
    pub fn checkpoint(text: impl Into<String>) -> Refusal {
        Refusal::other(Code::Of(Cause::CheckpointUnusable), text)
    }

    /// A participant that cannot do its part. `problem` continues a sentence that begins with its name.
    pub fn participant(participant: &str, problem: impl Into<String>) -> Refusal {
        Unfit::participant(participant, problem).into()
    }
}

fn code_of_unfit(unfit: &Unfit) -> Code {
    match unfit {
        Unfit::NoInverse(_) => Code::NoInverse,
        Unfit::Geometry { .. } => Code::SurfacesApart,
        Unfit::Participant { .. } => Code::ParticipantUnfit,
        Unfit::Key { .. } => Code::SchemeUnsuited,
        Unfit::Interface { .. } => Code::InterfaceUnfit,
        Unfit::UnknownSet { .. } => Code::Of(Cause::UnknownSet),
        Unfit::SetTwice { .. } => Code::Of(Cause::SetCoupledTwice),
        Unfit::WindowTooLong { .. } => Code::WindowTooLong,
        Unfit::Roles { .. } => Code::WrongRoles,
        Unfit::Windows { .. } => Code::WindowsDiffer,
        Unfit::Unstable { .. } => Code::UnstableWindow,
        Unfit::TooManySteps { .. } => Code::TooManySteps,
    }
}

/// The code for a participant's own process that stopped.
fn code_of_participation(error: &ParticipateError) -> Code {
    match error {
        ParticipateError::NoSession
        | ParticipateError::Session { .. }
        | ParticipateError::NoChannel
        | ParticipateError::NoNetwork => Code::NotLaunched,
        ParticipateError::Signals(_) => Code::InputFailed,
        ParticipateError::Orphan(_) | ParticipateError::Link(_) => Code::CoordinatorGone,
        ParticipateError::Serve(error) => match error {
            ServeError::Link(_) | ServeError::Silent { .. } => Code::CoordinatorGone,
            ServeError::Frame(_) => Code::Of(Cause::ProtocolViolated),
            ServeError::Node(error) => Code::Of(error.cause()),
        },
    }
}
