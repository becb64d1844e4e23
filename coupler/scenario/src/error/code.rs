//! Error codes: a word for each cause with its own remedy, its exit code and the status in summary.json.

use protocol::{Cause, FaultCode};

/// Exit code for damaged logs and tables.
pub const DAMAGED: i32 = 6;

/// Makes the enum with its list, words and endings from one table, so that every code has all of them.
macro_rules! codes {
    ($($(#[doc = $doc:literal])+ $name:ident, $word:literal, $exit:expr, $status:literal;)*) => {
        /// Code of an error.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Code {
            /// Cause of a faulty key, or reported by a participant.
            Of(Cause),
            $($(#[doc = $doc])+ $name,)*
        }

        /// The coupler's own codes.
        const OWN: &[Code] = &[$(Code::$name),*];

        impl Code {
            /// Its word in messages and files.
            pub fn word(self) -> &'static str {
                match self {
                    Code::Of(cause) => cause.word(),
                    $(Code::$name => $word,)*
                }
            }

            /// Its documentation: a sentence, then the cause and the remedy.
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
    /// The command line is not valid.
    ///
    /// - Why: an unknown verb or flag, a value out of range, or an override of a key that does not exist.
    /// - Do: see `thirdbody VERB --help`.
    Usage, "usage", 2, "refused";
    /// The scenario is not TOML.
    ///
    /// - Why: a quotation mark, bracket or comma is missing, or a table is opened twice.
    /// - Do: look at the position in the message, and at the line before it.
    TomlSyntax, "toml-syntax", 2, "refused";
    /// No scenario has this name.
    ///
    /// - Why: names under scenarios/ are known only in the folder that contains scenarios/; a folder needs a
    ///   scenario.toml.
    /// - Do: give a path, or one of the names that the message lists.
    NoScenario, "no-scenario", 2, "refused";
    /// No solver of this kind is built in.
    ///
    /// - Why: the kind is mistyped, or a program of your own has no command.
    /// - Do: write `fem` or `dem`, or give `command`.
    UnknownKind, "unknown-kind", 2, "refused";
    /// The command of a participant cannot be started.
    ///
    /// - Why: it is not on PATH (a Python environment is not active), or its path is not relative to the folder of the
    ///   scenario.
    /// - Do: activate the environment, build the program, or give its absolute path.
    CommandNotFound, "command-not-found", 2, "refused";
    /// A scenario from elsewhere starts a program of its own.
    ///
    /// - Why: replay, resume and received scenarios start no unknown program without your consent.
    /// - Do: read the command, then repeat with `--allow-commands`.
    ForeignCommand, "foreign-command", 2, "refused";
    /// A file cannot be read, or a process cannot be started.
    ///
    /// - Why: it does not exist, or you lack the permission or the resources for it.
    /// - Do: the message ends with the system's error and, where known, with the remedy.
    InputFailed, "input-failed", 2, "refused";
    /// A file or folder is not the kind that the verb needs.
    ///
    /// - Why: it is another kind of file, was cut off or written by hand, or is a folder that exists already.
    /// - Do: give a run directory, or the file that the message names.
    FileUnfit, "file-unfit", 2, "refused";
    /// No message of the log was selected.
    ///
    /// - Why: no message passes the filters.
    /// - Do: `thirdbody inspect` lists the streams.
    NothingChosen, "nothing-chosen", 2, "refused";
    /// A benchmark or a trial gave no result.
    ///
    /// - Why: the machine is too busy, or the measured run failed.
    /// - Do: read the message, and repeat it on an idle machine.
    MeasurementFailed, "measurement-failed", 2, "refused";
    /// This program is a participant, but no coordinator launched it.
    ///
    /// - Why: it was started by hand, without the session file that the coordinator writes.
    /// - Do: start it with `thirdbody run`.
    NotLaunched, "not-launched", 2, "refused";
    /// The coordinator of this participant has ended.
    ///
    /// - Why: it was killed or stopped, so the participant ended itself.
    /// - Do: read the end of logs/coordinator.log, then continue with `thirdbody resume`.
    CoordinatorGone, "coordinator-gone", 2, "refused";
    /// A participant cannot take its part in the scenario.
    ///
    /// - Why: it cannot run alone, cannot run in the coordinator's process, or would have two roles.
    /// - Do: change the key that the message names.
    ParticipantUnfit, "participant-unfit", 2, "refused";
    /// The run has no participant of this name.
    ///
    /// - Why: the name is mistyped, or belongs to another run.
    /// - Do: take one of the names in the message.
    UnknownParticipant, "unknown-participant", 2, "refused";
    /// An interface cannot be built or resumed.
    ///
    /// - Why: it joins too few participants, its points cannot be mapped, or the checkpoint belongs to other
    ///   interfaces.
    /// - Do: compare `between` with the sets of both participants.
    InterfaceUnfit, "interface-unfit", 2, "refused";
    /// The points of two sets do not fit each other.
    ///
    /// - Why: they face the same way, extend beyond each other's ends, or have different periods.
    /// - Do: look at both sets in their own coordinates; often two interfaces are swapped, or a size is in the wrong
    ///   unit.
    SurfacesApart, "surfaces-apart", 2, "refused";
    /// An interface joins two sides of the same kind.
    ///
    /// - Why: it needs one side that advances under forces and one that stands on a wall.
    /// - Do: join a body and grains; two bodies need grains between them.
    WrongRoles, "wrong-roles", 2, "refused";
    /// Connected interfaces have windows of different lengths.
    ///
    /// - Why: the product of `time.step_s` and `substeps` differs between their bodies.
    /// - Do: choose `substeps` and `time.step_s` with the same product.
    WindowsDiffer, "windows-differ", 2, "refused";
    /// The window is longer than the solver on the wall allows.
    ///
    /// - Why: a window of grains may last no longer than their inertial time.
    /// - Do: lower `substeps` to the value in the message, or raise `mass_scale`.
    WindowTooLong, "window-too-long", 2, "refused";
    /// The coupling is predicted to be unstable.
    ///
    /// - Why: the window is too long for the stiffness and masses at the interface, the scheme is naive, or the
    ///   continuum's own step exceeds its limit.
    /// - Do: follow the message: a shorter step, fewer `substeps`, or `scheme = "dual-schur"`. `unsafe_window = true`
    ///   shows how it fails.
    UnstableWindow, "unstable-window", 2, "refused";
    /// A key of an interface or of the run does not fit the participants' descriptions.
    ///
    /// - Why: the scheme needs a capability that a side lacks, or a tolerance is finer than the solver's.
    /// - Do: take the value or the scheme that the message names.
    SchemeUnsuited, "scheme-unsuited", 2, "refused";
    /// Masses or an impedance at an interface have no inverse.
    ///
    /// - Why: points without mass, or a step above the stability limit.
    /// - Do: lower `time.step_s`, or take `scheme = "dual-schur"`.
    NoInverse, "no-inverse", 2, "refused";
    /// The run has no defined end.
    ///
    /// - Why: no participant has a load history with an end.
    /// - Do: give `run.end_s`.
    NoEnd, "no-end", 2, "refused";
    /// The run would need far too many steps.
    ///
    /// - Why: the end or a load history is in the wrong unit, or the step is very short.
    /// - Do: check `run.end_s`, `time.step_s` and the wheel's load history.
    TooManySteps, "too-many-steps", 2, "refused";
    /// There is no coupler to replay.
    ///
    /// - Why: the solver ran alone.
    /// - Do: replay the participant.
    NoCoupler, "no-coupler", 2, "refused";
    /// A replay lost the record that it replays.
    ///
    /// - Why: a bug in the program or a fault of the machine.
    /// - Do: repeat it, and report it to us if it happens again.
    ReplayBroken, "replay-broken", 2, "refused";
    /// A window did not converge.
    ///
    /// - Why: too few repeats, a tolerance finer than the solvers', or a nonlinear continuum under `dual-schur`.
    /// - Do: raise `repeats_max` or `tolerance_rel`, take `dual-schur-secant`, or set `on_not_converged`.
    NotConverged, "not-converged", 3, "not_converged";
    /// A participant answered NaN or infinity.
    ///
    /// - Why: it diverged in this window.
    /// - Do: shorten the window, or have it halved: `on_not_converged = "halve"`.
    NotFinite, "not-finite", 3, "diverged";
    /// The answers of a participant contradict its energy ledger.
    ///
    /// - Why: its answers do not belong to the state that it keeps, or it counts its work wrongly.
    /// - Do: `thirdbody conform` names the rule that it breaks.
    Inconsistent, "inconsistent", 3, "inconsistent";
    /// A participant ended in the middle of the run.
    ///
    /// - Why: it crashed or was killed, perhaps by the system for lack of memory.
    /// - Do: read `logs/<name>.log`, then continue with `thirdbody resume`.
    PeerLost, "peer-lost", 4, "peer_lost";
    /// A participant did not answer in time.
    ///
    /// - Why: it is stopped or waits for something, its answer takes longer than `run.deadlines` allows, or, for
    ///   `link_s`, its host or the network to it is down.
    /// - Do: read `logs/<name>.log`, and raise the deadline that the message names.
    DeadlineMissed, "deadline-missed", 5, "deadline";
    /// The exchange log is damaged.
    ///
    /// - Why: its writer was killed, or the file was damaged in a copy.
    /// - Do: the part before the damage is valid: `--recover` reads it.
    LogCorrupt, "log-corrupt", DAMAGED, "log_corrupt";
    /// A table of a run (`signals.csv`, `profile.csv`, the tables in `fields/`) or a file of its fields differs from
    /// what the run wrote.
    ///
    /// - Why: it was changed, cut off, removed or only partly copied after the run: its size, its rows or its blake3
    ///   differ from `tables` or `fields.blake3` in summary.json.
    /// - Do: put the file back, or repeat the run: with the same build, `thirdbody run RUN/scenario.toml` writes the
    ///   same file.
    TableDamaged, "table-damaged", DAMAGED, "refused";
    /// The file is not an exchange log.
    ///
    /// - Why: it is another kind of file, or its writer was killed at the very start.
    /// - Do: give a run directory, or its exchange.mcap.
    NotALog, "not-a-log", DAMAGED, "log_corrupt";
    /// The exchange log could not be written for a long time.
    ///
    /// - Why: a disk or a network drive hangs.
    /// - Do: write to a local disk with `--out`.
    LogStalled, "log-stalled", 9, "output_failed";
    /// A signal ended the run in an orderly way; its number is added to the exit code.
    ///
    /// - Why: Ctrl-C, a closed terminal, or a queue that ends its jobs.
    /// - Do: continue from the last checkpoint with `thirdbody resume`.
    Interrupted, "interrupted", 128, "interrupted";
}

impl Code {
    /// All codes.
    pub fn all() -> impl Iterator<Item = Code> {
        let causes = Cause::ALL.iter().copied().map(Code::Of);
        causes.chain(OWN.iter().copied())
    }

    /// Exit code of an error with this code; for `interrupted`, the number of the signal is added.
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
