//! Curves over a pair of axes.

use std::fmt::Write as _;
use std::ops::Range;

use super::axis::labelled;
use crate::picture::{drawing, escape};

/// One line of a plot.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Its words in the legend.
    pub label: String,
    /// Its points.
    pub points: Vec<(f64, f64)>,
    /// Its place among the [styles](STYLES).
    pub style: usize,
}

/// Attributes of lines: colours whose lightness tells neighbours apart in grey, and dashes.
const STYLES: [&str; 10] = [
    "stroke=\"#12355b\" stroke-width=\"1.8\"",
    "stroke=\"#e27d1e\" stroke-width=\"1.8\"",
    "stroke=\"#3c8c6e\" stroke-width=\"1.8\" stroke-dasharray=\"10 4\"",
    "stroke=\"#aabed2\" stroke-width=\"1.5\"",
    "stroke=\"#733278\" stroke-width=\"1.8\" stroke-dasharray=\"4 3\"",
    "stroke=\"#787878\" stroke-width=\"1.8\" stroke-dasharray=\"14 5\"",
    "stroke=\"#12355b\" stroke-width=\"1.8\" stroke-dasharray=\"2 3\"",
    "stroke=\"#e27d1e\" stroke-width=\"1.8\" stroke-dasharray=\"7 5\"",
    "stroke=\"#3c8c6e\" stroke-width=\"1\"",
    "stroke=\"#aabed2\" stroke-width=\"1.8\" stroke-dasharray=\"6 3\"",
];

/// Style of a thin background curve.
pub const BACKGROUND: usize = 3;

/// More dots than this make a file that browsers are slow to draw.
const DOTS_MAX: usize = 4000;
/// Buckets of samples of a line, of each of which the first, the lowest, the highest and the last are drawn.
const BUCKETS: usize = 500;
/// Height of a line of the legend (pixels).
const LEGEND_LINE: f64 = 17.0;
/// Size of a plot without its legend (pixels).
const SIZE: [f64; 2] = [530.0, 290.0];
/// Space for labels and words left of the area and below it, and beside its other edges (pixels).
const LEFT: f64 = 78.0;
const BELOW: f64 = 46.0;
const EDGE: f64 = 12.0;

/// Words along the axes.
#[derive(Clone, Copy)]
pub struct Labels<'a> {
    /// Words along x.
    pub x: &'a str,
    /// Words along y.
    pub y: &'a str,
    /// True where the y of the points are decimal logarithms.
    pub log_y: bool,
}

/// One dot for each point, pale enough that their density shows.
pub fn cloud(labels: Labels, points: &[(f64, f64)]) -> String {
    let stride = points.len().div_ceil(DOTS_MAX).max(1);
    let axes = Axes::new(points.iter(), 0);
    let mut text = axes.svg(labels);
    text += "<path fill=\"none\" stroke=\"#12355b\" stroke-opacity=\".3\" stroke-width=\"4\" stroke-linecap=\"round\" d=\"";
    for point in points.iter().step_by(stride) {
        let (x, y) = axes.at(point);
        let _ = write!(text, "M{x:.1} {y:.1}h0");
    }
    text += "\"/>";
    axes.drawing(&text)
}

/// Lines, and their legend above the axes.
pub fn plot(labels: Labels, curves: &[Curve]) -> String {
    let axes = Axes::new(curves.iter().flat_map(|curve| &curve.points), curves.len());
    let mut text = axes.svg(labels);
    for (k, curve) in curves.iter().enumerate() {
        let style = STYLES[curve.style % STYLES.len()];
        let points = thinned(&curve.points).into_iter().map(|point| {
            let (x, y) = axes.at(&point);
            format!("{x:.1} {y:.1}")
        });
        let points: Vec<String> = points.collect();
        let _ = write!(
            text,
            "<polyline fill=\"none\" stroke-linejoin=\"round\" {style} points=\"{}\"/>",
            points.join(" ")
        );
        text += &legend(k, &curve.label, style);
    }
    axes.drawing(&text)
}

/// A line of the legend.
fn legend(place: usize, label: &str, style: &str) -> String {
    let (right, y) = (SIZE[0] - EDGE, 10.0 + LEGEND_LINE * place as f64);
    format!(
        "<path fill=\"none\" {style} d=\"M{} {y}h30\"/><text x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>",
        right - 30.0,
        right - 38.0,
        y + 4.5,
        escape(label)
    )
}

/// Points of which each bucket of neighbours keeps its first, lowest, highest and last.
fn thinned(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let finite = points
        .iter()
        .filter(|(x, y)| x.is_finite() && y.is_finite());
    let finite: Vec<(f64, f64)> = finite.copied().collect();
    if finite.len() <= 4 * BUCKETS {
        return finite;
    }
    let buckets = finite.chunks(finite.len().div_ceil(BUCKETS));
    let kept = buckets.flat_map(|bucket| {
        let by = |a: &usize, b: &usize| bucket[*a].1.total_cmp(&bucket[*b].1);
        let all = 0..bucket.len();
        let extremes = [all.clone().min_by(by), all.max_by(by)];
        let mut places = [Some(0), extremes[0], extremes[1], Some(bucket.len() - 1)];
        places.sort();
        places.into_iter().flatten().map(|place| bucket[place])
    });
    kept.collect()
}

/// A pair of axes and the area between them.
struct Axes {
    x: Range<f64>,
    y: Range<f64>,
    /// Upper edge of the area, below the legend (pixels).
    top: f64,
}

impl Axes {
    /// Axes that hold these points, below so many lines of a legend.
    fn new<'a>(points: impl Iterator<Item = &'a (f64, f64)> + Clone, lines: usize) -> Axes {
        Axes {
            x: range(points.clone().map(|point| point.0)),
            y: range(points.map(|point| point.1)),
            top: EDGE + LEGEND_LINE * lines as f64,
        }
    }

    /// Place of a point (pixels).
    fn at(&self, (x, y): &(f64, f64)) -> (f64, f64) {
        let share =
            |value: f64, range: &Range<f64>| (value - range.start) / (range.end - range.start);
        let (width, height) = (SIZE[0] - LEFT - EDGE, SIZE[1] - BELOW - EDGE);
        (
            LEFT + width * share(*x, &self.x),
            self.top + height * (1.0 - share(*y, &self.y)),
        )
    }

    /// Lower edge of the area (pixels).
    fn bottom(&self) -> f64 {
        self.top + SIZE[1] - BELOW - EDGE
    }

    /// Lines of the grid, labels and words.
    fn svg(&self, labels: Labels) -> String {
        let (left, right, top, bottom) = (LEFT, SIZE[0] - EDGE, self.top, self.bottom());
        let up = if labels.log_y {
            decades(&self.y)
        } else {
            labelled([self.y.start, self.y.end], 6)
        };
        let mut text = String::new();
        for (x, label) in labelled([self.x.start, self.x.end], 7) {
            let x = self.at(&(x, self.y.start)).0;
            let _ = write!(
                text,
                "<path stroke=\"#ddd\" d=\"M{x:.1} {top:.1}V{bottom:.1}\"/><text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{label}</text>",
                bottom + 17.0
            );
        }
        for (y, label) in up {
            let y = self.at(&(self.x.start, y)).1;
            let _ = write!(
                text,
                "<path stroke=\"#ddd\" d=\"M{left} {y:.1}H{right}\"/><text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
                left - 7.0,
                y + 4.5
            );
        }
        let (across, down) = (0.5 * (left + right), 0.5 * (top + bottom));
        let _ = write!(
            text,
            "<path fill=\"none\" stroke=\"#444\" d=\"M{left} {top:.1}V{bottom:.1}H{right}\"/><text x=\"{across:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text><text transform=\"translate(14 {down:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            bottom + 36.0,
            escape(labels.x),
            escape(labels.y)
        );
        text
    }

    /// The whole drawing.
    fn drawing(&self, inside: &str) -> String {
        drawing(SIZE[0], self.bottom() + BELOW, inside)
    }
}

/// Labels of an axis of decimal logarithms: decades, or 1, 2 and 5 of each where there are few.
fn decades(range: &Range<f64>) -> Vec<(f64, String)> {
    let (low, high) = (range.start.floor() as i32, range.end.ceil() as i32);
    let every = ((high - low) / 8).max(1) as usize;
    let parts: &[i32] = if high - low > 3 { &[1] } else { &[1, 2, 5] };
    let all = (low..=high).step_by(every);
    let all = all.flat_map(|k| parts.iter().map(move |part| (k, *part)));
    let place = |(k, part): (i32, i32)| {
        (
            f64::from(k) + f64::from(part).log10(),
            format!("{part}e{k}"),
        )
    };
    all.map(place)
        .filter(|(place, _)| range.contains(place))
        .collect()
}

fn range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let finite = values.filter(|value| value.is_finite());
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = finite.fold(none, |(low, high), v| (low.min(v), high.max(v)));
    if low > high {
        return 0.0..1.0;
    }
    let (size, extent) = (low.abs().max(high.abs()), high - low);
    // A constant is a line in the middle, not the noise of its last digit.
    let margin = match (extent > 1e-9 * size, size > 0.0) {
        (true, _) => 0.04 * extent,
        (false, true) => 0.1 * size,
        (false, false) => 1.0,
    };
    low - margin..high + margin
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thinned_line_keeps_its_peaks_and_ends() {
        let mut points: Vec<(f64, f64)> = (0..100_000).map(|k| (f64::from(k), 0.0)).collect();
        points[54_321].1 = 7.0;
        points[54_322].1 = -7.0;
        let thin = thinned(&points);
        assert!(thin.len() <= 4 * BUCKETS, "{}", thin.len());
        assert_eq!((thin[0].0, thin[thin.len() - 1].0), (0.0, 99_999.0));
        assert!(thin.contains(&points[54_321]) && thin.contains(&points[54_322]));
        assert!(thin.is_sorted_by_key(|point| point.0));
    }
}
