//! The grains that a feed brings in later, see [`dem_kernel::step::injection`].

use dem_kernel::bodies::disk::Disk;
use dem_kernel::random::RandomNumbers;

use crate::config::DemConfig;
use crate::sample::types::Sample;

/// Sets the random numbers of the fed grains apart from those of the sample.
const STREAM: u64 = 0x5165;

/// The grains of a feed, in store: as many as it takes, none for a scene without. `seed` is the run's.
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
    let mut grains = Vec::new();
    while left > 0.0 && !sample.free.is_empty() {
        let drawn = (random.unit() * sample.free.len() as f64) as usize;
        let radius = sample.free[drawn].radius;
        left -= config.real_mass(radius, thickness);
        grains.push(Disk::at_rest(centre, radius));
    }
    grains
}
