//! The messages of a connection: a piece of a frame, or a sign of life, with a signature that only the two ends can make.

use blake2::Blake2bMac;
use blake2::digest::consts::U32;
use blake2::digest::{FixedOutput, KeyInit, Update};
use protocol::Header;
use thiserror::Error;

/// Key of signatures.
pub type Key = [u8; 32];

/// Bytes of the signature, BLAKE2b keyed.
const SIGNATURE: usize = 32;

/// Bytes of the numbers after the signature.
const NUMBERS: usize = 6 * 8;

/// Bytes of a frame's header.
const HEADER: usize = 72;

/// The end that sends: the two ends sign differently.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sender {
    /// It asks.
    Coordinator = b'q' as isize,
    /// It answers.
    Participant = b'a' as isize,
}

impl Sender {
    /// The end that receives.
    pub fn other(self) -> Sender {
        match self {
            Sender::Coordinator => Sender::Participant,
            Sender::Participant => Sender::Coordinator,
        }
    }
}

/// The purpose of a message.
#[derive(Clone, Debug, PartialEq)]
pub enum Purpose {
    /// The next doubles of a frame.
    Piece(Header, Vec<f64>),
    /// The receiver answers it at once with a pong.
    Ping,
    /// Answer to a ping, to a piece out of order, or to a pong before which a piece is missing.
    Pong,
    /// The sender has left.
    Left,
}

/// A message.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// Its purpose.
    pub purpose: Purpose,
    /// Number of the piece, counted from 1; in other messages the number of the last piece.
    pub number: u64,
    /// Pieces that the sender has received without a gap.
    pub received: u64,
    /// Frames that the sender has taken.
    pub taken: u64,
    /// The sender's monotonic clock (ns).
    pub clock_ns: u64,
    /// Clock (ns) of the last message that the sender has received, in a pong of the message that it answers.
    pub echo_ns: u64,
}

/// The reason why a message is refused.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs)]
pub enum Refused {
    #[error("have no signature of this run")]
    Signature,
    #[error("came again")]
    Repeated,
    #[error("are not messages of this protocol")]
    Form,
}

impl Message {
    /// Its bytes, signed.
    pub fn signed(&self, key: &Key, sender: Sender) -> Vec<u8> {
        let (code, header, doubles): (u64, _, &[f64]) = match &self.purpose {
            Purpose::Piece(header, doubles) => (0, Some(header), doubles),
            Purpose::Ping => (1, None, &[]),
            Purpose::Pong => (2, None, &[]),
            Purpose::Left => (3, None, &[]),
        };
        let mut bytes = vec![0; SIGNATURE];
        bytes.reserve(NUMBERS + HEADER + 8 * doubles.len());
        let numbers = [
            code,
            self.number,
            self.received,
            self.taken,
            self.clock_ns,
            self.echo_ns,
        ];
        bytes.extend(numbers.map(u64::to_le_bytes).as_flattened());
        if let Some(header) = header {
            bytes.extend(header_bytes(header));
        }
        for double in doubles {
            bytes.extend(double.to_bits().to_le_bytes());
        }
        let signature = signature(&bytes[SIGNATURE..], key, sender);
        bytes[..SIGNATURE].copy_from_slice(&signature);
        bytes
    }

    /// Reads a message from this sender.
    pub fn read(bytes: &[u8], key: &Key, sender: Sender) -> Result<Message, Refused> {
        let (signed, content) = bytes.split_at_checked(SIGNATURE).ok_or(Refused::Form)?;
        if signature(content, key, sender) != signed {
            return Err(Refused::Signature);
        }
        let (numbers, rest) = content.split_at_checked(NUMBERS).ok_or(Refused::Form)?;
        let [code, number, received, taken, clock_ns, echo_ns] = words(numbers);
        let purpose = match (code, rest.len()) {
            (0, HEADER..) if rest.len() % 8 == 0 => {
                let (header, doubles) = rest.split_at(HEADER);
                let doubles = doubles.chunks_exact(8);
                let doubles = doubles.map(|word| f64::from_bits(words::<1>(word)[0]));
                Purpose::Piece(header_of(header), doubles.collect())
            }
            (1, 0) => Purpose::Ping,
            (2, 0) => Purpose::Pong,
            (3, 0) => Purpose::Left,
            _ => return Err(Refused::Form),
        };
        Ok(Message {
            purpose,
            number,
            received,
            taken,
            clock_ns,
            echo_ns,
        })
    }
}

fn signature(content: &[u8], key: &Key, sender: Sender) -> [u8; SIGNATURE] {
    let mut hasher = keyed(key);
    hasher.update(&[sender as u8]);
    hasher.update(content);
    hasher.finalize_fixed().into()
}

/// The key of one participant; another participant's key cannot be derived from it.
pub fn derived_key(key: &Key, participant: &str) -> Key {
    let mut hasher = keyed(key);
    hasher.update(participant.as_bytes());
    hasher.finalize_fixed().into()
}

fn keyed(key: &Key) -> Blake2bMac<U32> {
    Blake2bMac::new_from_slice(key).expect("a key of 32 bytes is one of BLAKE2b")
}

/// Words of eight bytes, little-endian.
fn words<const N: usize>(bytes: &[u8]) -> [u64; N] {
    let (words, _) = bytes.as_chunks::<8>();
    std::array::from_fn(|at| u64::from_le_bytes(words[at]))
}

fn header_bytes(header: &Header) -> [u8; HEADER] {
    let pair = |low: u32, high: u32| u64::from(low) | u64::from(high) << 32;
    let words = [
        pair(header.kind, header.protocol),
        header.run_id,
        pair(header.interface, header.iteration),
        header.window,
        header.step,
        pair(header.substeps, header.count),
        header.t0_s.to_bits(),
        header.t1_s.to_bits(),
        header.checksum,
    ];
    let mut bytes = [0; HEADER];
    bytes.copy_from_slice(words.map(u64::to_le_bytes).as_flattened());
    bytes
}

fn header_of(bytes: &[u8]) -> Header {
    let [
        kinds,
        run_id,
        repeat,
        window,
        step,
        counts,
        t0,
        t1,
        checksum,
    ] = words(bytes);
    let [low, high] = [|word: u64| word as u32, |word: u64| (word >> 32) as u32];
    Header {
        kind: low(kinds),
        protocol: high(kinds),
        run_id,
        interface: low(repeat),
        iteration: high(repeat),
        window,
        step,
        substeps: low(counts),
        count: high(counts),
        t0_s: f64::from_bits(t0),
        t1_s: f64::from_bits(t1),
        checksum,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::Kind;

    const KEY: Key = [7; 32];

    fn message(purpose: Purpose) -> Message {
        Message {
            purpose,
            number: 1,
            received: 2,
            taken: 3,
            clock_ns: 4,
            echo_ns: 5,
        }
    }

    #[test]
    fn a_message_is_read_as_it_was_signed() {
        let header = Header {
            interface: 1,
            iteration: 2,
            substeps: 3,
            count: 4,
            t0_s: -0.5,
            ..Header::of(Kind::Motion)
        };
        let piece = Purpose::Piece(header, vec![1.0, -0.0]);
        for purpose in [piece, Purpose::Ping, Purpose::Pong, Purpose::Left] {
            let sent = message(purpose);
            let bytes = sent.signed(&KEY, Sender::Coordinator);
            assert_eq!(Message::read(&bytes, &KEY, Sender::Coordinator), Ok(sent));
        }
    }

    #[test]
    fn another_key_another_sender_and_any_other_bit_are_refused() {
        let piece = Purpose::Piece(Header::of(Kind::Motion), vec![1.0]);
        let bytes = message(piece).signed(&KEY, Sender::Coordinator);
        let read = |bytes: &[u8], key, sender| Message::read(bytes, key, sender).err();
        let refused = Some(Refused::Signature);
        assert_eq!(read(&bytes, &[8; 32], Sender::Coordinator), refused);
        assert_eq!(read(&bytes, &KEY, Sender::Participant), refused);
        for at in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] ^= 1;
            assert_eq!(read(&damaged, &KEY, Sender::Coordinator), refused, "{at}");
        }
        for length in 0..bytes.len() {
            assert!(read(&bytes[..length], &KEY, Sender::Coordinator).is_some());
        }
    }

    #[test]
    fn a_signed_message_of_another_form_is_refused() {
        let mut bytes = message(Purpose::Ping).signed(&KEY, Sender::Coordinator);
        bytes.extend([0; 8]);
        let signed = signature(&bytes[SIGNATURE..], &KEY, Sender::Coordinator);
        bytes[..SIGNATURE].copy_from_slice(&signed);
        let read = Message::read(&bytes, &KEY, Sender::Coordinator);
        assert_eq!(read, Err(Refused::Form));
    }
}
