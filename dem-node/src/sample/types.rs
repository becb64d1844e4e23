//! The grains of a sample.

use serde::{Deserialize, Serialize};

use dem_kernel::bodies::cluster::ClusterMembers;
use dem_kernel::bodies::disk::Disk;
use dem_kernel::bodies::faces::RigidWall;
use dem_kernel::bodies::surface::BareSurface;

/// Grains at rest, ready to be loaded. The file of a kept sample holds what its recipe makes: no face, no walls, no clusters.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Sample {
    /// Grains that move by themselves.
    pub free: Vec<Disk>,
    /// Disks slaved to the body below, by ascending x, then those slaved to the body above.
    pub glued: Vec<Disk>,
    /// Number of disks slaved to the body above.
    pub lid: usize,
    /// Disks of the wheel's face, about its lowest point.
    #[serde(skip)]
    pub face: Vec<Disk>,
    /// The surface beside the glued disks, or in their place.
    #[serde(skip)]
    pub surface: BareSurface,
    /// Rigid walls, polylines segment by segment.
    #[serde(skip)]
    pub walls: Vec<RigidWall>,
    /// Names of the walls, segment by segment; empty for a wall without a name.
    #[serde(skip)]
    pub wall_names: Vec<String>,
    /// Free grains that move together.
    #[serde(skip)]
    pub clusters: Vec<ClusterMembers>,
    /// Solid fraction of the packing (0 where it has no meaning).
    pub solid_fraction: f64,
    /// Part taken off all radii at the end, where the preparation reduces all alike.
    pub radii_shrunk: Option<f64>,
}
