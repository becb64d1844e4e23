//! The continuum alone: hydrostatic pressure in the whole body, and displacement under the nodes that stick or slip.

use super::units::with_unit;
use super::view::{Frame, Panel, View, deformed_mm, elements, maps};
use coordinator::error::Error;
use draw::colour::{Scale, full_mpa, full_scale};
use draw::picture::Picture;
use runs::fields::{Arrays, numbers, read_all, read_first};
use runs::files::{Moment, RunFiles};

/// Hydrostatic pressure in the whole of each body at the first of the moments that has fields of one.
pub fn pressures(run: &RunFiles) -> Result<Vec<Picture>, Error> {
    for Moment { name, words } in &run.moments {
        let bodies = read_all(&run.path, name, "vtu")?;
        if bodies.is_empty() {
            continue;
        }
        let several = bodies.len() > 1;
        let pictures = bodies
            .iter()
            .enumerate()
            .filter_map(|(place, (name, arrays))| {
                // The first one keeps the name of its picture, however many there are.
                let file = match place {
                    0 => "pressure.svg".into(),
                    _ => format!("pressure-{name}.svg"),
                };
                let of = if several {
                    format!("of `{name}`, in its own frame, ")
                } else {
                    String::new()
                };
                pressure(file, &format!("{of}at the {words}"), arrays)
            });
        return Ok(pictures.collect());
    }
    Ok(Vec::new())
}

fn pressure(file: String, words: &str, arrays: &Arrays) -> Option<Picture> {
    let (view, values) = (whole(arrays)?, arrays.get("hydrostatic_pressure_pa")?);
    let largest = values.iter().copied().fold(0.0, f64::max);
    let scale = Scale {
        quantity: "hydrostatic pressure (MPa)".into(),
        end: full_mpa(largest),
        below: Some("tension"),
    };
    let frame = Frame {
        view,
        heading: String::new(),
    };
    let svg = maps(&[frame], Some(&scale), |panel, _| {
        elements(panel, arrays, |cell| scale.colour(1e-6 * values[cell]));
    });
    let scales = if view.is_to_scale() {
        ""
    } else {
        " Both axes have scales of their own."
    };
    Some(Picture {
        file,
        caption: format!("Hydrostatic pressure tr(σ)/3 in the whole body {words}.{scales}"),
        alternative: format!(
            "Map of {} elements; largest pressure of an element {}.",
            values.len(),
            with_unit(largest, "Pa")
        ),
        svg,
    })
}

/// Magnitude of the displacement near the contact, and the contact nodes by their status, at the first two of the moments
/// that have contact (Renouf, Saulot and Berthier 2006, figures 4 and 5).
pub fn status(run: &RunFiles) -> Result<Vec<Picture>, Error> {
    let mut names = ["status.svg", "status-later.svg"].into_iter();
    let mut pictures = Vec::new();
    for Moment { name, words } in &run.moments {
        let Some(arrays) = read_first(&run.path, name, "vtu")? else {
            continue;
        };
        let dots = dots(&arrays);
        if dots.is_empty() {
            continue;
        }
        let Some(file) = names.next() else {
            continue;
        };
        pictures.push(nodes(file, words, &arrays, &dots));
    }
    Ok(pictures)
}

/// The contact nodes over the displacement of the body.
fn nodes(file: &str, words: &str, arrays: &Arrays, dots: &[Dot]) -> Picture {
    let sizes = magnitudes(arrays);
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    let scale = Scale {
        quantity: "|u| (µm)".into(),
        end: 1e6 * full_scale(largest),
        below: None,
    };
    let frame = Frame {
        view: around(dots),
        heading: String::new(),
    };
    let svg = maps(&[frame], Some(&scale), |panel, _| {
        elements(panel, arrays, |cell| scale.colour(1e6 * sizes[cell]));
        mark(panel, dots);
    });
    let slipping = dots.iter().filter(|dot| dot.slips).count();
    Picture {
        file: file.into(),
        caption: format!(
            "Contact nodes and displacement of the body at the {words}: filled nodes slip, hollow ones stick."
        ),
        alternative: format!(
            "{slipping} of {} nodes in contact slip; largest mean displacement of an element {}.",
            dots.len(),
            with_unit(largest, "m")
        ),
        svg,
    }
}

fn mark(panel: &mut Panel, dots: &[Dot]) {
    panel.layer();
    for dot in dots {
        let inside = if dot.slips { "#000" } else { "#fff" };
        let style = format!("fill=\"{inside}\" stroke=\"#000\"");
        panel.dot(dot.at, 3.5, &style);
    }
}

/// A contact node.
struct Dot {
    /// Its current place (mm).
    at: (f64, f64),
    slips: bool,
}

/// All of the body; `None` for one without extent.
fn whole(arrays: &Arrays) -> Option<View> {
    let nodes = deformed_mm(arrays).into_iter().map(|place| (place, 0.0));
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
    let nodes = deformed_mm(arrays).into_iter();
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
