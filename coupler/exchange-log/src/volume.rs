//! Size of a log, predicted from the expected messages.

/// Compression ratios of lz4 for the payload and for the data around it, fitted to the log of the scene `quick`; the second is a guess. Logs
/// of short runs are up to a quarter smaller. Mantissas hardly compress, but each window begins with the last force of the window before,
/// and grains that stick to the boundary repeat zeros.
const PAYLOAD_PACKED: f64 = 0.79;
const HEADER_PACKED: f64 = 0.3;

/// Part of a message outside its chunk, which is not compressed: a time and a position in the index (bytes).
const INDEX_BYTES: u64 = 16;

/// Part of a message inside its chunk before its protobuf: operation, length, channel, sequence and two times (bytes).
const RECORD_BYTES: u64 = 31;

/// Protobuf of a message in the middle of a run, where numbers have typical lengths, without payload and names (bytes).
const MESSAGE_BYTES: u64 = 52;

/// Header and index of a chunk with about twenty streams (bytes).
const CHUNK_BYTES: u64 = 900;

/// Schemas, channels and statistics (bytes).
const FRAME_BYTES: u64 = 6_000;

/// Expected messages of a log.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Volume {
    /// Number of messages.
    pub messages: u64,
    /// Number of windows that will end.
    pub windows: u64,
    /// Doubles in all payloads.
    pub doubles: u64,
    /// Data around the payloads, before compression (bytes).
    header_bytes: u64,
}

impl Volume {
    /// Adds `times` messages of `doubles` doubles; the names are interface, sender and receiver.
    pub fn add(&mut self, times: u64, doubles: usize, names: [&str; 3]) {
        let [interface, sender, receiver] = names;
        let topic = interface.len() as u64;
        let around = RECORD_BYTES + MESSAGE_BYTES + (sender.len() + receiver.len()) as u64;
        self.messages += times;
        self.doubles += times * doubles as u64;
        self.header_bytes += times * around + topic;
    }

    /// Adds windows, each of which ends with a mark.
    pub fn add_windows(&mut self, windows: u64) {
        self.windows += windows;
        self.header_bytes += windows * (RECORD_BYTES + 3);
    }

    /// Size of the file (bytes) with `provenance_bytes` of text, if a chunk ends with every `flush_every_windows` windows.
    pub fn bytes(&self, provenance_bytes: usize, flush_every_windows: u64) -> u64 {
        let packed =
            PAYLOAD_PACKED * (8 * self.doubles) as f64 + HEADER_PACKED * self.header_bytes as f64;
        let chunks = self.windows.div_ceil(flush_every_windows.max(1));
        let plain = INDEX_BYTES * (self.messages + self.windows)
            + CHUNK_BYTES * chunks
            // Twice: as metadata and as attachments.
            + 2 * provenance_bytes as u64
            + FRAME_BYTES;
        packed.round() as u64 + plain
    }
}
