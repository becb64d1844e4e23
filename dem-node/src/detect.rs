//! Detection of pairs that may touch: linked cells, a Verlet list with a skin, and contact slots that persist.

use serde::{Deserialize, Serialize};

use crate::bodies::Bodies;
use crate::faces::Face;
use crate::geometry::{Period, between_points, range, squared_displacements};
use crate::positions::{Positions, distance};

/// A pair of bodies that may touch, with its memory from step to step.
///
/// Bodies are numbered free grains first, then glued disks, then the wheel, then the walls; `a < b` always,
/// and the normal points from `b` to `a`. Forces, not impulses, are kept: they stay right when the step changes.
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
    /// Gap, or opening of the bond, that the last step left along its normal (m); 0 without contact.
    pub left: f64,
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
    /// Position of the wheel when the list was built (m).
    wheel: [f64; 2],
    /// Time for which walls had moved when the list was built (s).
    wall_time: f64,
}

impl VerletList {
    /// Rebuilds the list when a pair outside of it may come closer than `alert` in a step in which no body
    /// moves further than `travel` (m); forces and springs of pairs that stay are carried over. Bonded pairs stay
    /// listed, however far apart.
    pub fn refresh(
        &mut self,
        bodies: &Bodies,
        positions: &Positions,
        travel: f64,
        bonded: impl Iterator<Item = (u32, u32)>,
    ) {
        let needed = bodies.alert + 2.0 * travel;
        if self.centres.len() == positions.centres.len()
            && needed + 2.0 * self.drift(bodies, positions) <= self.reach
        {
            return;
        }
        self.reach = needed + bodies.skin;
        self.centres.clear();
        self.centres.extend_from_slice(positions.centres);
        self.wheel = positions.wheel;
        self.wall_time = positions.wall_time;
        let mut listed = list_pairs(bodies, positions, self.reach);
        add_bonded(&mut listed, bonded);
        carry_over(&self.slots, &mut listed);
        self.slots = listed;
    }

    /// Makes the next refresh build a new list, as if a body had moved too far.
    pub(crate) fn invalidate(&mut self) {
        self.reach = 0.0;
    }

    /// Force and spring of a disk that has passed from one segment of a polyline to the next go along.
    pub fn hand_over(&mut self, bodies: &Bodies, positions: &Positions) {
        for index in 0..self.slots.len() {
            let slot = self.slots[index];
            let loaded = slot.force != [0.0; 2] || slot.spring != 0.0;
            let Some(wall) = bodies.wall_of(slot.b as usize).filter(|_| loaded) else {
                continue;
            };
            let centre = wall.frame(positions.centres[slot.a as usize], positions.wall_time);
            let successor = match &wall.face {
                Face::HalfPlane { .. } => None,
                Face::Segment(segment) => segment.successor(centre),
            };
            if let Some(next) = successor {
                self.move_slot(index, bodies.first_wall() + next);
            }
        }
    }

    fn move_slot(&mut self, index: usize, body: usize) {
        let old = self.slots[index];
        self.slots[index] = slot(old.a as usize, old.b as usize);
        let pair = (old.a, body as u32);
        let Ok(target) = self.slots.binary_search_by_key(&pair, |s| (s.a, s.b)) else {
            return;
        };
        let new = &mut self.slots[target];
        // One that is loaded already is a contact of its own: the other side of a concave corner.
        if new.force == [0.0; 2] {
            (new.force, new.spring, new.left) = (old.force, old.spring, old.left);
        }
    }

    /// Largest displacement of a body since the list was built (m).
    fn drift(&self, bodies: &Bodies, positions: &Positions) -> f64 {
        let squared = squared_displacements(positions.centres, &self.centres);
        let [x, y] = [0, 1].map(|k| positions.wheel[k] - self.wheel[k]);
        let farthest = squared.fold(0.0, f64::max).sqrt().max(x.hypot(y));
        match positions.wall_time - self.wall_time {
            0.0 => farthest,
            time => farthest.max(time * bodies.wall_speed()),
        }
    }

    /// All numbers that can change a later bit.
    pub fn for_each_number(&self, mut visit: impl FnMut(f64)) {
        visit(self.reach);
        visit(self.wheel[1]);
        // The x of a flat wheel is nowhere used, and 0.
        if self.wheel[0] != 0.0 {
            visit(self.wheel[0]);
        }
        if self.wall_time != 0.0 {
            visit(self.wall_time);
        }
        self.centres.iter().flatten().for_each(|x| visit(*x));
        for slot in &self.slots {
            visit(f64::from(slot.a));
            visit(f64::from(slot.b));
            visit(slot.force[0]);
            visit(slot.force[1]);
            visit(slot.spring);
            visit(slot.left);
        }
    }
}

fn list_pairs(bodies: &Bodies, positions: &Positions, reach: f64) -> Vec<Slot> {
    let mut slots = Vec::new();
    let mut near = NearPairs::new(
        positions.centres,
        &bodies.radii,
        bodies.free,
        reach,
        bodies.period,
    );
    let store = positions.store(bodies);
    for a in (0..store.start).chain(store.end..bodies.disks()) {
        let near = near.of(a).iter().map(|b| *b as usize);
        let near = near.filter(|b| !store.contains(b));
        let apart = near.filter(|b| !bodies.clusters.share(a, *b));
        slots.extend(apart.map(|b| slot(a, b)));
        // A rough face is met in its disks.
        let others = bodies.disks() + usize::from(!bodies.face.is_empty())..bodies.count();
        slots.extend(
            others
                .map(|b| slot(a, b))
                // A glued disk has no business with a fixed wall: neither of them can yield.
                .filter(|s| a < bodies.free || bodies.wall_of(s.b as usize).is_none())
                .filter(|s| distance(bodies, positions, a, s.b as usize) < reach),
        );
    }
    slots
}

fn slot(a: usize, b: usize) -> Slot {
    Slot {
        a: a as u32,
        b: b as u32,
        ..Slot::default()
    }
}

/// Adds the bonded pairs that are missing in a list sorted by (a, b).
fn add_bonded(slots: &mut Vec<Slot>, bonded: impl Iterator<Item = (u32, u32)>) {
    let listed = slots.len();
    for pair in bonded {
        let found = slots[..listed].binary_search_by_key(&pair, |s| (s.a, s.b));
        if found.is_err() {
            slots.push(slot(pair.0 as usize, pair.1 as usize));
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

/// Linked cells over disks: answers which disks of higher index are nearer than `reach` to a disk.
/// Pairs of two disks from `movable` on are left out.
pub struct NearPairs<'a> {
    centres: &'a [[f64; 2]],
    radii: &'a [f64],
    movable: usize,
    reach: f64,
    period: Option<Period>,
    origin: [f64; 2],
    /// Width and height of a cell (m).
    cell_size: [f64; 2],
    columns: usize,
    rows: usize,
    /// First entry of each cell in `members`.
    starts: Vec<u32>,
    members: Vec<u32>,
    found: Vec<u32>,
}

impl<'a> NearPairs<'a> {
    /// Sorts the disks into cells.
    pub fn new(
        centres: &'a [[f64; 2]],
        radii: &'a [f64],
        movable: usize,
        reach: f64,
        period: Option<Period>,
    ) -> Self {
        let [x, y] = [0, 1].map(|axis| range(centres.iter().map(|c| c[axis])));
        let mut origin = [x[0], y[0]];
        let (mut width, height) = (x[1] - x[0], y[1] - y[0]);
        if let Some(period) = period {
            (origin[0], width) = (period.left, period.length);
        }
        let widest = radii.iter().copied().fold(0.0, f64::max);
        // A grain that flew far away must not make the number of cells explode: four per disk suffice.
        let affordable = (width * height / (4.0 * centres.len() as f64)).sqrt();
        let along = width.max(height) / (4.0 * centres.len() as f64);
        let cell_size = (2.0 * widest + reach).max(affordable).max(along);
        let rows = 1 + (height / cell_size) as usize;
        // The columns of a strip fill it, none of them is cut.
        let (columns, cell_width) = match period {
            None => (1 + (width / cell_size) as usize, cell_size),
            Some(_) => {
                let columns = ((width / cell_size) as usize).max(1);
                (columns, width / columns as f64)
            }
        };
        let mut cells = NearPairs {
            centres,
            radii,
            movable,
            reach,
            period,
            origin,
            cell_size: [cell_width, cell_size],
            columns,
            rows,
            starts: vec![0; columns * rows + 1],
            members: vec![0; centres.len()],
            found: Vec::new(),
        };
        cells.fill();
        cells
    }

    fn fill(&mut self) {
        let cells: Vec<usize> = self.centres.iter().map(|c| self.cell(*c)).collect();
        for cell in &cells {
            self.starts[cell + 1] += 1;
        }
        for cell in 1..self.starts.len() {
            self.starts[cell] += self.starts[cell - 1];
        }
        let mut next = self.starts.clone();
        for (disk, cell) in cells.into_iter().enumerate() {
            self.members[next[cell] as usize] = disk as u32;
            next[cell] += 1;
        }
    }

    fn column_and_row(&self, centre: [f64; 2]) -> (usize, usize) {
        let x = self.period.map_or(centre[0], |p| p.inside(centre[0]));
        let index = |axis: usize, x: f64| ((x - self.origin[axis]) / self.cell_size[axis]) as usize;
        (
            index(0, x).min(self.columns - 1),
            index(1, centre[1]).min(self.rows - 1),
        )
    }

    fn cell(&self, centre: [f64; 2]) -> usize {
        let (column, row) = self.column_and_row(centre);
        row * self.columns + column
    }

    /// The disks with an index above `a` nearer than `reach` to it, in ascending order.
    pub fn of(&mut self, a: usize) -> &[u32] {
        let (column, row) = self.column_and_row(self.centres[a]);
        self.found.clear();
        for r in row.saturating_sub(1)..=(row + 1).min(self.rows - 1) {
            for [left, right] in self.columns_near(column) {
                // The cells of a row lie one after the other, and so do their members.
                let (first, last) = (r * self.columns + left, r * self.columns + right);
                for at in self.starts[first]..self.starts[last + 1] {
                    let b = self.members[at as usize] as usize;
                    if b > a && a < self.movable && self.is_near(a, b) {
                        self.found.push(b as u32);
                    }
                }
            }
        }
        self.found.sort_unstable();
        &self.found
    }

    /// Ranges of columns next to a column, itself included; the second is empty but at the seam of a strip.
    fn columns_near(&self, column: usize) -> impl Iterator<Item = [usize; 2]> + use<> {
        let last = self.columns - 1;
        let mut around = None;
        let mut near = [column.saturating_sub(1), (column + 1).min(last)];
        if self.period.is_some() && self.columns < 3 {
            near = [0, last];
        } else if self.period.is_some() && column == 0 {
            around = Some([last, last]);
        } else if self.period.is_some() && column == last {
            around = Some([0, 0]);
        }
        std::iter::once(near).chain(around)
    }

    fn is_near(&self, a: usize, b: usize) -> bool {
        let [dx, dy] = between_points(self.centres[a], self.centres[b], self.period);
        let reach = self.radii[a] + self.radii[b] + self.reach;
        dx * dx + dy * dy < reach * reach
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linked_cells_find_what_the_double_loop_finds() {
        let centres: Vec<[f64; 2]> = (0..60)
            .map(|i| [f64::from(i * 37 % 60), f64::from(i * i % 23)])
            .collect();
        let radii: Vec<f64> = (0..60).map(|i| 0.5 + f64::from(i % 4) * 0.4).collect();
        let mut near = NearPairs::new(&centres, &radii, 50, 0.3, None);
        for a in 0..60 {
            let expected: Vec<u32> = (a + 1..60)
                .filter(|b| a < 50 && near.is_near(a, *b))
                .map(|b| b as u32)
                .collect();
            assert_eq!(near.of(a), expected);
        }
    }

    #[test]
    fn linked_cells_of_a_strip_find_pairs_across_its_seam() {
        for length in [4.2, 8.0, 13.7, 60.0] {
            let period = Some(Period { left: -3.0, length });
            let centres: Vec<[f64; 2]> = (0..60)
                .map(|i| [f64::from(i * 37 % 60) * 1.7 - 40.0, f64::from(i * i % 23)])
                .collect();
            let radii: Vec<f64> = (0..60).map(|i| 0.3 + f64::from(i % 4) * 0.2).collect();
            let mut near = NearPairs::new(&centres, &radii, 60, 0.2, period);
            let mut wrapped = 0;
            for a in 0..60 {
                let expected: Vec<u32> = (a + 1..60)
                    .filter(|b| near.is_near(a, *b))
                    .map(|b| b as u32)
                    .collect();
                wrapped += expected.len();
                assert_eq!(near.of(a), expected, "length {length}");
            }
            assert!(wrapped > 0);
        }
    }

    #[test]
    fn a_stray_grain_does_not_blow_up_the_cells() {
        let mut centres = vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]];
        centres.push([1e9, -1e9]);
        let near = NearPairs::new(&centres, &[0.5; 4], 4, 0.1, None);
        assert!(near.columns * near.rows <= 100);
    }

    #[test]
    fn bonded_pairs_are_listed_however_far_apart() {
        let mut slots = vec![slot(0, 2), slot(1, 2), slot(3, 4)];
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
                ..slot(0, 3)
            },
            Slot {
                force: [7.0, 0.0],
                ..slot(2, 4)
            },
        ];
        let mut new = [slot(0, 2), slot(0, 3), slot(1, 2), slot(2, 4), slot(2, 5)];
        carry_over(&old, &mut new);
        assert_eq!(new.map(|s| s.force[0]), [0.0, 5.0, 0.0, 7.0, 0.0]);
        assert_eq!(new[1].spring, 2.0);
    }
}
