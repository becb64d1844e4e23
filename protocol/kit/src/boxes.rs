//! Means of a traction over boxes: single nodes and grains carry single contacts, whose pressures say little.

use std::collections::BTreeMap;

use protocol::larger;

/// Part of a box by which the end of a line may miss it.
const ROUNDING: f64 = 1e-6;

/// The largest mean (N/m) over boxes of `width_m`, centred at multiples of it, of forces (N) that are each spread evenly over a piece of a
/// line: its ends (m). A box between two pieces has its share of both, and one across the seam of a line that repeats every
/// `period_m` has that of the images beyond. `None` where no box lies on the line as a whole: on a shorter one a mean would be over
/// what is not there.
pub fn peak_of_means(
    pieces: impl Iterator<Item = ([f64; 2], f64)>,
    width_m: f64,
    period_m: Option<f64>,
) -> Option<f64> {
    let images = period_m.map_or(vec![0.0], |p| vec![0.0, -p, p]);
    let index = |x: f64| (x / width_m).round() as i64;
    let (mut boxes, mut ends) = (BTreeMap::new(), [f64::INFINITY, f64::NEG_INFINITY]);
    for ([low, high], force) in pieces {
        for by in &images {
            let [low, high] = [low + by, high + by];
            ends = [ends[0].min(low), larger(ends[1], high)];
            for cell in index(low)..=index(high) {
                let left = (cell as f64 - 0.5) * width_m;
                let covered = high.min(left + width_m) - low.max(left);
                *boxes.entry(cell).or_insert(0.0) += force * covered / (high - low);
            }
        }
    }
    let is_whole = |cell: &i64| {
        let [low, high] = [-0.5, 0.5].map(|side| (*cell as f64 + side) * width_m);
        low >= ends[0] - ROUNDING * width_m && high <= ends[1] + ROUNDING * width_m
    };
    let means = boxes.values().map(|force| force / width_m);
    boxes.keys().any(is_whole).then(|| means.fold(0.0, larger))
}
