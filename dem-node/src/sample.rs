//! Where the grains come from.

pub mod bed;
pub mod grading;
pub mod layer;
pub mod relax;

use crate::bodies::HalfPlane;
use crate::config::{Config, DisksConfig, LawKind, SampleConfig};
use crate::error::DemError;

/// A disk of a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Disk {
    /// Centre (m).
    pub centre: [f64; 2],
    /// Radius (m).
    pub radius: f64,
    /// Velocity and spin at the start (m/s, m/s, rad/s).
    pub velocity: [f64; 3],
}

/// Grains at rest in their places, ready to be loaded.
#[derive(Clone, Debug, Default)]
pub struct Sample {
    /// Grains that move by themselves.
    pub free: Vec<Disk>,
    /// Disks slaved to the wall below, by ascending x.
    pub glued: Vec<Disk>,
    /// Fixed walls.
    pub walls: Vec<HalfPlane>,
    /// Solid fraction of the packing (0 where it has no meaning).
    pub solid_fraction: f64,
}

/// Prepares the sample of a scenario. `seed` is the run's, which `sample.seed` overrides.
pub fn prepare(config: &Config, seed: u64) -> Result<Sample, DemError> {
    match &config.sample {
        SampleConfig::Disks(disks) => Ok(listed(disks)),
        SampleConfig::Layer(recipe) => layer::prepare(
            recipe,
            config.law.contact_stiffness_pa,
            // Rigid contacts must not overlap when their bond breaks.
            config.law.kind.plain() == LawKind::Cohesion
                && config.law.contact_stiffness_pa.is_some(),
            recipe.seed.unwrap_or(seed),
        ),
    }
}

fn listed(config: &DisksConfig) -> Sample {
    let pick = |glued: bool| {
        let chosen = config.disks.iter().filter(move |disk| disk.glued == glued);
        let disks = chosen.map(|disk| Disk {
            centre: [disk.x_m, disk.y_m],
            radius: disk.radius_m,
            velocity: [disk.vx_m_per_s, disk.vy_m_per_s, disk.spin_rad_per_s],
        });
        disks.collect::<Vec<_>>()
    };
    let mut glued = pick(true);
    glued.sort_by(|a, b| a.centre[0].total_cmp(&b.centre[0]));
    let walls = config.walls.iter().map(|wall| {
        let length = wall.nx.hypot(wall.ny);
        HalfPlane {
            point: [wall.x_m, wall.y_m],
            normal: [wall.nx / length, wall.ny / length],
        }
    });
    Sample {
        free: pick(false),
        glued,
        walls: walls.collect(),
        solid_fraction: 0.0,
    }
}
