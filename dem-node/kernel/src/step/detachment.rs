//! Detachment: the steel of bare surfaces as a source of third body.
//!
//! ```text
//!     sum |F_t du_t| >= e A     on a segment of the area A: a layer of the depth d goes, and its mass d A rho is due as grains
//! ```
//!
//! The sum is the work of friction in the contacts with the segment since its last layer (Fleischer 1973: an energy density of wear, here e/d). The
//! points at its ends take half of the layer each, over their tributary lengths, so that the volume between the line and its reference is the volume
//! of the layers. The detached mass is due in the feed of [`crate::step::injection`]: a grain begins in the widest gap above the segment that lost
//! the last layer, at rest, and grows.
//!
//! The body below keeps its mesh, stiffness and inertia, which is valid while the depth is small: a segment loses at most a third of the length of
//! the shortest one. Contacts above lost steel open by the depth of a layer, and the energy that their springs release is part of the work of the
//! feed; a bond does not change.

use crate::bodies::Bodies;
use crate::bodies::feed::Detachment;
use crate::contact::bond::find_bond;
use crate::step::state::GrainState;

/// Slots of contacts without a bond, and their openings (m).
type Opened = Vec<(usize, f64)>;

/// Takes the layers off that are due. Returns the point around which the next grain begins (m), and the contacts that have opened.
pub fn detach(state: &mut GrainState, bodies: &Bodies, law: &Detachment) -> ([f64; 2], Opened) {
    let mut opened = Opened::new();
    for segment in 0..state.worn.work.len() {
        let length = bodies.surface.length(segment);
        let energy = law.energy * length;
        let due = (state.worn.work[segment] / energy).floor();
        if due < 1.0 {
            continue;
        }
        let (taken, deeper) = take_layers(state, bodies, law, (segment, due));
        let worn = &mut state.worn;
        worn.work[segment] = (worn.work[segment] - due * energy).max(0.0);
        worn.done[1] += (due - taken) * energy;
        if taken > 0.0 {
            worn.mass += taken * law.mass * law.depth * length;
            worn.last = segment as u32;
            open_contacts(state, bodies, deeper, &mut opened);
        }
    }
    let last = state.worn.last as usize;
    let [start, along] = bodies.surface.line(last, &state.surface);
    let reach = bodies.mean_radius() / along[0].hypot(along[1]);
    let point = [
        start[0] + 0.5 * along[0] - reach * along[1],
        start[1] + 0.5 * along[1] + reach * along[0],
    ];
    (point, opened)
}

/// Opens the contacts over points that now lie `deeper` (m).
fn open_contacts(
    state: &mut GrainState,
    bodies: &Bodies,
    deeper: [(usize, f64); 2],
    opened: &mut Opened,
) {
    let surface = &bodies.surface;
    for (index, slot) in state.list.slots.iter().enumerate() {
        let Some(segment) = bodies.segment_index(slot.b as usize) else {
            continue;
        };
        let foot = surface.foot(segment, &state.surface, state.centres[slot.a as usize]);
        let of = |point: usize| deeper.iter().find(|(other, _)| *other == point);
        let parts = foot.parts([1.0, 0.0]).into_iter();
        let parts = parts.filter_map(|(point, [share, _])| Some(share * of(point)?.1));
        let length: f64 = parts.sum();
        match find_bond(&state.bonds, (slot.a, slot.b)) {
            _ if length == 0.0 => {}
            None => opened.push((index, length)),
            Some(bond) => state.bonds[bond].reference += length,
        }
    }
}

/// Takes the due number of layers off a segment, or as many as may come off. Returns their number, and the added depth of its points (m).
fn take_layers(
    state: &mut GrainState,
    bodies: &Bodies,
    law: &Detachment,
    (segment, due): (usize, f64),
) -> (f64, [(usize, f64); 2]) {
    let surface = &bodies.surface;
    let half = 0.5 * surface.length(segment);
    let points = surface.points_of(segment);
    let layers = points.map(|point| law.depth * half / surface.tributary(point));
    let room = |k: usize| (law.limit - state.worn.depth(points[k])) / layers[k];
    let taken = due.min(room(0).min(room(1)).floor().max(0.0));
    let deeper = [0, 1].map(|k| (points[k], taken * layers[k]));
    for (point, deeper) in deeper {
        for (k, n) in surface.normal(point).into_iter().enumerate() {
            state.worn.offsets[point][k] -= deeper * n;
            state.surface[point][k] -= deeper * n;
        }
    }
    (taken, deeper)
}
