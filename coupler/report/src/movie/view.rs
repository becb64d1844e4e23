//! Parts of the scene that a movie shows, and the scale at which displacements can be seen in them.

use serde_json::{Value, json};

use super::range::MovieRanges;
use super::scene::Scene;
use super::shots::Shots;
use draw::extent::Extent;
use runs::fields::numbers;

/// Part of a view's height that the largest displacement is drawn as.
const SEEN: f64 = 0.15;
/// Largest scale.
const SCALE_MOST: f64 = 1_000.0;

/// A part of the scene (m) with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct MovieView {
    name: &'static str,
    extent: Extent,
}

/// The views of a scene, that to begin with first: the contact, where there is one.
pub fn views(scene: &Scene, focus: [f64; 2], wheel: bool) -> Vec<MovieView> {
    let (body, layer) = (Extent::around(nodes(scene)), Extent::around(circles(scene)));
    let both = [body, layer].into_iter().flatten();
    let ends = |e: Extent| [([e.x[0], e.y[0]], 0.0), ([e.x[1], e.y[1]], 0.0)];
    let Some(all) = Extent::around(both.flat_map(ends)) else {
        return Vec::new();
    };
    let edge = 0.06 * all.width().max(all.height());
    let whole = all.with_margin(edge, edge, edge);
    // Above a layer is a mesh, or a rigid wheel that needs no room.
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
    let view = |name| move |extent| MovieView { name, extent };
    let [whole, contact] = [view("whole")(whole), view("contact")(contact)];
    let mut views: Vec<MovieView> = match (body, close.map(view("close-up"))) {
        (None, Some(close)) => vec![close, whole, contact],
        (None, None) => vec![whole, contact],
        (Some(_), None) if layer.is_none() && !wheel => vec![whole, contact],
        (Some(_), close) => [contact, whole].into_iter().chain(close).collect(),
    };
    views.dedup_by(|a, b| a.extent == b.extent);
    views
}

impl MovieView {
    /// The view as the page takes it (mm).
    pub fn json(&self) -> Value {
        let [x, y] = [self.extent.x, self.extent.y].map(|range| range.map(|end| 1e3 * end));
        json!({ "name": self.name, "box": [x[0], x[1], y[0], y[1]] })
    }

    /// Scale at which the largest displacement is about a seventh of its height: 1, 2 or 5 times a power of ten, 1 at least.
    pub fn scale(&self, largest_m: f64) -> f64 {
        if largest_m <= 0.0 {
            return 1.0;
        }
        let most = SEEN * self.extent.height() / largest_m;
        let steps = (0..3).flat_map(|k| [1.0, 2.0, 5.0].map(|digit| digit * 10f64.powi(k)));
        let steps = steps.chain([SCALE_MOST]);
        steps.filter(|step| *step <= most).fold(1.0, f64::max)
    }
}

/// Part of a scale that grains without a mesh get: those that close a gap are drawn as far in each other.
const OF_GRAINS: f64 = 0.3;

/// The largest displacement that a scale applies to (m): of the nodes of meshes, or where there are none of bonded grains since
/// the first frame. Grains without bonds move past each other, and their motion is seen as it is.
pub fn largest_displacement(shots: &Shots, ranges: &MovieRanges) -> f64 {
    if !shots.meshes.is_empty() {
        let far = |range: [f64; 2]| range[1].max(-range[0]);
        return far(ranges.displacement[0]).max(far(ranges.displacement[1]));
    }
    let mut largest = 0.0;
    for over in &shots.grains {
        let mut frames = over.iter().flatten();
        let Some(first) = frames.next() else { continue };
        if !first.bonded {
            return f64::INFINITY;
        }
        for shot in frames {
            let [x, y] = [0, 1].map(|k| shot.centre[k].iter().zip(&first.centre[k]));
            let moved = x.zip(y).map(|(x, y)| (x.0 - x.1).hypot(y.0 - y.1));
            largest = moved.fold(largest, f64::max);
        }
    }
    largest / OF_GRAINS
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

/// A quarter of the scene around a point, as far as the scene goes.
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
    fn a_scale_makes_displacements_seen_and_is_never_below_one() {
        let view = MovieView {
            name: "whole",
            extent: Extent {
                x: [0.0, 10e-3],
                y: [0.0, 5e-3],
            },
        };
        let scales = [1e-3, 9e-5, 1e-5, 1e-9, 0.0].map(|largest| view.scale(largest));
        assert_eq!(scales, [1.0, 5.0, 50.0, 1000.0, 1.0]);
    }

    #[test]
    fn margins_end_with_the_scene() {
        let all = Extent {
            x: [0.0, 65.0],
            y: [-20.0, 1.0],
        };
        let near = around([32.5, 0.0], &all);
        assert_eq!((near.x, near.y), ([24.375, 40.625], [-4.875, 1.0]));
    }
}
