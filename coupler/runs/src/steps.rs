//! Numbers on the segments of a line, as tractions are given node by node, and the distance of two of them.

use std::ops::Range;

use protocol::larger;

use super::curve::Distance;

/// Least bins of the reference's line, with fewer of which what differs cancels, and most of the whole line, which memory holds.
pub const BINS: [f64; 2] = [8.0, 1e5];

/// A vector on each segment of a line, a number being one whose second component is 0; 0 beside them.
#[derive(Clone, Debug, PartialEq)]
pub struct Steps {
    /// Ends of the segments, one more than there are vectors, ascending.
    edges: Vec<f64>,
    vectors: Vec<[f64; 2]>,
}

impl Steps {
    /// Numbers at ascending positions, each on the segment that ends half-way to its neighbours: what a node's share of the surface
    /// is. The first and the last position are the ends of the line.
    pub fn around(positions: &[f64], numbers: &[f64]) -> Option<Steps> {
        Steps::of_vectors(positions, numbers.iter().map(|number| [*number, 0.0]))
    }

    /// The same of vectors.
    pub fn of_vectors(positions: &[f64], vectors: impl Iterator<Item = [f64; 2]>) -> Option<Steps> {
        let (first, last) = (*positions.first()?, *positions.last()?);
        let middles = positions.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
        let edges = std::iter::once(first).chain(middles).chain([last]);
        Some(Steps {
            edges: edges.collect(),
            vectors: vectors.collect(),
        })
    }

    /// The same segments with 0 on each.
    pub fn zero(&self) -> Steps {
        Steps {
            vectors: vec![[0.0; 2]; self.vectors.len()],
            ..self.clone()
        }
    }

    /// The mean over a part of the line.
    fn mean(&self, [low, high]: [f64; 2]) -> [f64; 2] {
        let first = self.edges.partition_point(|edge| *edge <= low);
        let mut sum = [0.0; 2];
        for segment in first.saturating_sub(1)..self.vectors.len() {
            let [left, right] = [self.edges[segment], self.edges[segment + 1]];
            if left >= high {
                break;
            }
            let covered = -larger(-high, -right) - larger(low, left);
            for (sum, component) in sum.iter_mut().zip(self.vectors[segment]) {
                *sum += component * larger(covered, 0.0);
            }
        }
        sum.map(|sum| sum / (high - low))
    }

    /// The distance of means over the segments of the reference, or over bins of this width about its multiples, where one is
    /// given. Squares are weighted by the lengths.
    ///
    /// # Errors
    /// The bins are too wide or too narrow, see [`bin_fits`].
    pub fn distance(&self, reference: &Steps, bin: Option<f64>) -> Result<Distance, String> {
        let [own, other] = [self, reference].map(|of| [of.edges[0], of.edges[of.edges.len() - 1]]);
        let whole = larger(own[1], other[1]) + larger(-own[0], -other[0]);
        bin.map_or(Ok(()), |width| {
            bin_fits(width, [other[1] - other[0], whole])
        })?;
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
        let lengths = || bins.iter().map(|[low, high]| high - low);
        let means = |bin: &[f64; 2]| {
            let [own, other] = [self.mean(*bin), reference.mean(*bin)];
            [[own[0] - other[0], own[1] - other[1]], other]
        };
        let means: Vec<[[f64; 2]; 2]> = bins.iter().map(means).collect();
        let square = |[x, y]: [f64; 2]| x * x + y * y;
        let squares = [0, 1].map(|k| {
            let parts = lengths().zip(&means);
            parts.map(|(length, of)| length * square(of[k])).sum()
        });
        let sizes = [0, 1].map(|k| {
            let sizes = means.iter().map(|of| f64::hypot(of[k][0], of[k][1]));
            sizes.fold(0.0, larger)
        });
        Ok(Distance::new(lengths().sum(), squares, sizes))
    }
}

/// Refuses bins of this width (m) that are too wide for the surface of the reference, or too narrow for that of both (m).
///
/// # Errors
/// The text says between which widths they must lie.
pub fn bin_fits(width: f64, [reference, whole]: [f64; 2]) -> Result<(), String> {
    let [narrowest, widest] = [whole / BINS[1], reference / BINS[0]];
    if (narrowest..=widest * (1.0 + 1e-9)).contains(&width) {
        return Ok(());
    }
    Err(format!(
        "bins of {width:e} m do not fit a surface of {reference:.4e} m: in wide ones differences cancel, narrow ones fill the memory; take {narrowest:.1e} to {widest:.1e} m, a few grains or elements"
    ))
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
        assert_eq!(steps.mean([0.25, 1.0])[0], (0.25 * 4.0 + 0.5 * 2.0) / 0.75);
        assert_eq!(steps.mean([-1.0, 3.0])[0], (2.0 + 2.0 + 4.0) / 4.0);
        assert_eq!(steps.mean([2.5, 3.0]), [0.0; 2]);
    }

    /// The same force on lines of 3 and of 5 nodes: 1 everywhere, but for 3 on the middle half of the second.
    #[test]
    fn meshes_that_differ_are_compared_by_means() {
        let coarse = steps(&[0.0, 1.0, 2.0], &[1.0, 1.0, 1.0]);
        let fine = steps(&[0.0, 0.5, 1.0, 1.5, 2.0], &[1.0, 1.0, 3.0, 1.0, 1.0]);
        let of_segments = fine.distance(&coarse, None).expect("they are compared");
        // Means of the segments of the coarse one: 1, 2, 1.
        assert_eq!(of_segments.max_rel, Some(1.0));
        assert_eq!(of_segments.l2_rel, Some((1.0f64 / 2.0).sqrt()));
        let same = fine.distance(&fine, Some(0.2)).expect("ten bins will do");
        assert_eq!([same.rms, same.max], [0.0; 2]);
    }

    /// Nine bins of width 0.5 about -2, -1.5, .., 2 on [-2, 2]: those at the ends hold half of what they would.
    #[test]
    fn bins_lie_about_multiples_of_their_width() {
        let ends = [-2.0, 2.0];
        let (own, reference) = (steps(&ends, &[3.0, 3.0]), steps(&ends, &[1.0, 1.0]));
        let found = own.distance(&reference, Some(0.5)).expect("nine bins");
        assert_eq!((found.max, found.max_rel), (2.0, Some(2.0)));
        assert_eq!(found.rms, ((7.0 * 4.0 + 2.0 * 1.0) / 9.0f64).sqrt());
    }

    /// (3, 4) and (3, 5) against (0, 4): distances of 3 and sqrt(10) from vectors of the length 4.
    #[test]
    fn a_vector_is_as_far_as_both_of_its_components() {
        let of = |vectors: [[f64; 2]; 2]| Steps::of_vectors(&[0.0, 1.0], vectors.into_iter());
        let own = of([[3.0, 4.0], [3.0, 5.0]]).expect("two nodes");
        let found = own.distance(&of([[0.0, 4.0]; 2]).expect("two nodes"), None);
        let found = found.expect("they are compared");
        assert_eq!(found.l2_rel, Some((19.0f64 / 32.0).sqrt()));
        assert_eq!(found.max_rel, Some(10.0f64.sqrt() / 4.0));
    }

    /// Numbers that only change places have the same mean over a wide bin: what differs by their size would differ by nothing. A bin of
    /// 1 pm asks for 4e12 of them.
    #[test]
    fn bins_that_hide_what_differs_are_refused() {
        let ends = [-2.0, 2.0];
        let (own, reference) = (steps(&ends, &[3.0, 1.0]), steps(&ends, &[1.0, 3.0]));
        let of = |width| own.distance(&reference, Some(width));
        assert_eq!(of(0.5).expect("they fit").max, 2.0);
        for width in [1e-12, 0.6, 8.0, 1e30] {
            let why = of(width).expect_err("they do not fit");
            assert!(why.contains("take 4.0e-5 to 5.0e-1 m"), "{width}: {why}");
        }
    }
}
