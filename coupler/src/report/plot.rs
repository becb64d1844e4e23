//! Curves over a pair of axes.

use std::ops::Range;

use plotters::prelude::*;

use super::view::{Panel, picture, svg};
use crate::error::Error;

/// One line of a plot.
pub(crate) struct Curve<'a> {
    pub(crate) label: &'a str,
    pub(crate) points: Vec<(f64, f64)>,
    pub(crate) colour: RGBColor,
}

/// Colour of the first curve, and of dots.
pub(super) const BLUE_LINE: RGBColor = RGBColor(31, 90, 160);
/// More dots than this make a file that browsers are slow to draw.
const DOTS_MAX: usize = 8000;
/// Height of a line of the legend over that of the curves.
const LEGEND_LINE: f64 = 0.1;
/// Size of a plot (pixels).
const SIZE: (u32, u32) = (900, 380);

/// Words along the axes.
#[derive(Clone, Copy)]
pub(crate) struct Labels<'a> {
    pub(crate) x: &'a str,
    pub(crate) y: &'a str,
}

/// One dot for each point, pale enough that their density shows.
pub(super) fn cloud(labels: Labels, points: &[(f64, f64)]) -> Result<String, Error> {
    let stride = points.len().div_ceil(DOTS_MAX).max(1);
    svg(SIZE, |area| {
        let mut chart = axes(area, labels, ranges(points.iter()))?;
        let dot = |point: &(f64, f64)| Circle::new(*point, 1, BLUE_LINE.mix(0.35).filled());
        let dots = points.iter().step_by(stride).map(dot);
        chart.draw_series(dots).map(|_| ()).map_err(picture)
    })
}

/// Lines and their legend.
pub(crate) fn plot(labels: Labels, curves: &[Curve]) -> Result<String, Error> {
    let [x, mut y] = ranges(curves.iter().flat_map(|curve| &curve.points));
    // The legend stands above all curves.
    y.end += LEGEND_LINE * curves.len() as f64 * (y.end - y.start);
    svg(SIZE, |area| {
        let mut chart = axes(area, labels, [x, y])?;
        for curve in curves {
            let colour = curve.colour;
            chart
                .draw_series(LineSeries::new(curve.points.iter().copied(), &colour))
                .map_err(picture)?
                .label(curve.label)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour));
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .background_style(WHITE)
            .border_style(BLACK.mix(0.3))
            .draw()
            .map_err(picture)
    })
}

/// Extents of the axes.
fn ranges<'a>(points: impl Iterator<Item = &'a (f64, f64)> + Clone) -> [Range<f64>; 2] {
    let x = points.clone().map(|point| point.0);
    [range(x), range(points.map(|point| point.1))]
}

fn axes<'a, 'b>(
    area: &'a DrawingArea<SVGBackend<'b>, plotters::coord::Shift>,
    labels: Labels,
    [x, y]: [Range<f64>; 2],
) -> Result<Panel<'a, 'b>, Error> {
    let mut chart = ChartBuilder::on(area)
        .margin(14)
        .x_label_area_size(40)
        .y_label_area_size(70)
        .build_cartesian_2d(x, y)
        .map_err(picture)?;
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .bold_line_style(BLACK.mix(0.1))
        .x_desc(labels.x)
        .y_desc(labels.y)
        .draw()
        .map_err(picture)?;
    Ok(chart)
}

fn range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let finite = values.filter(|value| value.is_finite());
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = finite.fold(none, |(low, high), v| (low.min(v), high.max(v)));
    if low > high {
        return 0.0..1.0;
    }
    let margin = 0.04 * (high - low).max(1e-12 * high.abs()).max(f64::MIN_POSITIVE);
    low - margin..high + margin
}
