//! The frame: a header of fixed layout and a payload of doubles.

use std::fmt;

use iceoryx2::prelude::ZeroCopySend;
use thiserror::Error;
use xxhash_rust::xxh3::xxh3_64;

/// Version of the frames and of the conversation. Participants of another version are refused at the handshake.
pub const PROTOCOL_VERSION: u32 = 2;

/// Makes the enum and its words from one table, so that every kind has a word.
macro_rules! kinds {
    ($($(#[$doc:meta])* $name:ident = $number:literal, $word:literal;)*) => {
        /// The subject of a frame. Requests travel from the coordinator to a participant; each has one answer.
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(u32)]
        pub enum Kind {
            $($(#[$doc])* $name = $number,)*
        }

        impl Kind {
            /// The names of the kinds in logs, topics, exports and messages. They stay when a variant is renamed.
            pub const WORDS: [(Kind, &'static str); 33] = [$((Kind::$name, $word),)*];
        }
    };
}

kinds! {
    /// Request, text: the [`crate::serve::Hello`] of the coordinator.
    Hello = 1, "Hello";
    /// Answer to `Hello`, text: the participant's [`crate::serve::Welcome`].
    Welcome = 2, "Welcome";
    /// Request, text: the name of a set that an interface couples.
    Couple = 3, "Couple";
    /// Answer to `Couple`: rows of (x, y, mass, radius, length), see [`crate::Surface`].
    Surface = 4, "Surface";
    /// Request: indices of the points that will be exchanged from now on.
    Select = 5, "Select";
    /// Request: the condensed compliance of `substeps` own steps; no payload.
    Columns = 6, "Columns";
    /// Answer to `Columns`: the square matrix C (m/N), column by column.
    Compliance = 7, "Compliance";
    /// Request: window length (s), then the square matrix W_g (1/kg), column by column.
    CompliantBoundary = 8, "Wall";
    /// Answer to requests that return nothing (`Select`, `CompliantBoundary`).
    Ready = 9, "Ready";
    /// Request: interface force (N), held constant over the window.
    Advance = 10, "Advance";
    /// Answer to `Advance`: displacement increments (m) of the exchanged points.
    Motion = 11, "Motion";
    /// Request: velocity of the glued points without contact forces, a_g (m/s).
    Solve = 12, "Solve";
    /// Answer to `Solve`: F_g (N), v_g (m/s), iterations, true residual, converged (0 or 1).
    Force = 13, "Force";
    /// Request: accept the window. Payload: total displacements (m) of the glued points, or nothing.
    Commit = 14, "Commit";
    /// Answer to `Commit` and `AdvanceAlone`: signals, then ledger terms, in the order of the description.
    Report = 15, "Report";
    /// Request: advance alone by `substeps` own steps, without any interface.
    AdvanceAlone = 16, "March";
    /// Request: the run has ended.
    Finish = 17, "Finish";
    /// Answer to `Finish`, text: the participant's [`crate::serve::Farewell`], with its [`crate::Outcome`].
    Finished = 18, "Finished";
    /// Answer to any request, text: the participant cannot go on, a [`crate::NodeError`].
    Fault = 19, "Fault";
    /// Request, text: write the fields of the committed state under this name.
    Snapshot = 20, "Snapshot";
    /// Answer to `Snapshot`: the files are written. Like its request, it is not part of the exchange.
    Saved = 21, "Saved";
    /// Request: the committed state as bytes. Like its answer and the next two kinds, it is not part of the exchange.
    Checkpoint = 22, "Checkpoint";
    /// Answer to `Checkpoint`, bytes that only this node reads, see [`crate::Node::checkpoint`].
    State = 23, "State";
    /// Request, bytes: make this the committed state, see [`crate::Node::restore`].
    Restore = 24, "Restore";
    /// Answer to `Restore`.
    Restored = 25, "Restored";
    /// Request: the impedance of `substeps` own steps; no payload.
    ImpedanceColumns = 26, "Resist";
    /// Answer to `ImpedanceColumns`: the square matrix D (kg/s), column by column.
    Impedance = 27, "Impedance";
    /// Request: velocity (m/s) at the end of the window, reached linearly from its start.
    PrescribeVelocity = 28, "Follow";
    /// Answer to `PrescribeVelocity`: force (N) at the end of the window, then displacement increments (m), then work (J).
    Reaction = 29, "Reaction";
    /// Request: heat (J) that has entered at each exchanged point since the last one.
    TakeHeat = 30, "Heat";
    /// Answer to `TakeHeat`: temperature (K) of each exchanged point.
    Temperatures = 31, "Temperatures";
    /// Request: temperature (K) of the body at each glued point.
    TakeTemperatures = 32, "Surroundings";
    /// Answer to `TakeTemperatures`: heat (J) that has left at each glued point since the last one, and the heat per kelvin (J/K).
    HeatGiven = 33, "Given";
}

impl Kind {
    /// The kind with this number, if there is one.
    pub fn from_number(number: u32) -> Option<Kind> {
        let mut known = Self::WORDS.into_iter().map(|(kind, _)| kind);
        known.find(|kind| *kind as u32 == number)
    }

    /// Its word in [`Kind::WORDS`].
    pub fn word(self) -> &'static str {
        let mut known = Self::WORDS.into_iter();
        let found = known.find(|(kind, _)| *kind == self);
        found.expect("a test compares the table with the enum").1
    }

    /// True for requests about a window.
    pub fn is_about_window(self) -> bool {
        use Kind::*;
        matches!(
            self,
            Advance | PrescribeVelocity | Solve | Commit | AdvanceAlone
        )
    }

    /// True for frames of interface data, which are logged, replayed and part of `hashes.exchange`. Greetings, farewells and
    /// faults are not, because they hold process ids, wall-clock times and texts.
    pub fn is_exchange(self) -> bool {
        !matches!(
            self,
            Kind::Hello
                | Kind::Welcome
                | Kind::Finish
                | Kind::Finished
                | Kind::Fault
                | Kind::Snapshot
                | Kind::Saved
                | Kind::Checkpoint
                | Kind::State
                | Kind::Restore
                | Kind::Restored
        )
    }
}

impl fmt::Debug for Kind {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.word())
    }
}

/// The header of every frame, with the same layout on both sides of shared memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, ZeroCopySend)]
#[repr(C)]
#[type_name("thirdbody.header.v1")]
pub struct Header {
    /// [`Kind`] as its number.
    pub kind: u32,
    /// [`PROTOCOL_VERSION`] of the sender.
    pub protocol: u32,
    /// The run that this frame belongs to.
    pub run_id: u64,
    /// Index of the interface in the scenario, from 0. A participant on several interfaces exchanges the points of all of
    /// them in one frame, which carries the index of the first.
    pub interface: u32,
    /// Repeat of the window, from 0.
    pub iteration: u32,
    /// Coupling window, from 0.
    pub window: u64,
    /// Explicit steps since the start of the run at `t0_s`.
    pub step: u64,
    /// Explicit steps inside the window.
    pub substeps: u32,
    /// Doubles in the payload.
    pub count: u32,
    /// Start of the window (s).
    pub t0_s: f64,
    /// End of the window (s).
    pub t1_s: f64,
    /// XXH3 of the payload's bytes in little-endian order. On a link it also covers the rest of the header and the turn, see
    /// [`Frame::stamp`].
    pub checksum: u64,
}

impl Header {
    /// A header of this kind, outside of any window.
    pub fn of(kind: Kind) -> Header {
        Header {
            kind: kind as u32,
            protocol: PROTOCOL_VERSION,
            ..Header::default()
        }
    }

    /// Window, steps, times and interface in words.
    pub fn subject(&self) -> String {
        format!(
            "window {}, iteration {}, steps {} + {}, {:e} to {:e} s, interface {}",
            self.window,
            self.iteration,
            self.step,
            self.substeps,
            self.t0_s,
            self.t1_s,
            self.interface
        )
    }

    /// XXH3 of all other fields in little-endian order.
    fn own_checksum(&self) -> u64 {
        let [kind, protocol, interface] = [self.kind, self.protocol, self.interface].map(u64::from);
        let [iteration, substeps, count] =
            [self.iteration, self.substeps, self.count].map(u64::from);
        let fields = [
            kind,
            protocol,
            self.run_id,
            interface,
            iteration,
            self.window,
            self.step,
            substeps,
            count,
            self.t0_s.to_bits(),
            self.t1_s.to_bits(),
        ];
        xxh3_64(fields.map(u64::to_le_bytes).as_flattened())
    }
}

/// The reason why a frame cannot be used.
#[derive(Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum FrameError {
    #[error("frame of unknown kind {0}")]
    UnknownKind(u32),
    #[error("the header says {header} doubles, the payload holds {payload}")]
    Length { header: u32, payload: usize },
    #[error(
        "checksum of the payload is {computed:016x}, the header says {saved:016x}: the message was damaged"
    )]
    Checksum { saved: u64, computed: u64 },
    #[error(
        "message {turn} of this connection arrived instead of message {due}: one was lost, repeated or overtaken"
    )]
    Turn { turn: u64, due: u64 },
    #[error("the text of the frame cannot be read: {0}")]
    Text(String),
}

/// A header with its payload.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Kind of the frame, with its run, window and iteration.
    pub header: Header,
    /// The numbers, or a text packed eight bytes to a double (see [`Frame::text`]).
    pub payload: Vec<f64>,
}

impl Frame {
    /// Joins a header and a payload; count and checksum are filled in.
    pub fn new(mut header: Header, payload: Vec<f64>) -> Frame {
        header.count = u32::try_from(payload.len()).expect("payloads stay far below 2^32 doubles");
        header.checksum = checksum(&payload);
        Frame { header, payload }
    }

    /// The text that was [`packed`].
    pub fn text(&self) -> Result<String, FrameError> {
        String::from_utf8(self.bytes()?).map_err(|error| FrameError::Text(error.to_string()))
    }

    /// The bytes that were [`packed`].
    pub fn bytes(&self) -> Result<Vec<u8>, FrameError> {
        let (length, words) = self
            .payload
            .split_first()
            .ok_or_else(|| FrameError::Text("it is empty".into()))?;
        let bytes = words.iter().flat_map(|word| word.to_bits().to_le_bytes());
        let mut bytes: Vec<u8> = bytes.collect();
        if !(*length >= 0.0 && *length <= bytes.len() as f64) {
            return Err(FrameError::Text(format!(
                "it claims {length} bytes and holds {}",
                bytes.len()
            )));
        }
        bytes.truncate(*length as usize);
        Ok(bytes)
    }

    /// The kind in the header.
    pub fn kind(&self) -> Result<Kind, FrameError> {
        Kind::from_number(self.header.kind).ok_or(FrameError::UnknownKind(self.header.kind))
    }

    /// Checks length and checksum of a frame that arrived.
    pub fn verify(&self) -> Result<(), FrameError> {
        if self.header.count as usize != self.payload.len() {
            return Err(FrameError::Length {
                header: self.header.count,
                payload: self.payload.len(),
            });
        }
        let computed = checksum(&self.payload);
        if computed != self.header.checksum {
            return Err(FrameError::Checksum {
                saved: self.header.checksum,
                computed,
            });
        }
        Ok(())
    }

    /// Adds the frame's turn and the checksum of the rest of its header to its checksum, before it goes onto a link. Requests
    /// count from 0, and an answer has the turn of its request. Two requests may have equal header and payload; only the turn
    /// then tells their answers apart.
    pub fn stamp(&mut self, turn: u64) {
        let added = self.header.own_checksum().wrapping_add(turn);
        self.header.checksum = self.header.checksum.wrapping_add(added);
    }

    /// Checks length, checksum and turn of a frame that arrived on a link, and undoes [`Frame::stamp`].
    pub fn open(&mut self, due: u64) -> Result<(), FrameError> {
        let added = self.header.own_checksum().wrapping_add(due);
        self.header.checksum = self.header.checksum.wrapping_sub(added);
        let checked = self.verify();
        let Err(FrameError::Checksum { saved, computed }) = checked else {
            return checked;
        };
        let turn = saved.wrapping_add(due).wrapping_sub(computed);
        if turn < TURNS {
            return Err(FrameError::Turn { turn, due });
        }
        checked
    }
}

/// A text or bytes as a payload: the number of bytes, then the bytes, eight to a double, the last double padded with zeros.
pub fn packed(bytes: impl AsRef<[u8]>) -> Vec<f64> {
    let bytes = bytes.as_ref();
    let words = bytes.chunks(8).map(|chunk| {
        let mut word = [0u8; 8];
        word[..chunk.len()].copy_from_slice(chunk);
        f64::from_bits(u64::from_le_bytes(word))
    });
    [bytes.len() as f64].into_iter().chain(words).collect()
}

/// Most turns of a link; a larger difference of checksums means damage.
const TURNS: u64 = 1 << 40;

/// XXH3 of the bits of the doubles, independent of the byte order of the machine.
fn checksum(payload: &[f64]) -> u64 {
    let mut bytes = vec![0; payload.len() * 8];
    // The compiler turns a loop over pieces of known length into one copy.
    for (piece, value) in bytes.chunks_exact_mut(8).zip(payload) {
        piece.copy_from_slice(&value.to_bits().to_le_bytes());
    }
    xxh3_64(&bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_of_any_length_survive_packing() {
        for text in ["", "a", "12345678", "naïve: σ = 672 MPa"] {
            let frame = Frame::new(Header::of(Kind::Fault), packed(text));
            assert_eq!(frame.text().as_deref(), Ok(text));
        }
    }

    #[test]
    fn bytes_survive_packing_even_as_nan() {
        // 0x7ff4... is a signalling NaN, whose bits a computation would change.
        let signalling = f64::from_bits(0x7ff4_0000_0000_0001).to_bits();
        let mut bytes = signalling.to_le_bytes().to_vec();
        bytes.extend([255; 13]);
        let frame = Frame::new(Header::of(Kind::State), packed(&bytes));
        assert_eq!(frame.bytes(), Ok(bytes));
    }

    #[test]
    fn one_flipped_bit_is_detected() {
        let mut frame = Frame::new(Header::of(Kind::Motion), vec![1.0, -2.0]);
        frame.payload[1] = f64::from_bits(frame.payload[1].to_bits() ^ 1);
        assert!(matches!(frame.verify(), Err(FrameError::Checksum { .. })));
    }

    #[test]
    fn a_frame_is_opened_in_its_turn_only() {
        let sent = Frame::new(Header::of(Kind::Ready), Vec::new());
        let mut stamped = sent.clone();
        stamped.stamp(7);
        for due in [6, 8] {
            let refused = stamped.clone().open(due);
            assert_eq!(refused, Err(FrameError::Turn { turn: 7, due }));
        }
        let damages: [fn(&mut Header); 12] = [
            |header| header.checksum ^= 1 << 50,
            |header| header.kind ^= 1,
            |header| header.protocol ^= 1,
            |header| header.run_id ^= 1,
            |header| header.interface ^= 1,
            |header| header.iteration ^= 1,
            |header| header.window ^= 1,
            |header| header.step ^= 1,
            |header| header.substeps ^= 1,
            |header| header.t0_s = 1.0,
            |header| header.t1_s = 1.0,
            |header| header.t0_s = -0.0,
        ];
        for damage in damages {
            let mut damaged = stamped.clone();
            damage(&mut damaged.header);
            let refused = damaged.open(7);
            assert!(
                matches!(refused, Err(FrameError::Checksum { .. })),
                "{refused:?}"
            );
        }
        assert_eq!(stamped.open(7), Ok(()));
        assert_eq!(stamped, sent);
    }

    #[test]
    fn every_kind_is_found_by_its_number() {
        for (kind, word) in Kind::WORDS {
            assert_eq!(kind.word(), word);
            assert_eq!(Kind::from_number(kind as u32), Some(kind));
        }
        assert_eq!(Kind::from_number(0), None);
    }
}
