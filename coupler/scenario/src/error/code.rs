//! Codes of errors: a word for each cause that has a cure of its own, with its exit code and the status of summary.json.

use protocol::{Cause, FaultCode};

/// Exit code of a log that is damaged inside.
pub const DAMAGED: i32 = 6;

/// Makes the enum with its list, words and endings from one table, so that no code is without.
macro_rules! codes {
    ($($name:ident, $word:literal, $exit:expr, $status:literal, $doc:literal;)*) => {
        /// Code of an error.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Code {
            /// Of a key, or told by a participant.
            Of(Cause),
            $(#[doc = $doc] $name,)*
        }

        /// The codes that are the coupler's own.
        const OWN: &[Code] = &[$(Code::$name),*];

        impl Code {
            /// Its word in messages and files.
            pub fn word(self) -> &'static str {
                match self {
                    Code::Of(cause) => cause.word(),
                    $(Code::$name => $word,)*
                }
            }

            /// Exit code of the program and status of the run.
            pub fn ending(self) -> (i32, &'static str) {
                match self {
                    Code::Of(cause) => ending_of(cause.fault()),
                    $(Code::$name => ($exit, $status),)*
                }
            }
        }
    };
}

codes! {
    Usage, "usage", 2, "refused", "An argument of the command line.";
    TomlSyntax, "toml-syntax", 2, "refused", "A scenario that is not TOML.";
    NoScenario, "no-scenario", 2, "refused", "No scenario of that name.";
    UnknownKind, "unknown-kind", 2, "refused", "A kind of solver that is not built in.";
    CommandNotFound, "command-not-found", 2, "refused", "A program of a participant that is not there.";
    ForeignCommand, "foreign-command", 2, "refused", "A received scenario that starts a program.";
    InputFailed, "input-failed", 2, "refused", "A file that cannot be read, a process that cannot be started.";
    FileUnfit, "file-unfit", 2, "refused", "A file or folder that is not what the verb needs.";
    NothingChosen, "nothing-chosen", 2, "refused", "An export without messages.";
    MeasurementFailed, "measurement-failed", 2, "refused", "A benchmark or trial that came to nothing.";
    NotLaunched, "not-launched", 2, "refused", "A participant's program that nobody launched.";
    CoordinatorGone, "coordinator-gone", 2, "refused", "A participant whose coordinator has ended.";
    ParticipantUnfit, "participant-unfit", 2, "refused", "A participant that cannot take that part.";
    UnknownParticipant, "unknown-participant", 2, "refused", "No participant of that name in the run.";
    InterfaceUnfit, "interface-unfit", 2, "refused", "An interface that cannot be built.";
    SurfacesApart, "surfaces-apart", 2, "refused", "Two sets whose points do not fit.";
    WrongRoles, "wrong-roles", 2, "refused", "An interface of two sides of the same kind.";
    WindowsDiffer, "windows-differ", 2, "refused", "Connected interfaces with windows of their own.";
    WindowTooLong, "window-too-long", 2, "refused", "A window above the bound of the grains.";
    UnstableWindow, "unstable-window", 2, "refused", "A window that is predicted to be unstable.";
    SchemeUnsuited, "scheme-unsuited", 2, "refused", "A scheme that asks for more than a side offers.";
    NoInverse, "no-inverse", 2, "refused", "Masses or an impedance without an inverse.";
    NoEnd, "no-end", 2, "refused", "A run without an end.";
    TooManySteps, "too-many-steps", 2, "refused", "A run of more steps than can be waited for.";
    NoCoupler, "no-coupler", 2, "refused", "A replay of a coupler that there was none of.";
    ReplayBroken, "replay-broken", 2, "refused", "A replay that lost its tape.";
    NotConverged, "not-converged", 3, "not_converged", "A window that did not converge.";
    NotFinite, "not-finite", 3, "diverged", "An answer that is no number.";
    Inconsistent, "inconsistent", 3, "inconsistent", "Answers and ledger that contradict each other.";
    PeerLost, "peer-lost", 4, "peer_lost", "A participant that is gone.";
    DeadlineMissed, "deadline-missed", 5, "deadline", "A participant that did not answer in time.";
    LogCorrupt, "log-corrupt", DAMAGED, "log_corrupt", "A log that is damaged.";
    TableDamaged, "table-damaged", DAMAGED, "refused", "A table of a run that is not what the run wrote.";
    NotALog, "not-a-log", DAMAGED, "log_corrupt", "A file that is no exchange log.";
    LogStalled, "log-stalled", 9, "output_failed", "A disk that takes nothing.";
    Interrupted, "interrupted", 128, "interrupted", "A signal that ended the run.";
}

impl Code {
    /// All codes.
    pub fn all() -> impl Iterator<Item = Code> {
        let causes = Cause::ALL.iter().copied().map(Code::Of);
        causes.chain(OWN.iter().copied())
    }

    /// Exit code of an error with this code; that of `interrupted` is what the number of the signal is added to.
    pub fn exit_code(self) -> i32 {
        self.ending().0
    }
}

fn ending_of(fault: FaultCode) -> (i32, &'static str) {
    match fault {
        FaultCode::Configuration => (2, "refused"),
        FaultCode::Diverged => (3, "diverged"),
        FaultCode::Protocol => (4, "protocol"),
        FaultCode::Output => (9, "output_failed"),
    }
}
