//! A portion of a rail that consists of grains: a dense packing between plates, cut along crown and base.
//!
//! The disks start at the final solid fraction and are at rest when the root mean square of the unbalanced forces is small. A packing of this size
//! that is dropped in a looser box and pressed, like a layer, is not at rest after 80 000 steps of the relaxation. The largest unbalanced force is no
//! criterion: a single rattler decides it.

use std::f64::consts::PI;

use dem_kernel::bodies::disk::{Disk, in_columns};
use dem_kernel::bodies::geometry::drop_at;
use dem_kernel::contact::cells::NearPairs;
use dem_kernel::random::RandomNumbers;
use dem_kernel::relax::{Packing, PackingForces};

use crate::config::rail::RailConfig;
use crate::error::DemError;
use crate::sample::types::Sample;

/// Solid fraction of the box, just below the one at which p ~ r^-2 jams (0.8426).
const FRACTION: f64 = 0.84;
/// Height of the box above the crown and below the base, in mean diameters: the ordering along floor and ceiling stays out of the rail.
const MARGIN: f64 = 5.0;
/// Root mean square of the unbalanced forces over the mean contact force in a packing at rest.
const UNBALANCED: f64 = 1e-3;
/// Root mean square of the overlaps over the smallest radius below which a packing that is not jammed is at rest.
const APART: f64 = 1e-4;
const MAX_ITERATIONS: usize = 80_000;
/// Part of the radii that is taken off, for the overlaps that most contacts still have.
const SHRUNK: f64 = 3e-4;
/// Least part of the radii that a packing loses when it is too tight.
const SLACKENED: f64 = 1e-4;
/// Largest remaining overlap of two disks over the smaller radius.
const OVERLAP: f64 = 1e-3;

/// Prepares the rail. Its solid fraction is the area of the disks above the base over the area inside base, sides and crown.
pub fn prepare(recipe: &RailConfig, seed: u64) -> Result<Sample, DemError> {
    let mut packing = drop_disks(recipe, &mut RandomNumbers::new(seed));
    let slackened = settle(&mut packing, recipe.radius_min_m)?;
    let (free, mut glued) = cut(recipe, &packing);
    let mut free = in_columns(free);
    glued.sort_by(|a, b| a.centre[0].total_cmp(&b.centre[0]));
    let last = shrinkage(&free, &glued);
    for disk in free.iter_mut().chain(&mut glued) {
        disk.radius *= 1.0 - last;
    }
    let shrunk = 1.0 - slackened * (1.0 - last);
    Ok(Sample {
        solid_fraction: area_above(recipe.base(), free.iter().chain(&glued)) / recipe.area(),
        radii_shrunk: Some(shrunk),
        free,
        glued,
        ..Sample::default()
    })
}

/// Draws disks until they fill the box and places their centres at random in it, numbered so that neighbours lie close in
/// memory.
fn drop_disks(recipe: &RailConfig, random: &mut RandomNumbers) -> Packing {
    let (radii, half_width) = (recipe.radii(), 0.5 * recipe.width_m);
    let margin = MARGIN * 2.0 * radii.mean();
    let (floor, ceiling) = (recipe.base() - margin, margin);
    let target = FRACTION * recipe.width_m * (ceiling - floor);
    let mut disks = Vec::new();
    let mut filled = 0.0;
    while filled < target {
        let r = radii.at(random.unit());
        filled += PI * r * r;
        let x = random.between(r - half_width, half_width - r);
        let y = random.between(floor + r, ceiling - r);
        disks.push(Disk::at_rest([x, y], r));
    }
    let disks = in_columns(disks);
    Packing {
        centres: disks.iter().map(|disk| disk.centre).collect(),
        radii: disks.iter().map(|disk| disk.radius).collect(),
        movable: disks.len(),
        ceiling,
        floor,
        half_width,
        ..Packing::default()
    }
}

/// Lets the packing relax until it is at rest. Packings of few or of equal disks jam below [`FRACTION`]: as long as overlaps are too large, all radii
/// lose the mean overlap and the packing relaxes again. Without the largest overlap at once it would have no contacts left. Returns the remaining
/// part of the radii.
fn settle(packing: &mut Packing, smallest: f64) -> Result<f64, DemError> {
    let at_rest = |load: &PackingForces| {
        load.rms() <= APART * smallest || load.unbalanced_rms() <= UNBALANCED * load.mean()
    };
    let mean = packing.radii.iter().sum::<f64>() / packing.radii.len() as f64;
    let (mut left, mut spent) = (1.0, 0);
    loop {
        let (iterations, load) = packing.relax(MAX_ITERATIONS - spent, at_rest);
        spent += iterations;
        if !at_rest(&load) {
            return Err(DemError::RailNotAtRest {
                iterations: spent,
                unbalanced: load.unbalanced_rms() / load.mean(),
                needed: UNBALANCED,
            });
        }
        if load.largest() <= (OVERLAP + 2.0 * SHRUNK) * smallest {
            return Ok(left);
        }
        let part = 1.0 - (0.5 * load.mean() / mean).max(SLACKENED);
        packing.radii.iter_mut().for_each(|r| *r *= part);
        left *= part;
    }
}

/// Cuts along the crown, above which no centre stays, so that grains make the surface rough. Cuts along the base: disks wholly below are removed,
/// disks that cross it are glued. Returns free and glued disks.
fn cut(recipe: &RailConfig, packing: &Packing) -> (Vec<Disk>, Vec<Disk>) {
    let base = recipe.base();
    packing
        .disks()
        .filter(|disk| disk.centre[1] <= -drop_at(disk.centre[0], recipe.crown_radius_m))
        .filter(|disk| disk.centre[1] > base - disk.radius)
        .partition(|disk| disk.centre[1] >= base + disk.radius)
}

/// Part s to take off all radii: with an overlap o of two disks, o - s (r_a + r_b) is then at most the part [`OVERLAP`] of the smaller radius (1 - s)
/// r.
fn shrinkage(free: &[Disk], glued: &[Disk]) -> f64 {
    let all = || free.iter().chain(glued);
    let centres: Vec<[f64; 2]> = all().map(|disk| disk.centre).collect();
    let radii: Vec<f64> = all().map(|disk| disk.radius).collect();
    let mut near = NearPairs::new(&centres, &radii, free.len(), 0.0, None);
    let mut needed = SHRUNK;
    for a in 0..free.len() {
        for b in near.of(a).iter().map(|b| *b as usize) {
            let [dx, dy] = [0, 1].map(|k| centres[a][k] - centres[b][k]);
            let (sum, left) = (radii[a] + radii[b], OVERLAP * radii[a].min(radii[b]));
            let overlap = sum - (dx * dx + dy * dy).sqrt();
            needed = needed.max((overlap - left) / (sum - left));
        }
    }
    needed
}

/// Area of the parts of disks that lie above a height (m2): r^2 acos(-d/r) + d sqrt(r^2 - d^2), d being the height of the centre
/// above it.
fn area_above<'a>(height: f64, disks: impl Iterator<Item = &'a Disk>) -> f64 {
    let part = |disk: &Disk| {
        let r = disk.radius;
        let d = (disk.centre[1] - height).clamp(-r, r);
        r * r * (-d / r).acos() + d * (r * r - d * d).sqrt()
    };
    disks.map(part).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_area_above_a_line_is_all_half_or_none_of_a_disk() {
        for (y, part) in [(2.0, 1.0), (0.0, 0.5), (-2.0, 0.0)] {
            let disk = Disk {
                centre: [0.0, y],
                radius: 1.0,
                ..Disk::default()
            };
            let area = area_above(0.0, std::iter::once(&disk));
            assert!((area - part * PI).abs() < 1e-15, "{area}");
        }
    }
}
