//! The fingerprint of an exchange, `hashes.exchange` of the summary.

use protocol::{Frame, Kind};

use super::entry::Entry;

/// Order of a frame in its block; equal frames keep their order of arrival.
type Order = (u64, bool, u32, String, u32);

/// blake3 over the digests of all exchanged frames, ordered by (window, iteration, sender), then by kind and arrival. The frames of the
/// handshake come before the other frames of the window that they name.
///
/// The digest of a frame is blake3 over interface, sender (each after its length), window, iteration, t0, t1, kind, and the payload after
/// its length, all integers and doubles little-endian. It excludes the run id, the host, the number of threads and the transport, so that
/// equal runs have equal fingerprints.
///
/// [`ExchangeHasher::end_window`] sorts the frames of a window: if participants answer at the same time, the order of arrival differs from
/// run to run.
///
/// ```
/// use exchange_log::ExchangeHasher;
/// use protocol::{Frame, Header, Kind};
/// let frame = Frame::new(Header::of(Kind::Motion), vec![1.0]);
/// let mut hasher = ExchangeHasher::default();
/// hasher.add("layer-base", "rail", &frame);
/// hasher.end_window();
/// assert_eq!(hasher.finish().len(), 64);
/// ```
#[derive(Clone, Debug, Default)]
pub struct ExchangeHasher {
    whole: blake3::Hasher,
    block: Vec<(Order, blake3::Hash)>,
}

impl ExchangeHasher {
    /// Adds one entry of the log.
    pub fn add_entry(&mut self, entry: &Entry) {
        match entry {
            Entry::Exchange(exchange) => {
                self.add(&exchange.interface, &exchange.sender, &exchange.frame);
            }
            Entry::WindowEnd(_) => self.end_window(),
        }
    }

    /// Adds one frame of the current window.
    pub fn add(&mut self, interface: &str, sender: &str, frame: &Frame) {
        let header = &frame.header;
        let (window, iteration, kind) = (header.window, header.iteration, header.kind);
        let order = (window, !is_handshake(kind), iteration, sender.into(), kind);
        self.block.push((order, digest(interface, sender, frame)));
    }

    /// Ends the window and sorts its frames.
    pub fn end_window(&mut self) {
        self.block.sort_by(|(left, _), (right, _)| left.cmp(right));
        for (_, digest) in self.block.drain(..) {
            self.whole.update(digest.as_bytes());
        }
    }

    /// The fingerprint in hexadecimal, including frames of an incomplete window.
    pub fn finish(mut self) -> String {
        self.end_window();
        self.whole.finalize().to_hex().to_string()
    }
}

/// True for kinds of the handshake, which have no window.
pub(super) fn is_handshake(kind: u32) -> bool {
    use Kind::*;
    matches!(
        Kind::from_number(kind),
        Some(Couple | Surface | Select | Columns | Compliance | CompliantBoundary | Ready)
            | Some(ImpedanceColumns | Impedance)
    )
}

/// Adds a text after its length.
pub(super) fn add_text(hasher: &mut blake3::Hasher, text: &str) {
    hasher.update(&(text.len() as u64).to_le_bytes());
    hasher.update(text.as_bytes());
}

fn digest(interface: &str, sender: &str, frame: &Frame) -> blake3::Hash {
    let header = &frame.header;
    let mut hasher = blake3::Hasher::new();
    for text in [interface, sender] {
        add_text(&mut hasher, text);
    }
    hasher.update(&header.window.to_le_bytes());
    hasher.update(&header.iteration.to_le_bytes());
    for time in [header.t0_s, header.t1_s] {
        // Adding zero turns -0.0 into 0.0: protobuf does not keep the sign of a zero outside lists.
        hasher.update(&(time + 0.0).to_bits().to_le_bytes());
    }
    hasher.update(&header.kind.to_le_bytes());
    hasher.update(&(frame.payload.len() as u64).to_le_bytes());
    let mut bytes = [0u8; 8 * 512];
    for values in frame.payload.chunks(512) {
        for (slot, value) in bytes.chunks_exact_mut(8).zip(values) {
            slot.copy_from_slice(&value.to_bits().to_le_bytes());
        }
        hasher.update(&bytes[..8 * values.len()]);
    }
    hasher.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::Header;

    fn frame(kind: Kind, window: u64, iteration: u32, payload: &[f64]) -> Frame {
        let header = Header {
            window,
            iteration,
            ..Header::of(kind)
        };
        Frame::new(header, payload.to_vec())
    }

    fn hash(frames: &[(&str, Frame)]) -> String {
        let mut hasher = ExchangeHasher::default();
        for (sender, frame) in frames {
            hasher.add("base", sender, frame);
        }
        hasher.finish()
    }

    fn window() -> Vec<(&'static str, Frame)> {
        vec![
            ("coupler", frame(Kind::Advance, 3, 0, &[1.0])),
            ("rail", frame(Kind::Motion, 3, 0, &[0.1, 0.2])),
            ("layer", frame(Kind::Force, 3, 0, &[])),
            ("rail", frame(Kind::Motion, 3, 1, &[0.3])),
        ]
    }

    #[test]
    fn the_order_of_arrival_between_senders_does_not_matter() {
        let expected = hash(&window());
        for turn in 1..4 {
            let mut turned = window();
            turned.rotate_left(turn);
            assert_eq!(hash(&turned), expected);
        }
    }

    #[test]
    fn the_order_of_one_senders_frames_of_one_kind_matters() {
        let one = ("rail", frame(Kind::Motion, 3, 0, &[1.0]));
        let two = ("rail", frame(Kind::Motion, 3, 0, &[2.0]));
        assert_ne!(hash(&[one.clone(), two.clone()]), hash(&[two, one]));
    }

    #[test]
    fn the_last_bit_of_a_payload_matters() {
        let mut changed = window();
        let value = &mut changed[1].1.payload[1];
        *value = f64::from_bits(value.to_bits() ^ 1);
        assert_ne!(hash(&changed), hash(&window()));
        let zero = |value| hash(&[("rail", frame(Kind::Motion, 0, 0, &[value]))]);
        assert_ne!(zero(0.0), zero(-0.0));
    }

    #[test]
    fn everything_else_that_defines_the_exchange_matters() {
        type Change = fn(&mut (&str, Frame));
        let changes: [Change; 6] = [
            |(sender, _)| *sender = "wheel",
            |(_, frame)| frame.header.kind = Kind::Force as u32,
            |(_, frame)| frame.header.iteration = 7,
            |(_, frame)| frame.header.t0_s = 1e-9,
            |(_, frame)| frame.header.t1_s = 1e-9,
            |(_, frame)| frame.payload.push(0.0),
        ];
        for (index, change) in changes.into_iter().enumerate() {
            let mut changed = window();
            change(&mut changed[1]);
            assert_ne!(hash(&changed), hash(&window()), "change {index}");
        }
        let mut other_interface = ExchangeHasher::default();
        for (sender, frame) in &window() {
            other_interface.add("top", sender, frame);
        }
        assert_ne!(other_interface.finish(), hash(&window()));
    }

    #[test]
    fn the_run_and_the_checksum_do_not_matter() {
        let mut changed = window();
        for (_, frame) in &mut changed {
            frame.header.run_id = 99;
            frame.header.checksum = 1;
        }
        assert_eq!(hash(&changed), hash(&window()));
    }

    #[test]
    fn where_blocks_end_does_not_matter_when_frames_come_window_by_window() {
        let frames = [
            ("coupler", frame(Kind::Couple, 0, 0, &[1.0])),
            ("rail", frame(Kind::Motion, 0, 0, &[2.0])),
            ("rail", frame(Kind::Motion, 1, 0, &[3.0])),
        ];
        let mut hasher = ExchangeHasher::default();
        for (sender, frame) in &frames {
            hasher.add("base", sender, frame);
            hasher.end_window();
        }
        assert_eq!(hasher.finish(), hash(&frames));
    }

    #[test]
    fn the_handshake_comes_before_window_zero() {
        let surface = ("rail", frame(Kind::Surface, 0, 0, &[1.0]));
        let advance = ("coupler", frame(Kind::Advance, 0, 0, &[2.0]));
        let mut apart = ExchangeHasher::default();
        apart.add("base", surface.0, &surface.1);
        apart.end_window();
        apart.add("base", advance.0, &advance.1);
        assert_eq!(hash(&[advance, surface]), apart.finish());
    }
}
