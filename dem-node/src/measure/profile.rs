//! Profiles: velocity, solid fraction, stress and shear rate of the grains in slices, means over intervals of time.
//!
//! Grains are the free disks and the clusters that nothing drives. A disk counts in each slice with the part of its area
//! that lies there; velocities are means over areas. The stress is the contacts', compression positive, sigma_ij = -(1/V) sum f_i l_j, f being the
//! force on a grain and l from its centre to the contact (Love 1927; Weber 1966). Each l is divided among the slices that it crosses, so that in
//! equilibrium a slice of any thickness transmits the load beyond it. The stress of the velocity fluctuations is not included. Only intervals that
//! are over have results.

use std::fmt::Write as _;

use dem_kernel::bodies::Bodies;
use dem_kernel::bodies::geometry::range;
use dem_kernel::step::state::GrainState;
use serde::{Deserialize, Serialize};

use crate::config::profile::{ProfileAxis, ProfileConfig};
use crate::measure::loads::{Load, add_moment, ends, for_each_load, grains, shown};

kit::results! {
    /// # Profiles across a layer
    /// - `profile_solid_fraction`: Solid fraction, mean over the middle half of the layer and the last full interval.
    /// - `profile_shear_rate_per_s`: Shear rate, mean over the middle half of the layer and the last full interval.
    /// - `profile_normal_stress_pa`: Stress across the layer, the same mean as
    ///   `profile_shear_rate_per_s`.
    /// - `profile_shear_over_normal`: Shear stress over `profile_normal_stress_pa`: the effective friction of a plane shear flow.
    /// - `profile_inertial_number`: Inertial number, the same mean as `profile_shear_rate_per_s`.
    /// - `profile_granular_temperature_m2_per_s2`: Mean square of the grains' velocities about the
    ///   mean velocity of their slice, the same mean as `profile_shear_rate_per_s`.
    /// - `shear_localisation`: Share of the whole jump of velocity in the fifth of the layer where it is largest: 0.2 in a uniform shear, near 1
    ///   where a plug slides.
    /// - `shear_localisation_at`: Middle of the fifth of `shear_localisation`, 0 at the lower end of the layer and 1 at the upper end.
}

/// Sums over the steps of an interval in a slice.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct SliceSums {
    /// Area of grains (m2).
    area: f64,
    /// Area times velocity (m3/s).
    flow: [f64; 2],
    /// Area times the square of the velocity (m4/s2).
    squares: f64,
    /// f_i l_j (N m): xx, xy, yx, yy.
    moment: [f64; 4],
}

/// Means of a slice.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Slice {
    /// Start and end of the interval (s).
    times: [f64; 2],
    /// Middle of the slice (m).
    position: f64,
    /// Velocity (m/s), NaN without grains.
    velocity: [f64; 2],
    solid_fraction: f64,
    /// Stress (Pa): xx, xy, yx, yy.
    stress: [f64; 4],
    /// Derivative of the velocity across the axis along it (1/s).
    shear_rate: f64,
    /// <v.v> - <v>.<v> (m2/s2).
    temperature: f64,
}

/// The interval of the moment.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Interval {
    number: u64,
    /// Ends along the axis (m).
    ends: [f64; 2],
    /// Width across it (m).
    width: f64,
    /// Time of its steps so far (s), from the start of the first to the end of the last.
    times: [f64; 2],
    steps: u64,
    sums: Vec<SliceSums>,
    /// Sum of the velocities across the axis over steps (m/s), and number of summands, for the bodies that are not grains, below and above the
    /// middle.
    walls: [[f64; 2]; 2],
}

/// A profile with its sums so far.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct GrainProfile {
    interval: Option<Interval>,
    /// Slices of the intervals that are over.
    slices: Vec<Slice>,
    /// Mean velocities across the axis of the bodies below and above the grains in the last of these intervals (m/s).
    walls: [Option<f64>; 2],
}

impl GrainProfile {
    /// Adds the state at the end of a step that lasted from `start` to `end` (s); `thickness` in m.
    pub fn record(
        &mut self,
        config: &ProfileConfig,
        (bodies, state, thickness): (&Bodies, &GrainState, f64),
        [start, end]: [f64; 2],
    ) {
        let since = 0.5 * (start + end) - config.start_s;
        if since < 0.0 {
            return;
        }
        let number = (since / config.every_s) as u64;
        if self.interval.as_ref().is_some_and(|i| i.number != number) {
            self.close(config.axis, thickness);
        }
        let new = || Interval::new(config, bodies, state, number, start);
        let interval = self.interval.get_or_insert_with(new);
        interval.add(config.axis, bodies, state);
        interval.times[1] = end;
    }

    /// Ends the interval of the moment.
    fn close(&mut self, axis: ProfileAxis, thickness: f64) {
        if let Some(interval) = self.interval.take() {
            self.walls = interval.wall_speeds();
            self.slices.extend(interval.slices(axis, thickness));
        }
    }

    /// The slices of the intervals that are over, and of the interval of the moment if it is over or may be `open`.
    fn all(&self, config: &ProfileConfig, thickness: f64, open: bool) -> Vec<Slice> {
        let last = self.interval.iter();
        let last = last.filter(|interval| open || interval.is_over(config));
        let last = last.flat_map(|interval| interval.slices(config.axis, thickness));
        self.slices.iter().copied().chain(last).collect()
    }

    /// Advice on a run that ended within its first interval, and on one without grains to measure.
    pub fn advice(&self, config: &ProfileConfig) -> Option<String> {
        let slices = self.all(config, 1.0, false);
        let no_grains = slices.iter().all(|slice| slice.velocity[0].is_nan());
        if no_grains && !slices.is_empty() {
            return Some("profile: no slice held a grain, so that there are no results: driven clusters and glued disks are the walls of a profile, not its grains; add grains, or remove the key".into());
        }
        slices.is_empty().then(|| {
            format!(
                "profile: the run ended within its first interval of {:e} s from {:e} s on, so that there are no results; make profile.every_s shorter, or the run longer",
                config.every_s, config.start_s
            )
        })
    }

    /// The slices as CSV, a line each, also of an interval that the end of the run cut.
    pub fn csv(&self, config: &ProfileConfig, thickness: f64) -> String {
        let mut text = format!(
            "t0_s,t1_s,{}_m,vx_m_per_s,vy_m_per_s,solid_fraction,stress_xx_pa,stress_xy_pa,stress_yx_pa,stress_yy_pa,shear_rate_per_s,granular_temperature_m2_per_s2\n",
            ['x', 'y'][config.axis.index()]
        );
        for slice in self.all(config, thickness, true) {
            let numbers = (slice.times.into_iter().chain([slice.position]))
                .chain(slice.velocity)
                .chain([slice.solid_fraction])
                .chain(slice.stress)
                .chain([slice.shear_rate, slice.temperature]);
            let words: Vec<String> = numbers.map(|x| format!("{x:e}")).collect();
            let _ = writeln!(text, "{}", words.join(","));
        }
        text
    }

    /// Means over the middle half of the slices in the last full interval, and the localisation of its shear.
    ///
    /// - `profile_solid_fraction`, `profile_shear_rate_per_s`;
    /// - `profile_normal_stress_pa` along the axis, and `profile_shear_over_normal`, the size of the shear stress over it: the
    ///   effective friction of a plane shear flow;
    /// - `profile_granular_temperature_m2_per_s2`: mean square of the velocities about the mean velocities of their slices;
    /// - `shear_localisation`, the share of the whole jump of velocity in the fifth of the layer where it is largest, and
    ///   `shear_localisation_at`, the middle of that fifth;
    /// - `profile_inertial_number`: I = shear rate x sqrt(m/P), m being the mean mass of a grain over the thickness and P the
    ///   normal stress (da Cruz, Emam, Prochnow, Roux and Chevoir 2005).
    pub fn results(
        &self,
        config: &ProfileConfig,
        (bodies, state, thickness): (&Bodies, &GrainState, f64),
    ) -> Vec<(&'static str, f64)> {
        let all = self.all(config, thickness, false);
        let bins = config.bins as usize;
        let Some(last) = all.len().checked_sub(bins).map(|first| &all[first..]) else {
            return Vec::new();
        };
        let middle = &last[bins / 4..bins - bins / 4];
        let mean =
            |of: &dyn Fn(&Slice) -> f64| middle.iter().map(of).sum::<f64>() / middle.len() as f64;
        let (along, across) = (config.axis.index(), 1 - config.axis.index());
        let normal = mean(&|slice| slice.stress[3 * along]);
        let shear = mean(&|slice| slice.stress[2 * across + along]);
        let rate = mean(&|slice| slice.shear_rate);
        let solid = mean(&|slice| slice.solid_fraction);
        let temperature = mean(&|slice| slice.temperature);
        let masses = grains(bodies, state).map(|disk| bodies.masses[disk]);
        let masses: Vec<f64> = masses.filter(|mass| *mass > 0.0).collect();
        let mass = masses.iter().sum::<f64>() / masses.len() as f64 / thickness;
        let inertial = rate.abs() * (mass / normal).sqrt();
        let named = [
            ("profile_solid_fraction", solid),
            ("profile_shear_rate_per_s", rate),
            ("profile_normal_stress_pa", normal),
            ("profile_shear_over_normal", shear.abs() / normal),
            ("profile_inertial_number", inertial),
            ("profile_granular_temperature_m2_per_s2", temperature),
        ];
        let speeds: Vec<f64> = last.iter().map(|slice| slice.velocity[across]).collect();
        let over = self.interval.as_ref().filter(|open| open.is_over(config));
        let walls = over.map_or(self.walls, Interval::wall_speeds);
        let named = named.into_iter().chain(localisation(&speeds, walls));
        named.filter(|(_, x)| x.is_finite()).collect()
    }
}

impl Interval {
    fn new(
        config: &ProfileConfig,
        bodies: &Bodies,
        state: &GrainState,
        number: u64,
        start: f64,
    ) -> Interval {
        let axis = config.axis.index();
        let [low, high] = [axis, 1 - axis].map(|k| ends(bodies, state, k, grains(bodies, state)));
        Interval {
            number,
            ends: low,
            width: high[1] - high[0],
            times: [start; 2],
            steps: 0,
            sums: vec![SliceSums::default(); config.bins as usize],
            walls: [[0.0; 2]; 2],
        }
    }

    /// True if the middle of another step would lie beyond the interval.
    fn is_over(&self, config: &ProfileConfig) -> bool {
        let [start, end] = self.times;
        let next = end + 0.5 * (end - start) / self.steps as f64;
        next >= config.start_s + (self.number + 1) as f64 * config.every_s
    }

    fn add(&mut self, axis: ProfileAxis, bodies: &Bodies, state: &GrainState) {
        self.steps += 1;
        for disk in grains(bodies, state) {
            self.add_disk(axis, bodies, state, disk);
        }
        let middle = 0.5 * (self.ends[0] + self.ends[1]);
        for disk in walls(bodies) {
            let above = state.centres[disk][axis.index()] > middle;
            let [sum, count] = &mut self.walls[usize::from(above)];
            *sum += state.velocity_of(bodies, disk)[1 - axis.index()];
            *count += 1.0;
        }
        for_each_load(bodies, state, |load| {
            self.add_load(axis, bodies, state, load)
        });
    }

    fn add_disk(&mut self, axis: ProfileAxis, bodies: &Bodies, state: &GrainState, disk: usize) {
        let (radius, centre) = (bodies.radii[disk], shown(bodies, state.centres[disk]));
        let [vx, vy, _] = state.velocity_of(bodies, disk);
        let middle = centre[axis.index()];
        let edges = [middle - radius, middle + radius];
        for (bin, [low, high]) in self.crossed(edges) {
            let area =
                radius * radius * (cap((high - middle) / radius) - cap((low - middle) / radius));
            let sums = &mut self.sums[bin];
            sums.area += area;
            sums.flow[0] += area * vx;
            sums.flow[1] += area * vy;
            sums.squares += area * (vx * vx + vy * vy);
        }
    }

    /// Divides the moment of a load among the slices that its lever crosses.
    fn add_load(&mut self, axis: ProfileAxis, bodies: &Bodies, state: &GrainState, load: &Load) {
        let moment = load.moment();
        let along = axis.index();
        let own = state.centres[load.disk];
        let offset = shown(bodies, own)[along] - own[along];
        let ends = [load.centre[along] + offset, load.point[along] + offset];
        let [low, high] = range(ends);
        if low == high {
            let bin = self.bin_of(low);
            add_moment(&mut self.sums[bin].moment, 1.0, moment);
            return;
        }
        for (bin, [from, to]) in self.crossed([low, high]) {
            let part = (to - from) / (high - low);
            add_moment(&mut self.sums[bin].moment, part, moment);
        }
    }

    fn wall_speeds(&self) -> [Option<f64>; 2] {
        self.walls
            .map(|[sum, count]| (count > 0.0).then(|| sum / count))
    }

    fn thickness(&self) -> f64 {
        (self.ends[1] - self.ends[0]) / self.sums.len() as f64
    }

    /// The slice of a position; positions beyond the ends belong to the outermost slices.
    fn bin_of(&self, position: f64) -> usize {
        let bin = (position - self.ends[0]) / self.thickness();
        (bin.max(0.0) as usize).min(self.sums.len() - 1)
    }

    /// The slices that a piece of the axis crosses, with the part of the piece in each; the outermost slices extend to infinity.
    fn crossed(&self, [low, high]: [f64; 2]) -> impl Iterator<Item = (usize, [f64; 2])> + use<> {
        let (first, last) = (self.bin_of(low), self.bin_of(high));
        let (start, thickness) = (self.ends[0], self.thickness());
        let edge = move |bin: usize| start + bin as f64 * thickness;
        (first..=last).map(move |bin| {
            let from = if bin == first { low } else { edge(bin) };
            let to = if bin == last { high } else { edge(bin + 1) };
            (bin, [from, to])
        })
    }

    fn slices(&self, axis: ProfileAxis, thickness: f64) -> Vec<Slice> {
        let (pitch, steps) = (self.thickness(), self.steps as f64);
        let volume = pitch * self.width;
        let means = self.sums.iter().enumerate().map(|(bin, sums)| {
            let velocity = sums.flow.map(|flow| flow / sums.area);
            Slice {
                times: self.times,
                position: self.ends[0] + (bin as f64 + 0.5) * pitch,
                velocity,
                solid_fraction: sums.area / (steps * volume),
                stress: sums.moment.map(|m| -m / (steps * volume * thickness)),
                shear_rate: 0.0,
                temperature: sums.squares / sums.area
                    - velocity.iter().map(|v| v.powi(2)).sum::<f64>(),
            }
        });
        let mut slices: Vec<Slice> = means.collect();
        let across = 1 - axis.index();
        let speeds: Vec<f64> = slices.iter().map(|slice| slice.velocity[across]).collect();
        for (bin, slice) in slices.iter_mut().enumerate() {
            let (below, above) = (bin.saturating_sub(1), (bin + 1).min(speeds.len() - 1));
            slice.shear_rate = (speeds[above] - speeds[below]) / ((above - below) as f64 * pitch);
        }
        slices
    }
}

/// Bodies that are not grains: driven clusters and glued disks.
fn walls(bodies: &Bodies) -> impl Iterator<Item = usize> {
    let driven = bodies.clusters.driven();
    let driven = driven.flat_map(|(_, cluster, _)| &cluster.disks);
    driven.copied().chain(bodies.free..bodies.first_face())
}

/// Localisation of the shear, from the speeds of the slices and of the bodies below and above the layer (of the outermost slices without such
/// bodies): `shear_localisation`, the share of the whole jump of velocity in the fifth of the layer where it is largest, 0.2 in a uniform shear, and
/// `shear_localisation_at`, the middle of that fifth, 0 at the lower end of the layer and 1 at the upper end.
fn localisation(slices: &[f64], walls: [Option<f64>; 2]) -> Vec<(&'static str, f64)> {
    let ([first, .., last], width) = (slices, slices.len() / 5) else {
        return Vec::new();
    };
    let between = slices.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
    let edges = std::iter::once(walls[0].unwrap_or(*first)).chain(between);
    let edges: Vec<f64> = edges.chain([walls[1].unwrap_or(*last)]).collect();
    let jump = edges[edges.len() - 1] - edges[0];
    let fifths = edges.windows(width + 1);
    let shares = fifths.map(|fifth| (fifth[width] - fifth[0]) / jump);
    let largest = shares.enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
    let found = largest.filter(|_| width > 0).map(|(start, share)| {
        let middle = start as f64 + 0.5 * width as f64;
        [
            ("shear_localisation", share),
            ("shear_localisation_at", middle / slices.len() as f64),
        ]
    });
    found.into_iter().flatten().collect()
}

/// Area of the unit disk below a height (Archimedes' segment): s sqrt(1 - s^2) + asin s + pi/2 for -1 <= s <= 1.
fn cap(height: f64) -> f64 {
    let s = height.clamp(-1.0, 1.0);
    s * (1.0 - s * s).sqrt() + s.asin() + std::f64::consts::FRAC_PI_2
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(slices: &[f64], walls: [Option<f64>; 2]) -> [f64; 2] {
        let found = localisation(slices, walls);
        let [share, at] = &found[..] else {
            panic!("it has two numbers: {found:?}");
        };
        assert_eq!(
            (share.0, at.0),
            ("shear_localisation", "shear_localisation_at")
        );
        [share.1, at.1]
    }

    /// Ten slices between walls at 0 and 1: uniform shear, a plug that slips at the upper wall, a band in the middle.
    #[test]
    fn shear_is_found_where_the_velocity_jumps() {
        let walls = [Some(0.0), Some(1.0)];
        let uniform: Vec<f64> = (0..10).map(|k| (f64::from(k) + 0.5) / 10.0).collect();
        let [share, _] = found(&uniform, walls);
        assert!((share - 0.2).abs() < 1e-15);
        let [share, at] = found(&[0.0; 10], walls);
        assert_eq!((share, at), (1.0, 0.9));
        let band: Vec<f64> = (0..10).map(|k| f64::from(u8::from(k > 4))).collect();
        let [share, at] = found(&band, [None; 2]);
        assert_eq!(share, 1.0);
        assert!((at - 0.5).abs() <= 0.1, "{at}");
    }
}
