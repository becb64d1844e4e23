//! Meshes and grains from the files of fields, in millimetres for maps.

use draw::extent::Extent;
use draw::map::{Panel, middle};
use runs::fields::{Arrays, numbers, points};

/// Draws the displaced elements that touch a map; `colour` takes the index of an element.
pub(super) fn draw_elements(panel: &mut Panel, arrays: &Arrays, colour: impl Fn(usize) -> String) {
    let (cells, nodes) = (numbers(arrays, "connectivity"), deformed_mm(arrays));
    for (number, cell) in cells.chunks_exact(4).enumerate() {
        let corners: Vec<[f64; 2]> = cell.iter().map(|node| nodes[*node as usize]).collect();
        if corners.iter().any(|corner| panel.shows(*corner)) {
            let colour = colour(number);
            // A thin edge of the same colour hides the seams between neighbours.
            let style = format!("fill=\"{colour}\" stroke=\"{colour}\" stroke-width=\".4\"");
            panel.line(&corners, true, &style);
        }
    }
}

/// Current positions of the nodes of a mesh (mm); its points are the positions before the deformation.
pub(super) fn deformed_mm(arrays: &Arrays) -> Vec<[f64; 2]> {
    let moved = numbers(arrays, "displacement_m");
    let at = |k: usize| 1e3 * moved.get(k).copied().unwrap_or(0.0);
    let points = points_mm(arrays).into_iter().enumerate();
    let points = points.map(|(node, [x, y])| [x + at(3 * node), y + at(3 * node + 1)]);
    points.collect()
}

/// The extent of a displaced mesh (mm); `None` without nodes.
pub(super) fn deformed_extent(arrays: &Arrays) -> Option<Extent> {
    let nodes = deformed_mm(arrays).into_iter();
    Extent::around(nodes.map(|node| (node, 0.0)))
}

/// The part of layers of grains, given by name and extent, that a second map shows larger, with the heading of that map: the middle of a
/// layer that is much longer than high, or one of several layers.
pub(super) fn closer(layers: &[(&str, Extent)]) -> Option<(Extent, String)> {
    match layers {
        [(_, layer)] => Some((middle(layer)?, "The middle of the layer".into())),
        _ => {
            let (name, layer) = layers.get(layers.len() / 2)?;
            Some((*layer, format!("The grains of {name}")))
        }
    }
}

/// The points of a file (mm): the current centres of grains.
pub(super) fn points_mm(arrays: &Arrays) -> Vec<[f64; 2]> {
    let points = points(arrays).into_iter();
    points.map(|point| point.map(|x| 1e3 * x)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_are_drawn_deformed_and_grains_where_they_are() {
        let mut arrays = Arrays::new();
        arrays.insert("points".into(), vec![1e-3, 2e-3, 0.0]);
        arrays.insert("displacement_m".into(), vec![0.5e-3, -1e-3, 0.0]);
        assert_eq!(deformed_mm(&arrays), [[1.5, 1.0]]);
        assert_eq!(points_mm(&arrays), [[1.0, 2.0]]);
    }
}
