//! Linear and logarithmic axes with their labels, and the grid of a pair of axes.

use crate::svg::{Anchor, FRAME, Svg};

/// Width of a letter (pixels), for keeping words apart.
pub(crate) const LETTER: f64 = 7.0;

/// One axis.
#[derive(Clone, Debug)]
pub struct PlotAxis {
    /// Words along it.
    pub words: String,
    /// Numbers that have labels.
    pub ticks: Vec<(f64, String)>,
    /// Numbers at its ends, or on a logarithmic axis their decimal logarithms.
    ends: [f64; 2],
    logarithmic: bool,
}

impl PlotAxis {
    /// A linear axis between two numbers, with at most about `count` labels.
    pub fn linear(words: &str, ends: [f64; 2], count: usize) -> PlotAxis {
        PlotAxis {
            words: words.into(),
            ticks: labelled(ends, count),
            ends,
            logarithmic: false,
        }
    }

    /// A linear axis that contains these numbers and a margin.
    pub fn around(words: &str, numbers: impl Iterator<Item = f64>, count: usize) -> PlotAxis {
        let Some([low, high]) = range(numbers) else {
            return PlotAxis::linear(words, [0.0, 1.0], count);
        };
        let (size, extent) = (low.abs().max(high.abs()), high - low);
        // Draw a constant as a line in the middle, not the noise of its last digit.
        let margin = match (extent > 1e-9 * size, size > 0.0) {
            (true, _) => 0.04 * extent,
            (false, true) => 0.1 * size,
            (false, false) => 1.0,
        };
        PlotAxis::linear(words, [low - margin, high + margin], count)
    }

    /// A logarithmic axis that contains the positive ones of these numbers and a margin.
    pub fn logarithmic(words: &str, numbers: impl Iterator<Item = f64>) -> PlotAxis {
        let logarithms = numbers.filter(|x| *x > 0.0).map(f64::log10);
        let [low, high] = range(logarithms).unwrap_or([0.0; 2]);
        let margin = (0.06 * (high - low)).max(0.08);
        let ends = match low < high {
            true => [low - margin, high + margin],
            false => [low - 10.0 * margin, high + 10.0 * margin],
        };
        PlotAxis {
            words: words.into(),
            ticks: logarithmic_ticks(ends),
            ends,
            logarithmic: true,
        }
    }

    /// Position of a number as a share of the axis: 0 to 1 between the ends, not finite for a number that the axis cannot show.
    pub fn share(&self, number: f64) -> f64 {
        let drawn = match self.logarithmic {
            true => number.log10(),
            false => number,
        };
        (drawn - self.ends[0]) / (self.ends[1] - self.ends[0])
    }

    /// True for a number between its ends.
    pub fn holds(&self, number: f64) -> bool {
        (0.0..=1.0).contains(&self.share(number))
    }
}

/// Marks at the labels of a pair of axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grid {
    /// Lines across the area.
    Lines,
    /// Ticks outside the area.
    Ticks,
}

/// A pair of axes around an area.
#[derive(Clone, Debug)]
pub struct AxisPair {
    /// Axis to the right.
    pub x: PlotAxis,
    /// Axis upwards.
    pub y: PlotAxis,
    /// Left and right edge of the area (pixels).
    pub across: [f64; 2],
    /// Upper and lower edge of the area (pixels).
    pub down: [f64; 2],
}

impl AxisPair {
    /// Position of a point (pixels).
    pub fn at(&self, (x, y): (f64, f64)) -> [f64; 2] {
        let ([left, right], [top, bottom]) = (self.across, self.down);
        [
            left + (right - left) * self.x.share(x),
            bottom - (bottom - top) * self.y.share(y),
        ]
    }

    /// Draws frame, labels and words.
    pub fn draw(&self, svg: &mut Svg, grid: Grid) {
        let ([left, right], [top, bottom]) = (self.across, self.down);
        let style = ["stroke=\"#ddd\"", "stroke=\"#444\""][usize::from(grid == Grid::Ticks)];
        let mut free = f64::NEG_INFINITY;
        let mut ticks = self.x.ticks.clone();
        ticks.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (number, label) in &ticks {
            let x = left + (right - left) * self.x.share(*number);
            let mark = match grid {
                Grid::Lines => format!("M{x:.1} {top:.1}V{bottom:.1}"),
                Grid::Ticks => format!("M{x:.1} {bottom:.1}v5"),
            };
            svg.path(style, &mark);
            let half = 0.5 * LETTER * label.chars().count() as f64;
            if x - half >= free {
                svg.text([x, bottom + 17.0], Anchor::Middle, label);
                free = x + half + LETTER;
            }
        }
        for (number, label) in &self.y.ticks {
            let y = bottom - (bottom - top) * self.y.share(*number);
            let mark = match grid {
                Grid::Lines => format!("M{left:.1} {y:.1}H{right:.1}"),
                Grid::Ticks => format!("M{left:.1} {y:.1}h-5"),
            };
            svg.path(style, &mark);
            svg.text([left - 8.0, y + 4.5], Anchor::End, label);
        }
        let mut frame = format!("M{left:.1} {top:.1}V{bottom:.1}H{right:.1}");
        if grid == Grid::Ticks {
            frame += &format!("V{top:.1}z");
        }
        svg.path(FRAME, &frame);
        let middle = [0.5 * (left + right), 0.5 * (top + bottom)];
        svg.text([middle[0], bottom + 36.0], Anchor::Middle, &self.x.words);
        let beside = left - if grid == Grid::Ticks { 45.0 } else { 64.0 };
        svg.upright_text([beside, middle[1]], &self.y.words);
    }
}

/// The smallest and the largest of the finite numbers.
pub fn range(numbers: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let finite = numbers.filter(|number| number.is_finite());
    finite.fold(None, |range, x| {
        let [low, high] = range.unwrap_or([x; 2]);
        Some([low.min(x), high.max(x)])
    })
}

/// Labels of a logarithmic axis with these ends (logarithms): decades, or 1, 2 and 5 of each decade on a short axis, or other round
/// numbers if fewer than two of these fit.
fn logarithmic_ticks([low, high]: [f64; 2]) -> Vec<(f64, String)> {
    let every = (((high - low) / 8.0).ceil() as usize).max(1);
    let parts: &[i32] = if high - low > 2.5 { &[1] } else { &[1, 2, 5] };
    let decades = (low.floor() as i32..=high.ceil() as i32).step_by(every);
    let all = decades.flat_map(|k| parts.iter().map(move |part| (k, *part)));
    // Parsed from text, the number is the nearest to the decimal one.
    let all = all.filter_map(|(k, part)| format!("{part}e{k}").parse::<f64>().ok());
    let ticks: Vec<f64> = all.filter(|x| (low..=high).contains(&x.log10())).collect();
    if ticks.len() < 2 {
        return labelled([low, high].map(|end| 10f64.powf(end)), 4);
    }
    ticks.into_iter().map(|x| (x, number(x))).collect()
}

/// A number with three digits, as short as possible.
pub fn number(x: f64) -> String {
    let rounded: f64 = format!("{x:.2e}").parse().unwrap_or(x);
    if (1e-3..1e5).contains(&rounded.abs()) {
        return format!("{rounded}");
    }
    format!("{rounded:e}")
}

/// Round numbers within a range: about `count` multiples of 1, 2 or 5 times a power of ten.
pub fn ticks([low, high]: [f64; 2], count: usize) -> Vec<f64> {
    let raw = (high - low) / count.max(1) as f64;
    if !(raw > 0.0 && raw.is_finite()) {
        return vec![low];
    }
    let decade = 10f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|part| part * decade);
    let step = step.into_iter().find(|step| *step >= raw * (1.0 - 1e-9));
    let step = step.unwrap_or(10.0 * decade);
    let first = (low / step - 1e-9).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    (first..=last).map(|k| k as f64 * step).collect()
}

/// A number at an axis whose labels are `step` apart, with enough decimals to distinguish them.
pub fn label(value: f64, step: f64) -> String {
    let size = value.abs().max(step);
    if value == 0.0 {
        return "0".into();
    }
    if !(1e-3..1e6).contains(&size) {
        let text = format!("{value:.2e}");
        return text.replace(".00e", "e").replace("0e", "e");
    }
    // Labels that are closer than rounding have all digits.
    let decimals = -(step.max(1e-12 * size) * (1.0 + 1e-9)).log10().floor();
    let decimals = decimals.clamp(0.0, 15.0) as usize;
    format!("{value:.decimals$}")
}

/// Round numbers within a range with their labels.
pub fn labelled(range: [f64; 2], count: usize) -> Vec<(f64, String)> {
    let all = ticks(range, count);
    let step = all.windows(2).map(|pair| pair[1] - pair[0]).next();
    let step = step.unwrap_or(range[1] - range[0]);
    all.into_iter().map(|x| (x, label(x, step))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(ticks: Vec<(f64, String)>) -> Vec<String> {
        ticks.into_iter().map(|(_, text)| text).collect()
    }

    #[test]
    fn labels_are_round_and_distinct() {
        let texts = |range, count| texts(labelled(range, count));
        assert_eq!(
            texts([-32.5, 32.5], 8),
            ["-30", "-20", "-10", "0", "10", "20", "30"]
        );
        assert_eq!(texts([0.28, 0.33], 3), ["0.28", "0.30", "0.32"]);
        assert_eq!(texts([0.0, 1e-6], 2), ["0", "5e-7", "1e-6"]);
        assert_eq!(ticks([1.0, 1.0], 5), [1.0]);
        assert_eq!(texts([0.25, 0.25], 5).len(), 1);
        assert_eq!(texts([1.0, 1.0 + 1e-15], 5)[0], "1.000000000000");
    }

    #[test]
    fn logarithmic_axes_have_decades_or_parts_of_them() {
        let axis = |numbers: &[f64]| PlotAxis::logarithmic("e", numbers.iter().copied());
        let long = axis(&[1e-9, 0.0, 1e-3, f64::NAN]);
        let decades = ["1e-9", "1e-8", "1e-7", "1e-6", "1e-5", "1e-4", "0.001"];
        assert_eq!(texts(long.ticks.clone()), decades);
        assert!(long.holds(1e-9) && !long.holds(0.0) && !long.holds(1.0));
        assert!((long.share(1e-6) - 0.5).abs() < 1e-12);
        assert_eq!(texts(axis(&[1.0, 9.0]).ticks), ["1", "2", "5", "10"]);
        assert_eq!(texts(axis(&[3.0, 3.3]).ticks), ["2.5", "3.0", "3.5"]);
        assert!(!axis(&[]).ticks.is_empty());
    }
}
