//! Samples: grains listed one by one, a pressed layer, or a rail of grains.
//!
//! In reading order:
//! - [`types`]: a sample;
//! - `fill`, [`fed`]: grains that fill a region, and grains that are fed in later;
//! - [`bed`], [`layer`], [`rail`]: grains that are pressed and cut;
//! - [`surface`]: the surface beside their glued rows;
//! - [`wheel_face`]: the disks of a rough wheel;
//! - [`prepared`]: samples that are kept for later runs.

pub mod bed;
pub mod fed;
pub(crate) mod fill;
pub mod layer;
pub mod prepared;
pub mod rail;
pub mod surface;
pub mod types;
pub mod wheel_face;

use dem_kernel::bodies::cluster::ClusterMembers;
use dem_kernel::bodies::disk::Disk;
use dem_kernel::bodies::drive::Drive;
use dem_kernel::bodies::faces::{Face, RigidWall, polyline};
use dem_kernel::random::RandomNumbers;

use crate::config::DemConfig;
use crate::config::disks::{DiskConfig, DisksConfig, WallConfig};
use crate::config::drive::ClusterDriveConfig;
use crate::config::law::LawKind;
use crate::config::sample::SampleConfig;
use crate::error::DemError;
use types::Sample;

/// Prepares the sample of a scenario. `seed` is the run's seed, which `sample.seed` overrides.
pub fn prepare(config: &DemConfig, seed: u64) -> Result<Sample, DemError> {
    match &config.sample {
        SampleConfig::Disks(disks) => Ok(listed(&fill::expanded(disks, seed))),
        SampleConfig::Rail(recipe) => rail::prepare(recipe, recipe.seed.unwrap_or(seed)),
        SampleConfig::Layer(recipe) => layer::prepare(
            recipe,
            config.law.contact_stiffness_pa,
            stays_as_cut(config),
            recipe.seed.unwrap_or(seed),
        ),
    }
}

/// Largest displacement of a perturbed grain over its radius.
const PERTURBATION: f64 = 1e-12;

/// Displaces each free grain by up to 1e-12 of its radius along x and along y.
pub fn perturb(sample: &mut Sample, seed: u64) {
    let mut numbers = RandomNumbers::new(seed);
    for disk in &mut sample.free {
        let most = PERTURBATION * disk.radius;
        disk.centre = disk.centre.map(|x| x + numbers.between(-most, most));
    }
}

/// True for a layer whose grains stay where they were cut: compliant bonds take gaps and overlaps as their reference. Rigid contacts must not overlap
/// when their bond breaks.
pub(crate) fn stays_as_cut(config: &DemConfig) -> bool {
    config.law.kind.plain() == LawKind::Cohesion && config.law.contact_stiffness_pa.is_some()
}

fn listed(config: &DisksConfig) -> Sample {
    let pick = |glued: bool, lid: bool| {
        let chosen = |disk: &&DiskConfig| (disk.glued, disk.lid) == (glued, lid);
        let disks = config.disks.iter().filter(chosen).map(|disk| Disk {
            centre: [disk.x_m, disk.y_m],
            radius: disk.radius_m,
            velocity: [disk.vx_m_per_s, disk.vy_m_per_s, disk.spin_rad_per_s],
        });
        disks.collect::<Vec<_>>()
    };
    let along = |mut row: Vec<Disk>| {
        row.sort_by(|a, b| a.centre[0].total_cmp(&b.centre[0]));
        row
    };
    let mut glued = along(pick(true, false));
    let lid = along(pick(true, true));
    let on_top = lid.len();
    glued.extend(lid);
    Sample {
        free: pick(false, false),
        glued,
        lid: on_top,
        walls: walls(&config.walls),
        wall_names: wall_names(&config.walls),
        clusters: clusters(config),
        ..Sample::default()
    }
}

fn walls(config: &[WallConfig]) -> Vec<RigidWall> {
    let mut walls = Vec::new();
    for wall in config {
        let faces = match &wall.points_m {
            Some(points) => polyline(points, walls.len())
                .into_iter()
                .map(Face::Segment)
                .collect(),
            None => vec![half_plane(wall)],
        };
        walls.extend(faces.into_iter().map(|face| RigidWall {
            face,
            velocity: wall.velocity_m_per_s,
        }));
    }
    walls
}

fn wall_names(config: &[WallConfig]) -> Vec<String> {
    let names = config.iter().flat_map(|wall| {
        let faces = wall.points_m.as_ref().map_or(1, |points| points.len() - 1);
        std::iter::repeat_n(wall.name.clone().unwrap_or_default(), faces)
    });
    names.collect()
}

fn half_plane(wall: &WallConfig) -> Face {
    let [x, y, nx, ny] = [wall.x_m, wall.y_m, wall.nx, wall.ny].map(Option::unwrap_or_default);
    let length = nx.hypot(ny);
    Face::HalfPlane {
        point: [x, y],
        normal: [nx / length, ny / length],
    }
}

/// Clusters in the order of their first disks; free grains keep the order in which they are listed.
fn clusters(config: &DisksConfig) -> Vec<ClusterMembers> {
    let mut clusters: Vec<(&String, ClusterMembers)> = Vec::new();
    let free = config.disks.iter().filter(|disk| !disk.glued);
    for (number, disk) in free.enumerate() {
        let Some(name) = &disk.cluster else {
            continue;
        };
        match clusters.iter_mut().find(|(known, _)| *known == name) {
            Some((_, members)) => members.disks.push(number),
            None => clusters.push((name, members(config, name, number))),
        }
    }
    clusters.into_iter().map(|(_, members)| members).collect()
}

fn members(config: &DisksConfig, name: &str, first: usize) -> ClusterMembers {
    let listed = config.clusters.iter().find(|c| c.name == name);
    let cluster = listed.cloned().unwrap_or_default();
    let drive = cluster.drive.as_ref();
    let prescribed = drive.map_or([None; 2], ClusterDriveConfig::velocity);
    ClusterMembers {
        name: name.to_string(),
        disks: vec![first],
        locked: cluster.holds(),
        mass: cluster.mass(),
        inertia: cluster.inertia_kg_m2,
        velocity: [
            prescribed[0].unwrap_or(cluster.vx_m_per_s),
            prescribed[1].unwrap_or(cluster.vy_m_per_s),
            cluster.spin_rad_per_s,
        ],
        drive: drive.map(|drive| Drive {
            name: name.to_string(),
            forces: drive.forces(),
            damping: drive.damping_n_s_per_m,
        }),
    }
}
