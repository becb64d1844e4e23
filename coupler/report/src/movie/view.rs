//! Parts of the scene that a movie shows, and the scale at which displacements can be seen in them.

use serde_json::{Value, json};

use super::range::Ranges;
use super::scene::Scene;
use super::shots::Shots;
use runs::fields::numbers;

/// Part of a view's height that the largest displacement is drawn as.
const SEEN: f64 = 0.15;
/// Largest scale.
const SCALE_MOST: f64 = 1_000.0;

/// Bounds along x and y (m).
type Bounds = [[f64; 2]; 2];

/// A part of the scene with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    name: &'static str,
    bounds: Bounds,
}

/// The views of a scene, that to begin with first: the contact, where there is one.
pub fn views(scene: &Scene, focus: [f64; 2], wheel: bool) -> Vec<View> {
    let (body, layer) = (bounds(nodes(scene)), bounds(circles(scene)));
    let all = [body, layer].into_iter().flatten();
    let ends = |b: Bounds| [([b[0][0], b[1][0]], 0.0), ([b[0][1], b[1][1]], 0.0)];
    let Some(all) = bounds(all.flat_map(ends)) else {
        return Vec::new();
    };
    let whole = View {
        name: "whole",
        bounds: with_margin(all, 0.06 * longer(&all), [0.06 * longer(&all); 2]),
    };
    // Above a layer is a mesh, or a rigid wheel that needs no room.
    let above = layer.is_some_and(|layer| all[1][1] > layer[1][1]);
    let close = layer.filter(|b| length(b[1]) < 0.1 * length(b[0]));
    let close = close.map(|layer| middle(layer, above));
    let contact = match (body, layer) {
        (Some(_), Some(layer)) => {
            let width = length(layer[0]);
            within(
                with_margin(
                    layer,
                    0.02 * width,
                    [0.16 * width, if above { 0.16 } else { 0.04 } * width],
                ),
                &whole.bounds,
            )
        }
        _ => around(focus, &whole.bounds),
    };
    let contact = View {
        name: "contact",
        bounds: contact,
    };
    let close = close.map(|bounds| View {
        name: "close-up",
        bounds,
    });
    let mut views: Vec<View> = match (body, close) {
        (None, Some(close)) => vec![close, whole, contact],
        (None, None) => vec![whole, contact],
        (Some(_), None) if layer.is_none() && !wheel => vec![whole, contact],
        (Some(_), close) => [contact, whole].into_iter().chain(close).collect(),
    };
    views.dedup_by(|a, b| a.bounds == b.bounds);
    views
}

impl View {
    /// The view as the page takes it (mm).
    pub fn told(&self) -> Value {
        let [x, y] = self.bounds.map(|range| range.map(|end| 1e3 * end));
        json!({ "name": self.name, "box": [x[0], x[1], y[0], y[1]] })
    }

    /// Scale at which the largest displacement is about a seventh of its height: 1, 2 or 5 times a power of ten, 1 at least.
    pub fn scale(&self, largest_m: f64) -> f64 {
        if largest_m <= 0.0 {
            return 1.0;
        }
        let most = SEEN * length(self.bounds[1]) / largest_m;
        let steps = (0..3).flat_map(|k| [1.0, 2.0, 5.0].map(|digit| digit * 10f64.powi(k)));
        let steps = steps.chain([SCALE_MOST]);
        steps.filter(|step| *step <= most).fold(1.0, f64::max)
    }
}

/// Part of a scale that grains without a mesh get: those that close a gap are drawn as far in each other.
const OF_GRAINS: f64 = 0.3;

/// The largest displacement that a scale applies to (m): of the nodes of meshes, or where there are none of bonded grains since
/// the first frame. Grains without bonds move past each other, and their motion is seen as it is.
pub fn largest_displacement(shots: &Shots, ranges: &Ranges) -> f64 {
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
        let up = body.place.up;
        body.mesh
            .nodes
            .iter()
            .map(move |n| ([n[0], n[1] + up], 0.0))
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

fn bounds(circles: impl Iterator<Item = ([f64; 2], f64)>) -> Option<Bounds> {
    let none = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    let all = circles.fold(none, |bounds, (centre, radius)| {
        [0, 1].map(|k| {
            [
                bounds[k][0].min(centre[k] - radius),
                bounds[k][1].max(centre[k] + radius),
            ]
        })
    });
    (all[0][0] <= all[0][1]).then_some(all)
}

fn length(range: [f64; 2]) -> f64 {
    range[1] - range[0]
}

fn longer(bounds: &Bounds) -> f64 {
    length(bounds[0]).max(length(bounds[1]))
}

/// With margins at the sides, below and above.
fn with_margin([x, y]: Bounds, side: f64, [below, above]: [f64; 2]) -> Bounds {
    [[x[0] - side, x[1] + side], [y[0] - below, y[1] + above]]
}

fn within(bounds: Bounds, other: &Bounds) -> Bounds {
    [0, 1].map(|k| [bounds[k][0].max(other[k][0]), bounds[k][1].min(other[k][1])])
}

/// The middle of a layer that is much longer than high.
fn middle(layer: Bounds, above: bool) -> Bounds {
    let (height, centre) = (length(layer[1]), 0.5 * (layer[0][0] + layer[0][1]));
    let half = 4.5 * height;
    with_margin(
        [[centre - half, centre + half], layer[1]],
        0.0,
        [0.8 * height, if above { 0.8 } else { 0.3 } * height],
    )
}

/// A quarter of the scene around a place, as far as the scene goes.
fn around(centre: [f64; 2], all: &Bounds) -> Bounds {
    let half = 0.125 * length(all[0]);
    let high = half.min(0.5 * length(all[1])) * 0.6;
    let part = [
        [centre[0] - half, centre[0] + half],
        [centre[1] - high, centre[1] + high],
    ];
    within(part, all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_makes_displacements_seen_and_is_never_below_one() {
        let view = View {
            name: "whole",
            bounds: [[0.0, 10e-3], [0.0, 5e-3]],
        };
        let scales = [1e-3, 9e-5, 1e-5, 1e-9, 0.0].map(|largest| view.scale(largest));
        assert_eq!(scales, [1.0, 5.0, 50.0, 1000.0, 1.0]);
    }

    #[test]
    fn margins_end_with_the_scene() {
        let all = [[0.0, 65.0], [-20.0, 1.0]];
        let near = around([32.5, 0.0], &all);
        assert_eq!(near, [[24.375, 40.625], [-4.875, 1.0]]);
    }
}
