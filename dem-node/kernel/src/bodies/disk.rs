//! A disk with its position and its velocity at the start.

use serde::{Deserialize, Serialize};

/// A disk of a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Disk {
    /// Centre (m).
    pub centre: [f64; 2],
    /// Radius (m).
    pub radius: f64,
    /// Velocity and spin at the start (m/s, m/s, rad/s).
    #[serde(skip)]
    pub velocity: [f64; 3],
}

impl Disk {
    /// A disk at rest.
    pub fn at_rest(centre: [f64; 2], radius: f64) -> Disk {
        Disk {
            centre,
            radius,
            velocity: [0.0; 3],
        }
    }
}

/// Numbers the grains column by column, so that neighbours lie close in memory.
pub fn in_columns(mut disks: Vec<Disk>) -> Vec<Disk> {
    let widest = disks.iter().map(|disk| disk.radius).fold(0.0, f64::max);
    let column = |disk: &Disk| (disk.centre[0] / (2.0 * widest)).floor();
    disks.sort_by(|a, b| {
        let by_column = column(a).total_cmp(&column(b));
        by_column.then(a.centre[1].total_cmp(&b.centre[1]))
    });
    disks
}
