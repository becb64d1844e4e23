//! The first difference between two streams of frames.

use protocol::{Frame, Kind};
use thiserror::Error;

/// The first difference between a message and its logged twin.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("`{sender}` departs in window {window}, iteration {iteration}, {kind}: {difference}")]
pub struct Mismatch {
    /// Its sender.
    pub sender: String,
    /// Window.
    pub window: u64,
    /// Repeat of the window.
    pub iteration: u32,
    /// Kind of the message.
    pub kind: String,
    /// The difference.
    pub difference: Difference,
}

/// The difference.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Difference {
    /// Another message, window or length.
    #[error("the log has {logged}, the replay {ours}")]
    Message {
        /// In the log.
        logged: String,
        /// In the replay.
        ours: String,
    },
    /// One number.
    #[error(
        "entry {entry} (point {}, {}): the log has {logged:e}, the replay {ours:e}, {ulps} ulps apart",
        .entry / 2, if .entry % 2 == 0 { "x" } else { "y" }
    )]
    Number {
        /// Entry of the payload.
        entry: usize,
        /// In the log.
        logged: f64,
        /// In the replay.
        ours: f64,
        /// Representable numbers between the two.
        ulps: u64,
    },
}

impl Mismatch {
    /// Compares a message with its logged twin, bit for bit; run ids may differ.
    pub fn between(sender: &str, logged: &Frame, ours: &Frame) -> Option<Mismatch> {
        let differing = || Mismatch::at(sender, logged, &describe(logged), &describe(ours));
        if about(logged) != about(ours) {
            return Some(differing());
        }
        let mut pairs = logged.payload.iter().zip(&ours.payload);
        let differ = |(a, b): (&f64, &f64)| a.to_bits() != b.to_bits();
        let entry = pairs.position(differ)?;
        Some(differing().at_entry(logged, ours, entry))
    }

    /// A departure of `sender` at a message of the log, with words for the content of the log and of the replay.
    pub fn at(sender: &str, message: &Frame, logged: &str, ours: &str) -> Mismatch {
        Mismatch {
            sender: sender.to_string(),
            window: message.header.window,
            iteration: message.header.iteration,
            kind: kind(message),
            difference: Difference::Message {
                logged: logged.to_string(),
                ours: ours.to_string(),
            },
        }
    }

    /// The same departure at an entry of the payload.
    pub fn at_entry(self, logged: &Frame, ours: &Frame, entry: usize) -> Mismatch {
        let (logged, ours) = (logged.payload[entry], ours.payload[entry]);
        let difference = Difference::Number {
            entry,
            logged,
            ours,
            ulps: ulps(logged, ours),
        };
        Mismatch { difference, ..self }
    }
}

fn kind(frame: &Frame) -> String {
    let number = frame.header.kind;
    Kind::from_number(number).map_or(format!("kind {number}"), |kind| kind.word().into())
}

/// A frame without run, checksum and numbers, as bits. The log does not keep the sign of a time of zero.
fn about(frame: &Frame) -> [u64; 10] {
    let header = &frame.header;
    [
        header.kind.into(),
        header.protocol.into(),
        header.interface.into(),
        frame.payload.len() as u64,
        header.window,
        header.iteration.into(),
        header.step,
        header.substeps.into(),
        (header.t0_s + 0.0).to_bits(),
        (header.t1_s + 0.0).to_bits(),
    ]
}

/// The same parts in words.
fn describe(frame: &Frame) -> String {
    format!(
        "{} of {} doubles for {}, protocol {}",
        kind(frame),
        frame.payload.len(),
        frame.header.subject(),
        frame.header.protocol
    )
}

/// Representable numbers between two; the largest count if one is NaN.
fn ulps(a: f64, b: f64) -> u64 {
    if a.is_nan() || b.is_nan() {
        return u64::MAX;
    }
    let ordered = |x: f64| match x.to_bits() as i64 {
        bits @ ..0 => i64::MIN.wrapping_sub(bits),
        bits => bits,
    };
    ordered(a).abs_diff(ordered(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::Header;

    #[test]
    fn one_bit_is_found_and_counted() {
        let logged = Frame::new(Header::of(Kind::Motion), vec![1.0, 2.0, 3.0]);
        let ours = Frame::new(
            Header::of(Kind::Motion),
            vec![1.0, 2.0, f64::from_bits(3f64.to_bits() + 2)],
        );
        let found = Mismatch::between("rail", &logged, &ours).expect("they differ");
        assert!(matches!(
            found.difference,
            Difference::Number {
                entry: 2,
                ulps: 2,
                ..
            }
        ));
        assert_eq!(Mismatch::between("rail", &logged, &logged), None);
    }

    #[test]
    fn ulps_cross_zero() {
        assert_eq!(ulps(0.0, -0.0), 0);
        assert_eq!(ulps(f64::from_bits(1), -f64::from_bits(1)), 2);
    }
}
