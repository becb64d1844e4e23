//! Grains and continuum around the contact, coloured by pressure.

use std::path::Path;

use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use super::fields::{Arrays, named, read};
use crate::error::{Error, Refusal};

pub(super) type Panel<'a, 'b> =
    ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// A part of the scene: x and y from and to (mm), and the size it is drawn at (pixels).
pub(super) struct View {
    pub(super) x_mm: [f64; 2],
    pub(super) y_mm: [f64; 2],
    pub(super) width: u32,
    pub(super) height: u32,
}

/// Pressure at which the colours end (MPa).
const FULL_COLOUR_MPA: f64 = 1000.0;
pub(super) const MARGIN: u32 = 46;

/// The scene at the end of the hold, else at the end of the run: the whole contact above, its middle below. `None` where
/// no participant wrote fields.
pub fn at_the_hold(run: &Path) -> Result<Option<String>, Error> {
    for name in ["hold", "end"] {
        let continuum = named(run, name, "vtu")
            .first()
            .map(|path| read(path))
            .transpose()?;
        let grains = named(run, name, "vtp")
            .first()
            .map(|path| read(path))
            .transpose()?;
        if continuum.is_some() || grains.is_some() {
            return draw(continuum.as_ref(), grains.as_ref()).map(Some);
        }
    }
    Ok(None)
}

fn draw(continuum: Option<&Arrays>, grains: Option<&Arrays>) -> Result<String, Error> {
    let views = [
        View {
            x_mm: [-9.2, 9.2],
            y_mm: [-3.0, 0.4],
            width: 1380,
            height: 255,
        },
        View {
            x_mm: [-1.6, 1.6],
            y_mm: [-0.35, 0.37],
            width: 1380,
            height: 311,
        },
    ];
    let height: u32 = views.iter().map(|view| view.height + MARGIN).sum::<u32>() + 20;
    let mut svg = String::new();
    {
        let area =
            SVGBackend::with_string(&mut svg, (1380 + MARGIN + 20, height)).into_drawing_area();
        area.fill(&WHITE).map_err(picture)?;
        let (above, below) = area.split_vertically(views[0].height + MARGIN + 10);
        for (area, view) in [above, below].iter().zip(&views) {
            let mut panel = panel(area, view)?;
            if let Some(arrays) = continuum
                && let Some(pressure) = arrays.get("hydrostatic_pressure_pa")
            {
                elements(&mut panel, view, arrays, |cell| {
                    pressure_colour(1e-6 * pressure[cell] / FULL_COLOUR_MPA)
                })?;
            }
            if let Some(arrays) = grains {
                disks(&mut panel, view, arrays)?;
            }
            panel
                .configure_mesh()
                .disable_mesh()
                .x_desc("x (mm); blue to red: pressure 0 to 1 000 MPa; outlined dark: glued grains")
                .y_desc("y (mm)")
                .draw()
                .map_err(picture)?;
        }
        area.present().map_err(picture)?;
    }
    Ok(svg)
}

/// The axes of a view, ready to be drawn into.
pub(super) fn panel<'a, 'b>(
    area: &'a DrawingArea<SVGBackend<'b>, plotters::coord::Shift>,
    view: &View,
) -> Result<Panel<'a, 'b>, Error> {
    ChartBuilder::on(area)
        .margin_right(20)
        .margin_top(8)
        .x_label_area_size(MARGIN)
        .y_label_area_size(MARGIN)
        .build_cartesian_2d(view.x_mm[0]..view.x_mm[1], view.y_mm[0]..view.y_mm[1])
        .map_err(picture)
}

/// The displaced elements inside a view, each in the colour of its number.
pub(super) fn elements(
    panel: &mut Panel,
    view: &View,
    arrays: &Arrays,
    colour: impl Fn(usize) -> RGBColor,
) -> Result<(), Error> {
    let (Some(points), Some(cells)) = (arrays.get("points"), arrays.get("connectivity")) else {
        return Ok(());
    };
    let moved = arrays.get("displacement_m");
    let place = |node: usize| -> (f64, f64) {
        let at = |k: usize| 1e3 * (points[3 * node + k] + moved.map_or(0.0, |u| u[3 * node + k]));
        (at(0), at(1))
    };
    for (number, cell) in cells.chunks_exact(4).enumerate() {
        let corners: Vec<(f64, f64)> = cell.iter().map(|node| place(*node as usize)).collect();
        if corners.iter().any(|corner| view.holds(*corner)) {
            let clipped: Vec<(f64, f64)> =
                corners.iter().map(|corner| view.clip(*corner)).collect();
            let shape = Polygon::new(clipped, colour(number).filled());
            panel.draw_series(std::iter::once(shape)).map_err(picture)?;
        }
    }
    Ok(())
}

fn disks(panel: &mut Panel, view: &View, arrays: &Arrays) -> Result<(), Error> {
    let (Some(points), Some(radii)) = (arrays.get("points"), arrays.get("radius_m")) else {
        return Ok(());
    };
    let scale = f64::from(view.width) / (view.x_mm[1] - view.x_mm[0]);
    for (i, radius) in radii.iter().enumerate() {
        let centre = (1e3 * points[3 * i], 1e3 * points[3 * i + 1]);
        if !view.holds(centre) {
            continue;
        }
        let value = |name: &str| {
            arrays
                .get(name)
                .and_then(|a| a.get(i))
                .copied()
                .unwrap_or(0.0)
        };
        let size = (1e3 * radius * scale).round() as i32;
        let edge = if value("glued") > 0.0 {
            BLACK.stroke_width(2)
        } else {
            BLACK.mix(0.6).stroke_width(1)
        };
        let shapes = [
            Circle::new(
                centre,
                size,
                pressure_colour(1e-6 * value("pressure_pa") / FULL_COLOUR_MPA).filled(),
            ),
            Circle::new(centre, size, edge),
        ];
        panel.draw_series(shapes).map_err(picture)?;
    }
    Ok(())
}

impl View {
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

/// From pale blue (nothing) over yellow to red (the end of the scale, 1); tension is grey.
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
    let upper = STOPS
        .iter()
        .position(|(stop, _)| share <= *stop)
        .unwrap_or(3)
        .max(1);
    let ((a, from), (b, to)) = (STOPS[upper - 1], STOPS[upper]);
    let t = (share - a) / (b - a);
    let channel = |k: usize| (from[k] + t * (to[k] - from[k])).round() as u8;
    RGBColor(channel(0), channel(1), channel(2))
}

/// Errors of the drawing library, which writes to memory here.
pub fn picture(error: impl std::fmt::Display) -> Error {
    Refusal::Picture(error.to_string()).into()
}
