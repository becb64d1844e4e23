//! A page that a library of curves draws on.

use plotters::coord::Shift;
use plotters::prelude::*;

/// A white page of so many pixels that `draw` has filled with curves, as SVG.
pub fn svg(
    size: (u32, u32),
    draw: impl FnOnce(&DrawingArea<SVGBackend, Shift>) -> Result<(), String>,
) -> Result<String, String> {
    let mut svg = String::new();
    let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
    area.fill(&WHITE).map_err(picture)?;
    draw(&area)?;
    area.present().map_err(picture)?;
    drop(area);
    Ok(svg)
}

/// Errors of the drawing library, which writes to memory here.
pub fn picture(error: impl std::fmt::Display) -> String {
    error.to_string()
}
