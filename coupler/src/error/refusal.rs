//! Reasons for which a run or a verb is refused.

use std::path::PathBuf;

use protocol::participate::ParticipateError;
use protocol::{Cause, FrameError, ServeError};
use thiserror::Error;

use super::code::Code;

/// Something that cannot be followed: an argument, a file, a key of the scenario, or a participant that does not fit.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum Refusal {
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
    #[error("participant `{participant}`: {problem}")]
    SingularImpedance {
        participant: String,
        problem: String,
    },
    #[error("interface `{interface}` between {} and {}: {why}", between[0], between[1])]
    Geometry {
        interface: String,
        between: [String; 2],
        why: String,
    },
    #[error("the masses of the glued points on the surface nodes have no inverse")]
    SingularMasses,
    #[error("the run's state cannot be written down: {0}")]
    NoState(String),
    #[error("the log: {0}")]
    Frame(#[from] FrameError),
    #[error("a tape broke")]
    BrokenTape,
    #[error("{0}; resume with the build and the scenario that wrote it")]
    Unusable(String),
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
    WindowTooLong { interface: String, problem: String },
    #[error(
        "interface `{interface}` joins {} and {}: it takes one participant that advances under forces and one that stands on a compliant wall", between[0], between[1]
    )]
    Roles {
        interface: String,
        between: [String; 2],
    },
    #[error(
        "interfaces `{}` and `{}` are connected but have windows of {:.9e} s ({} x {:.9e} s) and {:.9e} s ({} x {:.9e} s): give substeps and time.step_s with the same product",
        .0.interface, .1.interface,
        .0.window_s(), .0.substeps, .0.step_s,
        .1.window_s(), .1.substeps, .1.step_s
    )]
    Windows(WindowOf, WindowOf),
    #[error(
        "interface `{interface}`: scheme {scheme} with {substeps} substeps is predicted to be unstable{bound}: a disturbance grows {growth:.3}-fold a window; take scheme = \"dual-schur\"{other_way} or fewer substeps, or set interface.{interface}.unsafe_window = true to see it fail"
    )]
    Unstable {
        interface: String,
        scheme: String,
        substeps: u32,
        /// The bound that is broken, if it has a name.
        bound: String,
        growth: f64,
        /// Another remedy, if there is one.
        other_way: &'static str,
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
    #[error("checkpoint {}: {problem}", path.display())]
    Checkpoint { path: PathBuf, problem: String },
    #[error("the handshake is not that of the log: {why}; resume with the build that wrote it")]
    OtherHandshake { why: String },
    #[error(
        "the handshake ended before that of the log, which goes on with a message of `{sender}`: resume with the build that wrote it"
    )]
    ShortHandshake { sender: String },
}

/// The window of an interface.
#[derive(Clone, Debug)]
pub struct WindowOf {
    /// The interface.
    pub interface: String,
    /// Steps in it.
    pub substeps: u32,
    /// Step of its continuum (s).
    pub step_s: f64,
}

impl WindowOf {
    fn window_s(&self) -> f64 {
        self.step_s * f64::from(self.substeps)
    }
}

impl Refusal {
    /// Its code.
    pub fn code(&self) -> Code {
        match self {
            Refusal::Argument { .. } => Code::Usage,
            Refusal::NoScenario { .. } => Code::NoScenario,
            Refusal::File { .. } => Code::FileUnfit,
            Refusal::EmptyExport => Code::NothingChosen,
            Refusal::Picture(_) => Code::PictureFailed,
            Refusal::Benchmark(_) => Code::MeasurementFailed,
            Refusal::NotLaunched(error) => code_of_participation(error),
            Refusal::ForeignCommand { .. } => Code::ForeignCommand,
            Refusal::NoSolver(_) | Refusal::UnknownKind { .. } => Code::UnknownKind,
            Refusal::NoProgram { .. } => Code::CommandNotFound,
            Refusal::SingularImpedance { .. } | Refusal::SingularMasses => Code::NoInverse,
            Refusal::Geometry { .. } => Code::SurfacesApart,
            Refusal::NoState(_) | Refusal::Unusable(_) | Refusal::Checkpoint { .. } => {
                Code::Of(Cause::CheckpointUnusable)
            }
            Refusal::OtherHandshake { .. } | Refusal::ShortHandshake { .. } => {
                Code::Of(Cause::CheckpointUnusable)
            }
            Refusal::Frame(_) => Code::FileUnfit,
            Refusal::BrokenTape => Code::ReplayBroken,
            Refusal::Participant { .. } => Code::ParticipantUnfit,
            Refusal::Version { .. } | Refusal::OtherRun { .. } => Code::Of(Cause::OtherRelease),
            Refusal::NoParticipant { .. } => Code::UnknownParticipant,
            Refusal::NoEnd => Code::NoEnd,
            Refusal::NoCoupler => Code::NoCoupler,
            Refusal::Key { .. } => Code::SchemeUnsuited,
            Refusal::Interface { .. } => Code::InterfaceUnfit,
            Refusal::UnknownSet { .. } => Code::Of(Cause::UnknownSet),
            Refusal::WindowTooLong { .. } => Code::WindowTooLong,
            Refusal::Roles { .. } => Code::WrongRoles,
            Refusal::Windows(..) => Code::WindowsDiffer,
            Refusal::Unstable { .. } => Code::UnstableWindow,
            Refusal::TooManySteps { .. } => Code::TooManySteps,
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
        Refusal::Participant {
            participant: participant.into(),
            problem: problem.into(),
        }
    }

    /// An interface that cannot be built.
    pub fn interface(interface: &str, problem: impl Into<String>) -> Refusal {
        Refusal::Interface {
            interface: interface.into(),
            problem: problem.into(),
        }
    }

    /// A key of the scenario that does not fit what the participants said; the problem goes on from it.
    pub fn key(key: impl Into<String>, problem: impl Into<String>) -> Refusal {
        Refusal::Key {
            key: key.into(),
            problem: problem.into(),
        }
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
