//! Means of a traction over boxes: single nodes and grains carry single contacts, whose pressures say little.

use std::collections::BTreeMap;

use protocol::larger;

/// The largest mean (N/m) over boxes of `width_m`, centred at multiples of it, of forces (N) that are each spread evenly over a piece of a
/// line: its ends (m). A box between two pieces has its share of both, and one across the seam of a line that repeats every
/// `period_m` has that of the images beyond.
pub fn peak_of_means(
    pieces: impl Iterator<Item = ([f64; 2], f64)>,
    width_m: f64,
    period_m: Option<f64>,
) -> f64 {
    let images = period_m.map_or(vec![0.0], |p| vec![0.0, -p, p]);
    let index = |x: f64| (x / width_m).round() as i64;
    let mut boxes = BTreeMap::new();
    for ([low, high], force) in pieces {
        for by in &images {
            let [low, high] = [low + by, high + by];
            for cell in index(low)..=index(high) {
                let left = (cell as f64 - 0.5) * width_m;
                let covered = high.min(left + width_m) - low.max(left);
                *boxes.entry(cell).or_insert(0.0) += force * covered / (high - low);
            }
        }
    }
    let means = boxes.values().map(|force| force / width_m);
    means.fold(0.0, larger)
}
