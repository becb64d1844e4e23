//! Inertia of the grains, scaled or not, in a quasi-static motion of the wheel.

use crate::bounds::Bounds;
use crate::config::{Config, SampleConfig};
use crate::geometry::range;
use crate::sample::{Disk, Sample};
use crate::wheel::WheelProgram;

/// Two numbers that tell whether a scaled mass still lets the layer follow the wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassScaling {
    /// I = (V/H) d sqrt(rho/P) (GDR MiDi, Eur. Phys. J. E 14, 2004): V = 2 pi f A the highest speed of the wheel, H the height
    /// of the grains, d their mean diameter, rho the scaled density, P = `time.pressure_pa`. Quasi-static below 1e-3.
    pub inertial_number: f64,
    /// rho H (2 pi f)^2 A (Pa): shear stress that accelerates the height H with the wheel.
    pub pressure: f64,
}

impl MassScaling {
    /// The numbers of a scene whose wheel moves sideways.
    pub fn new(config: &Config, bounds: &Bounds, sample: &Sample) -> Option<MassScaling> {
        let program = WheelProgram(config.wheel?);
        let (speed, height) = (program.top_speed(), height(config, sample));
        if speed == 0.0 || height <= 0.0 {
            return None;
        }
        let density = config.density_kg_per_m3 * config.mass_scale;
        Some(MassScaling {
            inertial_number: speed / height * bounds.inertial_time,
            pressure: density * height * speed * program.angular_frequency(),
        })
    }
}

/// Height of the grains (m): the layer's own, or from the lowest to the highest point of the free disks.
fn height(config: &Config, sample: &Sample) -> f64 {
    if let SampleConfig::Layer(layer) = &config.sample {
        return layer.thickness_m;
    }
    let ends = |d: &Disk| [d.centre[1] - d.radius, d.centre[1] + d.radius];
    let [low, high] = range(sample.free.iter().flat_map(ends));
    high - low
}
