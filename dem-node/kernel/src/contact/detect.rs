//! Detection of pairs that may touch: a Verlet list with a skin, and contact slots that persist.

use serde::{Deserialize, Serialize};

use crate::bodies::geometry::squared_displacements;
use crate::bodies::positions::Positions;
use crate::contact::cells::NearPairs;

/// A pair of bodies that may touch, with its memory from step to step.
///
/// Bodies are numbered free grains first, then glued disks, then the wheel, the walls and the surface; `a < b` always,
/// and the normal points from `b` to `a`. Forces, not impulses, are kept: they stay valid when the step changes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Slot {
    /// The candidate.
    pub a: u32,
    /// The antagonist.
    pub b: u32,
    /// Normal and tangential force of the last step (N), compression positive.
    pub force: [f64; 2],
    /// Elongation of the tangential spring (m).
    pub spring: f64,
    /// Gap, or opening of the bond, along its normal at the end of the last step (m); 0 without contact.
    pub last_gap: f64,
    /// Gap at which the pair of a broken bond touches (m), until it has come apart once; 0 for other pairs.
    pub reference: f64,
    /// Sum over the contacts of the disk on other segments with which it shares its springs: it has the share 1 / (1 + `joined`).
    pub joined: f64,
    /// Couple of rolling resistance on `a` (N m).
    pub couple: f64,
    /// Attraction by adhesion (N), included in `force`.
    pub attraction: f64,
    /// Time for which a pair without bond has been under the pressure at which it heals (s).
    pub pressed: f64,
}

impl Slot {
    /// The slot of a pair without memory.
    pub fn new(a: u32, b: u32) -> Slot {
        Slot {
            a,
            b,
            ..Slot::default()
        }
    }

    /// Contact force without the attraction, normal and tangential (N), for which contact and friction hold.
    pub fn pressure(&self) -> [f64; 2] {
        [self.force[0] + self.attraction, self.force[1]]
    }

    /// True for a pair that pressed or attracted each other in the last step, or touches where its bond broke.
    pub(crate) fn remembers(&self) -> bool {
        self.force != [0.0; 2] || self.attraction != 0.0 || self.reference != 0.0
    }

    /// Gap of the pair (m) at this distance of its surfaces. The pair of a broken bond touches at the bond's reference: at its surfaces it would have
    /// an overlap or a void that the bond did not have, which creates or absorbs energy. Once the pair has come apart, it touches at its surfaces.
    pub fn gap(&mut self, distance: f64) -> f64 {
        if distance > self.reference.max(0.0) {
            self.reference = 0.0;
        }
        distance - self.reference
    }
}

/// The Verlet list: all pairs that were closer than `reach` when it was built.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct VerletList {
    /// Sorted by (a, b).
    pub slots: Vec<Slot>,
    /// Gap up to which pairs were listed (m).
    reach: f64,
    /// Centres when the list was built (m).
    centres: Vec<[f64; 2]>,
    /// Points of the surface when the list was built (m).
    surface: Vec<[f64; 2]>,
    /// Position of the wheel when the list was built (m).
    wheel: [f64; 2],
    /// Time for which walls had moved when the list was built (s).
    wall_motion_time: f64,
}

impl VerletList {
    /// Rebuilds the list when a pair outside of it may come closer than `alert` in a step in which no body
    /// moves further than `travel` (m); forces and springs of pairs that stay are carried over. Bonded pairs, and pairs that touch at the reference
    /// of a broken bond, stay listed at any distance.
    pub fn refresh(
        &mut self,
        positions: &Positions,
        travel: f64,
        bonded: impl Iterator<Item = (u32, u32)>,
    ) {
        let bodies = positions.bodies;
        let needed = bodies.alert + 2.0 * travel;
        if self.centres.len() == positions.centres.len()
            && needed + 2.0 * self.drift(positions) <= self.reach
        {
            return;
        }
        self.reach = needed + bodies.skin;
        self.centres.clear();
        self.centres.extend_from_slice(positions.centres);
        self.surface.clear();
        self.surface.extend_from_slice(positions.surface);
        self.wheel = positions.wheel;
        self.wall_motion_time = positions.wall_motion_time;
        let mut listed = list_pairs(positions, self.reach);
        let touching = self.slots.iter().filter(|slot| slot.reference > 0.0);
        let touching = touching.map(|slot| (slot.a, slot.b));
        add_bonded(&mut listed, bonded.chain(touching));
        carry_over(&self.slots, &mut listed);
        self.slots = listed;
    }

    /// The pairs that press on each other, bonded or not.
    pub fn pressing(&self) -> impl Iterator<Item = &Slot> {
        self.slots.iter().filter(|slot| slot.pressure()[0] > 0.0)
    }

    /// Makes the next refresh build a new list, as if a body had moved too far.
    pub(crate) fn invalidate(&mut self) {
        self.reach = 0.0;
    }

    /// Largest displacement of a body since the list was built (m).
    fn drift(&self, positions: &Positions) -> f64 {
        let squared = squared_displacements(positions.centres, &self.centres);
        let squared = squared.chain(squared_displacements(positions.surface, &self.surface));
        let bodies = positions.bodies;
        let [mut x, y] = [0, 1].map(|k| positions.wheel[k] - self.wheel[k]);
        if bodies.rolls {
            // Pairs within this way are listed.
            x = if x.abs() < bodies.rolling_skin() {
                0.0
            } else {
                f64::INFINITY
            };
        }
        let farthest = squared.fold(0.0, f64::max).sqrt().max(x.hypot(y));
        match positions.wall_motion_time - self.wall_motion_time {
            0.0 => farthest,
            time => farthest.max(time * positions.bodies.wall_speed()),
        }
    }

    /// All numbers that can change a later bit.
    pub fn for_each_number(&self, mut visit: impl FnMut(f64)) {
        visit(self.reach);
        visit(self.wheel[1]);
        // The x of a flat wheel is not used, and 0.
        if self.wheel[0] != 0.0 {
            visit(self.wheel[0]);
        }
        if self.wall_motion_time != 0.0 {
            visit(self.wall_motion_time);
        }
        let both = self.centres.iter().chain(&self.surface);
        both.flatten().for_each(|x| visit(*x));
        for slot in &self.slots {
            let ([n, t], pair) = (slot.force, [slot.a, slot.b]);
            pair.into_iter().for_each(|body| visit(f64::from(body)));
            [n, t, slot.spring, slot.last_gap]
                .into_iter()
                .for_each(&mut visit);
            for (_, rare) in kit::named!(slot; reference, joined, couple, attraction, pressed) {
                if rare != 0.0 {
                    visit(rare);
                }
            }
        }
    }
}

/// The pairs that are closer than `reach` (m), by their numbers; two glued disks, and two disks of one cluster, are no pair.
pub fn list_pairs(positions: &Positions, reach: f64) -> Vec<Slot> {
    let bodies = positions.bodies;
    let mut slots = Vec::new();
    let mut near = NearPairs::new(
        positions.centres,
        &bodies.radii,
        bodies.free,
        reach,
        bodies.period,
    );
    let store = positions.store();
    let segments = bodies.surface.order(positions.surface);
    let there = (0..store.start).chain(store.end..bodies.disks());
    for a in there.filter(|a| !positions.is_taken(*a)) {
        let near = near.of(a).iter().map(|b| *b as usize);
        let near = near.filter(|b| !store.contains(b) && !positions.is_taken(*b));
        let apart = near.filter(|b| !bodies.clusters.share(a, *b));
        slots.extend(apart.map(|b| Slot::new(a as u32, b as u32)));
        // Contacts with a rough face are contacts with its disks.
        let others = bodies.disks() + usize::from(!bodies.face.is_empty())..bodies.first_segment();
        let [x, _] = positions.centres[a];
        let near = segments.near(x, bodies.radii[a] + reach).into_iter();
        let near = near.map(|segment| bodies.first_segment() + segment as usize);
        slots.extend(
            others
                .chain(near.filter(|_| a < bodies.free))
                .map(|b| Slot::new(a as u32, b as u32))
                // A glued disk and a fixed wall make no contact: neither can yield.
                .filter(|s| a < bodies.free || bodies.wall_of(s.b as usize).is_none())
                .filter(|s| positions.distance(a, s.b as usize) < reach),
        );
    }
    slots
}

/// Adds the bonded pairs that are missing in a list sorted by (a, b).
fn add_bonded(slots: &mut Vec<Slot>, bonded: impl Iterator<Item = (u32, u32)>) {
    let listed = slots.len();
    for pair in bonded {
        let found = slots[..listed].binary_search_by_key(&pair, |s| (s.a, s.b));
        if found.is_err() {
            slots.push(Slot::new(pair.0, pair.1));
        }
    }
    if slots.len() > listed {
        slots.sort_unstable_by_key(|s| (s.a, s.b));
    }
}

/// Copies forces and springs between two lists that are both sorted by (a, b).
fn carry_over(old: &[Slot], new: &mut [Slot]) {
    let mut rest = old.iter().peekable();
    for slot in new {
        while rest.next_if(|o| (o.a, o.b) < (slot.a, slot.b)).is_some() {}
        if let Some(same) = rest.next_if(|o| (o.a, o.b) == (slot.a, slot.b)) {
            *slot = *same;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bonded_pairs_are_listed_at_any_distance() {
        let mut slots = vec![Slot::new(0, 2), Slot::new(1, 2), Slot::new(3, 4)];
        add_bonded(&mut slots, [(0, 4), (1, 2), (2, 3)].into_iter());
        let pairs: Vec<(u32, u32)> = slots.iter().map(|s| (s.a, s.b)).collect();
        assert_eq!(pairs, [(0, 2), (0, 4), (1, 2), (2, 3), (3, 4)]);
    }

    #[test]
    fn forces_survive_a_new_list() {
        let old = [
            Slot {
                force: [5.0, 1.0],
                spring: 2.0,
                ..Slot::new(0, 3)
            },
            Slot {
                force: [7.0, 0.0],
                ..Slot::new(2, 4)
            },
        ];
        let mut new = [
            Slot::new(0, 2),
            Slot::new(0, 3),
            Slot::new(1, 2),
            Slot::new(2, 4),
            Slot::new(2, 5),
        ];
        carry_over(&old, &mut new);
        assert_eq!(new.map(|s| s.force[0]), [0.0, 5.0, 0.0, 7.0, 0.0]);
        assert_eq!(new[1].spring, 2.0);
    }
}
