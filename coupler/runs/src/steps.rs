//! Piecewise constant numbers on the segments of a line, as for tractions of nodes, and the distance of two such lines.

use protocol::larger;

use super::curve::Distance;

/// Fewest bins on the reference's line, as differences cancel in wider ones, and most bins on the whole line, as memory
/// is limited.
pub const BINS: [f64; 2] = [8.0, 1e5];

/// A vector on each segment of a line, and 0 outside. A number is a vector whose second component is 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Steps {
    /// Ends of the segments, ascending: one more than there are vectors.
    edges: Vec<f64>,
    vectors: Vec<[f64; 2]>,
}

impl Steps {
    /// Numbers at ascending positions, each on a segment that ends half-way to its neighbours, like a node's share of
    /// the surface. The first and the last position are the ends of the line.
    pub fn around(positions: &[f64], numbers: &[f64]) -> Option<Steps> {
        Steps::of_vectors(positions, numbers.iter().map(|number| [*number, 0.0]))
    }

    /// The same for vectors.
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

    /// The distance between means over the segments of the reference or, if a width is given, over bins centred at its
    /// multiples, the outermost of which end with two lines of the same ends. Squares are weighted by the lengths.
    ///
    /// # Errors
    /// The bins are too wide or too narrow, see [`bin_fits`].
    pub fn distance(&self, reference: &Steps, bin: Option<f64>) -> Result<Distance, String> {
        let [own, other] = [self, reference].map(|of| [of.edges[0], of.edges[of.edges.len() - 1]]);
        let [start, end] = [-larger(-own[0], -other[0]), larger(own[1], other[1])];
        let whole = end - start;
        let bins = match bin {
            None => pairs(&reference.edges),
            Some(width) => {
                bin_fits(width, [other[1] - other[0], whole])?;
                let [first, last] = [start, end].map(|end| index(end, width));
                let bins = first..=last;
                let bins = bins.map(|k| [-0.5, 0.5].map(|side| (k as f64 + side) * width));
                // Where two surfaces have the same ends, the outermost bins have them, too. Else a bin lacks what one surface has not.
                let same = |k: usize| (own[k] - other[k]).abs() <= SAME_END * whole;
                let [from, to] = if same(0) && same(1) {
                    [start, end]
                } else {
                    [f64::NEG_INFINITY, f64::INFINITY]
                };
                let inside = bins.map(|[low, high]| [larger(low, from), -larger(-high, -to)]);
                inside.filter(|[low, high]| low < high).collect()
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

/// Refuses bins of this width (m) that are too wide for the reference's surface, or too narrow for both surfaces
/// together (m).
///
/// # Errors
/// The text states the allowed widths.
pub fn bin_fits(width: f64, [reference, whole]: [f64; 2]) -> Result<(), String> {
    let [narrowest, widest] = [whole / BINS[1], reference / BINS[0]];
    if (narrowest..=widest * (1.0 + 1e-9)).contains(&width) {
        return Ok(());
    }
    Err(format!(
        "bins of {width:e} m do not fit a surface of {reference:.4e} m: differences cancel in wide bins, and narrow bins fill the memory; take {narrowest:.1e} to {widest:.1e} m, a few grains or elements"
    ))
}

/// Distance of the ends of two surfaces, over their length together, up to which they are at one place.
const SAME_END: f64 = 1e-9;

/// Number of the bin that contains a position: bin k is centred at k widths.
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
    fn means_weight_segments_by_the_covered_length() {
        let steps = steps(&[0.0, 1.0, 2.0], &[4.0, 2.0, 8.0]);
        assert_eq!(steps.mean([0.25, 1.0])[0], (0.25 * 4.0 + 0.5 * 2.0) / 0.75);
        assert_eq!(steps.mean([-1.0, 3.0])[0], (2.0 + 2.0 + 4.0) / 4.0);
        assert_eq!(steps.mean([2.5, 3.0]), [0.0; 2]);
    }

    /// Lines of 3 and of 5 nodes: 1 everywhere, except 3 on the middle segment of the second.
    #[test]
    fn different_meshes_are_compared_by_means() {
        let coarse = steps(&[0.0, 1.0, 2.0], &[1.0, 1.0, 1.0]);
        let fine = steps(&[0.0, 0.5, 1.0, 1.5, 2.0], &[1.0, 1.0, 3.0, 1.0, 1.0]);
        let of_segments = fine.distance(&coarse, None).expect("they are compared");
        // Means over the segments of the coarse line: 1, 2, 1.
        assert_eq!(of_segments.max_rel, Some(1.0));
        assert_eq!(of_segments.l2_rel, Some((1.0f64 / 2.0).sqrt()));
        let same = fine.distance(&fine, Some(0.2)).expect("ten bins will do");
        assert_eq!([same.rms, same.max], [0.0; 2]);
    }

    /// Nine bins of width 0.5 centred at -2, -1.5, .., 2 on [-2, 2]: the line ends in the middle of the outermost.
    #[test]
    fn bins_are_centred_at_multiples_of_their_width() {
        let ends = [-2.0, 2.0];
        let (own, reference) = (steps(&ends, &[3.0, 3.0]), steps(&ends, &[1.0, 1.0]));
        let found = own.distance(&reference, Some(0.5)).expect("nine bins");
        assert_eq!((found.max, found.max_rel), (2.0, Some(2.0)));
        assert_eq!((found.rms, found.l2_rel), (2.0, Some(2.0)));
    }

    /// (3, 4) and (3, 5) against (0, 4): distances of 3 and sqrt(10) from vectors of the length 4.
    #[test]
    fn the_distance_of_vectors_takes_both_components() {
        let of = |vectors: [[f64; 2]; 2]| Steps::of_vectors(&[0.0, 1.0], vectors.into_iter());
        let own = of([[3.0, 4.0], [3.0, 5.0]]).expect("two nodes");
        let found = own.distance(&of([[0.0, 4.0]; 2]).expect("two nodes"), None);
        let found = found.expect("they are compared");
        assert_eq!(found.l2_rel, Some((19.0f64 / 32.0).sqrt()));
        assert_eq!(found.max_rel, Some(10.0f64.sqrt() / 4.0));
    }

    /// Numbers that only change places have the same mean over a wide bin: their difference would vanish. Bins of 1 pm
    /// would be 4e12 bins.
    #[test]
    fn bins_that_hide_differences_are_refused() {
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
