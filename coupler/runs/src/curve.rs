//! Numbers over time, linear between their positions, and the distance of two such curves.

use protocol::larger;

/// Fraction of the reference's span that a curve may miss at either end: reports are some windows apart.
const MISSED: f64 = 0.01;

/// Numbers over ascending positions.
#[derive(Clone, Copy, Debug)]
pub struct Curve<'a> {
    /// The positions.
    pub x: &'a [f64],
    /// The numbers, one for each position.
    pub y: &'a [f64],
}

/// Distance of numbers from a reference. The relative distances are absent if the reference is 0 throughout.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// sqrt(int d^2 / X) over the common span X, in the unit of the numbers.
    pub rms: f64,
    /// The same over the root mean square of the reference.
    pub l2_rel: Option<f64>,
    /// Largest |d|.
    pub max: f64,
    /// The same over the largest absolute value of the reference.
    pub max_rel: Option<f64>,
}

impl Distance {
    /// The distance from sums over a length: of d^2 and of the squared reference, with the largest absolute value of
    /// each.
    pub fn new(length: f64, [of_d, of_reference]: [f64; 2], [max, whole]: [f64; 2]) -> Self {
        Distance {
            rms: part(of_d, length).map_or(0.0, f64::sqrt),
            l2_rel: part(of_d, of_reference).map(f64::sqrt),
            max,
            max_rel: part(max, whole),
        }
    }
}

/// The quotient; `None` if the whole is 0.
pub fn part(of: f64, whole: f64) -> Option<f64> {
    (whole > 0.0).then_some(of / whole)
}

impl Curve<'_> {
    /// The number at a position inside the span; if two numbers share the position, the first. `None` outside.
    pub fn at(&self, position: f64) -> Option<f64> {
        let after = self.x.partition_point(|x| *x < position);
        let right = *self.x.get(after)?;
        if right == position {
            return Some(self.y[after]);
        }
        let left = self.x[after.checked_sub(1)?];
        let share = (position - left) / (right - left);
        Some(self.y[after - 1] + share * (self.y[after] - self.y[after - 1]))
    }

    fn span(&self) -> Option<[f64; 2]> {
        Some([*self.x.first()?, *self.x.last()?])
    }

    /// The distance from a reference, exact for piecewise linear curves: d is integrated and maximised over the pieces
    /// between the positions of both.
    ///
    /// # Errors
    /// This curve misses more than 1 % of the reference's span at either end, or one of the curves has no span.
    pub fn distance(&self, reference: &Curve) -> Result<Distance, String> {
        let (Some(own), Some(whole)) = (self.span(), reference.span()) else {
            return Err("there are no numbers".into());
        };
        let length = whole[1] - whole[0];
        let missed = [own[0] - whole[0], whole[1] - own[1]];
        if missed.iter().any(|missed| *missed > MISSED * length) {
            return Err(format!(
                "it spans {:.4e} to {:.4e}, but the reference {:.4e} to {:.4e}",
                own[0], own[1], whole[0], whole[1]
            ));
        }
        let [start, end] = [larger(own[0], whole[0]), -larger(-own[1], -whole[1])];
        let inside = |x: &&f64| (start..=end).contains(*x);
        let own_positions = self.x.iter().filter(inside);
        let positions = own_positions.chain(reference.x.iter().filter(inside));
        let mut positions: Vec<f64> = positions.copied().collect();
        positions.extend([start, end]);
        positions.sort_by(f64::total_cmp);
        positions.dedup();
        let pair = |x: &f64| Some([self.at(*x)?, reference.at(*x)?]);
        let pairs: Option<Vec<[f64; 2]>> = positions.iter().map(pair).collect();
        let pairs = pairs.ok_or("its positions are not in order")?;
        let [mut of_d, mut of_reference] = [0.0; 2];
        for (x, y) in positions.windows(2).zip(pairs.windows(2)) {
            let d = [0, 1].map(|k| y[k][0] - y[k][1]);
            of_d += square(x[1] - x[0], d);
            of_reference += square(x[1] - x[0], [y[0][1], y[1][1]]);
        }
        let largest =
            |of: &dyn Fn(&[f64; 2]) -> f64| pairs.iter().map(of).map(f64::abs).fold(0.0, larger);
        let sizes = [largest(&|[a, b]| a - b), largest(&|[_, b]| *b)];
        Ok(Distance::new(end - start, [of_d, of_reference], sizes))
    }
}

/// Integral of the square of a linear function between two numbers.
fn square(length: f64, [a, b]: [f64; 2]) -> f64 {
    length * (a * a + a * b + b * b) / 3.0
}

/// The median: the middle number, or the mean of the two in the middle; `None` without numbers.
pub fn median(mut numbers: Vec<f64>) -> Option<f64> {
    numbers.sort_by(f64::total_cmp);
    let last = numbers.len().checked_sub(1)?;
    Some(0.5 * (numbers[last / 2] + numbers[last.div_ceil(2)]))
}

/// The number below which this fraction (under 1) of the numbers lies; `None` without numbers.
pub fn quantile(mut numbers: Vec<f64>, share: f64) -> Option<f64> {
    let below = (share * numbers.len() as f64) as usize;
    (below < numbers.len()).then(|| *numbers.select_nth_unstable_by(below, f64::total_cmp).1)
}

/// `count` indices below `all`, evenly spaced, including the first and the last.
pub fn evenly(count: usize, all: usize) -> Vec<usize> {
    if count >= all {
        return (0..all).collect();
    }
    let last = count.saturating_sub(1).max(1);
    (0..count)
        .map(|k| (k * (all - 1) + last / 2) / last)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distance(own: [&[f64]; 2], reference: [&[f64]; 2]) -> Result<Distance, String> {
        let [own, reference] = [own, reference].map(|[x, y]| Curve { x, y });
        own.distance(&reference)
    }

    /// d = x on [0, 1] against 2: int x^2 = 1/3 of int 4.
    #[test]
    fn the_distance_of_a_ramp_from_a_constant_is_its_integral() {
        let found = distance([&[0.0, 1.0], &[2.0, 3.0]], [&[0.0, 0.25, 1.0], &[2.0; 3]]);
        let found = found.expect("they share a span");
        assert!((found.rms - (1f64 / 3.0).sqrt()).abs() < 1e-15);
        assert!((found.l2_rel.expect("it is not 0") - (1f64 / 12.0).sqrt()).abs() < 1e-15);
        assert_eq!((found.max, found.max_rel), (1.0, Some(0.5)));
    }

    /// A tent of height 1 on half of the span, against a curve that is zero and has no point at the tip.
    #[test]
    fn a_peak_between_the_positions_of_one_curve_counts() {
        let found = distance(
            [&[0.0, 4.0], &[0.0, 0.0]],
            [&[0.0, 1.0, 2.0, 4.0], &[0.0, 1.0, 0.0, 0.0]],
        );
        let found = found.expect("they share a span");
        assert!((found.rms - (2f64 / 3.0 / 4.0).sqrt()).abs() < 1e-15);
        assert_eq!((found.l2_rel, found.max_rel), (Some(1.0), Some(1.0)));
    }

    #[test]
    fn a_zero_reference_has_no_relative_distance() {
        let found = distance([&[0.0, 1.0], &[3.0, 3.0]], [&[0.0, 1.0], &[0.0, 0.0]]);
        let found = found.expect("they share a span");
        assert_eq!([found.l2_rel, found.max_rel], [None, None]);
        assert_eq!([found.rms, found.max], [3.0, 3.0]);
    }

    #[test]
    fn a_curve_that_ends_early_is_not_compared_over_the_rest() {
        let error = distance([&[0.0, 0.9], &[1.0, 1.0]], [&[0.0, 1.0], &[1.0, 1.0]]);
        assert!(error.expect_err("a tenth is missing").contains("9.0000e-1"));
        let fine = distance([&[0.001, 0.995], &[1.0, 1.0]], [&[0.0, 1.0], &[1.0, 1.0]]);
        assert_eq!(fine.expect("only 0.6 % is missing").max, 0.0);
    }

    #[test]
    fn even_choices_keep_both_ends() {
        assert_eq!(evenly(3, 9), [0, 4, 8]);
        assert_eq!(evenly(9, 3), [0, 1, 2]);
        assert_eq!(evenly(1, 5), [0]);
        let some = evenly(24, 400);
        assert_eq!((some[0], some[23]), (0, 399));
        assert!(some.windows(2).all(|two| two[0] < two[1]));
    }
}
