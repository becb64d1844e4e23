//! Codes of errors: a word for each cause that has a cure of its own, with its exit code and the status of summary.json.

use protocol::{Cause, FaultCode};

/// Exit code of a log that is damaged inside.
pub const DAMAGED: i32 = 6;

/// Makes the enum with its list, words and endings from one table, so that no code is without.
macro_rules! codes {
    ($($(#[doc = $doc:literal])+ $name:ident, $word:literal, $exit:expr, $status:literal;)*) => {
        /// Code of an error.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Code {
            /// Of a key, or told by a participant.
            Of(Cause),
            $($(#[doc = $doc])+ $name,)*
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

            /// Its documentation: a sentence, then why it comes and what to do.
            pub fn doc(self) -> &'static str {
                match self {
                    Code::Of(cause) => cause.doc(),
                    $(Code::$name => concat!($($doc, "\n"),+),)*
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
    /// The command line cannot be followed.
    ///
    /// - Why: an unknown verb or flag, a value out of its range, an override that names nothing.
    /// - Do: `thirdbody VERB --help`.
    Usage, "usage", 2, "refused";
    /// The scenario is not TOML.
    ///
    /// - Why: a quotation mark, bracket or comma is missing, or a table is opened twice.
    /// - Do: look at the place that the message points at, and at the line before.
    TomlSyntax, "toml-syntax", 2, "refused";
    /// No scenario has this name.
    ///
    /// - Why: names under scenarios/ hold in the folder that has it; a folder needs a
    ///   scenario.toml.
    /// - Do: give a path, or one of the names that the message lists.
    NoScenario, "no-scenario", 2, "refused";
    /// No solver of this kind is built in.
    ///
    /// - Why: the kind is mistyped, or a program of your own has no command.
    /// - Do: write `fem` or `dem`, or give `command`.
    UnknownKind, "unknown-kind", 2, "refused";
    /// The command of a participant is not a program that can be started.
    ///
    /// - Why: it is not on PATH (a Python environment that is not active), or its path does not
    ///   count from the folder of the scenario.
    /// - Do: activate the environment, build the program, or give its path from the root.
    CommandNotFound, "command-not-found", 2, "refused";
    /// A scenario that was handed on starts a program of its own.
    ///
    /// - Why: replay, resume and received scenarios do not start unknown programs unasked.
    /// - Do: read the command; then repeat with `--allow-commands`.
    ForeignCommand, "foreign-command", 2, "refused";
    /// A file cannot be read, or a process not be started.
    ///
    /// - Why: it is not there, or the user has no right or no room for it.
    /// - Do: the message ends with what the system said, and with what to do about it where that is
    ///   known.
    InputFailed, "input-failed", 2, "refused";
    /// A file or folder is not what the verb needs.
    ///
    /// - Why: another kind of file, one that was cut off or written by hand, or a folder that is
    ///   there already.
    /// - Do: give a run directory or the file that the message names.
    FileUnfit, "file-unfit", 2, "refused";
    /// No message of the log was chosen.
    ///
    /// - Why: the filters leave nothing.
    /// - Do: `thirdbody inspect` lists the streams.
    NothingChosen, "nothing-chosen", 2, "refused";
    /// A benchmark or a trial came to nothing.
    ///
    /// - Why: the machine is too busy, or what was to be measured failed.
    /// - Do: read the message; repeat it on an idle machine.
    MeasurementFailed, "measurement-failed", 2, "refused";
    /// This program is a participant and nobody launched it.
    ///
    /// - Why: it was started by hand, without the session that the coordinator writes.
    /// - Do: `thirdbody run` starts it.
    NotLaunched, "not-launched", 2, "refused";
    /// The coordinator of this participant has ended.
    ///
    /// - Why: it was killed or stopped, and the participant ends itself.
    /// - Do: look at the end of logs/coordinator.log; `thirdbody resume`.
    CoordinatorGone, "coordinator-gone", 2, "refused";
    /// A participant cannot take the part that the scenario gives it.
    ///
    /// - Why: it cannot run alone, or not in the coordinator's process, or would have two roles.
    /// - Do: change the key that the message names.
    ParticipantUnfit, "participant-unfit", 2, "refused";
    /// The run has no participant of this name.
    ///
    /// - Why: it is mistyped, or of another run.
    /// - Do: take one of those that the message lists.
    UnknownParticipant, "unknown-participant", 2, "refused";
    /// An interface cannot be built, or not taken up again.
    ///
    /// - Why: it joins too few participants, its points cannot be related, or a checkpoint is of
    ///   other interfaces.
    /// - Do: compare `between` with the sets of both sides; `thirdbody check` tells them.
    InterfaceUnfit, "interface-unfit", 2, "refused";
    /// The points of two sets do not fit each other.
    ///
    /// - Why: they face the same way, lie beyond each other's ends, or repeat with another period.
    /// - Do: look at both sets in their own coordinates; often two interfaces are exchanged, or a
    ///   size is in another unit.
    SurfacesApart, "surfaces-apart", 2, "refused";
    /// An interface joins two sides of the same kind.
    ///
    /// - Why: it takes one that advances under forces and one that stands on a wall.
    /// - Do: join a body and grains; two bodies need grains between them.
    WrongRoles, "wrong-roles", 2, "refused";
    /// Connected interfaces have windows of different lengths.
    ///
    /// - Why: steps and `substeps` of their bodies have different products.
    /// - Do: give `substeps` and `time.step_s` with the same product.
    WindowsDiffer, "windows-differ", 2, "refused";
    /// The window is above the bound of the solver on the wall.
    ///
    /// - Why: grains move by no more than a part of their inertial time in a window.
    /// - Do: lower `substeps` to what the message names, or raise `mass_scale`.
    WindowTooLong, "window-too-long", 2, "refused";
    /// The coupling is predicted to be unstable.
    ///
    /// - Why: the window is long for the stiffness and masses at the interface, the scheme is
    ///   naive, or the own step of the continuum is beyond its limit.
    /// - Do: what the message says: a shorter step, fewer `substeps`, or `scheme = "dual-schur"`.
    ///   `unsafe_window = true` shows how it fails.
    UnstableWindow, "unstable-window", 2, "refused";
    /// A key of an interface or of the run does not fit what the participants say of themselves.
    ///
    /// - Why: the scheme asks for more than a side offers, or a tolerance is finer than its
    ///   solver's.
    /// - Do: take the value or the scheme that the message names.
    SchemeUnsuited, "scheme-unsuited", 2, "refused";
    /// Masses or an impedance at an interface have no inverse.
    ///
    /// - Why: points without mass, or a step above the stability limit.
    /// - Do: lower `time.step_s`, or take `scheme = "dual-schur"`.
    NoInverse, "no-inverse", 2, "refused";
    /// Nothing says when the run ends.
    ///
    /// - Why: no participant has a load history that ends.
    /// - Do: give `run.end_s`.
    NoEnd, "no-end", 2, "refused";
    /// The run would take more steps than can be waited for.
    ///
    /// - Why: an end or a load history in another unit, or a very short step.
    /// - Do: check `run.end_s`, `time.step_s` and the wheel's history.
    TooManySteps, "too-many-steps", 2, "refused";
    /// There is no coupler to replay.
    ///
    /// - Why: the solver ran alone.
    /// - Do: replay the participant.
    NoCoupler, "no-coupler", 2, "refused";
    /// A replay lost the record that it plays.
    ///
    /// - Why: a fault of the program or of the machine.
    /// - Do: repeat it; tell us if it comes again.
    ReplayBroken, "replay-broken", 2, "refused";
    /// A window did not converge.
    ///
    /// - Why: too few repeats, a tolerance finer than the solvers', a continuum that is not linear
    ///   under `dual-schur`.
    /// - Do: raise `repeats_max` or `tolerance_rel`, take `dual-schur-secant`, or decide by
    ///   `on_not_converged`.
    NotConverged, "not-converged", 3, "not_converged";
    /// A participant answered a number that is none.
    ///
    /// - Why: it diverged in this window.
    /// - Do: shorten the window, or let it be halved: `on_not_converged = "halve"`.
    NotFinite, "not-finite", 3, "diverged";
    /// The answers of a participant contradict its ledger.
    ///
    /// - Why: it does not answer for the state that it keeps, or counts its work wrongly.
    /// - Do: `thirdbody conform` tells which rule it breaks.
    Inconsistent, "inconsistent", 3, "inconsistent";
    /// A participant is gone.
    ///
    /// - Why: it crashed or was killed; the system may have ended it for its memory.
    /// - Do: read `logs/<name>.log`, then go on with `thirdbody resume`.
    PeerLost, "peer-lost", 4, "peer_lost";
    /// A participant did not answer in time.
    ///
    /// - Why: it is stopped or waits for something; or its answer takes longer than `run.deadlines`
    ///   allows; or, with `link_s`, its host or the network to it is gone.
    /// - Do: read `logs/<name>.log`; raise the deadline that the message names.
    DeadlineMissed, "deadline-missed", 5, "deadline";
    /// The exchange log is damaged.
    ///
    /// - Why: its writer was killed, or the file was changed on its way.
    /// - Do: what comes before the damage is valid: `--recover` accepts it.
    LogCorrupt, "log-corrupt", DAMAGED, "log_corrupt";
    /// A table of a run (`signals.csv`, `profile.csv`, those beside the fields) or a file of its
    /// fields is not what the run wrote.
    ///
    /// - Why: it was changed, cut off or removed after the run, or copied in part: its size, its
    ///   rows or its blake3 are not those of `tables` or `fields.blake3` in summary.json.
    /// - Do: put the table back, or make the run again: `thirdbody run RUN/scenario.toml` gives the
    ///   same table with the same build.
    TableDamaged, "table-damaged", DAMAGED, "refused";
    /// The file is not an exchange log.
    ///
    /// - Why: another file, or one whose writer was killed at its very beginning.
    /// - Do: give a run directory, or its exchange.mcap.
    NotALog, "not-a-log", DAMAGED, "log_corrupt";
    /// The exchange log took nothing for a long time.
    ///
    /// - Why: a disk or a network drive that hangs.
    /// - Do: write to a local disk with `--out`.
    LogStalled, "log-stalled", 9, "output_failed";
    /// A signal ended the run in order; its number is added to the exit code.
    ///
    /// - Why: Ctrl-C, a closed terminal, a queue that ends its jobs.
    /// - Do: `thirdbody resume` goes on from the last checkpoint.
    Interrupted, "interrupted", 128, "interrupted";
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
