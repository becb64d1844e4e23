//! Views: parts of the scene that a movie shows.

use serde_json::{Value, json};

use super::scene::Scene;
use draw::extent::Extent;
use runs::fields::numbers;
use runs::scene::Setup;

/// A part of the scene (m) with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct MovieView {
    name: &'static str,
    extent: Extent,
    /// True for a view that moves with the wheel.
    follows: bool,
}

/// The views of a scene, the initial view first: a wheel that rolls, or the contact, if there is one.
pub fn views(scene: &Scene, focus: [f64; 2], setup: &Setup) -> Vec<MovieView> {
    let (body, layer) = (Extent::around(nodes(scene)), Extent::around(circles(scene)));
    let both = [body, layer].into_iter().flatten();
    let ends = |e: Extent| [([e.x[0], e.y[0]], 0.0), ([e.x[1], e.y[1]], 0.0)];
    let Some(all) = Extent::around(both.flat_map(ends)) else {
        return Vec::new();
    };
    let edge = 0.06 * all.width().max(all.height());
    let whole = all.with_margin(edge, edge, edge);
    // A mesh above a layer needs room, a rigid wheel does not.
    let above = layer.is_some_and(|layer| all.y[1] > layer.y[1]);
    let close = layer.filter(|layer| layer.height() < 0.1 * layer.width());
    let close = close.map(|layer| {
        let height = layer.height();
        let above = if above { 0.8 } else { 0.3 } * height;
        layer.middle().with_margin(0.0, 0.8 * height, above)
    });
    let contact = match (body, layer) {
        (Some(_), Some(layer)) => {
            let width = layer.width();
            let above = if above { 0.16 } else { 0.04 } * width;
            let near = layer.with_margin(0.02 * width, 0.16 * width, above);
            near.within(&whole)
        }
        _ => around(focus, &whole),
    };
    let view = |name, extent| MovieView {
        name,
        extent,
        follows: name == "wheel",
    };
    let [whole, contact] = [view("whole", whole), view("contact", contact)];
    let mut views: Vec<MovieView> = match (body, close.map(|close| view("close-up", close))) {
        (None, Some(close)) => vec![close, whole, contact],
        (None, None) => vec![whole, contact],
        (Some(_), None) if layer.is_none() && setup.wheel_of.is_none() => vec![whole, contact],
        (Some(_), close) => [contact, whole].into_iter().chain(close).collect(),
    };
    views.dedup_by(|a, b| a.extent == b.extent);
    if setup.rolls {
        views.insert(0, view("wheel", around(focus, &all)));
    }
    views
}

impl MovieView {
    /// The view in the form that the page reads (mm).
    pub fn json(&self) -> Value {
        let [x, y] = [self.extent.x, self.extent.y].map(|range| range.map(|end| 1e3 * end));
        json!({ "name": self.name, "box": [x[0], x[1], y[0], y[1]], "follows": self.follows })
    }
}

fn nodes(scene: &Scene) -> impl Iterator<Item = ([f64; 2], f64)> {
    scene.meshes.iter().flat_map(|body| {
        let (nodes, up) = (body.mesh.nodes.iter(), body.position.up);
        nodes.map(move |n| ([n[0], n[1] + up], 0.0))
    })
}

/// Centres and radii of the grains that are not in store (m).
fn circles(scene: &Scene) -> impl Iterator<Item = ([f64; 2], f64)> {
    let all = scene.grains.iter().flat_map(|grains| {
        let radii = numbers(&grains.first, "radius_m").to_vec();
        grains.centres().into_iter().zip(radii)
    });
    all.filter(|(_, radius)| *radius > 0.0)
}

/// A quarter of the scene around a point, within the scene.
fn around([x, y]: [f64; 2], all: &Extent) -> Extent {
    let half = 0.125 * all.width();
    let high = half.min(0.5 * all.height()) * 0.6;
    let part = Extent {
        x: [x - half, x + half],
        y: [y - high, y + high],
    };
    part.within(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_view_ends_at_the_edge_of_the_scene() {
        let all = Extent {
            x: [0.0, 65.0],
            y: [-20.0, 1.0],
        };
        let near = around([32.5, 0.0], &all);
        assert_eq!((near.x, near.y), ([24.375, 40.625], [-4.875, 1.0]));
    }
}
