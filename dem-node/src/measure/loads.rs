//! Loads of the grains: each force of a contact on a grain, and the point where it acts.
//!
//! Grains are the free disks and the clusters that nothing drives. Two disks touch in the middle of their gap or overlap, a disk touches a wall or
//! the wheel on their face. In equilibrium the moments of all grains then add up to the moments of the forces on the faces, for any overlaps.

use dem_kernel::bodies::Bodies;
use dem_kernel::bodies::geometry::range;
use dem_kernel::step::state::GrainState;

/// Force of a contact on a grain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// The disk under the force.
    pub disk: usize,
    /// Centre of its grain (m): of the disk or of its cluster.
    pub centre: [f64; 2],
    /// Point of contact (m), near this centre in a strip that repeats.
    pub point: [f64; 2],
    /// Force on it (N).
    pub force: [f64; 2],
}

impl Load {
    /// f_i l_j with the lever l from the centre to the point (N m): xx, xy, yx, yy.
    pub fn moment(&self) -> [f64; 4] {
        let [fx, fy] = self.force;
        let [lx, ly] = [0, 1].map(|k| self.point[k] - self.centre[k]);
        [fx * lx, fx * ly, fy * lx, fy * ly]
    }
}

/// Adds a part of a moment to a sum of moments.
pub fn add_moment(sum: &mut [f64; 4], part: f64, moment: [f64; 4]) {
    for (sum, moment) in sum.iter_mut().zip(moment) {
        *sum += part * moment;
    }
}

/// Visits the loads of all grains under the forces of the last step, by ascending contact.
pub fn for_each_load(bodies: &Bodies, state: &GrainState, mut visit: impl FnMut(&Load)) {
    let positions = state.positions(bodies);
    let mut load = |disk: usize, arm: [f64; 2], force: [f64; 2]| {
        if disk >= bodies.free || is_driven(bodies, disk) {
            return;
        }
        let [x, y] = state.centres[disk];
        visit(&Load {
            disk,
            centre: centre_of(bodies, state, disk),
            point: [x + arm[0], y + arm[1]],
            force,
        });
    };
    let slots = state.list.slots.iter();
    for slot in slots.filter(|slot| slot.force != [0.0; 2]) {
        let (a, b) = (slot.a as usize, slot.b as usize);
        let at = positions.proximity(a, b);
        let [nx, ny] = at.normal;
        let [f_n, f_t] = slot.force;
        let force = [f_n * nx - f_t * ny, f_n * ny + f_t * nx];
        let two_disks = b < bodies.disks();
        let share = if two_disks { 0.5 } else { 1.0 };
        let arm = bodies.radii[a] + share * at.gap;
        load(a, [-arm * nx, -arm * ny], force);
        if two_disks {
            let back = bodies.radii[b] + 0.5 * at.gap;
            load(b, [back * nx, back * ny], force.map(|f| -f));
        }
    }
}

/// The disks of the grains.
pub fn grains<'a>(bodies: &'a Bodies, state: &'a GrainState) -> impl Iterator<Item = usize> {
    state
        .grains(bodies)
        .filter(|disk| !is_driven(bodies, *disk))
}

fn is_driven(bodies: &Bodies, disk: usize) -> bool {
    let cluster = bodies.clusters.of(disk);
    cluster.is_some_and(|(_, cluster)| cluster.drive.is_some())
}

/// Lower and upper end of these disks along a coordinate, or of a strip that repeats along it (m).
pub fn ends(
    bodies: &Bodies,
    state: &GrainState,
    axis: usize,
    disks: impl Iterator<Item = usize>,
) -> [f64; 2] {
    if let (Some(period), 0) = (bodies.period, axis) {
        return [period.left, period.left + period.length];
    }
    range(disks.flat_map(|disk| {
        let (centre, radius) = (state.centres[disk][axis], bodies.radii[disk]);
        [centre - radius, centre + radius]
    }))
}

/// Centre of the grain of a disk (m), not folded back into a strip that repeats.
pub fn centre_of(bodies: &Bodies, state: &GrainState, disk: usize) -> [f64; 2] {
    match bodies.clusters.of(disk) {
        Some((index, _)) => state.clusters[index].centre,
        None => state.centres[disk],
    }
}

/// The image of a point inside a strip that repeats (m).
pub fn shown(bodies: &Bodies, [x, y]: [f64; 2]) -> [f64; 2] {
    [bodies.period.map_or(x, |period| period.inside(x)), y]
}
