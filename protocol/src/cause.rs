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
    ($($(#[doc = $doc:literal])+ $name:ident, $word:literal, $fault:ident;)*) => {
        /// Cause of an error that a key of the scenario has, or that ends a participant.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum Cause {
            $($(#[doc = $doc])+ $name,)*
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

            /// Its documentation: a sentence, then why it comes and what to do.
            pub fn doc(self) -> &'static str {
                match self {
                    $(Cause::$name => concat!($($doc, "\n"),+),)*
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
    /// A key that nothing reads.
    ///
    /// - Why: it is mistyped, stands in the wrong table, or carries another unit: `load_kn` for
    ///   `load_n`.
    /// - Do: take the key that the message proposes. Units belong to keys and are SI: convert the
    ///   number.
    UnknownKey, "unknown-key", Configuration;
    /// A required key is missing.
    ///
    /// - Why: physical quantities have no hidden defaults; some keys are required by others only,
    ///   as `law.friction` by `coulomb`.
    /// - Do: add the key to the table that the message names; the scenes under scenarios/ show
    ///   usual values.
    MissingKey, "missing-key", Configuration;
    /// A value has another type than the key takes.
    ///
    /// - Why: a number in quotation marks, a list of another length, a fraction where a whole
    ///   number is due; what `--set` cannot read as TOML it takes as a text.
    /// - Do: write the type that the message expects.
    WrongType, "wrong-type", Configuration;
    /// A word is none of the choices that its key has.
    ///
    /// - Why: it is mistyped, or of another release.
    /// - Do: take one of the words that the message lists.
    UnknownWord, "unknown-word", Configuration;
    /// A number lies outside of the range of its key, or is not finite.
    ///
    /// - Why: a wrong sign, or a value in another unit than the key ends with.
    /// - Do: the message tells the range; check the unit.
    OutOfRange, "out-of-range", Configuration;
    /// A value cannot be used, for a reason that only its message tells.
    ///
    /// - Why: it does not fit the mesh, the sample, or the other numbers of its table.
    /// - Do: follow the message; it names the key and what would fit.
    InvalidValue, "invalid-value", Configuration;
    /// Two keys do not go together.
    ///
    /// - Why: one of them switches off what the other is about, or both say the same thing.
    /// - Do: remove one of the two, as the message says.
    ConflictingKeys, "conflicting-keys", Configuration;
    /// A name is taken.
    ///
    /// - Why: participants, interfaces, probes, walls and clusters are told apart by their names;
    ///   `coupler` and `coordinator` are parts of the program.
    /// - Do: give each a name of its own.
    DuplicateName, "duplicate-name", Configuration;
    /// A name stands for nothing in the scenario or in the mesh.
    ///
    /// - Why: it is mistyped, or the mesh has no physical group of that name.
    /// - Do: take one of those that the message lists.
    UnknownName, "unknown-name", Configuration;
    /// The scene has more elements, grains, cells, slices or increments than can be computed.
    ///
    /// - Why: nearly always a size in another unit: millimetres where metres are due.
    /// - Do: check the units; else coarsen the mesh or enlarge the grains.
    TooMany, "too-many", Configuration;
    /// A file that the scenario names is not there or cannot be read.
    ///
    /// - Why: paths count from the folder of the scenario; the file was moved, or is a pipe, or too
    ///   long.
    /// - Do: correct the path, or give it from the root.
    FileUnreadable, "file-unreadable", Configuration;
    /// A mesh or a table of grains does not describe a body or grains.
    ///
    /// - Why: triangles, a second order, another format, missing columns, a file that was cut off.
    /// - Do: the message tells the line and how to save it; for Gmsh `Recombine Surface {:};` and
    ///   `Mesh.ElementOrder = 1`.
    FileUnsuitable, "file-unsuitable", Configuration;
    /// A step is above its bound.
    ///
    /// - Why: explicit steps are limited by the smallest element, those of the grains by their
    ///   inertial time and by the wheel's period.
    /// - Do: `time.step_s = "auto"` for a body, a shorter step or a larger `mass_scale` for grains.
    ///   `unsafe_step = true` shows how it fails.
    StepTooLong, "step-too-long", Configuration;
    /// A participant does not have the set that an interface names.
    ///
    /// - Why: it is mistyped; a sample without glued disks has no set, and only an open line on its
    ///   outline is one of a body.
    /// - Do: take one of the sets that the message lists.
    UnknownSet, "unknown-set", Configuration;
    /// A set takes no force because its motion is given.
    ///
    /// - Why: the lower edge is clamped (`base`), or `boundary.<set>` prescribes a motion.
    /// - Do: free it, or name another set.
    SetIsHeld, "set-is-held", Configuration;
    /// Two interfaces name the same row of a layer, or nodes of a body that are the same.
    ///
    /// - Why: an interface was copied and not changed, or two layers that one edge of a body
    ///   carries lie too close to each other.
    /// - Do: name another set, remove one of the interfaces, or move the layers apart until each
    ///   has nodes of its own.
    SetCoupledTwice, "set-coupled-twice", Configuration;
    /// A body that is coupled has a wheel of its own.
    ///
    /// - Why: `[participant.config.wheel]` stands at the body; in a coupled scene the wheel presses
    ///   on the grains.
    /// - Do: move the table to the grains, or remove the interface.
    WheelOnCoupledBody, "wheel-on-coupled-body", Configuration;
    /// A static analysis stands on an interface.
    ///
    /// - Why: windows need motion in time.
    /// - Do: write `analysis = "dynamic"`, or remove the interface.
    StaticBodyCoupled, "static-body-coupled", Configuration;
    /// A participant does not offer what the run asks it for.
    ///
    /// - Why: the scheme needs columns, a compliant wall, a prescribed velocity or a checkpoint
    ///   that this solver does not have.
    /// - Do: choose a scheme that does without, as the message says.
    NotOffered, "not-offered", Configuration;
    /// Rigid disks lie in each other at the start.
    ///
    /// - Why: their positions and radii do not leave room.
    /// - Do: move them apart, or give `law.contact_stiffness_pa`.
    OverlappingDisks, "overlapping-disks", Configuration;
    /// Threads cannot be started.
    ///
    /// - Why: the user's limit on processes is reached.
    /// - Do: ask for fewer with `--threads`, or raise the limit.
    ThreadsUnavailable, "threads-unavailable", Configuration;
    /// The stiffness of a body has no factor.
    ///
    /// - Why: nothing holds the body, or an element is inside out.
    /// - Do: check `base`, `sides` and the mesh.
    SingularStiffness, "singular-stiffness", Configuration;
    /// A checkpoint cannot be taken up or written.
    ///
    /// - Why: another build or scenario wrote it, participants are others now, or a file that the
    ///   scenario names (mesh, grains, program) is not what the run read.
    /// - Do: resume with the build that wrote it, put the file back, or run the scenario from its
    ///   start.
    CheckpointUnusable, "checkpoint-unusable", Configuration;
    /// Two programs do not speak the same protocol, or were launched for different runs.
    ///
    /// - Why: a participant is of an older release.
    /// - Do: build both from the same release.
    OtherRelease, "other-release", Configuration;
    /// A participant refused a request, without a closer word for it.
    ///
    /// - Why: only its message knows; a program of another make gives no code of its own.
    /// - Do: read the message, and `logs/<name>.log`.
    ParticipantRefused, "participant-refused", Configuration;
    /// A solution left the finite numbers or its bounds.
    ///
    /// - Why: a step or a window that is too long, an unsafe one that was asked for, or loads far
    ///   beyond the scene.
    /// - Do: lower `time.step_s`, `substeps` or the load; `thirdbody check` tells the bounds.
    Diverged, "diverged", Diverged;
    /// A participant was handed numbers that are none.
    ///
    /// - Why: the other side diverged.
    /// - Do: lower the step or the window of the other side.
    InputNotFinite, "input-not-finite", Diverged;
    /// A contact solver did not converge.
    ///
    /// - Why: strong friction, many rigid contacts, a long step, or too few iterations.
    /// - Do: as its message says: `solver.max_iterations`, a shorter step, springs in the contacts,
    ///   `kind = "nsgs"`.
    ContactNotConverged, "contact-not-converged", Diverged;
    /// A static contact has become wider than its solution holds for.
    ///
    /// - Why: the wheel is small for its load.
    /// - Do: raise `wheel.radius_m`, or lower `wheel.load_n`.
    ContactTooWide, "contact-too-wide", Diverged;
    /// In equilibrium a body has moved by more than its size.
    ///
    /// - Why: a load or a stiffness in another unit.
    /// - Do: check the units of loads, `material.young_pa` and `run.thickness_m`.
    DisplacementTooLarge, "displacement-too-large", Diverged;
    /// A prepared sample does not come to rest.
    ///
    /// - Why: an unlucky packing.
    /// - Do: choose another seed.
    SampleNotAtRest, "sample-not-at-rest", Diverged;
    /// A pressed bed carries no load: too few contacts.
    ///
    /// - Why: an unlucky packing, or a low pressure.
    /// - Do: choose another seed, or a higher `sample.press_pa`.
    SampleNotJammed, "sample-not-jammed", Diverged;
    /// A contact has no unique impulse.
    ///
    /// - Why: high friction on a body that jams (Painleve), a wall that yields oddly, or a rigid
    ///   contact between bodies whose motion along its normal is prescribed.
    /// - Do: lower `law.friction`, or change the shape of the cluster; give rigid contacts of
    ///   prescribed motions springs (`law.contact_stiffness_pa`).
    SlidingNotUnique, "sliding-not-unique", Diverged;
    /// A participant sent or received a frame that does not belong there.
    ///
    /// - Why: a program of one's own that breaks a rule of the wire, damage, or two releases.
    /// - Do: `thirdbody conform`; the rules are in protocol/WIRE.md.
    ProtocolViolated, "protocol-violated", Protocol;
    /// A file cannot be written.
    ///
    /// - Why: a full disk, a quota, a folder without rights.
    /// - Do: make room or choose another place with `--out`, then `thirdbody resume`.
    WriteFailed, "write-failed", Output;
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
