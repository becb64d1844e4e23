//! The rough face of a wheel: a row of touching disks.

#[cfg(test)]
mod tests;

use dem_kernel::bodies::disk::Disk;
use dem_kernel::random::RandomNumbers;

use crate::config::sample::SampleConfig;
use crate::config::wheel::{DemWheelConfig, FaceKind};

/// Disks of the face about its lowest point (m), by ascending x; empty for a smooth face.
///
/// They touch, their centres lie on a line, and the row is in the middle of the sample: as many disks of the sample's law as fit within its width.
/// `seed` is the run's, which the sample's seed overrides; the radii differ from the radii of the grains.
pub fn row(wheel: &DemWheelConfig, sample: &SampleConfig, seed: u64) -> Vec<Disk> {
    let rough = wheel.face == FaceKind::Disks;
    let Some((radii, most, own_seed)) = sample.wheel_row().filter(|_| rough) else {
        return Vec::new();
    };
    let mut random = RandomNumbers::new(!own_seed.unwrap_or(seed));
    let (mut row, mut width) = (Vec::new(), 0.0);
    loop {
        let radius = radii.at(random.unit());
        if width + 2.0 * radius > most {
            break;
        }
        row.push((width + radius, radius));
        width += 2.0 * radius;
    }
    let widest = row.iter().map(|(_, radius)| *radius).fold(0.0, f64::max);
    let disk = |(x, radius)| Disk::at_rest([x - 0.5 * width, widest], radius);
    row.into_iter().map(disk).collect()
}
