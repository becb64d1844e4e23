//! A part of the scene on a page: its axes, the elements in it, and the colours of a pressure.

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use super::fields::{Arrays, numbers};
use crate::error::{Error, Refusal};

/// A picture of the report.
pub struct Picture {
    /// Name of its file.
    pub file: &'static str,
    /// Text below it.
    pub caption: String,
    /// The picture itself.
    pub svg: String,
}

/// Axes that can be drawn into.
pub(super) type Panel<'a, 'b> =
    ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// Largest width and height of a view (pixels).
const WIDTH: f64 = 1380.0;
const HEIGHT_MAX: f64 = 900.0;
/// Least width and height of a view (pixels).
const LEAST: f64 = 100.0;
const MARGIN: u32 = 46;

/// A part of the scene (mm).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct View {
    pub(super) x_mm: [f64; 2],
    pub(super) y_mm: [f64; 2],
}

impl View {
    /// The smallest that holds all of these circles: centre (mm) and radius (mm). `None` without any.
    pub(super) fn around(circles: impl Iterator<Item = ((f64, f64), f64)>) -> Option<View> {
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        let (x_mm, y_mm) = circles.fold((none, none), |(x, y), ((at_x, at_y), radius)| {
            let with =
                |[low, high]: [f64; 2], at: f64| [low.min(at - radius), high.max(at + radius)];
            (with(x, at_x), with(y, at_y))
        });
        (x_mm[0] <= x_mm[1]).then_some(View { x_mm, y_mm })
    }

    /// Width (mm).
    pub(super) fn width_mm(&self) -> f64 {
        self.x_mm[1] - self.x_mm[0]
    }

    /// Height (mm).
    pub(super) fn height_mm(&self) -> f64 {
        self.y_mm[1] - self.y_mm[0]
    }

    /// The view with margins (mm) at its sides, below and above.
    pub(super) fn with_margin(self, side: f64, below: f64, above: f64) -> View {
        View {
            x_mm: [self.x_mm[0] - side, self.x_mm[1] + side],
            y_mm: [self.y_mm[0] - below, self.y_mm[1] + above],
        }
    }

    /// The part of it that another one holds too.
    pub(super) fn within(self, other: &View) -> View {
        let common = |a: [f64; 2], b: [f64; 2]| [a[0].max(b[0]), a[1].min(b[1])];
        View {
            x_mm: common(self.x_mm, other.x_mm),
            y_mm: common(self.y_mm, other.y_mm),
        }
    }

    /// Pixels a millimetre, the same in both directions.
    pub(super) fn scale(&self) -> f64 {
        (WIDTH / self.width_mm()).min(HEIGHT_MAX / self.height_mm())
    }

    /// Size with its axes (pixels). A body that is very tall or very flat keeps a width and a height that can be seen: its
    /// axes tell that the scales differ.
    fn size(&self) -> (u32, u32) {
        let pixels = |length: f64| (self.scale() * length).round().max(LEAST) as u32;
        (
            pixels(self.width_mm()) + MARGIN + 20,
            pixels(self.height_mm()) + MARGIN + 16,
        )
    }

    /// True for a place (mm) inside of it.
    pub(super) fn holds(&self, (x, y): (f64, f64)) -> bool {
        (self.x_mm[0]..=self.x_mm[1]).contains(&x) && (self.y_mm[0]..=self.y_mm[1]).contains(&y)
    }

    fn clip(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (
            x.clamp(self.x_mm[0], self.x_mm[1]),
            y.clamp(self.y_mm[0], self.y_mm[1]),
        )
    }
}

/// The least number with one significant digit that is not below `value`; 1 where nothing is positive.
pub(super) fn full_scale(value: f64) -> f64 {
    if !(value > 0.0 && value.is_finite()) {
        return 1.0;
    }
    let exponent = value.log10().floor();
    let digit = (value / 10f64.powf(exponent) * (1.0 - 1e-12)).ceil();
    // Through its text, so that it is the number nearest to the decimal one.
    format!("{digit}e{exponent}").parse().unwrap_or(value)
}

/// Colour of a share of the scale: pale blue (0) over yellow to red (1); tension is grey.
pub(super) fn pressure_colour(share: f64) -> RGBColor {
    const STOPS: [(f64, [f64; 3]); 4] = [
        (0.0, [222.0, 235.0, 247.0]),
        (0.35, [130.0, 190.0, 220.0]),
        (0.65, [253.0, 219.0, 110.0]),
        (1.0, [200.0, 30.0, 30.0]),
    ];
    if share < 0.0 {
        return RGBColor(225, 225, 225);
    }
    let share = share.min(1.0);
    let upper = STOPS.iter().position(|(stop, _)| share <= *stop);
    let upper = upper.unwrap_or(3).max(1);
    let ((a, from), (b, to)) = (STOPS[upper - 1], STOPS[upper]);
    let t = (share - a) / (b - a);
    let channel = |k: usize| (from[k] + t * (to[k] - from[k])).round() as u8;
    RGBColor(channel(0), channel(1), channel(2))
}

/// Views one above the other, each filled by `content` and with `legend` below it.
pub(super) fn page(
    views: &[View],
    legend: &str,
    content: impl Fn(&mut Panel, &View) -> Result<(), Error>,
) -> Result<String, Error> {
    let panels: Vec<(View, &str)> = views.iter().map(|view| (*view, legend)).collect();
    panels_below(&panels, |panel, place| content(panel, &views[place]))
}

/// Views one above the other with their legends, each filled by `content`, which is told its place.
pub(super) fn panels_below(
    panels: &[(View, &str)],
    content: impl Fn(&mut Panel, usize) -> Result<(), Error>,
) -> Result<String, Error> {
    let sizes: Vec<(u32, u32)> = panels.iter().map(|(view, _)| view.size()).collect();
    let width = sizes.iter().map(|size| size.0).max().unwrap_or(0);
    let height = sizes.iter().map(|size| size.1).sum();
    svg((width, height), |page| {
        let mut rest = page.clone();
        for (place, ((view, legend), size)) in panels.iter().zip(sizes).enumerate() {
            let (row, below) = rest.split_vertically(size.1);
            let (area, _) = row.split_horizontally(size.0);
            rest = below;
            let mut panel = ChartBuilder::on(&area)
                .margin_right(20)
                .margin_top(8)
                .x_label_area_size(MARGIN)
                .y_label_area_size(MARGIN)
                .build_cartesian_2d(view.x_mm[0]..view.x_mm[1], view.y_mm[0]..view.y_mm[1])
                .map_err(picture)?;
            content(&mut panel, place)?;
            let mut axes = panel.configure_mesh();
            let axes = axes.disable_mesh().x_desc(*legend).y_desc("y (mm)");
            axes.draw().map_err(picture)?;
        }
        Ok(())
    })
}

/// A white page of so many pixels that `draw` has filled, as SVG.
pub(crate) fn svg(
    size: (u32, u32),
    draw: impl FnOnce(&DrawingArea<SVGBackend, Shift>) -> Result<(), Error>,
) -> Result<String, Error> {
    let mut svg = String::new();
    let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
    area.fill(&WHITE).map_err(picture)?;
    draw(&area)?;
    area.present().map_err(picture)?;
    drop(area);
    Ok(svg)
}

/// The displaced elements inside a view, each in the colour of its number.
pub(super) fn elements(
    panel: &mut Panel,
    view: &View,
    arrays: &Arrays,
    colour: impl Fn(usize) -> RGBColor,
) -> Result<(), Error> {
    let (cells, places) = (numbers(arrays, "connectivity"), places_mm(arrays));
    for (number, cell) in cells.chunks_exact(4).enumerate() {
        let corners: Vec<(f64, f64)> = cell.iter().map(|node| places[*node as usize]).collect();
        if corners.iter().any(|corner| view.holds(*corner)) {
            let clipped: Vec<_> = corners.iter().map(|corner| view.clip(*corner)).collect();
            let shape = Polygon::new(clipped, colour(number).filled());
            panel.draw_series([shape]).map_err(picture)?;
        }
    }
    Ok(())
}

/// Current places of the points of a file (mm).
pub(super) fn places_mm(arrays: &Arrays) -> Vec<(f64, f64)> {
    let (points, moved) = (numbers(arrays, "points"), arrays.get("displacement_m"));
    let at = |k: usize| 1e3 * (points[k] + moved.map_or(0.0, |u| u[k]));
    let nodes = 0..points.len() / 3;
    nodes.map(|node| (at(3 * node), at(3 * node + 1))).collect()
}

/// A disk of so many pixels with its edge.
pub(super) fn disk(
    panel: &mut Panel,
    centre: (f64, f64),
    size: i32,
    inside: RGBColor,
    edge: ShapeStyle,
) -> Result<(), Error> {
    let shapes = [inside.filled(), edge].map(|style| Circle::new(centre, size, style));
    panel.draw_series(shapes).map(|_| ()).map_err(picture)
}

/// Errors of the drawing library, which writes to memory here.
pub(crate) fn picture(error: impl std::fmt::Display) -> Error {
    Refusal::Picture(error.to_string()).into()
}
