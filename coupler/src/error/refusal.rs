//! Reasons for which a run or a verb is refused.

use std::path::PathBuf;

use protocol::participate::ParticipateError;
use thiserror::Error;

/// Something that cannot be followed: an argument, a file, a key of the scenario, or a participant that does not fit.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum Refusal {
    #[error("{argument}: {problem}")]
    Argument { argument: String, problem: String },
    #[error(
        "no scenario `{name}`: give a folder with scenario.toml, a file, or a name under scenarios/{known}"
    )]
    NoScenario { name: String, known: String },
    #[error("{}: {problem}", path.display())]
    File { path: PathBuf, problem: String },
    #[error("no message was chosen: `thirdbody inspect` lists the streams")]
    EmptyExport,
    #[error("the picture cannot be drawn: {0}")]
    Picture(String),
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
    #[error("participant `{participant}` {problem}")]
    Participant {
        participant: String,
        problem: String,
    },
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
        Refusal::Participant {
            participant: participant.into(),
            problem: problem.into(),
        }
    }
}
