//! Causes of errors: one word for each that has its own cure. Scripts and `thirdbody explain` use these words.

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

/// Makes the enum, its list, its words and their faults from one table, so that every cause has all of them.
macro_rules! causes {
    ($($(#[doc = $doc:literal])+ $name:ident, $word:literal, $fault:ident;)*) => {
        /// Cause of an error in a key of the scenario, or of an error that ends a participant.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum Cause {
            $($(#[doc = $doc])+ $name,)*
        }

        impl Cause {
            /// All of them.
            pub const ALL: &[Cause] = &[$(Cause::$name),*];

            /// Its word in messages, in summary.json and on the wire.
            pub fn word(self) -> &'static str {
                match self {
                    $(Cause::$name => $word,)*
                }
            }

            /// Its documentation: a sentence, then why the error occurs and what to do.
            pub fn doc(self) -> &'static str {
                match self {
                    $(Cause::$name => concat!($($doc, "\n"),+),)*
                }
            }

            /// The fault that it belongs to; the exit code of the run follows from the fault.
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
    /// - Why: it is mistyped, stands in the wrong table, or names another unit: `load_kn` for
    ///   `load_n`.
    /// - Do: take the key that the message proposes. Units belong to keys and are SI: convert the
    ///   number.
    UnknownKey, "unknown-key", Configuration;
    /// A required key is missing.
    ///
    /// - Why: physical quantities have no hidden defaults; some keys require others, as `coulomb`
    ///   requires `law.friction`.
    /// - Do: add the key to the table that the message names; the scenes under scenarios/ show
    ///   usual values.
    MissingKey, "missing-key", Configuration;
    /// A value does not have the type of its key.
    ///
    /// - Why: a number in quotation marks, a list of another length, a fraction instead of a whole
    ///   number; `--set` reads a value as text if it is not valid TOML.
    /// - Do: write the type that the message expects.
    WrongType, "wrong-type", Configuration;
    /// A word is not among the choices of its key.
    ///
    /// - Why: it is mistyped, or of another release.
    /// - Do: take one of the words that the message lists.
    UnknownWord, "unknown-word", Configuration;
    /// A number lies outside the range of its key, or is not finite.
    ///
    /// - Why: a wrong sign, or a value that is not in the unit at the end of the key.
    /// - Do: the message states the range; check the unit.
    OutOfRange, "out-of-range", Configuration;
    /// A value cannot be used, for the reason that its message gives.
    ///
    /// - Why: it does not fit the mesh, the sample, or the other numbers of its table.
    /// - Do: follow the message; it names the key and a value that would fit.
    InvalidValue, "invalid-value", Configuration;
    /// Two keys do not go together.
    ///
    /// - Why: one of them disables the other, or both say the same thing.
    /// - Do: remove one of the two, as the message says.
    ConflictingKeys, "conflicting-keys", Configuration;
    /// A name is taken.
    ///
    /// - Why: names identify participants, interfaces, probes, walls and clusters; `coupler` and
    ///   `coordinator` are parts of the program.
    /// - Do: give each its own name.
    DuplicateName, "duplicate-name", Configuration;
    /// A name refers to nothing in the scenario or in the mesh.
    ///
    /// - Why: it is mistyped, or the mesh has no physical group of that name.
    /// - Do: take one of the names that the message lists.
    UnknownName, "unknown-name", Configuration;
    /// The scene has more elements, grains, cells, slices or increments than can be computed.
    ///
    /// - Why: nearly always a size in another unit: millimetres instead of metres.
    /// - Do: check the units; if they are right, coarsen the mesh or enlarge the grains.
    TooMany, "too-many", Configuration;
    /// A file that the scenario names does not exist or cannot be read.
    ///
    /// - Why: paths are relative to the folder of the scenario; the file was moved, or is a pipe,
    ///   or too long.
    /// - Do: correct the path, or give it from the root.
    FileUnreadable, "file-unreadable", Configuration;
    /// A mesh or a table of grains does not describe a body or grains.
    ///
    /// - Why: triangles, second-order elements, another format, missing columns, a truncated file.
    /// - Do: the message names the line and says how to save the file; for Gmsh
    ///   `Recombine Surface {:};` and `Mesh.ElementOrder = 1`.
    FileUnsuitable, "file-unsuitable", Configuration;
    /// A step is above its bound.
    ///
    /// - Why: the smallest element limits explicit steps; the inertial time of the grains and the
    ///   wheel's period limit the steps of the grains.
    /// - Do: `time.step_s = "auto"` for a body, a shorter step or a larger `mass_scale` for grains.
    ///   `unsafe_step = true` shows how the longer step fails.
    StepTooLong, "step-too-long", Configuration;
    /// A participant does not have the set that an interface names.
    ///
    /// - Why: it is mistyped; a sample without glued disks has no set, and the sets of a body are
    ///   open lines on its outline.
    /// - Do: take one of the sets that the message lists.
    UnknownSet, "unknown-set", Configuration;
    /// A set takes no force because its motion is prescribed.
    ///
    /// - Why: the lower edge is clamped (`base`), or `boundary.<set>` prescribes a motion.
    /// - Do: free it, or name another set.
    SetIsHeld, "set-is-held", Configuration;
    /// Two interfaces name the same row of a layer, or the same nodes of a body.
    ///
    /// - Why: an interface was copied and not changed, or two layers on one edge of a body lie too
    ///   close to each other.
    /// - Do: name another set, remove one of the interfaces, or move the layers apart until each
    ///   has its own nodes.
    SetCoupledTwice, "set-coupled-twice", Configuration;
    /// A coupled body has its own wheel.
    ///
    /// - Why: the body has `[participant.config.wheel]`; in a coupled scene the wheel presses on
    ///   the grains.
    /// - Do: move the table to the grains, or remove the interface.
    WheelOnCoupledBody, "wheel-on-coupled-body", Configuration;
    /// A body in static analysis is coupled.
    ///
    /// - Why: windows need motion in time.
    /// - Do: write `analysis = "dynamic"`, or remove the interface.
    StaticBodyCoupled, "static-body-coupled", Configuration;
    /// A participant does not offer a capability that the run needs.
    ///
    /// - Why: the scheme needs columns, a compliant wall, a prescribed velocity or a checkpoint
    ///   that this solver does not have.
    /// - Do: choose a scheme that does not need it, as the message says.
    NotOffered, "not-offered", Configuration;
    /// Rigid disks overlap at the start.
    ///
    /// - Why: their positions and radii do not leave room.
    /// - Do: move them apart, or give `law.contact_stiffness_pa`.
    OverlappingDisks, "overlapping-disks", Configuration;
    /// Threads cannot be started.
    ///
    /// - Why: the user's limit on processes is reached.
    /// - Do: ask for fewer with `--threads`, or raise the limit.
    ThreadsUnavailable, "threads-unavailable", Configuration;
    /// The stiffness matrix of a body cannot be factorised.
    ///
    /// - Why: nothing holds the body, or an element is inside out.
    /// - Do: check `base`, `sides` and the mesh.
    SingularStiffness, "singular-stiffness", Configuration;
    /// A checkpoint cannot be resumed from or written.
    ///
    /// - Why: another build or scenario wrote it, the participants have changed, or a file that the
    ///   scenario names (mesh, grains, program) has changed since the run read it.
    /// - Do: resume with the build that wrote it, restore the file, or run the scenario from its
    ///   start.
    CheckpointUnusable, "checkpoint-unusable", Configuration;
    /// Two programs do not speak the same protocol, or were launched for different runs.
    ///
    /// - Why: a participant was built from an older release.
    /// - Do: build both from the same release.
    OtherRelease, "other-release", Configuration;
    /// A participant refused a request and gave no specific cause.
    ///
    /// - Why: only its message says; a foreign program may send no cause.
    /// - Do: read the message, and `logs/<name>.log`.
    ParticipantRefused, "participant-refused", Configuration;
    /// A solution became infinite or NaN, or left its bounds.
    ///
    /// - Why: a step or a window that is too long, an unsafe step that the scenario asks for, or
    ///   loads far too large for the scene.
    /// - Do: lower `time.step_s`, `substeps` or the load; `thirdbody check` prints the bounds.
    Diverged, "diverged", Diverged;
    /// A participant received NaN or infinite numbers.
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
    /// A static contact is too wide for its solution to hold.
    ///
    /// - Why: the wheel is small for its load.
    /// - Do: raise `wheel.radius_m`, or lower `wheel.load_n`.
    ContactTooWide, "contact-too-wide", Diverged;
    /// At equilibrium a body has moved by more than its size.
    ///
    /// - Why: a load or a stiffness in another unit.
    /// - Do: check the units of loads, `material.young_pa` and `run.thickness_m`.
    DisplacementTooLarge, "displacement-too-large", Diverged;
    /// A prepared sample does not come to rest.
    ///
    /// - Why: an unlucky packing.
    /// - Do: choose another seed.
    SampleNotAtRest, "sample-not-at-rest", Diverged;
    /// A pressed bed carries no load: it has too few contacts.
    ///
    /// - Why: an unlucky packing, or a low pressure.
    /// - Do: choose another seed, or a higher `sample.press_pa`.
    SampleNotJammed, "sample-not-jammed", Diverged;
    /// A contact has no unique impulse.
    ///
    /// - Why: high friction on a body that jams (Painleve), a wall that yields oddly, or a rigid
    ///   contact between bodies whose motion along its normal is prescribed.
    /// - Do: lower `law.friction`, or change the shape of the cluster; add springs
    ///   (`law.contact_stiffness_pa`) to rigid contacts between prescribed motions.
    SlidingNotUnique, "sliding-not-unique", Diverged;
    /// A participant sent or received a frame out of place.
    ///
    /// - Why: a foreign program that breaks a rule of the wire, damage, or two releases.
    /// - Do: `thirdbody conform`; the rules are in protocol/WIRE.md.
    ProtocolViolated, "protocol-violated", Protocol;
    /// A file cannot be written.
    ///
    /// - Why: a full disk, a quota, a folder without write permission.
    /// - Do: make room or choose another place with `--out`, then `thirdbody resume`.
    WriteFailed, "write-failed", Output;
}

impl Cause {
    /// The cause with this word.
    pub fn of_word(word: &str) -> Option<Cause> {
        let mut all = Cause::ALL.iter().copied();
        all.find(|cause| cause.word() == word)
    }

    /// The general cause of a fault, for a program that sends no specific one.
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
    fn words_differ_and_equal_the_words_of_the_wire() {
        for cause in Cause::ALL {
            let text = serde_json::to_string(cause).expect("it is a word");
            assert_eq!(text, format!("\"{}\"", cause.word()));
            assert_eq!(Cause::of_word(cause.word()), Some(*cause));
        }
    }
}
