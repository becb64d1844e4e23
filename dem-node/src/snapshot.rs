//! Fields of the grains as VTK XML PolyData, for ParaView.

use std::f64::consts::PI;
use std::fmt::Write as _;
use std::iter::repeat_n;
use std::path::Path;

use crate::bodies::Bodies;
use crate::bond::BondCursor;
use crate::detect::Slot;
use crate::error::DemError;
use crate::flow::{Body, Flow, NEVER};
use crate::state::State;

/// Writes disks as vertices and the contacts between them, bonds too, as lines. Point data: radius_m (0 of fed grains in
/// store, less than their own of those that grow), velocity_m_per_s, spin_rad_per_s,
/// glued, pressure_pa; of a wheel of disks also wheel, 1 for these; where flows are followed also body (0 first body, 1 third body, 2 initial stock, 3 fed in) and detached_s, -1 for
/// grains that never were. Cell data: force_n (normal, tangential), zero on vertices; of a
/// cohesive law also adhesion, 0 on vertices and on contacts without bond.
pub fn write(
    path: &Path,
    bodies: &Bodies,
    state: &State,
    flow: Option<&Flow>,
    thickness: f64,
) -> Result<(), DemError> {
    write_text(path, &document(bodies, state, flow, thickness))
}

/// Writes a text file.
pub fn write_text(path: &Path, text: &str) -> Result<(), DemError> {
    std::fs::write(path, text).map_err(|source| DemError::Write {
        path: path.display().to_string(),
        source,
    })
}

fn document(bodies: &Bodies, state: &State, flow: Option<&Flow>, thickness: f64) -> String {
    let disks = bodies.disks();
    let mut bonds = BondCursor::new(&state.bonds);
    let slots = state.list.slots.iter().map(|slot| {
        let bond = bonds.find((slot.a, slot.b));
        (slot, bond.map_or(0.0, |(_, bond)| bond.adhesion))
    });
    let between_disks = slots.filter(|(slot, _)| (slot.b as usize) < disks);
    let lines: Vec<(&Slot, f64)> = between_disks
        .filter(|(slot, adhesion)| slot.force[0] > 0.0 || *adhesion > 0.0)
        .filter(|(slot, _)| !across_the_seam(bodies, state, slot))
        .collect();
    let mut text = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"0.1\" byte_order=\"LittleEndian\">\n<PolyData>\n<Piece NumberOfPoints=\"{disks}\" NumberOfVerts=\"{disks}\" NumberOfLines=\"{}\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n",
        lines.len()
    );
    let points = state.centres.iter();
    let points = points.flat_map(|c| [shown(bodies, c[0]), c[1], 0.0]);
    text += "<Points>\n";
    array(&mut text, "Float64", "points", 3, points);
    text += "</Points>\n<Verts>\n";
    array(&mut text, "Int64", "connectivity", 1, 0..disks);
    array(&mut text, "Int64", "offsets", 1, 1..=disks);
    text += "</Verts>\n<Lines>\n";
    let ends = lines.iter().flat_map(|(slot, _)| [slot.a, slot.b]);
    array(&mut text, "Int64", "connectivity", 1, ends);
    let offsets = (1..=lines.len()).map(|k| 2 * k);
    array(&mut text, "Int64", "offsets", 1, offsets);
    text += "</Lines>\n<PointData>\n";
    point_data(&mut text, bodies, state, thickness);
    if let Some(flow) = flow {
        flow_data(&mut text, bodies, flow);
    }
    text += "</PointData>\n<CellData>\n";
    let forces = lines.iter().flat_map(|(slot, _)| slot.force);
    let cells = repeat_n(0.0, 2 * disks).chain(forces);
    array(&mut text, "Float64", "force_n", 2, cells);
    if bodies.law.cohesion.is_some() {
        let adhesion = lines.iter().map(|(_, adhesion)| *adhesion);
        let cells = repeat_n(0.0, disks).chain(adhesion);
        array(&mut text, "Float64", "adhesion", 1, cells);
    }
    text += "</CellData>\n</Piece>\n</PolyData>\n</VTKFile>\n";
    text
}

/// A strip that repeats is drawn once.
fn shown(bodies: &Bodies, x: f64) -> f64 {
    bodies.period.map_or(x, |period| period.inside(x))
}

/// A line from one end of the strip to the other would be no contact.
fn across_the_seam(bodies: &Bodies, state: &State, slot: &Slot) -> bool {
    let x = |disk: u32| shown(bodies, state.centres[disk as usize][0]);
    let half = bodies.period.map(|period| 0.5 * period.length);
    half.is_some_and(|half| (x(slot.a) - x(slot.b)).abs() > half)
}

fn point_data(text: &mut String, bodies: &Bodies, state: &State, thickness: f64) {
    let velocities: Vec<[f64; 3]> = (0..bodies.disks())
        .map(|disk| state.velocity_of(bodies, disk))
        .collect();
    let flat = velocities.iter().flat_map(|v| [v[0], v[1], 0.0]);
    let spins = velocities.iter().map(|v| v[2]);
    let flag = |of: &dyn Fn(usize) -> bool| -> Vec<u8> {
        let disks = 0..bodies.disks();
        disks.map(|disk| u8::from(of(disk))).collect()
    };
    let radii = (0..bodies.disks()).map(|disk| state.radius(bodies, disk));
    array(text, "Float64", "radius_m", 1, radii);
    array(text, "Float64", "velocity_m_per_s", 3, flat);
    array(text, "Float64", "spin_rad_per_s", 1, spins);
    let glued = flag(&|disk| bodies.glued_index(disk).is_some());
    array(text, "UInt8", "glued", 1, glued);
    if !bodies.face.is_empty() {
        let wheel = flag(&|disk| disk >= bodies.first_face());
        array(text, "UInt8", "wheel", 1, wheel);
    }
    let pressures = pressures(bodies, state, thickness);
    array(text, "Float64", "pressure_pa", 1, pressures);
}

fn flow_data(text: &mut String, bodies: &Bodies, flow: &Flow) {
    let others = bodies.disks() - bodies.free;
    let kinds = flow.bodies().chain(repeat_n(Body::First, others));
    array(text, "UInt8", "body", 1, kinds.map(|body| body as u8));
    let times = flow.detached().chain(repeat_n(NEVER, others));
    array(text, "Float64", "detached_s", 1, times);
}

/// Mean in-plane pressure in each disk (Pa): half the trace of its stress (1/V) sum f (x_c - x) (Love 1927; Weber 1966), that
/// is sum f_n / (2 pi r thickness).
pub fn pressures(bodies: &Bodies, state: &State, thickness: f64) -> Vec<f64> {
    let mut sums = vec![0.0; bodies.count()];
    for slot in &state.list.slots {
        sums[slot.a as usize] += slot.force[0];
        sums[slot.b as usize] += slot.force[0];
    }
    let per_disk = sums.iter().zip(&bodies.radii);
    per_disk
        .map(|(sum, r)| sum / (2.0 * PI * r * thickness))
        .collect()
}

fn array<T: std::fmt::Display>(
    text: &mut String,
    kind: &str,
    name: &str,
    components: usize,
    values: impl IntoIterator<Item = T>,
) {
    let _ = writeln!(
        text,
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"ascii\">"
    );
    for value in values {
        let _ = write!(text, "{value} ");
    }
    text.push_str("\n</DataArray>\n");
}
