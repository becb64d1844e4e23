//! The grains that a feed brings in later, see [`dem_kernel::step::injection`].

use std::collections::HashSet;

use dem_kernel::bodies::disk::Disk;
use dem_kernel::random::RandomNumbers;

use crate::config::DemConfig;
use crate::sample::types::Sample;

/// Separates the random numbers of fed grains from the sample's.
const STREAM: u64 = 0x5165;

/// The grains of a feed, in store: as many as it needs, none for a scene without a feed. `seed` is the run's.
pub fn store(config: &DemConfig, thickness: f64, sample: &Sample, seed: u64) -> Vec<Disk> {
    let surface = &sample.surface;
    let (mut left, centre) = match (&config.injection, &config.detachment) {
        (None, None) => return Vec::new(),
        (Some(feed), _) => (
            feed.rate_kg_per_s * (feed.end_s - feed.start_s),
            [feed.x_m, feed.y_m],
        ),
        (None, Some(_)) => {
            let area = surface.deepest() * surface.bare_length();
            (
                area * thickness * config.density_kg_per_m3,
                surface.points[0],
            )
        }
    };
    let mut random = RandomNumbers::new(seed ^ STREAM);
    let (mut grains, radii) = (Vec::new(), radii(sample));
    while left > 0.0 && !radii.is_empty() {
        let drawn = (random.unit() * radii.len() as f64) as usize;
        let radius = radii[drawn];
        left -= config.real_mass(radius, thickness);
        grains.push(Disk::at_rest(centre, radius));
    }
    grains
}

/// Radii of the grains (m). A driven cluster counts as a body that moves the grains, unless all disks belong to driven clusters.
fn radii(sample: &Sample) -> Vec<f64> {
    let driven = sample.clusters.iter().filter(|c| c.drive.is_some());
    let driven: HashSet<usize> = driven.flat_map(|c| c.disks.iter().copied()).collect();
    let all = driven.len() == sample.free.len();
    let disks = sample.free.iter().enumerate();
    let grains = disks.filter(|(i, _)| all || !driven.contains(i));
    grains.map(|(_, disk)| disk.radius).collect()
}
