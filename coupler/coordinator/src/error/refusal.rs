//! Reasons for which a run or a verb is refused.

use std::path::PathBuf;

use protocol::participate::ParticipateError;
use protocol::{Cause, FrameError, ServeError};
use scheme::error::Unfit;
use thiserror::Error;

use super::code::Code;

/// Something that cannot be followed: an argument, a file, a key of the scenario, or a participant that does not fit.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum Refusal {
    #[error(transparent)]
    Unfit(#[from] Unfit),
    #[error("{argument}: {problem}")]
    Argument { argument: String, problem: String },
    #[error(
        "no scenario `{name}`: give a folder with scenario.toml, a file, a name under scenarios/, or one that `thirdbody scenes` lists{}", .meant.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default()
    )]
    NoScenario {
        name: String,
        meant: Option<&'static str>,
    },
    #[error("{}: {problem}", path.display())]
    File { path: PathBuf, problem: String },
    #[error("no message was chosen: `thirdbody inspect` lists the streams")]
    EmptyExport,
    #[error("{0}")]
    Benchmark(String),
    #[error(transparent)]
    NotLaunched(#[from] ParticipateError),
    #[error(
        "the scenario starts `{command}` for participant `{participant}`: read it, then repeat with --allow-commands"
    )]
    ForeignCommand {
        participant: String,
        command: String,
    },
    #[error("no solver of kind `{0}` is built in")]
    NoSolver(String),
    #[error("participant `{participant}`: {problem}")]
    UnknownKind {
        participant: String,
        problem: String,
    },
    #[error("participant `{participant}`: {problem}")]
    NoProgram {
        participant: String,
        problem: String,
    },
    #[error("the run's state cannot be written down: {0}")]
    NoState(String),
    #[error("the log: {0}")]
    Frame(#[from] FrameError),
    #[error("a tape broke")]
    BrokenTape,
    #[error("{0}; resume with the build and the scenario that wrote it")]
    Unusable(String),
    #[error(
        "participant `{participant}` speaks protocol version {theirs}, the coordinator speaks {ours}: build both from the same release"
    )]
    Version {
        participant: String,
        theirs: u32,
        ours: u32,
    },
    #[error(
        "participant `{participant}` {what} {theirs}, the coordinator {ours}: build both from the same release and launch both for the same run"
    )]
    OtherRun {
        participant: String,
        what: &'static str,
        theirs: String,
        ours: String,
    },
    #[error("no participant `{name}` in this run; participants: {known}")]
    NoParticipant { name: String, known: String },
    #[error("no participant has a load history that ends: give run.end_s")]
    NoEnd,
    #[error("a solver that ran alone has no coupler to replay")]
    NoCoupler,
    #[error("checkpoint {}: {problem}", path.display())]
    Checkpoint { path: PathBuf, problem: String },
    #[error("the handshake is not that of the log: {why}; resume with the build that wrote it")]
    OtherHandshake { why: String },
    #[error(
        "the handshake ended before that of the log, which goes on with a message of `{sender}`: resume with the build that wrote it"
    )]
    ShortHandshake { sender: String },
}

impl Refusal {
    /// Its code.
    pub fn code(&self) -> Code {
        match self {
            Refusal::Unfit(unfit) => code_of_unfit(unfit),
            Refusal::Argument { .. } => Code::Usage,
            Refusal::NoScenario { .. } => Code::NoScenario,
            Refusal::File { .. } => Code::FileUnfit,
            Refusal::EmptyExport => Code::NothingChosen,
            Refusal::Benchmark(_) => Code::MeasurementFailed,
            Refusal::NotLaunched(error) => code_of_participation(error),
            Refusal::ForeignCommand { .. } => Code::ForeignCommand,
            Refusal::NoSolver(_) | Refusal::UnknownKind { .. } => Code::UnknownKind,
            Refusal::NoProgram { .. } => Code::CommandNotFound,
            Refusal::NoState(_) | Refusal::Unusable(_) | Refusal::Checkpoint { .. } => {
                Code::Of(Cause::CheckpointUnusable)
            }
            Refusal::OtherHandshake { .. } | Refusal::ShortHandshake { .. } => {
                Code::Of(Cause::CheckpointUnusable)
            }
            Refusal::Frame(_) => Code::FileUnfit,
            Refusal::BrokenTape => Code::ReplayBroken,
            Refusal::Version { .. } | Refusal::OtherRun { .. } => Code::Of(Cause::OtherRelease),
            Refusal::NoParticipant { .. } => Code::UnknownParticipant,
            Refusal::NoEnd => Code::NoEnd,
            Refusal::NoCoupler => Code::NoCoupler,
        }
    }

    /// An argument of the command line.
    pub fn argument(argument: impl Into<String>, problem: impl Into<String>) -> Refusal {
        Refusal::Argument {
            argument: argument.into(),
            problem: problem.into(),
        }
    }

    /// A file that is not what it should be.
    pub fn file(path: impl Into<PathBuf>, problem: impl Into<String>) -> Refusal {
        Refusal::File {
            path: path.into(),
            problem: problem.into(),
        }
    }

    /// A participant that cannot do its part; the problem goes on from its name.
    pub fn participant(participant: &str, problem: impl Into<String>) -> Refusal {
        Unfit::participant(participant, problem).into()
    }
}

fn code_of_unfit(unfit: &Unfit) -> Code {
    match unfit {
        Unfit::SingularImpedance { .. } | Unfit::SingularMasses => Code::NoInverse,
        Unfit::Geometry { .. } => Code::SurfacesApart,
        Unfit::Participant { .. } => Code::ParticipantUnfit,
        Unfit::Key { .. } => Code::SchemeUnsuited,
        Unfit::Interface { .. } => Code::InterfaceUnfit,
        Unfit::UnknownSet { .. } => Code::Of(Cause::UnknownSet),
        Unfit::WindowTooLong { .. } => Code::WindowTooLong,
        Unfit::Roles { .. } => Code::WrongRoles,
        Unfit::Windows(..) => Code::WindowsDiffer,
        Unfit::Unstable { .. } => Code::UnstableWindow,
        Unfit::TooManySteps { .. } => Code::TooManySteps,
    }
}

/// The code of a participant's own process that stopped.
fn code_of_participation(error: &ParticipateError) -> Code {
    match error {
        ParticipateError::NoSession
        | ParticipateError::Session { .. }
        | ParticipateError::NoChannel => Code::NotLaunched,
        ParticipateError::Signals(_) => Code::InputFailed,
        ParticipateError::Orphan(_) | ParticipateError::Link(_) => Code::CoordinatorGone,
        ParticipateError::Serve(error) => match error {
            ServeError::Link(_) | ServeError::Silent { .. } => Code::CoordinatorGone,
            ServeError::Frame(_) => Code::Of(Cause::ProtocolViolated),
            ServeError::Node(error) => Code::Of(error.cause()),
        },
    }
}
