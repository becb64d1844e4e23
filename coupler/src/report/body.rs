//! The continuum alone: hydrostatic pressure in the whole body, and displacement under the nodes that stick or slip.

use std::path::Path;

use plotters::prelude::*;

use super::fields::{Arrays, named, read};
use super::scene::{MARGIN, View, elements, panel, picture, pressure_colour};
use crate::error::Error;

/// Width of a picture without its margins (pixels).
const WIDTH: u32 = 1380;

/// Moments that are drawn, with what they are called below the picture.
const MOMENTS: [(&str, &str); 3] = [
    ("hold", "end of the hold"),
    ("cycling", "end of the cycles"),
    ("end", "end of the run"),
];

/// Hydrostatic pressure in the whole body at the end of the hold, else at the end of the run. `None` where no
/// continuum wrote fields.
pub fn pressure(run: &Path) -> Result<Option<String>, Error> {
    for name in ["hold", "end"] {
        let Some(path) = named(run, name, "vtu").into_iter().next() else {
            continue;
        };
        let arrays = read(&path)?;
        let (Some(view), Some(values)) = (whole(&arrays), arrays.get("hydrostatic_pressure_pa"))
        else {
            return Ok(None);
        };
        let full = values.iter().fold(0.0, |full: f64, p| full.max(*p));
        let legend = format!(
            "x (mm); blue to red: hydrostatic pressure 0 to {:.0} MPa, grey: tension",
            1e-6 * full
        );
        let colour = |cell: usize| pressure_colour(values[cell] / full.max(f64::MIN_POSITIVE));
        return one(&view, &arrays, &legend, colour, &[]).map(Some);
    }
    Ok(None)
}

/// Magnitude of the displacement near the contact, and the contact nodes by their status, at the moments that the run
/// kept: caption and picture of each.
pub fn status(run: &Path) -> Result<Vec<(&'static str, &'static str, String)>, Error> {
    let mut pictures = Vec::new();
    for (name, moment) in MOMENTS {
        let Some(path) = named(run, name, "vtu").into_iter().next() else {
            continue;
        };
        let arrays = read(&path)?;
        let dots = dots(&arrays);
        if dots.is_empty() || pictures.len() == 2 {
            continue;
        }
        let sizes = magnitudes(&arrays);
        let full = sizes.iter().fold(0.0, |full: f64, size| full.max(*size));
        let legend = format!(
            "x (mm), {moment}; blue to red: |u| 0 to {:.1} um; nodes: filled slip, hollow stick",
            1e6 * full
        );
        let colour = |cell: usize| pressure_colour(sizes[cell] / full.max(f64::MIN_POSITIVE));
        let svg = one(&around(&dots), &arrays, &legend, colour, &dots)?;
        pictures.push(match pictures.len() {
            0 => (
                "status.svg",
                "Nodes that stick and slip, over the displacement of the body",
                svg,
            ),
            _ => ("status-later.svg", "The same later", svg),
        });
    }
    Ok(pictures)
}

/// A contact node.
struct Dot {
    /// Where it has gone (mm).
    at: (f64, f64),
    slips: bool,
}

fn one(
    view: &View,
    arrays: &Arrays,
    legend: &str,
    colour: impl Fn(usize) -> RGBColor,
    dots: &[Dot],
) -> Result<String, Error> {
    let mut svg = String::new();
    {
        let size = (WIDTH + MARGIN + 20, view.height + MARGIN + 16);
        let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        area.fill(&WHITE).map_err(picture)?;
        let mut panel = panel(&area, view)?;
        elements(&mut panel, view, arrays, colour)?;
        for dot in dots {
            let inside = if dot.slips { BLACK } else { WHITE };
            let shapes = [
                Circle::new(dot.at, 3, inside.filled()),
                Circle::new(dot.at, 3, BLACK.stroke_width(1)),
            ];
            panel.draw_series(shapes).map_err(picture)?;
        }
        panel
            .configure_mesh()
            .disable_mesh()
            .x_desc(legend)
            .y_desc("y (mm)")
            .draw()
            .map_err(picture)?;
        area.present().map_err(picture)?;
    }
    Ok(svg)
}

/// All of the body.
fn whole(arrays: &Arrays) -> Option<View> {
    let points = arrays.get("points")?;
    let range = |k: usize| {
        let values = points.iter().skip(k).step_by(3);
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
            [low.min(1e3 * v), high.max(1e3 * v)]
        })
    };
    let (x, y) = (range(0), range(1));
    let span = [x[1] - x[0], y[1] - y[0]];
    if !(span[0] > 0.0 && span[1] > 0.0) {
        return None;
    }
    let margin = 0.02 * span[1];
    Some(View {
        x_mm: x,
        y_mm: [y[0] - margin, y[1] + margin],
        width: WIDTH,
        // A tall body is drawn as high as it is wide; its axes tell that the scales differ.
        height: (f64::from(WIDTH) * (span[1] / span[0]).min(1.0)) as u32,
    })
}

/// The contact nodes and a margin of half of their width, three times as wide as deep.
fn around(dots: &[Dot]) -> View {
    let far = dots
        .iter()
        .fold(0.0, |far: f64, dot| far.max(dot.at.0.abs()));
    let half = 1.5 * far.max(1e-3);
    let top = dots
        .iter()
        .fold(f64::NEG_INFINITY, |top, dot| top.max(dot.at.1));
    View {
        x_mm: [-half, half],
        y_mm: [top - 0.5 * half, top + 0.08 * half],
        width: WIDTH,
        height: (f64::from(WIDTH) * 0.29) as u32,
    }
}

/// Nodes in contact: status 1 sticks, 2 slips.
fn dots(arrays: &Arrays) -> Vec<Dot> {
    let (Some(points), Some(u), Some(status)) = (
        arrays.get("points"),
        arrays.get("displacement_m"),
        arrays.get("node_status"),
    ) else {
        return Vec::new();
    };
    let closed = status
        .iter()
        .enumerate()
        .filter(|(_, status)| **status > 0.0);
    closed
        .map(|(node, status)| Dot {
            at: (
                1e3 * (points[3 * node] + u[3 * node]),
                1e3 * (points[3 * node + 1] + u[3 * node + 1]),
            ),
            slips: *status > 1.0,
        })
        .collect()
}

/// Mean |u| of the corners of each element (m).
fn magnitudes(arrays: &Arrays) -> Vec<f64> {
    let (Some(u), Some(cells)) = (arrays.get("displacement_m"), arrays.get("connectivity")) else {
        return Vec::new();
    };
    let size = |node: &f64| u[3 * *node as usize].hypot(u[3 * *node as usize + 1]);
    let elements = cells.chunks_exact(4);
    elements
        .map(|cell| cell.iter().map(size).sum::<f64>() / 4.0)
        .collect()
}
