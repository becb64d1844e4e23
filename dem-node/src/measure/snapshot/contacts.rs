//! The contacts that press, and the bonds, as lines.

use dem_kernel::contact::bond::BondCursor;
use dem_kernel::contact::detect::Slot;
use kit::vtk::{DatasetKind, VtkFile};

use super::parts::{FieldScene, cells, points, poly_data};
use crate::measure::loads::shown;

/// Relative distance from the friction limit below which a contact counts as sliding. It allows for rounding, as every local solution lies on its
/// limit or inside.
const ON_THE_LIMIT: f64 = 1e-6;

/// A contact between two disks, or of a disk with a wall or a smooth wheel.
struct Line {
    slot: Slot,
    gap: f64,
    /// 0 without bond.
    adhesion: f64,
    /// The point of contact on a wall or the wheel (m); `None` between two disks.
    face: Option<[f64; 2]>,
}

/// Contacts as lines between the centres of two disks, or from a centre to the point of a wall or a smooth wheel that it touches.
/// In a strip that repeats, contacts across its seam are left out. Data: force_n (normal, compression positive, and tangential), gap_m (negative
/// where they overlap), status (1 stick, 2 slip, 3 bonded), partner of the disk (0 disk, 1 wheel, 2 wall, 3 surface), with a cohesive law also
/// adhesion.
pub(super) fn file(scene: &FieldScene) -> VtkFile {
    let lines = lines(scene);
    let disks = scene.bodies.disks();
    let faces: Vec<[f64; 2]> = lines.iter().filter_map(|line| line.face).collect();
    let mut file = poly_data([disks + faces.len(), 0, lines.len()]);
    file.section("Points", |file| points(file, scene, faces.into_iter()));
    file.section("Lines", |file| {
        let ends = ends(&lines, disks);
        cells(file, 2, ends.into_iter());
    });
    file.section("CellData", |file| {
        let forces = lines.iter().map(|line| line.slot.force);
        file.array(DatasetKind::Float64, "force_n", forces);
        let gaps = lines.iter().map(|line| [line.gap]);
        file.array(DatasetKind::Float64, "gap_m", gaps);
        let statuses = lines.iter().map(|line| [status(scene, line)]);
        file.array(DatasetKind::UInt8, "status", statuses);
        let partners = lines.iter().map(|line| [partner(scene, line)]);
        file.array(DatasetKind::UInt8, "partner", partners);
        if scene.bodies.law.cohesion.is_some() {
            let adhesion = lines.iter().map(|line| [line.adhesion]);
            file.array(DatasetKind::Float64, "adhesion", adhesion);
        }
    });
    file
}

fn lines(scene: &FieldScene) -> Vec<Line> {
    let FieldScene { bodies, state, .. } = *scene;
    let positions = state.positions(bodies);
    let mut bonds = BondCursor::new(&state.bonds);
    let slots = state.list.slots.iter().map(|slot| {
        let bond = bonds.find((slot.a, slot.b));
        (slot, bond.map_or(0.0, |(_, bond)| bond.adhesion))
    });
    let held = slots.filter(|(slot, adhesion)| slot.pressure()[0] > 0.0 || *adhesion > 0.0);
    let seen = held.filter(|(slot, _)| !across_the_seam(scene, slot));
    let line = |(slot, adhesion): (&Slot, f64)| {
        let [a, b] = [slot.a, slot.b].map(|body| body as usize);
        let at = positions.proximity(a, b);
        let reach = bodies.radii[a] + at.gap;
        let centre = state.centres[a];
        let point = [0, 1].map(|k| centre[k] - reach * at.normal[k]);
        Line {
            slot: *slot,
            gap: at.gap,
            adhesion,
            face: (b >= bodies.disks()).then_some(point),
        }
    };
    seen.map(line).collect()
}

/// True for a contact that would be a line from one end of the strip to the other.
fn across_the_seam(scene: &FieldScene, slot: &Slot) -> bool {
    let Some(period) = scene.bodies.period else {
        return false;
    };
    let centres = [slot.a, slot.b].map(|body| scene.state.centres.get(body as usize));
    let [Some(a), Some(b)] = centres else {
        return false;
    };
    let [a, b] = [a, b].map(|centre| shown(scene.bodies, *centre)[0]);
    (a - b).abs() > 0.5 * period.length
}

/// Numbers of the points of all lines; points on faces follow the centres of the disks.
fn ends(lines: &[Line], disks: usize) -> Vec<f64> {
    let mut faces = (disks..).map(|point| point as f64);
    let ends = lines.iter().flat_map(|line| {
        let second = match line.face {
            None => f64::from(line.slot.b),
            Some(_) => faces.next().expect("there is no last one"),
        };
        [f64::from(line.slot.a), second]
    });
    ends.collect()
}

fn partner(scene: &FieldScene, line: &Line) -> f64 {
    let (bodies, body) = (scene.bodies, line.slot.b as usize);
    if body < bodies.disks() {
        0.0
    } else if bodies.wheel() == Some(body) {
        1.0
    } else if bodies.wall_of(body).is_some() {
        2.0
    } else {
        3.0
    }
}

fn status(scene: &FieldScene, line: &Line) -> f64 {
    let Slot { a, b, .. } = line.slot;
    let pressure = line.slot.pressure();
    if line.adhesion > 0.0 {
        return 3.0;
    }
    let law = scene.state.law_of(scene.bodies, [a, b]);
    let slips = pressure[1].abs() >= (1.0 - ON_THE_LIMIT) * law.friction * pressure[0];
    if slips { 2.0 } else { 1.0 }
}
