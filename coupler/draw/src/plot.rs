//! Curves over a pair of axes.

use crate::axis::{AxisPair, Grid, PlotAxis};
use crate::svg::{Anchor, Svg};

/// One line of a plot.
#[derive(Clone, Debug)]
pub struct PlotCurve {
    /// Words in the legend.
    pub label: String,
    /// Points; NaN makes a gap.
    pub points: Vec<(f64, f64)>,
    /// Index of the style: colour and dashes.
    pub style: usize,
}

/// Colour, width and dashes of lines; neighbouring colours differ in lightness, so that they differ in grey.
const STYLES: [(&str, f64, &str); 10] = [
    ("#12355b", 1.8, ""),
    ("#e27d1e", 1.8, ""),
    ("#3c8c6e", 1.8, "10 4"),
    ("#aabed2", 1.5, ""),
    ("#733278", 1.8, "4 3"),
    ("#787878", 1.8, "14 5"),
    ("#12355b", 1.8, "2 3"),
    ("#e27d1e", 1.8, "7 5"),
    ("#3c8c6e", 1.0, ""),
    ("#aabed2", 1.8, "6 3"),
];

/// Attributes of a line. Styles from ten on repeat the colours, thinner, with alternating long and short dashes.
fn style(number: usize) -> String {
    let (colour, width, dashes) = STYLES[number % STYLES.len()];
    let (width, dashes) = match (number / STYLES.len(), dashes) {
        (0, _) => (width, dashes.into()),
        (_, "") => (1.2, "14 3 6 3".into()),
        (_, dashes) => (1.2, format!("{dashes} 6 3")),
    };
    format!("stroke=\"{colour}\" stroke-width=\"{width}\" stroke-dasharray=\"{dashes}\"")
        .replace(" stroke-dasharray=\"\"", "")
}

/// First style of lines that are compared with others of the same kind.
pub const BESIDE: usize = STYLES.len();

/// Style of a thin background curve.
pub const BACKGROUND: usize = 3;

/// Largest number of dots: browsers draw larger files slowly.
const DOTS_MAX: usize = 4000;
/// Number of buckets of a line's samples; the first, the lowest, the highest and the last of each are drawn.
const BUCKETS: usize = 500;
/// Height of a line of the legend (pixels).
const LEGEND_LINE: f64 = 17.0;
/// Size of a plot without its legend (pixels).
const SIZE: [f64; 2] = [530.0, 290.0];
/// Space for labels and words left of the area and below it, and at its other edges (pixels).
const LEFT: f64 = 78.0;
const BELOW: f64 = 46.0;
const EDGE: f64 = 12.0;

/// One dot per point, over axes with these words along x and y; dots are pale, so that their density is visible.
pub fn cloud(words: [&str; 2], points: &[(f64, f64)]) -> String {
    let stride = points.len().div_ceil(DOTS_MAX).max(1);
    let (axes, mut svg) = frame(words, false, points.iter(), 0);
    let dots = points.iter().step_by(stride).map(|point| {
        let [x, y] = axes.at(*point);
        format!("M{x:.1} {y:.1}h0")
    });
    let style = "fill=\"none\" stroke=\"#12355b\" stroke-opacity=\".3\" stroke-width=\"4\" stroke-linecap=\"round\"";
    svg.path(style, &dots.collect::<String>());
    page(&axes, &svg)
}

/// Lines over axes with these words along x and y. The legend above lists the lines with a label. A logarithmic axis leaves out values
/// that are not positive.
pub fn plot(words: [&str; 2], log_y: bool, curves: &[PlotCurve]) -> String {
    let points = curves.iter().flat_map(|curve| &curve.points);
    let labelled = curves.iter().filter(|curve| !curve.label.is_empty());
    let (axes, mut svg) = frame(words, log_y, points, labelled.count());
    let mut line = 0.0;
    for curve in curves {
        let style = style(curve.style);
        let is_gap = |(x, y): &(f64, f64)| x.is_nan() || y.is_nan();
        for piece in curve.points.split(is_gap).filter(|piece| !piece.is_empty()) {
            let drawn = thinned(piece.iter().map(|point| axes.at(*point)));
            svg.line(&format!("stroke-linejoin=\"round\" {style}"), drawn);
        }
        if curve.label.is_empty() {
            continue;
        }
        let (right, y) = (SIZE[0] - EDGE, 10.0 + LEGEND_LINE * line);
        line += 1.0;
        let sample = format!("M{} {y}h30", right - 30.0);
        svg.path(&format!("fill=\"none\" {style}"), &sample);
        svg.text([right - 38.0, y + 4.5], Anchor::End, &curve.label);
    }
    page(&axes, &svg)
}

/// Axes that contain these points, drawn below `lines` lines of a legend.
fn frame<'a>(
    [words_x, words_y]: [&str; 2],
    log_y: bool,
    points: impl Iterator<Item = &'a (f64, f64)> + Clone,
    lines: usize,
) -> (AxisPair, Svg) {
    let heights = points.clone().map(|point| point.1);
    let top = EDGE + LEGEND_LINE * lines as f64;
    let axes = AxisPair {
        x: PlotAxis::around(words_x, points.map(|point| point.0), 7),
        y: match log_y {
            true => PlotAxis::logarithmic(words_y, heights),
            false => PlotAxis::around(words_y, heights, 6),
        },
        across: [LEFT, SIZE[0] - EDGE],
        down: [top, top + SIZE[1] - BELOW - EDGE],
    };
    let mut svg = Svg::default();
    axes.draw(&mut svg, Grid::Lines);
    (axes, svg)
}

fn page(axes: &AxisPair, svg: &Svg) -> String {
    svg.page([SIZE[0], axes.down[1] + BELOW])
}

/// The finite points, thinned: each bucket of neighbours keeps its first, lowest, highest and last.
fn thinned(points: impl Iterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
    let finite: Vec<[f64; 2]> = points.filter(|p| p.iter().all(|x| x.is_finite())).collect();
    if finite.len() <= 4 * BUCKETS {
        return finite;
    }
    let buckets = finite.chunks(finite.len().div_ceil(BUCKETS));
    let kept = buckets.flat_map(|bucket| {
        let by = |a: &usize, b: &usize| bucket[*a][1].total_cmp(&bucket[*b][1]);
        let all = 0..bucket.len();
        let extremes = [all.clone().min_by(by), all.max_by(by)];
        let mut kept = [Some(0), extremes[0], extremes[1], Some(bucket.len() - 1)];
        kept.sort();
        kept.into_iter().flatten().map(|k| bucket[k])
    });
    kept.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_of_eighteen_lines_look_the_same() {
        let all: std::collections::BTreeSet<String> = (0..18).map(style).collect();
        assert_eq!(all.len(), 18, "{all:?}");
        assert_eq!(style(0), "stroke=\"#12355b\" stroke-width=\"1.8\"");
    }

    #[test]
    fn a_line_has_a_gap_at_nan() {
        let curve = PlotCurve {
            label: "a".into(),
            points: [1.0, 2.0, f64::NAN, 3.0, 4.0].map(|y| (y, y)).to_vec(),
            style: 0,
        };
        let svg = plot(["x", "y"], false, &[curve]);
        assert_eq!(svg.matches("<polyline").count(), 2);
    }

    #[test]
    fn a_thinned_line_keeps_its_peaks_and_ends() {
        let mut points: Vec<[f64; 2]> = (0..100_000).map(|k| [f64::from(k), 0.0]).collect();
        points[54_321][1] = 7.0;
        points[54_322][1] = -7.0;
        let thin = thinned(points.iter().copied());
        assert!(thin.len() <= 4 * BUCKETS, "{}", thin.len());
        assert_eq!((thin[0][0], thin[thin.len() - 1][0]), (0.0, 99_999.0));
        assert!(thin.contains(&points[54_321]) && thin.contains(&points[54_322]));
        assert!(thin.is_sorted_by_key(|point| point[0]));
    }
}
