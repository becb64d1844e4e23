//! Inertia of the grains, scaled or not, in a quasi-static motion of the wheel.

use dem_kernel::bodies::disk::Disk;
use dem_kernel::bodies::geometry::range;

use crate::config::DemConfig;
use crate::config::sample::SampleConfig;
use crate::sample::types::Sample;
use crate::setup::bounds::StepBounds;

/// Two numbers that show whether a layer of scaled mass still follows the wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassScaling {
    /// I = (V/H) d sqrt(rho/P) (GDR MiDi, Eur. Phys. J. E 14, 2004): V = 2 pi f A the highest speed of the wheel, H the height
    /// of the grains, d their mean diameter, rho the scaled density, P = `time.pressure_pa`. Quasi-static below 1e-3.
    pub inertial_number: f64,
    /// rho H (2 pi f)^2 A (Pa): shear stress that accelerates a layer of height H with the wheel.
    pub pressure: f64,
}

impl MassScaling {
    /// The numbers of a scene whose wheel moves sideways.
    pub fn new(config: &DemConfig, bounds: &StepBounds, sample: &Sample) -> Option<MassScaling> {
        let program = config.program()?;
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

/// Time in which the load could push the whole layer aside by a diameter, over the time until the wheel moves. `quick` has 0.04; the load on its rail
/// is off by 0.7 % at 0.13 (mass_scale 1e4), 3 % at 0.22 (3e4) and 26 % at 0.40 (1e5).
const SLUGGISH: f64 = 0.2;

/// Advice on a layer whose scaled mass m cannot follow the load P of its wheel: it moves by a mean diameter d in sqrt(2 d m / P),
/// which must be short compared with ramp and hold.
pub fn advice(config: &DemConfig, thickness: f64) -> Option<String> {
    let (SampleConfig::Layer(layer), Some(wheel)) = (&config.sample, &config.wheel) else {
        return None;
    };
    let area = 2.0 * layer.half_width_m * layer.thickness_m;
    let mass = config.density_kg_per_m3 * config.mass_scale * area * thickness;
    let (mean, _) = config.sample.radii();
    let follows = (4.0 * mean * mass / wheel.load_n).sqrt();
    let given = wheel.ramp_s + wheel.hold_s;
    (config.mass_scale > 1.0 && follows > SLUGGISH * given).then(|| {
        format!(
            "mass_scale: with {:e} the layer weighs {mass:.2e} kg, and a load of {} N moves it by a diameter in {follows:.1e} s, which is {:.2} of ramp and hold; above {SLUGGISH} its inertia bears part of the load: lower mass_scale, or load more slowly",
            config.mass_scale,
            wheel.load_n,
            follows / given
        )
    })
}

/// Part of a cycle that grains pressed out may need to leave. The wheel of `third-body-flow` sinks by 93 +- 60 um in three cycles at 0.30 (mass_scale
/// 1000), by 186 +- 73 um at 0.16 (300) and by 252 +- 55 um at 0.10 (100).
const LATE: f64 = 0.1;

/// Advice on a flow whose scaled grains cannot leave in time: under the pressure P at one end a layer of the length L leaves in
/// L sqrt(2 rho/P), L being its half-width; this time must be short compared with a cycle.
pub fn advice_on_flow(config: &DemConfig) -> Option<String> {
    let (SampleConfig::Layer(layer), Some(wheel)) = (&config.sample, &config.wheel) else {
        return None;
    };
    let density = config.density_kg_per_m3 * config.mass_scale;
    let leaves = layer.half_width_m * (2.0 * density / config.time.pressure_pa).sqrt();
    let share = leaves * wheel.frequency_hz;
    let counts = config.flow.is_some() && wheel.cycles > 0.0 && config.mass_scale > 1.0;
    (counts && share > LATE).then(|| {
        format!(
            "mass_scale: with {:e} grains that are pressed out need {leaves:.1e} s to leave the layer, {share:.2} of a cycle; above {LATE} inertia keeps them in, and the mass that leaves and the sinking of the wheel depend on mass_scale: lower it, and the step with its root",
            config.mass_scale
        )
    })
}

/// Advice on grains that may fly: gravity acts on the unscaled mass, so that a grain of scaled mass falls more slowly.
pub fn advice_on_flight(config: &DemConfig) -> Option<String> {
    let loose = matches!(&config.sample, SampleConfig::Disks(_)) && config.wheel.is_none();
    let [x, y] = config.gravity_m_per_s2;
    (loose && config.mass_scale > 1.0 && x.hypot(y) > 0.0).then(|| {
        format!(
            "mass_scale: with {:e} grains keep their weight and get more mass, so that flying and sliding grains fall at {:.2e} m/s2: only forces at rest follow gravity_m_per_s2; write mass_scale = 1 where grains move under their weight",
            config.mass_scale,
            x.hypot(y) / config.mass_scale
        )
    })
}

/// Height of the grains (m): the layer's own, or from the lowest to the highest point of the free disks.
fn height(config: &DemConfig, sample: &Sample) -> f64 {
    if let SampleConfig::Layer(layer) = &config.sample {
        return layer.thickness_m;
    }
    let ends = |d: &Disk| [d.centre[1] - d.radius, d.centre[1] + d.radius];
    let [low, high] = range(sample.free.iter().flat_map(ends));
    high - low
}
