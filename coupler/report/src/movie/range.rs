//! Ranges of the numbers of a movie, over all its frames.

use draw::axis::range;
use runs::curve::quantile;

use super::encode::Codes;
use super::shots::Shots;

/// Share of the grains whose colours differ: single grains carry many times the mean.
const SHOWN: f64 = 0.98;
/// Positions of grains are rounded to the smallest radius over this number, or finer.
const PARTS: f64 = 20.0;

/// Ranges over all frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MovieRanges {
    /// Displacements of nodes along x and y (m).
    pub displacement: [[f64; 2]; 2],
    /// Positions of grains along x and y (m); grains beyond are not shown.
    pub position: [[f64; 2]; 2],
    /// Largest radius (m).
    pub radius_m: f64,
    /// Pressures (Pa); pressures beyond have the colours of the ends.
    pub pressure_pa: [f64; 2],
    /// Speed of grains at which the colours end (m/s).
    pub speed_m_per_s: f64,
    /// Normal force at which lines are widest (N).
    pub force_n: f64,
}

impl MovieRanges {
    /// The ranges of these frames.
    pub fn of(shots: &Shots) -> MovieRanges {
        let meshes = || shots.meshes.iter().flatten().flatten();
        let grains = || shots.grains.iter().flatten().flatten();
        let radii = of(grains().flat_map(|shot| &shot.radius).copied());
        let smallest = grains().flat_map(|shot| &shot.radius).filter(|r| **r > 0.0);
        let smallest = smallest.copied().fold(f64::INFINITY, f64::min);
        let position = [0, 1].map(|k| {
            let all = of(grains().flat_map(|shot| &shot.centre[k]).copied());
            let first = grains().take(1).flat_map(|shot| &shot.centre[k]);
            limited(all, of(first.copied()), smallest)
        });
        let body = of(meshes().flat_map(|shot| &shot.pressure).copied());
        let carried = share(grains().flat_map(|shot| &shot.pressure).copied());
        let speeds = grains().filter_map(|shot| shot.speed.as_ref()).flatten();
        let forces = grains().flat_map(|shot| &shot.lines).map(|line| line.force);
        MovieRanges {
            displacement: [0, 1].map(|k| of(meshes().flat_map(|shot| &shot.u[k]).copied())),
            position,
            radius_m: radii[1],
            pressure_pa: pressures(body, carried),
            speed_m_per_s: round_up(share(speeds.copied())),
            force_n: round_up(share(forces)),
        }
    }

    /// Codes of pressures (Pa).
    pub fn pressure(&self) -> Codes {
        Codes::coarse(self.pressure_pa)
    }

    /// Codes of speeds (m/s).
    pub fn speed(&self) -> Codes {
        Codes::coarse([0.0, self.speed_m_per_s])
    }

    /// Codes of normal forces (N).
    pub fn force(&self) -> Codes {
        Codes::coarse([0.0, self.force_n])
    }
}

/// From the largest tension of the continuum, if it is large enough to show, to its largest pressure; without pressure in a continuum, to
/// the pressure that most grains stay below.
fn pressures([low, high]: [f64; 2], carried: f64) -> [f64; 2] {
    let most = round_up(if high > 0.0 { high } else { carried });
    let tension = round_up(-low);
    // A rounding error is no pressure.
    let most = if most > 1e-9 * tension { most } else { 0.0 };
    [if tension > 0.02 * most { -tension } else { 0.0 }, most]
}

/// The range of all positions, or the part around the first frame's range in which the codes resolve the grains.
fn limited(all: [f64; 2], first: [f64; 2], smallest: f64) -> [f64; 2] {
    let most = 65_534.0 * smallest / PARTS;
    if all[1] - all[0] <= most {
        return all;
    }
    let middle = 0.5 * (first[0] + first[1]);
    let from = (middle - 0.5 * most).max(all[0]).min(all[1] - most);
    [from, from + most]
}

/// Smallest and largest of the numbers; zeros without any.
pub fn of(numbers: impl Iterator<Item = f64>) -> [f64; 2] {
    range(numbers).unwrap_or_default()
}

/// The number that most positive numbers stay below.
fn share(numbers: impl Iterator<Item = f64>) -> f64 {
    let numbers = numbers.filter(|number| *number > 0.0);
    quantile(numbers.collect(), SHOWN).unwrap_or(0.0)
}

/// The smallest number with two significant digits that is not below a positive number; 0 for other numbers.
pub fn round_up(number: f64) -> f64 {
    if !(number > 0.0 && number.is_finite()) {
        return 0.0;
    }
    let exponent = number.log10().floor() - 1.0;
    let digits = (number / 10f64.powf(exponent) * (1.0 - 1e-12)).ceil();
    // Parsed from text, the result is the nearest to the decimal number.
    format!("{digits}e{exponent}").parse().unwrap_or(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn full_scales_have_two_digits_and_are_not_below() {
        let rounded = [771.02, 0.0123, 99.5, 20.0, -3.0].map(round_up);
        assert_eq!(rounded, [780.0, 0.013, 100.0, 20.0, 0.0]);
    }

    #[test]
    fn tension_has_colours_if_it_is_large_enough() {
        assert_eq!(pressures([-1.0, 770.0], 9e9), [0.0, 770.0]);
        assert_eq!(pressures([-77.0, 770.0], 9e9), [-77.0, 770.0]);
        assert_eq!(pressures([0.0, 0.0], 12.0), [0.0, 12.0]);
        assert_eq!(pressures([-5.0, -5.0], 0.0), [-5.0, 0.0]);
        assert_eq!(pressures([-5.0, 1e-15], 0.0), [-5.0, 0.0]);
    }

    #[test]
    fn a_grain_that_flies_away_leaves_the_precision_of_the_others() {
        let near = [0.0, 16e-3];
        assert_eq!(limited(near, near, 5e-5), near);
        let [low, high] = limited([0.0, 5.0], near, 5e-5);
        assert!(low == 0.0 && (high - 0.163835).abs() < 1e-12, "{high}");
    }
}
