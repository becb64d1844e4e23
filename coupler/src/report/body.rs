//! The continuum alone: hydrostatic pressure in the whole body, and displacement under the nodes that stick or slip.

use std::path::Path;

use plotters::prelude::*;

use super::fields::{Arrays, Moment, numbers, read_first};
use super::view::{Picture, View, disk, elements, full_scale, page, places_mm, pressure_colour};
use crate::error::Error;

/// Hydrostatic pressure in the whole body at the first of these moments that has fields of one.
pub fn pressure(run: &Path, moments: &[Moment]) -> Result<Option<Picture>, Error> {
    for Moment { name, words } in moments {
        let Some(arrays) = read_first(run, name, "vtu")? else {
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
            caption: format!("Hydrostatic pressure in the whole body at the {words}"),
            svg: body(view, &arrays, &legend, colour, &[])?,
        }));
    }
    Ok(None)
}

/// Magnitude of the displacement near the contact, and the contact nodes by their status, at the first two of these moments
/// that have contact.
pub fn status(run: &Path, moments: &[Moment]) -> Result<Vec<Picture>, Error> {
    let words = "Nodes that stick and slip, over the displacement of the body";
    let mut names = [
        ("status.svg", words),
        ("status-later.svg", "The same later"),
    ]
    .into_iter();
    let mut pictures = Vec::new();
    for Moment { name, words } in moments {
        let Some(arrays) = read_first(run, name, "vtu")? else {
            continue;
        };
        let dots = dots(&arrays);
        if dots.is_empty() {
            continue;
        }
        let Some((file, caption)) = names.next() else {
            continue;
        };
        let sizes = magnitudes(&arrays);
        let full = sizes.iter().copied().fold(0.0, f64::max);
        let legend = format!(
            "x (mm), {words}; blue to red: |u| 0 to {:.1} um; nodes: filled slip, hollow stick",
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
            disk(panel, dot.at, 3, inside, BLACK.stroke_width(1))?;
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
    let distances = dots.iter().map(|dot| dot.at.0.abs());
    let half = 1.5 * distances.fold(0.0, f64::max).max(1e-3);
    let heights = dots.iter().map(|dot| dot.at.1);
    let top = heights.fold(f64::NEG_INFINITY, f64::max);
    View {
        x_mm: [-half, half],
        y_mm: [top - 0.5 * half, top + 0.08 * half],
    }
}

/// Nodes in contact: status 1 sticks, 2 slips.
fn dots(arrays: &Arrays) -> Vec<Dot> {
    let nodes = places_mm(arrays).into_iter();
    let nodes = nodes.zip(numbers(arrays, "node_status"));
    let dot = |(at, status): ((f64, f64), &f64)| {
        let slips = *status > 1.0;
        (*status > 0.0).then_some(Dot { at, slips })
    };
    nodes.filter_map(dot).collect()
}

/// Mean |u| of the corners of each element (m).
fn magnitudes(arrays: &Arrays) -> Vec<f64> {
    let u = numbers(arrays, "displacement_m");
    if u.is_empty() {
        return Vec::new();
    }
    let size = |node: &f64| u[3 * *node as usize].hypot(u[3 * *node as usize + 1]);
    let elements = numbers(arrays, "connectivity").chunks_exact(4);
    elements
        .map(|cell| cell.iter().map(size).sum::<f64>() / 4.0)
        .collect()
}
