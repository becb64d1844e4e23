//! The continuum alone: hydrostatic pressure in the whole body, and displacement under the nodes that stick or slip.

use std::path::Path;

use plotters::prelude::*;

use super::fields::{Arrays, Moment, read_first};
use super::view::{Picture, View, elements, full_scale, page, picture, places_mm, pressure_colour};
use crate::error::Error;

/// Hydrostatic pressure in the whole body at the first of these moments that has fields of one.
pub fn pressure(run: &Path, moments: &[Moment]) -> Result<Option<Picture>, Error> {
    for moment in moments {
        let Some(arrays) = read_first(run, moment, "vtu")? else {
            continue;
        };
        let (Some(view), Some(values)) = (whole(&arrays), arrays.get("hydrostatic_pressure_pa"))
        else {
            return Ok(None);
        };
        let full = full_scale(values.iter().copied().fold(0.0, f64::max));
        let legend = format!(
            "x (mm); blue to red: hydrostatic pressure 0 to {} MPa, grey: tension",
            1e-6 * full
        );
        let colour = |cell: usize| pressure_colour(values[cell] / full);
        return Ok(Some(Picture {
            file: "pressure.svg",
            caption: format!(
                "Hydrostatic pressure in the whole body at the {}",
                moment.words
            ),
            svg: body(view, &arrays, &legend, colour, &[])?,
        }));
    }
    Ok(None)
}

/// Magnitude of the displacement near the contact, and the contact nodes by their status, at the first two of these moments
/// that have contact.
pub fn status(run: &Path, moments: &[Moment]) -> Result<Vec<Picture>, Error> {
    let names = [
        (
            "status.svg",
            "Nodes that stick and slip, over the displacement of the body",
        ),
        ("status-later.svg", "The same later"),
    ];
    let mut pictures = Vec::new();
    for moment in moments {
        let Some(arrays) = read_first(run, moment, "vtu")? else {
            continue;
        };
        let dots = dots(&arrays);
        let Some((file, caption)) = names.get(pictures.len()).filter(|_| !dots.is_empty()) else {
            continue;
        };
        let sizes = magnitudes(&arrays);
        let full = sizes.iter().copied().fold(0.0, f64::max);
        let legend = format!(
            "x (mm), {}; blue to red: |u| 0 to {:.1} um; nodes: filled slip, hollow stick",
            moment.words,
            1e6 * full
        );
        let colour = |cell: usize| pressure_colour(sizes[cell] / full.max(f64::MIN_POSITIVE));
        pictures.push(Picture {
            file,
            caption: caption.to_string(),
            svg: body(around(&dots), &arrays, &legend, colour, &dots)?,
        });
    }
    Ok(pictures)
}

/// A contact node.
struct Dot {
    /// Its current place (mm).
    at: (f64, f64),
    slips: bool,
}

/// A part of the body with its elements in these colours, and its contact nodes.
fn body(
    view: View,
    arrays: &Arrays,
    legend: &str,
    colour: impl Fn(usize) -> RGBColor,
    dots: &[Dot],
) -> Result<String, Error> {
    page(&[view], legend, |panel, view| {
        elements(panel, view, arrays, &colour)?;
        for dot in dots {
            let inside = if dot.slips { BLACK } else { WHITE };
            let shapes = [
                Circle::new(dot.at, 3, inside.filled()),
                Circle::new(dot.at, 3, BLACK.stroke_width(1)),
            ];
            panel.draw_series(shapes).map_err(picture)?;
        }
        Ok(())
    })
}

/// All of the body; `None` for one without extent.
fn whole(arrays: &Arrays) -> Option<View> {
    let nodes = places_mm(arrays).into_iter().map(|place| (place, 0.0));
    let view = View::around(nodes)?;
    let margin = 0.02 * view.height_mm();
    let flat = view.width_mm() <= 0.0 || view.height_mm() <= 0.0;
    (!flat).then(|| view.with_margin(0.0, margin, margin))
}

/// The contact nodes and a margin of half of their width, three times as wide as deep.
fn around(dots: &[Dot]) -> View {
    let far = dots
        .iter()
        .fold(0.0, |far: f64, dot| far.max(dot.at.0.abs()));
    let half = 1.5 * far.max(1e-3);
    let top = dots
        .iter()
        .map(|dot| dot.at.1)
        .fold(f64::NEG_INFINITY, f64::max);
    View {
        x_mm: [-half, half],
        y_mm: [top - 0.5 * half, top + 0.08 * half],
    }
}

/// Nodes in contact: status 1 sticks, 2 slips.
fn dots(arrays: &Arrays) -> Vec<Dot> {
    let status = arrays.get("node_status").map_or(&[][..], Vec::as_slice);
    let nodes = places_mm(arrays).into_iter().zip(status);
    nodes
        .filter(|(_, status)| **status > 0.0)
        .map(|(at, status)| Dot {
            at,
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
