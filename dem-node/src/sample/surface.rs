//! Surfaces of the bodies that carry a sample, beside the glued rows or in their place.

use std::f64::consts::{PI, TAU};

use dem_kernel::bodies::disk::Disk;
use dem_kernel::bodies::geometry::{Period, between_disks, between_points};
use dem_kernel::bodies::surface::BareSurface;
use dem_kernel::random::RandomNumbers;

use crate::config::sample::{CutLine, SampleConfig};
use crate::config::surface::{RoughnessConfig, SPACING, SurfaceConfig};
use crate::sample::types::Sample;

/// Default reach of a surface beyond its layer, in mean radii.
pub(crate) const REACH: f64 = 9.0;
/// Waves of a rough profile.
const WAVES: usize = 256;

/// The surface of a prepared sample. `seed` is the run's.
///
/// Beside a glued row it begins where the last disk of the row ends. It closes gaps of the row into which the smallest grain would be pressed, so
/// that no grain falls in.
pub fn surface(config: &SampleConfig, sample: &Sample, seed: u64) -> BareSurface {
    let mean = mean_radius(sample);
    let Some(keys) = config.surface() else {
        return BareSurface::default();
    };
    let [width, _] = config.ends().unwrap_or_default();
    let width = width + REACH * mean;
    let ends = config.period_ends();
    let period = ends.map(Period::between);
    if let Some(points) = &keys.points_m {
        return BareSurface::new([std::slice::from_ref(points), &[]], period);
    }
    let width = keys.half_width_m.unwrap_or(width);
    let (base, lid) = sample.glued.split_at(sample.glued.len() - sample.lid);
    let spacing = keys.spacing_m.unwrap_or(SPACING * mean);
    let lines = lines_of(config, keys);
    let waves = keys.roughness.map(|rough| Waves::new(rough, seed, period));
    let make = |row: &[Disk], line: CutLine, side: f64| -> Vec<Vec<[f64; 2]>> {
        let height =
            |x: f64| line.height_at(x, side) + waves.as_ref().map_or(0.0, |waves| waves.at(x));
        let sides = [-width, width].map(|x| config.middle() + x);
        let pieces = pieces(row, ends, sides).into_iter();
        let point = |x: f64| [x, height(x)];
        let line = |[left, right]: [f64; 2]| {
            let count = ((right - left) / spacing).ceil().max(1.0) as usize;
            let x = |k: usize| left + (right - left) * k as f64 / count as f64;
            (0..=count).map(|k| point(x(k))).collect()
        };
        pieces.map(line).collect()
    };
    let below = make(base, lines[0], -1.0);
    let mut above = match lid {
        [] => Vec::new(),
        row => make(row, lines[1], 1.0),
    };
    above.iter_mut().for_each(|line| line.reverse());
    let mut surface = BareSurface::new([&below, &above], period);
    if config.cut_lines().is_some() {
        let free = sample.free.iter().map(|disk| disk.radius);
        let smallest = free.fold(f64::INFINITY, f64::min);
        for (first, row, line, side) in
            [(0, base, lines[0], -1.0), (base.len(), lid, lines[1], 1.0)]
        {
            for [a, b] in wide_gaps(row, smallest, period) {
                let offset = |i: usize| {
                    let [x, y] = row[i].centre;
                    [0.0, line.height_at(x, side) - y]
                };
                // The solid is on the right.
                let [a, b] = if side < 0.0 { [a, b] } else { [b, a] };
                surface.bridge([first + a, first + b], [offset(a), offset(b)]);
            }
        }
    }
    surface
}

/// Neighbours in a row with more room between them than this (m), also across the seam of a strip.
fn wide_gaps(row: &[Disk], room: f64, period: Option<Period>) -> Vec<[usize; 2]> {
    let pairs = (1..row.len()).map(|next| [next - 1, next]);
    let seam = period.filter(|_| row.len() > 2).map(|_| [row.len() - 1, 0]);
    let gap = |[a, b]: [usize; 2]| {
        let from_b = between_points(row[a].centre, row[b].centre, period);
        between_disks(from_b, row[a].radius + row[b].radius).gap
    };
    pairs.chain(seam).filter(|pair| gap(*pair) > room).collect()
}

/// Mean radius of grains and glued disks (m).
pub(crate) fn mean_radius(sample: &Sample) -> f64 {
    let disks = || sample.free.iter().chain(&sample.glued);
    let count = disks().count().max(1);
    disks().map(|disk| disk.radius).sum::<f64>() / count as f64
}

/// The lines of the bodies below and above, as [`dem_kernel::bodies::Bodies::lines`]: a glued disk of a layer lies on the line of its cut.
pub fn lines(config: &SampleConfig, sample: &Sample) -> [Vec<(usize, [f64; 2])>; 2] {
    let Some(keys) = config.surface() else {
        return Default::default();
    };
    let glued = sample.glued.len();
    let base = glued - sample.lid;
    let rows = [0..base, base..glued];
    let surface = &sample.surface;
    let points = [0..surface.base, surface.base..surface.points.len()];
    let cut = config.cut_lines().is_some();
    [0, 1].map(|side| {
        let line = lines_of(config, keys)[side];
        let up = [-1.0, 1.0][side];
        let disks = rows[side].clone().filter(|_| cut).map(|number| {
            let [x, _] = sample.glued[number].centre;
            (number, [x, line.height_at(x, up)])
        });
        let points = points[side].clone().map(|i| (glued + i, surface.points[i]));
        let mut all: Vec<(usize, [f64; 2])> = disks.chain(points).collect();
        all.sort_by(|a, b| a.1[0].total_cmp(&b.1[0]));
        all
    })
}

/// Intervals of x (m) of a surface with these ends: its whole width or the strip, or the parts beside a glued row.
fn pieces(row: &[Disk], strip: Option<[f64; 2]>, ends: [f64; 2]) -> Vec<[f64; 2]> {
    let (Some(first), Some(last)) = (row.first(), row.last()) else {
        return vec![strip.unwrap_or(ends)];
    };
    let [left, right] = [first.centre[0] - first.radius, last.centre[0] + last.radius];
    let beside = [[ends[0], left], [right, ends[1]]];
    let beside = beside.into_iter().filter(|[from, to]| from < to);
    beside.filter(|_| strip.is_none()).collect()
}

/// A sum of waves of random length and phase, the spectral form of a Gaussian process (Shinozuka and Deodatis 1991).
struct Waves {
    /// Amplitude of each (m).
    amplitude: f64,
    /// Wave number (1/m) and phase of each.
    waves: Vec<[f64; 2]>,
}

impl Waves {
    fn new(rough: RoughnessConfig, seed: u64, period: Option<Period>) -> Waves {
        let mut random = RandomNumbers::new(rough.seed.unwrap_or(seed));
        let spread = std::f64::consts::SQRT_2 / rough.correlation_m;
        let wave = |_| {
            // A normal number from two uniform numbers (Box and Muller 1958).
            let size = (-2.0 * (1.0 - random.unit()).ln()).sqrt();
            let mut number = spread * size * (TAU * random.unit()).cos();
            if let Some(period) = period {
                let turn = TAU / period.length;
                number = turn * (number / turn).round();
            }
            [number, random.between(-PI, PI)]
        };
        Waves {
            waves: (0..WAVES).map(wave).collect(),
            amplitude: rough.rms_m * (2.0 / WAVES as f64).sqrt(),
        }
    }

    fn at(&self, x: f64) -> f64 {
        let waves = self.waves.iter();
        let heights = waves.map(|[number, phase]| (number * x + phase).cos());
        self.amplitude * heights.sum::<f64>()
    }
}

/// The lines of the bodies below and above.
fn lines_of(config: &SampleConfig, keys: &SurfaceConfig) -> [CutLine; 2] {
    let flat = CutLine {
        height: 0.0,
        crown_radius: keys.crown_radius_m.unwrap_or(0.0),
    };
    config.cut_lines().unwrap_or([flat; 2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_wide_where_the_smallest_grain_would_be_pressed_in() {
        let disk = |x: f64| Disk {
            centre: [x, 0.0],
            radius: 1.0,
            ..Disk::default()
        };
        let row = [0.0, 2.0, 4.4, 7.0].map(disk);
        assert_eq!(wide_gaps(&row, 0.5, None), [[2, 3]]);
        let strip = Period::between([-1.0, 9.0]);
        assert_eq!(wide_gaps(&row, 0.5, Some(strip)), [[2, 3], [3, 0]]);
    }
}
