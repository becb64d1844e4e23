//! A bed of disks between side walls, pressed against a flat plate until it is jammed.

use std::f64::consts::PI;

use dem_kernel::bodies::geometry::Period;
use dem_kernel::contact::graph::backbone;
use dem_kernel::random::RandomNumbers;
use dem_kernel::relax::Packing;

use crate::config::layer::LayerConfig;
use crate::error::DemError;

/// Solid fraction of a pressed bed of such disks; it sets the number of disks that are drawn.
const EXPECTED_FRACTION: f64 = 0.83;
/// Solid fraction at which the random disks are dropped: below jamming, so that their overlaps relax away.
const LOOSE_FRACTION: f64 = 0.75;
/// A frictionless packing at rest has 4 contacts per grain that carries load (2 unknowns, each contact shared by
/// two grains); 3.9 leaves room for the last decimals of the relaxation. A bed with 2 is a gas of chains.
const JAMMED: f64 = 3.9;
/// Largest unbalanced force over the mean contact force of a bed at rest.
const UNBALANCED: f64 = 1e-3;
const MAX_ITERATIONS: usize = 40_000;

/// A pressed bed whose upper plate stands at y = thickness of the layer.
pub struct Bed {
    /// The disks between their plates.
    pub packing: Packing,
    /// Area of the disks over the area between the plates.
    pub solid_fraction: f64,
    /// Mean overlap of the contacts under the last pressure (m).
    pub mean_overlap: f64,
}

/// Draws the disks, drops them between the walls and presses them. `stiffness` is the contacts' over the thickness (Pa).
pub fn press(recipe: &LayerConfig, stiffness: f64, seed: u64) -> Result<Bed, DemError> {
    let mut packing = drop_disks(recipe, &mut RandomNumbers::new(seed));
    let tolerated = 0.05 * recipe.radius_min_m;
    packing.relax(MAX_ITERATIONS, |load| load.largest() < tolerated);
    let mut mean_overlap = 0.0;
    for pressure in &recipe.press_pa {
        packing.thrust = Some(2.0 * packing.half_width * pressure / stiffness);
        let (iterations, load) = packing.relax(MAX_ITERATIONS, |load| load.is_balanced(UNBALANCED));
        mean_overlap = load.mean();
        if iterations == MAX_ITERATIONS {
            return Err(DemError::NotAtRest {
                pressure_pa: *pressure,
                iterations,
                unbalanced: load.unbalanced() / load.mean(),
                diameters: recipe.half_width_m / recipe.radii().mean(),
            });
        }
    }
    require_jammed(&packing)?;
    if let Some(period) = packing.period {
        for centre in &mut packing.centres {
            centre[0] = period.inside(centre[0]);
        }
    }
    Ok(Bed {
        solid_fraction: area(&packing.radii)
            / (2.0 * packing.half_width * (packing.ceiling - packing.floor)),
        packing,
        mean_overlap,
    })
}

/// Draws disks until they fill the bed and places their centres at random in a looser box under the plate.
fn drop_disks(recipe: &LayerConfig, random: &mut RandomNumbers) -> Packing {
    let width = 2.0 * recipe.half_width_m;
    let target = EXPECTED_FRACTION * width * (recipe.thickness_m + recipe.bed_extra_m);
    let mut radii = Vec::new();
    let mut filled = 0.0;
    while filled < target {
        let radius = recipe.radii().at(random.unit());
        filled += PI * radius * radius;
        radii.push(radius);
    }
    let period = recipe.periodic_x_m.map(Period::between);
    let ceiling = recipe.thickness_m;
    let floor = ceiling - filled / (LOOSE_FRACTION * width);
    let centres = radii.iter().map(|r| {
        // A strip has no side walls to keep away from.
        let margin = if period.is_some() { 0.0 } else { *r };
        let x = random.between(margin - recipe.half_width_m, recipe.half_width_m - margin);
        [x, random.between(floor + r, ceiling - r)]
    });
    Packing {
        centres: centres.collect(),
        movable: radii.len(),
        radii,
        period,
        ceiling,
        floor,
        half_width: recipe.half_width_m,
        ..Packing::default()
    }
}

fn area(radii: &[f64]) -> f64 {
    radii.iter().map(|r| PI * r * r).sum()
}

fn require_jammed(packing: &Packing) -> Result<(), DemError> {
    let coordination = coordination(packing);
    if coordination >= JAMMED {
        return Ok(());
    }
    Err(DemError::NotJammed {
        coordination,
        needed: JAMMED,
    })
}

/// Contacts per grain that carries load, times two; a contact with a plate counts once like any other. Grains with fewer than three contacts carry no
/// load (rattlers), nor do grains that only rattlers hold.
fn coordination(packing: &Packing) -> f64 {
    let [grains, contacts] = backbone(packing.movable, packing.contacts(), 3);
    2.0 * contacts as f64 / grains.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn packing(centres: Vec<[f64; 2]>) -> Packing {
        Packing {
            radii: vec![0.5; centres.len()],
            movable: centres.len(),
            centres,
            period: None,
            ceiling: f64::INFINITY,
            floor: 0.0,
            crown_radius: 0.0,
            half_width: f64::INFINITY,
            thrust: None,
        }
    }

    #[test]
    fn a_chain_in_equilibrium_is_no_packing() {
        let chain = packing(
            (0..10)
                .map(|i| [0.0, 0.499 + 0.998 * f64::from(i)])
                .collect(),
        );
        let error = require_jammed(&chain).expect_err("chains carry load at 2 contacts");
        assert!(error.to_string().contains("not jammed"), "{error}");
    }

    #[test]
    fn rattlers_and_grains_that_only_they_hold_do_not_count() {
        // A 4 x 4 square block on the floor: its corners have 2 contacts or 3, and peel off one after the other.
        let block = (0..16).map(|i| [0.998 * f64::from(i % 4), 0.499 + 0.998 * f64::from(i / 4)]);
        assert_eq!(coordination(&packing(block.collect())), 0.0);
    }
}
