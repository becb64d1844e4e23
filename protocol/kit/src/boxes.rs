//! Means of a traction over boxes: the pressure on a single node or grain depends on single contacts and says little.

use std::collections::BTreeMap;

use protocol::larger;

/// Fraction of a box by which the end of a line may miss the box.
const ROUNDING: f64 = 1e-6;

/// The largest mean (N/m) of forces over boxes of width `width_m`, centred at multiples of `width_m`. Each force (N) is spread evenly
/// over a piece of a line, given by its ends (m). A box between two pieces has its share of both; a box across the seam of a line with
/// the period `period_m` has the share of the images beyond. `None` if no box lies entirely on the line: the mean over a shorter line
/// would include a part without a line.
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
