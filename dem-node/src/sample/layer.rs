//! The layer between rail and wheel, or between two bodies: a pressed bed, cut from below, that follows the crown.
//!
//! The order of the steps decides the contact profile (relative L2 error against FE alone): cut from below 5 to 6 %;
//! a thin layer pressed on a ready glued row 9 to 40 %, depending on the seed; cut from the top 45 to 57 %, because the wheel then meets a rough
//! face. A flat top would touch the wheel over its whole width; the layer is therefore shifted by the crown's drop.

use dem_kernel::bodies::disk::{Disk, in_columns};
use dem_kernel::bodies::geometry::{drop_at, range};
use dem_kernel::relax::Packing;

use crate::config::layer::LayerConfig;
use crate::error::DemError;
use crate::sample::bed::{self, Bed};
use crate::sample::types::Sample;

/// Stiffness of the bed's contacts over the highest pressure when the law is rigid: overlaps near 1e-3 r. Rigid grains then lose this part of their
/// radius, see [`release`].
const RIGID_BED_STIFFNESS: f64 = 1e3;
/// The released layer is at rest when no resultant exceeds this part of the mean contact force in the pressed bed.
const RELEASED: f64 = 1e-2;
const MAX_ITERATIONS: usize = 20_000;

/// Prepares a layer; `stiffness` is the contacts' over the thickness (Pa).
///
/// A `bonded` layer stays as it was shifted: its bonds take gaps and overlaps as their reference, and nothing is left to relax. If it relaxes first,
/// the overlaps on the flanks lift the top there and flatten the crown: the approach under 8 000 N is then 0.8 % below the approach of the rail
/// alone.
pub fn prepare(
    recipe: &LayerConfig,
    stiffness: Option<f64>,
    bonded: bool,
    seed: u64,
) -> Result<Sample, DemError> {
    let highest = recipe.press_pa.iter().copied().fold(0.0, f64::max);
    let bed_stiffness = stiffness.unwrap_or(RIGID_BED_STIFFNESS * highest);
    let bed = bed::press(&bed_of(recipe), bed_stiffness, seed)?;
    let (mut lid, mut ceiling) = (Vec::new(), recipe.thickness_m);
    let (mut free, mut glued) = if recipe.glued {
        cut(&bed.packing)
    } else {
        ceiling -= bed.packing.floor;
        (laid_down(&bed.packing), Vec::new())
    };
    if recipe.lid {
        (free, lid) = cut_above(recipe, free);
        ceiling = f64::INFINITY;
    }
    let on_top = lid.len();
    for row in [&mut glued, &mut lid] {
        row.sort_by(|a, b| a.centre[0].total_cmp(&b.centre[0]));
    }
    glued.extend(lid);
    (free, glued) = (follow(recipe, free), follow(recipe, glued));
    if !bonded {
        let overlap;
        (free, overlap) = release(recipe, &bed, free, &glued, ceiling);
        if stiffness.is_none() {
            shrink(&mut free, overlap);
        }
    }
    for disk in free.iter_mut().chain(&mut glued) {
        disk.centre[0] += recipe.x_m;
    }
    Ok(Sample {
        free: in_columns(free),
        glued,
        lid: on_top,
        solid_fraction: bed.solid_fraction,
        ..Sample::default()
    })
}

/// The bed of a layer. A layer that is also cut from above has a bed with the same extra height above as below; a layer that is not cut has a bed of
/// its own height.
fn bed_of(recipe: &LayerConfig) -> LayerConfig {
    let extra = recipe.bed_extra_m;
    LayerConfig {
        thickness_m: recipe.bed_height(),
        bed_extra_m: if recipe.glued { extra } else { 0.0 },
        ..recipe.clone()
    }
}

/// The uncut bed, its lower plate at y = 0.
fn laid_down(packing: &Packing) -> Vec<Disk> {
    let down = |mut disk: Disk| {
        disk.centre[1] -= packing.floor;
        disk
    };
    packing.disks().map(down).collect()
}

/// Cuts along the line of the lid, while the base is straight: disks wholly above are removed, disks whose centre is less than r below it are glued.
fn cut_above(recipe: &LayerConfig, free: Vec<Disk>) -> (Vec<Disk>, Vec<Disk>) {
    let height = |disk: &Disk| recipe.height_at(disk.centre[0]);
    free.into_iter()
        .filter(|disk| disk.centre[1] < height(disk) + disk.radius)
        .partition(|disk| disk.centre[1] <= height(disk) - disk.radius)
}

/// Cuts along y = 0: disks wholly below are removed, disks whose centre is less than r above it are glued.
fn cut(packing: &Packing) -> (Vec<Disk>, Vec<Disk>) {
    let above = packing.disks().filter(|disk| disk.centre[1] > -disk.radius);
    above.partition(|disk| disk.centre[1] >= disk.radius)
}

fn follow(recipe: &LayerConfig, mut disks: Vec<Disk>) -> Vec<Disk> {
    for disk in &mut disks {
        disk.centre[1] -= drop_at(disk.centre[0], recipe.crown_radius_m);
    }
    disks
}

/// Takes the side walls away and lets the grains relax under the wheel, which is held where the plate was, or between
/// their glued rows.
///
/// The shift along the crown leaves overlaps of up to a few micrometres on the flanks. Grains without support drift off slowly; there is no reason to
/// wait for them, so the number of iterations is bounded, not the drift. Returns the grains and the largest overlap that is left (m).
fn release(
    recipe: &LayerConfig,
    bed: &Bed,
    free: Vec<Disk>,
    glued: &[Disk],
    ceiling: f64,
) -> (Vec<Disk>, f64) {
    let all = || free.iter().chain(glued);
    let mut packing = Packing {
        centres: all().map(|disk| disk.centre).collect(),
        radii: all().map(|disk| disk.radius).collect(),
        movable: free.len(),
        period: bed.packing.period,
        ceiling,
        floor: if recipe.glued { f64::NEG_INFINITY } else { 0.0 },
        crown_radius: recipe.crown_radius_m,
        half_width: f64::INFINITY,
        thrust: None,
    };
    let tolerated = RELEASED * bed.mean_overlap;
    let (_, load) = packing.relax(MAX_ITERATIONS, |load| load.unbalanced() <= tolerated);
    let moved = free.iter().zip(packing.centres);
    let moved = moved.map(|(disk, centre)| Disk { centre, ..*disk });
    (moved.collect(), load.largest())
}

/// Makes the grains smaller until none overlaps. The first step would repair the overlaps of rigid grains with the
/// velocity g/h, and that threw the wheel 17 um up.
fn shrink(disks: &mut [Disk], overlap: f64) {
    let [smallest, _] = range(disks.iter().map(|disk| disk.radius));
    for disk in disks {
        disk.radius *= 1.0 - overlap / smallest;
    }
}
