//! Fields of the grains and of their contacts as VTK XML PolyData, for ParaView.

mod contacts;
pub mod parts;

use std::f64::consts::PI;
use std::io;
use std::iter::{empty, repeat_n};
use std::path::Path;

use dem_kernel::bodies::Bodies;
use dem_kernel::contact::graph::degrees;
use dem_kernel::step::state::GrainState;
use kit::vtk::{DatasetKind, VtkFile};

use crate::error::DemError;
use crate::measure::flow::{Flow, FlowBody, NEVER};
use crate::measure::loads::shown;
use crate::measure::structure;
use parts::{FieldScene, cells, points, poly_data};

/// Writes `<stem>.vtp`, the disks as vertices, `<stem>-contacts.vtp`, the contacts between them, and where there are bare surfaces
/// `<stem>-surface.vtp`, their segments as lines, without data.
///
/// Data of the disks: radius_m (0 for fed grains in store, the present radius of growing ones), displacement_since_start_m (0 for fed grains; the
/// points include it, unlike a mesh's points and its displacement_m), velocity_m_per_s, spin_rad_per_s, glued, pressure_pa, coordination (contacts
/// that press), temperature_k (with `heat`, of grains and of clusters with a held one; NaN for other disks). Where bonds or adhesion hold grains together also agglomerate_grains (number of grains in its agglomerate); with a wheel of disks
/// wheel, 1 for its disks; in a sample with clusters cluster, -1 for single disks; where flows are measured body (0 first body, 1 third body, 2
/// initial stock, 3 fed in) and detached_s, -1 for grains that never were detached.
pub fn write(folder: &Path, stem: &str, scene: &FieldScene) -> Result<(), DemError> {
    let path = |suffix: &str| folder.join(format!("{stem}{suffix}.vtp"));
    written(&path(""), |path| grains(scene).write(path))?;
    written(&path("-contacts"), |path| contacts::file(scene).write(path))?;
    if scene.bodies.surface.segments() == 0 {
        return Ok(());
    }
    written(&path("-surface"), |path| surface(scene).write(path))
}

/// Writes a text file.
pub fn write_text(path: &Path, text: &str) -> Result<(), DemError> {
    written(path, |path| std::fs::write(path, text))
}

fn written(path: &Path, write: impl FnOnce(&Path) -> io::Result<()>) -> Result<(), DemError> {
    write(path).map_err(|source| DemError::Write {
        path: path.display().to_string(),
        source,
    })
}

fn grains(scene: &FieldScene) -> VtkFile {
    let disks = scene.bodies.disks();
    let mut file = poly_data([disks, disks, 0]);
    file.section("Points", |file| points(file, scene, empty()));
    file.section("Verts", |file| {
        cells(file, 1, (0..disks).map(|disk| disk as f64));
    });
    file.section("PointData", |file| {
        state_data(file, scene);
        kind_data(file, scene);
        if let Some(flow) = scene.flow {
            flow_data(file, scene.bodies, flow);
        }
    });
    file
}

/// Segments of bare surfaces, each with its own points, so that a strip that repeats has no line from one end to the other.
fn surface(scene: &FieldScene) -> VtkFile {
    let surface = &scene.bodies.surface;
    let (segments, places) = (surface.segments(), &scene.state.surface);
    let ends = (0..segments).flat_map(|index| {
        let [start, along] = surface.line(index, places);
        let [x, y] = shown(scene.bodies, start);
        [[x, y, 0.0], [x + along[0], y + along[1], 0.0]]
    });
    let mut file = poly_data([2 * segments, 0, segments]);
    file.section("Points", |file| {
        file.array(DatasetKind::Float64, "points", ends)
    });
    file.section("Lines", |file| {
        cells(file, 2, (0..2 * segments).map(|n| n as f64))
    });
    let worn = &scene.state.worn;
    if worn.detaches() {
        let points = (0..segments).flat_map(|index| surface.points_of(index));
        let depths = points.map(|point| [worn.depth(point)]);
        file.section("PointData", |file| {
            file.array(DatasetKind::Float64, "detached_depth_m", depths)
        });
    }
    file
}

fn state_data(file: &mut VtkFile, scene: &FieldScene) {
    let FieldScene { bodies, state, .. } = *scene;
    let radii = (0..bodies.disks()).map(|disk| [state.radius(bodies, disk)]);
    file.array(DatasetKind::Float64, "radius_m", radii);
    let fed = bodies.injection.as_ref().map_or(0, |feed| feed.grains);
    let fed = bodies.free - fed..bodies.free;
    let both = state.centres.iter().zip(scene.start).enumerate();
    let moved = both.map(|(disk, (centre, start))| {
        if fed.contains(&disk) {
            return [0.0; 3];
        }
        [centre[0] - start[0], centre[1] - start[1], 0.0]
    });
    file.array(DatasetKind::Float64, "displacement_since_start_m", moved);
    let velocity = |disk: usize| state.velocity_of(bodies, disk);
    let velocities: Vec<[f64; 3]> = (0..bodies.disks()).map(velocity).collect();
    let linear = velocities.iter().map(|v| [v[0], v[1], 0.0]);
    file.array(DatasetKind::Float64, "velocity_m_per_s", linear);
    let spins = velocities.iter().map(|v| [v[2]]);
    file.array(DatasetKind::Float64, "spin_rad_per_s", spins);
    let pressures = pressures(bodies, state, scene.thickness);
    let pressures = pressures.into_iter().take(bodies.disks());
    file.array(DatasetKind::Float64, "pressure_pa", pressures.map(|p| [p]));
    let pressing = state.list.pressing();
    let pairs = pressing.map(|slot| [slot.a as usize, slot.b as usize]);
    let coordination = degrees(bodies.disks(), pairs).into_iter();
    let coordination = coordination.map(|n| [n as f64]);
    file.array(DatasetKind::Int32, "coordination", coordination);
    if let Some(law) = &bodies.heat {
        let grains = state.heat.temperatures(law);
        let others = repeat_n(f64::NAN, bodies.disks() - bodies.free);
        let temperatures = grains.chain(others).map(|t| [t]);
        file.array(DatasetKind::Float64, "temperature_k", temperatures);
    }
    if let Some(sizes) = structure::agglomerate_sizes(bodies, state) {
        let others = repeat_n(0, bodies.disks() - bodies.free);
        let sizes = sizes.into_iter().chain(others);
        let sizes = sizes.map(|size| [f64::from(size)]);
        file.array(DatasetKind::Int32, "agglomerate_grains", sizes);
    }
}

fn kind_data(file: &mut VtkFile, scene: &FieldScene) {
    let bodies = scene.bodies;
    let disks = || 0..bodies.disks();
    let glued = disks().map(|disk| [f64::from(bodies.glued_index(disk).is_some())]);
    file.array(DatasetKind::UInt8, "glued", glued);
    if !bodies.face.is_empty() {
        let wheel = disks().map(|disk| [f64::from(disk >= bodies.first_face())]);
        file.array(DatasetKind::UInt8, "wheel", wheel);
    }
    if !bodies.clusters.list.is_empty() {
        let index = |disk| bodies.clusters.of(disk).map_or(-1.0, |(i, _)| i as f64);
        let indices = disks().map(|disk| [index(disk)]);
        file.array(DatasetKind::Int32, "cluster", indices);
    }
}

fn flow_data(file: &mut VtkFile, bodies: &Bodies, flow: &Flow) {
    let others = bodies.disks() - bodies.free;
    let kinds = flow.bodies().chain(repeat_n(FlowBody::First, others));
    let kinds = kinds.map(|body| [f64::from(body as u8)]);
    file.array(DatasetKind::UInt8, "body", kinds);
    let times = flow.detached().chain(repeat_n(NEVER, others));
    file.array(DatasetKind::Float64, "detached_s", times.map(|time| [time]));
}

/// Mean in-plane pressure in each disk (Pa): half the trace of its stress (1/V) sum f (x_c - x) (Love 1927; Weber 1966), that
/// is sum f_n / (2 pi r thickness).
pub fn pressures(bodies: &Bodies, state: &GrainState, thickness: f64) -> Vec<f64> {
    let mut sums = vec![0.0; bodies.count()];
    for slot in &state.list.slots {
        sums[slot.a as usize] += slot.force[0];
        sums[slot.b as usize] += slot.force[0];
    }
    let pressure = |(sum, r): (&f64, &f64)| sum / (2.0 * PI * r * thickness);
    sums.iter().zip(&bodies.radii).map(pressure).collect()
}
