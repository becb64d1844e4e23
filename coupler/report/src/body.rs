//! The continuum alone: hydrostatic pressure in the whole body, and displacement below the contact nodes, which stick or slip.

use super::mesh::{deformed_extent, deformed_mm, draw_elements};
use draw::colour::{ColourScale, full_mpa, full_scale};
use draw::extent::Extent;
use draw::map::{Map, Panel, is_to_scale, maps};
use draw::picture::Picture;
use draw::units::with_unit;
use runs::fields::{Arrays, numbers};
use runs::files::{MarkedMoment, RunFiles};
use scenario::error::Error;

/// Hydrostatic pressure in the whole of each body, at the first moment that has fields of a body.
pub fn pressures(run: &RunFiles) -> Result<Vec<Picture>, Error> {
    for MarkedMoment { name, words } in run.moments() {
        let bodies = run.all_fields(&name, ".vtu")?;
        if bodies.is_empty() {
            continue;
        }
        let several = bodies.len() > 1;
        let pictures = bodies.iter().enumerate().filter_map(|(k, (name, arrays))| {
            // The first picture has the same name for any number of bodies.
            let file = match k {
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

fn pressure(file: String, moment: &str, arrays: &Arrays) -> Option<Picture> {
    let body = deformed_extent(arrays).filter(|body| body.width() > 0.0 && body.height() > 0.0)?;
    let margin = 0.02 * body.height();
    let extent = body.with_margin(0.0, margin, margin);
    let values = arrays.get("hydrostatic_pressure_pa")?;
    let largest = values.iter().copied().fold(0.0, f64::max);
    let words = "hydrostatic pressure (MPa)";
    let scale = ColourScale::new(words, full_mpa(largest), Some("tension"));
    let scales = if is_to_scale(&extent) {
        ""
    } else {
        " Each axis has its own scale."
    };
    let (elements, most) = (values.len(), with_unit(largest, "Pa"));
    Some(Picture {
        file,
        caption: format!("Hydrostatic pressure -tr(σ)/3 in the whole body {moment}.{scales}"),
        alternative: format!("Map of {elements} elements; largest pressure of an element {most}."),
        svg: maps(&[Map::of(extent, "")], Some(&scale), |panel, _| {
            draw_elements(panel, arrays, |cell| scale.colour(1e-6 * values[cell]));
        }),
    })
}

/// Magnitude of the displacement near the contact, and the contact nodes by their status, at the first two moments with contact (Renouf,
/// Saulot and Berthier 2006, figures 4 and 5).
pub fn status(run: &RunFiles) -> Result<Vec<Picture>, Error> {
    let mut files = ["status.svg", "status-later.svg"].into_iter();
    let mut pictures = Vec::new();
    for MarkedMoment { name, words } in run.moments() {
        let Some(arrays) = run.fields(&name, ".vtu")? else {
            continue;
        };
        let nodes = contact_nodes(&arrays);
        if !nodes.is_empty()
            && let Some(file) = files.next()
        {
            pictures.push(contact(file, &words, &arrays, &nodes));
        }
    }
    Ok(pictures)
}

/// The contact nodes drawn over the displacement of the body.
fn contact(file: &str, words: &str, arrays: &Arrays, nodes: &[ContactNode]) -> Picture {
    let sizes = magnitudes(arrays);
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    let scale = ColourScale::new("|u| (µm)", 1e6 * full_scale(largest), None);
    let svg = maps(&[Map::of(around(nodes), "")], Some(&scale), |panel, _| {
        draw_elements(panel, arrays, |cell| scale.colour(1e6 * sizes[cell]));
        mark(panel, nodes);
    });
    let slipping = nodes.iter().filter(|node| node.slips).count();
    let (all, most) = (nodes.len(), with_unit(largest, "m"));
    Picture {
        file: file.into(),
        caption: format!(
            "Contact nodes and displacement of the body at the {words}: filled nodes slip, hollow ones stick."
        ),
        alternative: format!(
            "{slipping} of {all} nodes in contact slip; largest mean displacement of an element {most}."
        ),
        svg,
    }
}

fn mark(panel: &mut Panel, nodes: &[ContactNode]) {
    panel.layer();
    for node in nodes {
        let inside = if node.slips { "#000" } else { "#fff" };
        let style = format!("fill=\"{inside}\" stroke=\"#000\"");
        panel.dot(node.at, 3.5, &style);
    }
}

/// A node in contact.
struct ContactNode {
    /// Its current position (mm).
    at: [f64; 2],
    slips: bool,
}

/// The extent around the contact nodes, with a margin of half their width.
fn around(nodes: &[ContactNode]) -> Extent {
    let distances = nodes.iter().map(|node| node.at[0].abs());
    let half = 1.5 * distances.fold(0.0, f64::max).max(1e-3);
    let heights = nodes.iter().map(|node| node.at[1]);
    let top = heights.fold(f64::NEG_INFINITY, f64::max);
    Extent {
        x: [-half, half],
        y: [top - 0.5 * half, top + 0.08 * half],
    }
}

/// Nodes in contact: status 1 sticks, 2 slips.
fn contact_nodes(arrays: &Arrays) -> Vec<ContactNode> {
    let nodes = deformed_mm(arrays).into_iter();
    let nodes = nodes.zip(numbers(arrays, "node_status"));
    let touching = nodes.filter(|(_, status)| **status > 0.0);
    let node = |(at, status): ([f64; 2], &f64)| ContactNode {
        at,
        slips: *status > 1.0,
    };
    touching.map(node).collect()
}

/// Mean |u| of the corners of each element (m).
fn magnitudes(arrays: &Arrays) -> Vec<f64> {
    let u = numbers(arrays, "displacement_m");
    if u.is_empty() {
        return Vec::new();
    }
    let size = |node: &f64| u[3 * *node as usize].hypot(u[3 * *node as usize + 1]);
    let elements = numbers(arrays, "connectivity").chunks_exact(4);
    let elements = elements.map(|cell| cell.iter().map(size).sum::<f64>() / 4.0);
    elements.collect()
}
