//! A disk that passes from one segment of a wall or surface to the next takes its force, spring, time under pressure and bond with it.
//!
//! A bond keeps its opening and its slip, so that the passage has no effect on energy: the difference of the gaps over the lines of the two segments
//! goes into its reference. If the disk already presses on the next segment, or is bonded to it, the bond cannot move and is torn.

use crate::bodies::positions::Positions;
use crate::contact::bond::{Bond, find_bond};
use crate::contact::detect::Slot;
use crate::contact::loss::Loss;
use crate::step::state::GrainState;

/// Moves contacts and bonds of disks that have passed to their next segments; slots and bonds are sorted by (a, b). Returns the losses of torn bonds
/// with their pairs.
pub fn hand_over(
    slots: &mut [Slot],
    bonds: &mut Vec<Bond>,
    (positions, state): (&Positions, &GrainState),
) -> Vec<([u32; 2], Loss)> {
    let bodies = positions.bodies;
    let (mut torn, mut moved) = (Vec::new(), Vec::new());
    for index in 0..slots.len() {
        let slot = slots[index];
        let (a, start) = (slot.a as usize, slot.b as usize);
        if start < bodies.first_wall() {
            continue;
        }
        let bond = find_bond(bonds, (slot.a, slot.b));
        let idle = slot.force == [0.0; 2] && slot.spring == 0.0 && slot.attraction == 0.0;
        if bond.is_none() && idle {
            continue;
        }
        let mut passed = [start, start];
        // A disk may pass several short segments at once.
        while let Some(next) = positions.successor(a, passed[1])
            && next != passed[0]
        {
            passed = [passed[1], next];
        }
        let next = passed[1];
        if next == start {
            continue;
        }
        if let Some(bond) = bond {
            let pair = (slot.a, next as u32);
            let free = find(slots, pair).is_some_and(|there| slots[there].pressure() == [0.0; 2]);
            let gap = positions.proximity(a, next).gap;
            let before = positions.gap_over_line(a, start);
            match before.filter(|_| free && gap.is_finite() && find_bond(bonds, pair).is_none()) {
                Some(before) => {
                    bonds[bond].reference += gap - before;
                    moved.push((bond, next as u32));
                }
                None => {
                    let loss = bonds[bond]
                        .tear(&state.law_of(bodies, [slot.a, slot.b]), &mut slots[index]);
                    torn.push(([slot.a, slot.b], loss));
                }
            }
        }
        move_slot(slots, index, next);
    }
    if !(moved.is_empty() && torn.is_empty()) {
        moved.into_iter().for_each(|(bond, b)| bonds[bond].b = b);
        bonds.retain(|bond| bond.adhesion > 0.0);
        bonds.sort_by_key(Bond::pair);
    }
    torn
}

fn find(slots: &[Slot], pair: (u32, u32)) -> Option<usize> {
    slots.binary_search_by_key(&pair, |s| (s.a, s.b)).ok()
}

fn move_slot(slots: &mut [Slot], index: usize, body: usize) {
    let old = slots[index];
    slots[index] = Slot::new(old.a, old.b);
    let Some(target) = find(slots, (old.a, body as u32)) else {
        return;
    };
    let new = &mut slots[target];
    let attraction = new.attraction.max(old.attraction);
    if new.pressure() == [0.0; 2] {
        *new = Slot {
            a: new.a,
            b: new.b,
            ..old
        };
        new.force[0] += old.attraction - attraction;
        new.attraction = attraction;
        return;
    }
    // The other side of a concave corner: it keeps the energy of both.
    let share = (1.0 + new.joined) / (1.0 + old.joined);
    let both = |new: f64, old: f64| (new * new + share * old * old).sqrt();
    new.last_gap = -both(new.last_gap.min(0.0), old.last_gap.min(0.0));
    new.spring = both(new.spring, old.spring).copysign(new.spring + share * old.spring);
    new.force = [0, 1].map(|k| new.pressure()[k] + old.pressure()[k]);
    new.force[0] -= attraction;
    new.attraction = attraction;
}
