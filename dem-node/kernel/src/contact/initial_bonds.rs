//! The bonds at the start.

use crate::bodies::Bodies;
use crate::bodies::positions::Positions;
use crate::contact::bond::Bond;
use crate::contact::detect::{Slot, VerletList};
use crate::law::cohesion::Cohesion;

/// Bonds all pairs of grains, including glued disks and disks of a bonded face, that are nearer than the alert distance of the law. Then bonds grains
/// with too few bonds to their nearest neighbours.
///
/// A grain that carried nothing in the pressed bed may end up with one bond. Such a grain stands on its bond as on a pin, and rolls under the wheel
/// instead of sliding: one grain under 184 of 8 000 N made the friction loop 7 % larger.
pub fn initial_bonds(positions: &Positions, list: &VerletList) -> Vec<Bond> {
    let bodies = positions.bodies;
    let Some(law) = &bodies.law.cohesion else {
        return Vec::new();
    };
    let bondable = bondable(bodies) as u32;
    let grains = list.slots.iter().filter(|slot| slot.b < bondable);
    let bond = |slot: &Slot| {
        let gap = positions.proximity(slot.a as usize, slot.b as usize).gap;
        (gap < law.alert).then(|| Bond::new(bodies, law, [slot.a, slot.b], gap))
    };
    let mut bonds = grains.filter_map(bond).collect();
    if law.bonds_min > 0 {
        hold_loose_grains(positions, law, &mut bonds);
    }
    bonds
}

/// Number of the disks that can have bonds.
fn bondable(bodies: &Bodies) -> usize {
    if bodies.face_bonded {
        bodies.disks()
    } else {
        bodies.first_face()
    }
}

/// The bonds of the alert distance decide alone which grains lack bonds, so that the order of the grains does not.
fn hold_loose_grains(positions: &Positions, law: &Cohesion, bonds: &mut Vec<Bond>) {
    let bodies = positions.bodies;
    let mut count = vec![0; bodies.disks()];
    for bond in bonds.iter() {
        count[bond.a as usize] += 1;
        count[bond.b as usize] += 1;
    }
    let made = (0..positions.present).flat_map(|grain| {
        let missing = law.bonds_min.saturating_sub(count[grain]);
        let pairs = nearest(positions, bonds, grain as u32, missing).into_iter();
        pairs.map(|(pair, gap)| Bond::new(bodies, law, pair, gap))
    });
    let made: Vec<Bond> = made.collect();
    bonds.extend(made);
    bonds.sort_by_key(Bond::pair);
    bonds.dedup_by_key(|bond| bond.pair());
}

/// The `count` pairs of smallest gap (m) of a grain with disks to which it has no bond.
fn nearest(
    positions: &Positions,
    bonds: &[Bond],
    grain: u32,
    count: usize,
) -> Vec<([u32; 2], f64)> {
    if count == 0 {
        return Vec::new();
    }
    let pair = |other: u32| [grain.min(other), grain.max(other)];
    let gap = |[a, b]: [u32; 2]| positions.proximity(a as usize, b as usize).gap;
    let is_own = |bond: &&Bond| bond.a == grain || bond.b == grain;
    let own = bonds.iter().filter(is_own);
    let bonded: Vec<[u32; 2]> = own.map(|bond| [bond.a, bond.b]).collect();
    let store = positions.store();
    let mut pairs: Vec<_> = (0..bondable(positions.bodies) as u32)
        .filter(|other| !store.contains(&(*other as usize)))
        .filter(|other| {
            !positions
                .bodies
                .clusters
                .share(grain as usize, *other as usize)
        })
        .filter(|other| *other != grain && !bonded.contains(&pair(*other)))
        .map(|other| (pair(other), gap(pair(other))))
        .collect();
    let order = |a: &([u32; 2], f64), b: &([u32; 2], f64)| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0));
    if count < pairs.len() {
        pairs.select_nth_unstable_by(count, order);
        pairs.truncate(count);
    }
    pairs.sort_by(order);
    pairs
}
