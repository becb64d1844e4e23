//! Numbers on the segments of a line, as tractions are given node by node, and the distance of two of them.

use std::ops::Range;

use protocol::larger;

use super::curve::Distance;

/// A number on each segment of a line; 0 beside them.
#[derive(Clone, Debug, PartialEq)]
pub struct Steps {
    /// Ends of the segments, one more than there are numbers, ascending.
    edges: Vec<f64>,
    numbers: Vec<f64>,
}

impl Steps {
    /// Numbers at ascending positions, each on the segment that ends half-way to its neighbours: what a node's share of the surface
    /// is. The first and the last position are the ends of the line.
    pub fn around(positions: &[f64], numbers: &[f64]) -> Option<Steps> {
        let (first, last) = (*positions.first()?, *positions.last()?);
        let middles = positions.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
        let edges = std::iter::once(first).chain(middles).chain([last]);
        Some(Steps {
            edges: edges.collect(),
            numbers: numbers.to_vec(),
        })
    }

    /// The same segments with 0 on each.
    pub fn zero(&self) -> Steps {
        Steps {
            numbers: vec![0.0; self.numbers.len()],
            ..self.clone()
        }
    }

    /// The mean over a part of the line.
    fn mean(&self, [low, high]: [f64; 2]) -> f64 {
        let first = self.edges.partition_point(|edge| *edge <= low);
        let mut sum = 0.0;
        for segment in first.saturating_sub(1)..self.numbers.len() {
            let [left, right] = [self.edges[segment], self.edges[segment + 1]];
            if left >= high {
                break;
            }
            let covered = -larger(-high, -right) - larger(low, left);
            sum += self.numbers[segment] * larger(covered, 0.0);
        }
        sum / (high - low)
    }

    /// The distance of means over the segments of the reference, or over bins of this width about its multiples, where one is
    /// given. Squares are weighted by the lengths.
    pub fn distance(&self, reference: &Steps, bin: Option<f64>) -> Distance {
        let bins = match bin {
            None => pairs(&reference.edges),
            Some(width) => {
                let ends = [&self.edges, &reference.edges];
                let first = ends.iter().map(|e| index(e[0], width)).min();
                let last = ends.iter().map(|e| index(e[e.len() - 1], width)).max();
                let bins: Range<i64> = first.unwrap_or(0)..last.unwrap_or(0) + 1;
                bins.map(|k| [0.0, 1.0].map(|side| (k as f64 - 0.5 + side) * width))
                    .collect()
            }
        };
        let means = |bin: &[f64; 2]| [bin[1] - bin[0], self.mean(*bin), reference.mean(*bin)];
        let means: Vec<[f64; 3]> = bins.iter().map(means).collect();
        let sum = |of: &dyn Fn(&[f64; 3]) -> f64| means.iter().map(of).sum::<f64>();
        let largest =
            |of: &dyn Fn(&[f64; 3]) -> f64| means.iter().map(of).map(f64::abs).fold(0.0, larger);
        let of_d = sum(&|[length, a, b]| length * (a - b).powi(2));
        let squares = [of_d, sum(&|[length, _, b]| length * b * b)];
        let sizes = [largest(&|[_, a, b]| a - b), largest(&|[_, _, b]| *b)];
        Distance::new(sum(&|[length, ..]| *length), squares, sizes)
    }
}

/// Number of the bin that holds a position: bin k lies about k widths.
fn index(position: f64, width: f64) -> i64 {
    (position / width).round() as i64
}

fn pairs(edges: &[f64]) -> Vec<[f64; 2]> {
    let pairs = edges.windows(2).map(|pair| [pair[0], pair[1]]);
    pairs.filter(|[low, high]| low < high).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(positions: &[f64], numbers: &[f64]) -> Steps {
        Steps::around(positions, numbers).expect("there are positions")
    }

    /// Segments [0, 0.5], [0.5, 1.5], [1.5, 2].
    #[test]
    fn means_take_what_they_cover() {
        let steps = steps(&[0.0, 1.0, 2.0], &[4.0, 2.0, 8.0]);
        assert_eq!(steps.mean([0.25, 1.0]), (0.25 * 4.0 + 0.5 * 2.0) / 0.75);
        assert_eq!(steps.mean([-1.0, 3.0]), (2.0 + 2.0 + 4.0) / 4.0);
        assert_eq!(steps.mean([2.5, 3.0]), 0.0);
    }

    /// The same force on lines of 3 and of 5 nodes: 1 everywhere, but for 3 on the middle half of the second.
    #[test]
    fn meshes_that_differ_are_compared_by_means() {
        let coarse = steps(&[0.0, 1.0, 2.0], &[1.0, 1.0, 1.0]);
        let fine = steps(&[0.0, 0.5, 1.0, 1.5, 2.0], &[1.0, 1.0, 3.0, 1.0, 1.0]);
        let of_segments = fine.distance(&coarse, None);
        // Means of the segments of the coarse one: 1, 2, 1.
        assert_eq!(of_segments.max_rel, Some(1.0));
        assert_eq!(of_segments.l2_rel, Some((1.0f64 / 2.0).sqrt()));
        let same = fine.distance(&fine, Some(0.3));
        assert_eq!([same.rms, same.max], [0.0; 2]);
    }

    /// Bins about -2, 0 and 2 of width 2 on [-2, 2]: those at the ends hold half of what they would.
    #[test]
    fn bins_lie_about_multiples_of_their_width() {
        let ends = [-2.0, 2.0];
        let (own, reference) = (steps(&ends, &[3.0, 3.0]), steps(&ends, &[1.0, 1.0]));
        let found = own.distance(&reference, Some(2.0));
        assert_eq!((found.max, found.max_rel), (2.0, Some(2.0)));
        assert_eq!(
            found.rms,
            ((2.0 * 1.0 + 2.0 * 4.0 + 2.0 * 1.0) / 6.0f64).sqrt()
        );
    }
}
