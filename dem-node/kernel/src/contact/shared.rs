//! Springs that the contacts of one disk on several segments share.
//!
//! ```text
//!      ( o )             A disk that overlaps a concave corner presses on both of its sides. Where the corner lies outside of the
//!   _i__\_/__ j_/        disk these are two contacts; far inside, as on a polyline that is nearly straight, they are one. The
//!                        springs of i have the share 1 / (1 + sum_j c_ij), c_ij = (s_ij / max(d_i, d_j))^2, with the overlaps d
//!                        at the contacts and s at the shallowest corner between them.
//! ```
//!
//! A contact begins at a corner, s = d_j: the energy of both is then the energy of the first alone, k d_i^2 / 2, for any overlaps. A whole spring
//! each would create k d_j^2 / 2 out of nothing; a disk held by the nearest segment alone would sink into a surface that yields and bends around it.
//! The stored energy moves with the shares.
//!
//! A disk that is bonded to one of the segments has this contact only: a share of 0, `joined` infinite, is no contact. When the bond or the corner is
//! gone, the others touch at their present gaps, so that no energy is created.

use crate::bodies::positions::Positions;
use crate::contact::bond::{Bond, find_bond};
use crate::contact::detect::Slot;

/// Gives the contacts of each disk with segments of walls and surfaces their shares; slots and bonds are sorted by (a, b), and `missing` is the
/// length missing from the radius of a growing grain (m).
pub fn share_springs(
    slots: &mut [Slot],
    bonds: &[Bond],
    positions: &Positions,
    missing: impl Fn(u32) -> f64,
) {
    let (mut rest, bodies) = (slots, positions.bodies);
    while let Some(first) = rest
        .iter()
        .position(|s| s.b as usize >= bodies.first_wall())
    {
        let a = rest[first].a;
        let of_disk = rest[first..].iter().take_while(|slot| slot.a == a).count();
        let (on_faces, others) = rest[first..].split_at_mut(of_disk);
        if of_disk > 1 || on_faces[0].joined != 0.0 {
            share_among(on_faces, bonds, positions, missing(a));
        }
        rest = others;
    }
}

fn share_among(slots: &mut [Slot], bonds: &[Bond], positions: &Positions, missing: f64) {
    let a = slots[0].a as usize;
    let overlap = |slot: &Slot| {
        let law = positions.bodies.law_of(a, slot.b as usize);
        law.springs?;
        let gap = positions.proximity(a, slot.b as usize).gap + missing - slot.reference;
        (gap < 0.0).then_some(-gap)
    };
    let mut overlaps: Vec<f64> = slots.iter().map(|s| overlap(s).unwrap_or(0.0)).collect();
    let bonded = |slot: &Slot| find_bond(bonds, (slot.a, slot.b)).is_some();
    let bonded: Vec<bool> = slots.iter().map(bonded).collect();
    let presses = |slot: usize| bonded[slot] || overlaps[slot] > 0.0;
    let pressed = (0..slots.len()).filter(|slot| presses(*slot)).count();
    if pressed < 2 && slots.iter().all(|slot| slot.joined == 0.0) {
        return;
    }
    let mut pairs = Vec::new();
    for from in (0..slots.len()).filter(|slot| presses(*slot)) {
        let (mut at, mut shallowest) = (slots[from].b as usize, f64::INFINITY);
        while let Some((next, gap)) = positions.corner(a, at) {
            shallowest = shallowest.min(-gap - missing);
            if shallowest <= 0.0 || next == slots[from].b as usize {
                break;
            }
            let to = slots.binary_search_by_key(&(next as u32), |slot| slot.b);
            if let Some(to) = to.ok().filter(|to| presses(*to)) {
                pairs.push((from, to, shallowest));
            }
            at = next;
        }
    }
    let mut joined = vec![0.0; slots.len()];
    for (from, to, _) in &pairs {
        for (one, other) in [(*from, *to), (*to, *from)] {
            // A contact that stores energy keeps it and stays, next to the bond.
            let stores = slots[other].joined.is_finite() && slots[other].last_gap < 0.0;
            if bonded[one] && !bonded[other] && !stores {
                joined[other] = f64::INFINITY;
            }
        }
    }
    for ((slot, joined), overlap) in slots.iter_mut().zip(&joined).zip(&mut overlaps) {
        if slot.joined == f64::INFINITY && joined.is_finite() {
            // It touches at its present gap.
            slot.reference -= std::mem::take(overlap);
        }
    }
    for (from, to, depth) in pairs {
        if !(bonded[from] || bonded[to]) && overlaps[from].min(overlaps[to]) > 0.0 {
            let connection = (depth / overlaps[from].max(overlaps[to])).powi(2);
            joined[from] += connection;
            joined[to] += connection;
        }
    }
    divide(slots, &overlaps, &joined);
}

/// Sets the shares, and divides the stored energy of all springs among the contacts with a share.
fn divide(slots: &mut [Slot], overlaps: &[f64], joined: &[f64]) {
    let (mut stored, mut found, mut pull) = ([0.0; 2], [0.0; 2], 0.0);
    let changes = |slot: &Slot, joined: f64| slot.joined > 0.0 || joined > 0.0;
    let now = || overlaps.iter().zip(joined);
    for (slot, (overlap, joined)) in slots.iter().zip(now()) {
        if changes(slot, *joined) {
            let [before, after] = [slot.joined, *joined].map(|joined| 1.0 / (1.0 + joined));
            stored[0] += before * slot.last_gap.min(0.0).powi(2);
            stored[1] += before * slot.spring.powi(2);
            pull += before * slot.spring;
            found[0] += after * overlap.powi(2);
            found[1] += if *overlap > 0.0 { after } else { 0.0 };
        }
    }
    for (slot, (overlap, joined)) in slots.iter_mut().zip(now()) {
        if changes(slot, *joined) {
            let before = 1.0 / (1.0 + slot.joined);
            (slot.last_gap, slot.spring) = match *overlap {
                // If all have come apart, each keeps its own.
                0.0 if found[1] == 0.0 => {
                    (slot.last_gap * before.sqrt(), slot.spring * before.sqrt())
                }
                _ if *joined == f64::INFINITY => (0.0, 0.0),
                0.0 => (0.0, 0.0),
                overlap => (
                    -(stored[0] / found[0]).sqrt() * overlap,
                    (stored[1] / found[1]).sqrt().copysign(pull),
                ),
            };
        }
        slot.joined = *joined;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bodies::Bodies;
    use crate::bodies::faces::{Face, RigidWall, polyline};
    use crate::law::{Law, Springs};

    /// A disk of radius 1 deep in a corner, bonded to one side, then no more: the other side has no contact, and then touches at its present gap.
    #[test]
    fn a_contact_kept_out_by_a_bond_touches_at_its_present_gap() {
        let walls = polyline(&[[-5.0, 0.1], [0.0, 0.0], [5.0, 0.1]], 0);
        let wall = |segment| RigidWall {
            face: Face::Segment(segment),
            velocity: [0.0; 2],
        };
        let bodies = Bodies {
            free: 1,
            radii: vec![1.0],
            masses: vec![1.0],
            walls: walls.into_iter().map(wall).collect(),
            law: Law {
                springs: Some(Springs {
                    normal: 1.0,
                    tangential: 1.0,
                    damping: 0.0,
                }),
                ..Law::default()
            },
            ..Bodies::default()
        };
        let positions = Positions {
            taken: &[],
            bodies: &bodies,
            centres: &[[0.0, 0.9]],
            surface: &[],
            present: 1,
            wheel: [0.0; 2],
            wall_motion_time: 0.0,
        };
        let slot = |b, last_gap| Slot {
            b,
            last_gap,
            ..Slot::default()
        };
        let bond = Bond {
            b: 1,
            adhesion: 1.0,
            ..Bond::default()
        };
        let mut slots = [slot(1, -0.1), slot(2, 0.0)];
        let mut share = |bonds: &[Bond]| {
            share_springs(&mut slots, bonds, &positions, |_| 0.0);
            slots
        };
        let bonded = share(&[bond]);
        assert_eq!(bonded[0], slot(1, -0.1));
        assert_eq!(bonded[1].joined, f64::INFINITY);
        let [first, second] = share(&[]);
        assert_eq!(first, slot(1, -0.1));
        let gap = positions.proximity(0, 2).gap;
        assert!(
            gap < -0.09 && (second.reference - gap).abs() < 1e-15,
            "{second:?}"
        );
        assert_eq!((second.joined, second.last_gap), (0.0, 0.0));
    }
}
