//! Plausibility of the body's results: values of a run beyond the bounds of its scenario.

use protocol::Finding;

use crate::integrate::State;
use crate::mesh::Edge;
use crate::model::Model;
use crate::pack::{larger, largest};
use crate::probe::largest_strain;
use crate::profile::Profile;
use crate::statics::DirectedStatus;

/// The wheel must be at rest when its results are taken: `range` holds the least and largest force on it then (N).
pub(crate) fn wheel_at_rest(model: &Model, load: f64, range: [f64; 2]) -> Option<Finding> {
    let [low, high] = range;
    let value = larger(high - load, load - low) / load;
    let bounds = model.plausible.wheel_force_rel;
    let judged = bounds.judge("wheel_at_rest", value, || {
        format!("the wheel is not at rest before its motion: over the second half of the hold (without one, at its end) the body carried {low:.4e} to {high:.4e} N of its {load:e} N: make wheel.hold_s or wheel.ramp_s longer, lower wheel.mass_kg, or change time.start_mass_damping_per_s")
    });
    judged.filter(|_| load > 0.0)
}

/// A curved contact must be wider than its nodes are apart.
pub(crate) fn contact_resolution(model: &Model, profile: &Profile) -> Option<Finding> {
    let touching = profile.status.iter();
    let touching = touching.filter(|status| **status != DirectedStatus::Open);
    let nodes = touching.count();
    let value = 1.0 / nodes as f64;
    let bounds = model.plausible.contact_resolution;
    let judged = bounds.judge("contact_resolution", value, || {
        format!("only {nodes} nodes of the body touch the wheel, too few for its pressure and approach: make mesh.size_m smaller under the wheel, or raise wheel.load_n")
    });
    judged.filter(|_| nodes > 0 && is_curved(model))
}

/// True if a flat wheel would not touch all of the upper edge.
fn is_curved(model: &Model) -> bool {
    let nodes = model.mesh.edge(Edge::Top);
    let height = |n: &[usize; 2]| model.mesh.point(n[0], n[1])[1];
    let first = nodes.first().map(height);
    model.wheel_radius != 0.0 || nodes.iter().any(|node| Some(height(node)) != first)
}

/// A curved contact must end before the body does.
pub(crate) fn contact_reach<'a>(
    model: &Model,
    profiles: impl Iterator<Item = &'a Profile>,
) -> Option<Finding> {
    let nodes = model.mesh.edge(Edge::Top);
    let points = nodes.iter().map(|n| model.mesh.point(n[0], n[1]));
    let points: Vec<[f64; 2]> = points.collect();
    let (first, last) = (points.first()?, points.last()?);
    if !is_curved(model) {
        return None;
    }
    let (middle, half) = (0.5 * (first[0] + last[0]), 0.5 * (last[0] - first[0]).abs());
    let touching = profiles.flat_map(|profile| profile.x.iter().zip(&profile.status));
    let touching = touching.filter(|(_, status)| **status != DirectedStatus::Open);
    let reach = largest(touching.map(|(x, _)| (x - middle).abs()));
    let bounds = model.plausible.contact_reach_rel;
    bounds.judge("contact_reach", reach / half, || {
        format!("the wheel touches the body out to {reach:.3e} m from the middle of its upper edge, which ends at {half:.3e} m: the body is too narrow for this load; make mesh.width_m larger, or lower wheel.load_n")
    })
}

/// The larger of a strain and the largest of a state; not a number if either is none.
pub(crate) fn strain_so_far(before: f64, model: &Model, state: &State) -> f64 {
    larger(before, largest_strain(model, state))
}

/// Strain must stay within what the material model bears.
pub(crate) fn strain(model: &Model, value: f64) -> Option<Finding> {
    model.plausible.strain.judge("strain", value, || {
        let means = if model.law.is_some() {
            "its law holds for small stretches only"
        } else {
            "small-strain elasticity holds for small displacement gradients only"
        };
        format!("the body is strained by up to {value:.3}, and {means}: lower the load, or check young_pa and the dimensions")
    })
}
