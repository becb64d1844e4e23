//! Causes of errors: a word for each that has a cure of its own. Scripts and `thirdbody explain` go by it.

use serde::{Deserialize, Deserializer, Serialize};

/// Kind of the fault that ended a participant; the exit code of the run follows from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultCode {
    /// The scenario or a request cannot be followed.
    Configuration,
    /// The solution left the finite numbers or a solver did not converge.
    Diverged,
    /// The conversation broke: a frame that does not belong here.
    Protocol,
    /// A file cannot be written, for instance on a full disk.
    Output,
}

/// Makes the enum with its list, its words and the faults that they belong to from one table, so that no cause is without.
macro_rules! causes {
    ($($name:ident, $word:literal, $fault:ident, $doc:literal;)*) => {
        /// Cause of an error that a key of the scenario has, or that ends a participant.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum Cause {
            $(#[doc = $doc] $name,)*
        }

        impl Cause {
            /// All of them.
            pub const ALL: &[Cause] = &[$(Cause::$name),*];

            /// Its word: that of messages, of summary.json and of the wire.
            pub fn word(self) -> &'static str {
                match self {
                    $(Cause::$name => $word,)*
                }
            }

            /// The fault that it is a case of; the exit code of the run follows from it.
            pub fn fault(self) -> FaultCode {
                match self {
                    $(Cause::$name => FaultCode::$fault,)*
                }
            }
        }
    };
}

causes! {
    UnknownKey, "unknown-key", Configuration, "A key that nothing reads.";
    MissingKey, "missing-key", Configuration, "A key that is required.";
    WrongType, "wrong-type", Configuration, "A text where a number is due, and the like.";
    UnknownWord, "unknown-word", Configuration, "A word that is none of the choices.";
    OutOfRange, "out-of-range", Configuration, "A number outside of its range, or none.";
    InvalidValue, "invalid-value", Configuration, "A value that cannot be used for another reason.";
    ConflictingKeys, "conflicting-keys", Configuration, "Keys that do not go together.";
    DuplicateName, "duplicate-name", Configuration, "A name that is taken.";
    UnknownName, "unknown-name", Configuration, "A name of nothing in the scenario or in a mesh.";
    TooMany, "too-many", Configuration, "More elements, grains, cells or increments than can be computed.";
    FileUnreadable, "file-unreadable", Configuration, "A file of the scenario that is not there or cannot be read.";
    FileUnsuitable, "file-unsuitable", Configuration, "A mesh or table that gives no body and no grains.";
    StepTooLong, "step-too-long", Configuration, "A step above its bound.";
    UnknownSet, "unknown-set", Configuration, "A set that a participant does not have.";
    SetIsHeld, "set-is-held", Configuration, "A set whose motion is given and that takes no force.";
    SetCoupledTwice, "set-coupled-twice", Configuration, "A row of points, or nodes of a set, that two interfaces name.";
    WheelOnCoupledBody, "wheel-on-coupled-body", Configuration, "A body that is coupled and has a wheel of its own.";
    StaticBodyCoupled, "static-body-coupled", Configuration, "A static analysis on an interface.";
    NotOffered, "not-offered", Configuration, "A request that a participant does not answer.";
    OverlappingDisks, "overlapping-disks", Configuration, "Rigid disks that lie in each other.";
    ThreadsUnavailable, "threads-unavailable", Configuration, "Threads that cannot be started.";
    SingularStiffness, "singular-stiffness", Configuration, "A stiffness without a factor.";
    CheckpointUnusable, "checkpoint-unusable", Configuration, "A checkpoint of another build or scenario.";
    OtherRelease, "other-release", Configuration, "Two programs that were built or launched for different runs.";
    ParticipantRefused, "participant-refused", Configuration, "A refusal without a closer word.";
    Diverged, "diverged", Diverged, "A solution that left the finite numbers.";
    InputNotFinite, "input-not-finite", Diverged, "Numbers from the other side that are none.";
    ContactNotConverged, "contact-not-converged", Diverged, "A contact solver that did not converge.";
    ContactTooWide, "contact-too-wide", Diverged, "A static contact wider than its solution holds.";
    DisplacementTooLarge, "displacement-too-large", Diverged, "An equilibrium far from the undeformed body.";
    SampleNotAtRest, "sample-not-at-rest", Diverged, "A prepared sample that does not come to rest.";
    SampleNotJammed, "sample-not-jammed", Diverged, "A pressed bed without enough contacts.";
    SlidingNotUnique, "sliding-not-unique", Diverged, "Friction under which sliding has no unique impulse.";
    ProtocolViolated, "protocol-violated", Protocol, "A frame that does not belong there.";
    WriteFailed, "write-failed", Output, "A file that cannot be written.";
}

impl Cause {
    /// The cause with this word.
    pub fn of_word(word: &str) -> Option<Cause> {
        let mut all = Cause::ALL.iter().copied();
        all.find(|cause| cause.word() == word)
    }

    /// The cause of a fault of which nothing closer is known, as of a program that tells none.
    pub fn general(fault: FaultCode) -> Cause {
        match fault {
            FaultCode::Configuration => Cause::ParticipantRefused,
            FaultCode::Diverged => Cause::Diverged,
            FaultCode::Protocol => Cause::ProtocolViolated,
            FaultCode::Output => Cause::WriteFailed,
        }
    }
}

/// A cause on the wire: an unknown word, for instance of a later release, counts as missing.
pub(crate) fn lenient<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Cause>, D::Error> {
    let word = Option::<String>::deserialize(from)?;
    Ok(word.as_deref().and_then(Cause::of_word))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_those_of_the_wire_and_differ() {
        for cause in Cause::ALL {
            let text = serde_json::to_string(cause).expect("it is a word");
            assert_eq!(text, format!("\"{}\"", cause.word()));
            assert_eq!(Cause::of_word(cause.word()), Some(*cause));
        }
    }
}
