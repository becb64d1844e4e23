//! Distance of an answer from its logged twin, for solvers that do not repeat every bit.

use std::collections::BTreeMap;
use std::ops::Range;

use protocol::{Frame, Kind};

/// The largest deviation of an answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// Relative to the largest number of its kind in the log so far.
    pub rel: f64,
    /// Index in the payload.
    pub entry: usize,
}

/// Measures answers relative to the largest numbers in the log so far: over all points in motions and forces, for each signal and energy
/// in reports. Relative to itself, a number that passes through zero would have an infinite deviation.
#[derive(Clone, Debug, Default)]
pub struct Ruler {
    scales: BTreeMap<u32, Vec<f64>>,
}

impl Ruler {
    /// The largest deviation of `ours`, which must be as long as `logged`. Iterations and residual of a contact solve are not compared: they
    /// may depend on the solver.
    pub fn measure(&mut self, logged: &Frame, ours: &Frame) -> Deviation {
        let blocks = blocks(logged);
        let scales = self.scales.entry(logged.header.kind).or_default();
        scales.resize(blocks.len(), 0.0);
        let mut largest = Deviation { rel: 0.0, entry: 0 };
        for (block, scale) in blocks.into_iter().zip(scales) {
            let sizes = logged.payload[block.clone()].iter().map(|x| x.abs());
            *scale = sizes.fold(*scale, f64::max);
            for entry in block {
                let rel = relative(logged.payload[entry], ours.payload[entry], *scale);
                if rel > largest.rel {
                    largest = Deviation { rel, entry };
                }
            }
        }
        largest
    }
}

fn relative(logged: f64, ours: f64, scale: f64) -> f64 {
    match (logged - ours).abs() {
        difference if difference == 0.0 || logged.to_bits() == ours.to_bits() => 0.0,
        difference if difference.is_nan() => f64::INFINITY,
        difference => difference / scale,
    }
}

/// Parts of a payload whose numbers have one scale.
fn blocks(frame: &Frame) -> Vec<Range<usize>> {
    let length = frame.payload.len();
    match frame.kind() {
        Ok(Kind::Report) => (0..length).map(|entry| entry..entry + 1).collect(),
        Ok(Kind::Force) if length >= 3 => {
            let points = (length - 3) / 2;
            vec![0..points, points..2 * points, length - 1..length]
        }
        Ok(Kind::Reaction) => {
            let part = length / 3;
            vec![0..part, part..2 * part, 2 * part..length]
        }
        _ => std::iter::once(0..length).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::Header;

    fn frame(kind: Kind, payload: &[f64]) -> Frame {
        Frame::new(Header::of(kind), payload.to_vec())
    }

    #[test]
    fn forces_and_velocities_have_their_own_scales_and_iterations_have_none() {
        let logged = frame(Kind::Force, &[100.0, 0.0, 1e-3, 0.0, 50.0, 1e-6, 1.0]);
        let ours = frame(Kind::Force, &[100.0, 1.0, 1e-3, 1e-4, 60.0, 2e-6, 1.0]);
        let found = Ruler::default().measure(&logged, &ours);
        assert_eq!(found.entry, 3);
        assert!((found.rel - 0.1).abs() < 1e-12);
    }

    #[test]
    fn the_scale_is_the_largest_number_so_far() {
        let mut ruler = Ruler::default();
        ruler.measure(&frame(Kind::Motion, &[2.0]), &frame(Kind::Motion, &[2.0]));
        let found = ruler.measure(&frame(Kind::Motion, &[0.0]), &frame(Kind::Motion, &[0.5]));
        assert_eq!(found.rel, 0.25);
        let none = ruler.measure(
            &frame(Kind::Motion, &[f64::NAN]),
            &frame(Kind::Motion, &[0.0]),
        );
        assert_eq!(none.rel, f64::INFINITY);
    }
}
