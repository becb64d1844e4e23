//! Length of a log, predicted from the messages that are expected in it.

/// Shares that lz4 leaves of the payload and of everything around it. They are fitted to the log of the scene `quick`, the
/// second one being a guess; short runs pack up to a quarter better. Mantissas hardly pack, but each window begins with
/// the force that ended the one before, and grains that hang on the boundary repeat zeros.
const PAYLOAD_PACKED: f64 = 0.79;
const HEADER_PACKED: f64 = 0.3;

/// Of a message outside its chunk, which is not packed: a time and a place in the index (bytes).
const INDEX_BYTES: u64 = 16;

/// Of a message inside its chunk, before its protobuf: operation, length, channel, sequence and two times (bytes).
const RECORD_BYTES: u64 = 31;

/// Protobuf of a message in the middle of a run, where numbers have the length that most have, around the payload and the
/// letters of both names (bytes).
const MESSAGE_BYTES: u64 = 52;

/// Head and index of a chunk with some twenty streams (bytes).
const CHUNK_BYTES: u64 = 900;

/// Schemas, channels and statistics (bytes).
const FRAME_BYTES: u64 = 6_000;

/// Messages that are expected in a log.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Volume {
    /// Their number.
    pub messages: u64,
    /// Windows that will stand.
    pub windows: u64,
    /// Doubles in all payloads.
    pub doubles: u64,
    /// Everything around the payloads, before it is packed (bytes).
    header_bytes: u64,
}

impl Volume {
    /// `times` messages of so many doubles, passed between two of these names under the third.
    pub fn add(&mut self, times: u64, doubles: usize, names: [&str; 3]) {
        let [interface, sender, receiver] = names;
        let topic = interface.len() as u64;
        let around = RECORD_BYTES + MESSAGE_BYTES + (sender.len() + receiver.len()) as u64;
        self.messages += times;
        self.doubles += times * doubles as u64;
        self.header_bytes += times * around + topic;
    }

    /// Windows that stand, each with a mark of its own.
    pub fn add_windows(&mut self, windows: u64) {
        self.windows += windows;
        self.header_bytes += windows * (RECORD_BYTES + 3);
    }

    /// Size of the file (bytes) if `provenance_bytes` of text travel along and a chunk ends with every
    /// `flush_every_windows` windows.
    pub fn bytes(&self, provenance_bytes: usize, flush_every_windows: u64) -> u64 {
        let packed =
            PAYLOAD_PACKED * (8 * self.doubles) as f64 + HEADER_PACKED * self.header_bytes as f64;
        let chunks = self.windows.div_ceil(flush_every_windows.max(1));
        let plain = INDEX_BYTES * (self.messages + self.windows)
            + CHUNK_BYTES * chunks
            // As metadata and as attachments.
            + 2 * provenance_bytes as u64
            + FRAME_BYTES;
        packed.round() as u64 + plain
    }
}
