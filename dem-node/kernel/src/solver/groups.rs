//! Gauss-Seidel sweeps over contacts in groups of eight that share no body.
//!
//! Contacts of a group do not affect each other. Solving them side by side is the same as one after the other, and the compiler can use whole vector
//! registers. Contacts of glued disks and of the wheel are solved one by one.
//!
//! Contacts inside a block of [`super::partition`] come first, block beside block, then contacts across blocks.

mod grouping;
#[cfg(test)]
mod tests;

use super::contact::{BodyRecord, Contact, NO_BOND};
use super::partition::{Partition, Subdomain, for_each_subdomain};
use super::problem::Problem;
use super::residual::{Defect, Quad, Sums};
use super::rolling;
use crate::law::cohesion::Cohesion;
use crate::law::lanes::{self, widest};
use crate::law::vector::{normal_impulse, tangential_impulse};
use grouping::{EMPTY, Grouping, LANES};

/// Number of parts of the glued row under bonds that take turns, disk by disk: along the row each disk waits for its neighbour, and there are a tenth
/// more sweeps. With loose grains another order leads to another state, so the order along the row stays.
const GLUED_PARTS: usize = 4;

/// A number of each contact of a group.
type Doubles = lanes::Lanes<LANES>;

/// Eight contacts side by side.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
struct Group {
    /// Bodies, counted from the first of the subdomain.
    a: [u32; LANES],
    b: [u32; LANES],
    normal: [Doubles; 2],
    bias: [Doubles; 2],
    /// Lever of spin over the radius.
    lever: Doubles,
    /// 1/(W_nn + c_n) and 1/(W_tt + c_t); 0 in a lane without contact.
    inverse: [Doubles; 2],
    impulse: [Doubles; 2],
}

/// The bonds of a group, see [`crate::law::local::BondLaw`]: slip, coefficient of friction, and stiffness in shear and in tension; 0 in a lane
/// without contact.
#[derive(Clone, Copy, Debug, Default)]
struct GroupBonds {
    slip: Doubles,
    friction: Doubles,
    shear: Doubles,
    tension: Doubles,
    fall: GroupFall,
}

/// The numbers by which the bonds of a group fall, see [`crate::contact::bond::BondContact::fall`].
#[derive(Clone, Copy, Debug, Default)]
struct GroupFall {
    /// Adhesion at the start of the step.
    adhesion: Doubles,
    /// delta at detection (m), and delta_t/h at the start of the step (m/s).
    gap: Doubles,
    slip: Doubles,
}

impl GroupFall {
    /// 1 where the adhesion falls under these relative velocities (m/s), else 0.
    #[inline(always)]
    fn falls(&self, (law, h): &(Cohesion, f64), [u_n, u_t]: [Doubles; 2]) -> Doubles {
        let h = Doubles::splat(*h);
        let drive = law.drive(self.gap + h * u_n, h * (self.slip + u_t));
        let falls = |adhesion, drive| if law.holds(adhesion, drive) { 0.0 } else { 1.0 };
        self.adhesion.zip(drive, falls)
    }
}

/// Squares of a sweep, lane by lane: ||W dr||^2 and ||W r||^2.
type Squares = [Doubles; 2];

impl Group {
    /// Loads these contacts, and D of each. A lane without contact gets no impulse: it adds zeros to the first body of the subdomain.
    fn load(
        &mut self,
        contacts: &[Contact],
        members: &[u32; LANES],
        first: u32,
        diagonal: &mut [Doubles; 2],
    ) {
        if members.contains(&EMPTY) {
            (*self, *diagonal) = (Group::default(), [Doubles::default(); 2]);
        }
        for (k, member) in members.iter().enumerate() {
            let Some(contact) = contacts.get(*member as usize) else {
                continue;
            };
            (self.a[k], self.b[k]) = (contact.a - first, contact.b - first);
            let d = contact.diagonal();
            for axis in 0..2 {
                self.normal[axis].0[k] = contact.normal[axis];
                self.bias[axis].0[k] = contact.bias[axis];
                self.impulse[axis].0[k] = contact.impulse[axis];
                diagonal[axis].0[k] = d[axis];
            }
            self.lever.0[k] = contact.lever();
        }
        let one_over = |d: Doubles| d.zip(d, |d, _| if d == 0.0 { 0.0 } else { 1.0 / d });
        self.inverse = diagonal.map(one_over);
    }

    /// Loads the bonds of these contacts; the diagonal of the contact in compression replaces its own.
    fn take_bonds(&mut self, problem: &Problem, members: &[u32; LANES], bonds: &mut GroupBonds) {
        if members.contains(&EMPTY) {
            *bonds = GroupBonds::default();
        }
        for (k, member) in members.iter().enumerate() {
            let Some(contact) = problem.contacts.get(*member as usize) else {
                continue;
            };
            let bond = &problem.bonds[contact.bond as usize];
            let (law, compressed) = (&bond.law, &contact.law);
            bonds.fall.adhesion.0[k] = bond.adhesion[0];
            (bonds.fall.gap.0[k], bonds.fall.slip.0[k]) = (contact.gap, bond.slip());
            (bonds.slip.0[k], bonds.friction.0[k]) = (law.slip, compressed.friction);
            (bonds.shear.0[k], bonds.tension.0[k]) = (law.shear, law.tension);
            self.inverse[0].0[k] = compressed.inverse.nn;
            self.inverse[1].0[k] = compressed.inverse.tt;
        }
    }

    /// W in either direction, without springs, the impulse that each contact wants by its own law, and its velocity u. With W_nt = 0 the closed
    /// solution of [`crate::law::LocalLaw`] is r_n = max(0, -b_n / D_n), r_t = -b_t / D_t within +-mu r_n, D the diagonal of W with its springs and
    /// b = u + bias - W r; a bond has the solution of [`crate::law::local::BondLaw::impulse`].
    #[inline(always)]
    fn wanted<const FRICTION: bool>(
        &self,
        records: &[BodyRecord],
        friction: Doubles,
        bonds: Option<&GroupBonds>,
    ) -> [[Doubles; 2]; 3] {
        let [mut dx, mut dy, mut ds, mut w] = [[0.0; LANES]; 4];
        for k in 0..LANES {
            let (a, b) = (&records[self.a[k] as usize], &records[self.b[k] as usize]);
            dx[k] = a.velocity[0] - b.velocity[0];
            dy[k] = a.velocity[1] - b.velocity[1];
            ds[k] = a.velocity[2] + b.velocity[2];
            w[k] = a.inverse_mass + b.inverse_mass;
        }
        let [dx, dy, ds, w] = [dx, dy, ds, w].map(lanes::Lanes);
        let ([nx, ny], [old_n, old_t]) = (self.normal, self.impulse);
        let u_n = nx * dx + ny * dy;
        let b_n = u_n + self.bias[0] - w * old_n;
        let r_n = match bonds {
            None => normal_impulse(b_n, self.inverse[0]),
            Some(bonds) => {
                let pressed = self.inverse[0].zip(b_n, |x, b| if b < 0.0 { x } else { 0.0 });
                let pulled = bonds.tension.zip(b_n, |x, b| if b < 0.0 { 0.0 } else { x });
                -b_n * (pressed + pulled)
            }
        };
        if !FRICTION {
            return [[w, Doubles::default()], [r_n, old_t], [u_n, u_n]];
        }
        let (one, two) = (Doubles::splat(1.0), Doubles::splat(2.0));
        let lever = self.lever;
        let w_t = (one + two * lever * lever) * w;
        let u_t = nx * dy - ny * dx - lever * ds;
        let b_t = u_t + self.bias[1] - w_t * old_t;
        let r_t = match bonds {
            None => tangential_impulse(-b_t * self.inverse[1], friction * r_n),
            Some(bonds) => {
                let pull = bonds.shear * (b_t + bonds.slip);
                let trial = -(b_t - w_t * pull) * self.inverse[1];
                let pressure = r_n.zip(b_n, |r, b| if b < 0.0 { r } else { 0.0 });
                let r_f = tangential_impulse(trial, bonds.friction * pressure);
                r_f - pull - bonds.shear * w_t * r_f
            }
        };
        [[w, w_t], [r_n, r_t], [u_n, u_t]]
    }

    /// Adds the defects of the contacts, in the order of [`Sums::join`]; D is their diagonal with springs. Returns their velocities u.
    #[inline(always)]
    fn look<const FRICTION: bool>(
        &self,
        records: &[BodyRecord],
        friction: Doubles,
        (bonds, diagonal): (Option<&GroupBonds>, &[Doubles; 2]),
        sums: &mut [Doubles; 8],
    ) -> [Doubles; 2] {
        let [w, wanted, u] = self.wanted::<FRICTION>(records, friction, bonds);
        let half = Doubles::splat(0.5);
        let [mut dv_dv, mut rr] = [Doubles::default(); 2];
        for axis in 0..2 {
            let (w, d, r, new) = (w[axis], diagonal[axis], self.impulse[axis], wanted[axis]);
            let (missing, size) = (d * (r - new), d * r);
            let (dv, mean) = (w * (new - r), half * (r + new));
            let (of_r, of_new) = (w * r, w * new);
            sums[0] = sums[0] + missing * missing;
            sums[1] = sums[1] + size * size;
            sums[4] = sums[4] + half * (of_r * of_r + of_new * of_new);
            sums[6] = sums[6] + half * (of_r * r + of_new * new);
            sums[7] = sums[7] + mean * dv;
            dv_dv = dv_dv + dv * dv;
            rr = rr + mean * mean;
        }
        let one = Doubles::splat(1.0);
        sums[2] = sums[2] + one.zip(rr, |one, rr| if rr == 0.0 { 0.0 } else { one });
        sums[3] = sums[3] + dv_dv;
        sums[5] = sums[5] + dv_dv * rr;
        u
    }

    /// Solves each contact for its own impulse.
    #[inline(always)]
    fn solve<const FRICTION: bool>(
        &mut self,
        records: &mut [BodyRecord],
        friction: Doubles,
        bonds: Option<&GroupBonds>,
        squares: &mut Squares,
    ) {
        let [[w, w_t], [r_n, r_t], _] = self.wanted::<FRICTION>(records, friction, bonds);
        let ([nx, ny], [old_n, old_t]) = (self.normal, self.impulse);
        let step_n = r_n - old_n;
        let (mut px, mut py, mut turn) = (step_n * nx, step_n * ny, Doubles::default());
        add_squares(squares, w, [step_n, r_n]);
        self.impulse[0] = r_n;
        if FRICTION {
            let step_t = r_t - old_t;
            px = px - step_t * ny;
            py = py + step_t * nx;
            turn = Doubles::splat(2.0) * self.lever * step_t;
            add_squares(squares, w_t, [step_t, r_t]);
            self.impulse[1] = r_t;
        }
        for k in 0..LANES {
            let (px, py, turn) = (px.0[k], py.0[k], turn.0[k]);
            for (body, [px, py]) in [(self.a[k], [px, py]), (self.b[k], [-px, -py])] {
                let record = &mut records[body as usize];
                record.velocity[0] += record.inverse_mass * px;
                record.velocity[1] += record.inverse_mass * py;
                if FRICTION {
                    record.velocity[2] -= record.inverse_mass * turn;
                }
            }
        }
    }
}

/// Adds the squares of W dr and W r.
#[inline(always)]
fn add_squares(squares: &mut Squares, w: Doubles, [step, r]: [Doubles; 2]) {
    let [change, size] = [w * step, w * r];
    squares[0] = squares[0] + change * change;
    squares[1] = squares[1] + size * size;
}

/// Groups that are swept one after the other.
#[derive(Clone, Debug, Default)]
struct SweepList {
    /// Body from which on the groups count.
    first: usize,
    /// Contacts, then their groups.
    chosen: Vec<u32>,
    members: Vec<[u32; LANES]>,
    groups: Vec<Group>,
    /// D of each group, its diagonal with springs; 0 in a lane without contact.
    diagonals: Vec<[Doubles; 2]>,
    /// The bonds of each group of a list of bonded contacts; empty for other lists.
    bonds: Vec<GroupBonds>,
    /// Coefficients of friction of each group where temperature changes them; else empty.
    frictions: Vec<Doubles>,
    squares: Squares,
    /// Sums of the last measurement, in the order of [`Sums::join`].
    seen: [Doubles; 8],
    /// Contacts whose bonds fall at the last measurement; `None` before one.
    falling: Option<Vec<u32>>,
}

impl SweepList {
    fn clear(&mut self, first: usize) {
        self.first = first;
        self.chosen.clear();
        self.members.clear();
    }

    /// Groups the chosen contacts.
    fn sort(&mut self, problem: &Problem, grouping: &mut Grouping) {
        let (contacts, records) = (&problem.contacts[..], &problem.records[..]);
        grouping.sort(contacts, &self.chosen, records, &mut self.members);
    }

    /// Loads the numbers of its contacts.
    fn pack(&mut self, problem: &Problem, bonded: bool) {
        let contacts = &problem.contacts[..];
        let count = self.members.len();
        self.groups.resize(count, Group::default());
        self.diagonals.resize(count, Default::default());
        (self.bonds).resize(if bonded { count } else { 0 }, GroupBonds::default());
        self.falling = None;
        self.frictions.clear();
        // Bonds have coefficients of their own.
        let warm = !bonded && !problem.softening.is_empty();
        let first = self.first as u32;
        let groups = self.groups.iter_mut().zip(&mut self.diagonals);
        for (index, (members, (group, diagonal))) in self.members.iter().zip(groups).enumerate() {
            group.load(contacts, members, first, diagonal);
            if let Some(bonds) = self.bonds.get_mut(index) {
                group.take_bonds(problem, members, bonds);
            }
            if warm {
                let of = |member: &u32| {
                    contacts
                        .get(*member as usize)
                        .map_or(0.0, |c| c.law.friction)
                };
                self.frictions
                    .push(lanes::Lanes(members.each_ref().map(of)));
            }
        }
    }

    /// Loads the bonds of its contacts again.
    fn take_bonds(&mut self, problem: &Problem) {
        self.falling = None;
        let groups = self.groups.iter_mut().zip(&self.members);
        for ((group, members), bonds) in groups.zip(&mut self.bonds) {
            group.take_bonds(problem, members, bonds);
        }
    }

    /// `records` are the bodies' from the first on.
    fn sweep(&mut self, records: &mut [BodyRecord], friction: Option<f64>) {
        self.squares = match friction {
            Some(friction) => widest!(self.sweep_groups::<true>(records, friction)),
            None => widest!(self.sweep_groups::<false>(records, 0.0)),
        };
    }

    #[inline(always)]
    fn sweep_groups<const FRICTION: bool>(
        &mut self,
        records: &mut [BodyRecord],
        friction: f64,
    ) -> Squares {
        let mut squares = Squares::default();
        if self.frictions.is_empty() {
            for group in &mut self.groups {
                group.solve::<FRICTION>(records, Doubles::splat(friction), None, &mut squares);
            }
        }
        for (group, friction) in self.groups.iter_mut().zip(&self.frictions) {
            group.solve::<FRICTION>(records, *friction, None, &mut squares);
        }
        squares
    }

    /// The sweep over a list of bonded contacts.
    fn sweep_bonded(&mut self, records: &mut [BodyRecord]) {
        self.squares = widest!({
            let mut squares = Squares::default();
            for (group, bonds) in self.groups.iter_mut().zip(&self.bonds) {
                group.solve::<true>(records, Doubles::default(), Some(bonds), &mut squares);
            }
            squares
        });
    }

    /// Measures the defects of the contacts; `records` are the bodies' from the first on.
    fn look(&mut self, records: &[BodyRecord], friction: Option<f64>) {
        self.seen = widest!(match friction {
            Some(friction) => self.look_at::<true>(records, friction),
            None => self.look_at::<false>(records, 0.0),
        });
    }

    #[inline(always)]
    fn look_at<const FRICTION: bool>(&self, records: &[BodyRecord], friction: f64) -> [Doubles; 8] {
        let mut sums = [Doubles::default(); 8];
        for (index, (group, diagonal)) in self.groups.iter().zip(&self.diagonals).enumerate() {
            let own = self.frictions.get(index).copied();
            let friction = own.unwrap_or(Doubles::splat(friction));
            group.look::<FRICTION>(records, friction, (None, diagonal), &mut sums);
        }
        sums
    }

    /// The same for a list of bonded contacts, which fall by this law in this step (s).
    fn look_at_bonds(&mut self, records: &[BodyRecord], cohesion: Option<&(Cohesion, f64)>) {
        let mut falling = self.falling.take().unwrap_or_default();
        falling.clear();
        self.seen = widest!({
            let mut sums = [Doubles::default(); 8];
            let groups = self.groups.iter().zip(&self.diagonals);
            for ((group, diagonal), (bonds, members)) in
                groups.zip(self.bonds.iter().zip(&self.members))
            {
                let of = (Some(bonds), diagonal);
                // Bonds have coefficients of friction of their own.
                let u = group.look::<true>(records, Doubles::default(), of, &mut sums);
                let falls = cohesion.map_or(Doubles::default(), |law| bonds.fall.falls(law, u));
                if falls.any() {
                    let members = members.iter().zip(falls.0);
                    falling.extend(members.filter(|(_, falls)| *falls > 0.0).map(|(m, _)| *m));
                }
            }
            sums
        });
        self.falling = cohesion.map(|_| falling);
    }

    fn store(&self, contacts: &mut [Contact]) {
        for (group, members) in self.groups.iter().zip(&self.members) {
            for (k, member) in members.iter().enumerate() {
                if *member != EMPTY {
                    contacts[*member as usize].impulse =
                        [group.impulse[0].0[k], group.impulse[1].0[k]];
                }
            }
        }
    }
}

/// The part of a contact that determines its list and its group.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Pair {
    bodies: [u32; 2],
    /// True for a body that no impulse moves.
    fixed: [bool; 2],
    glued: bool,
    pair_law: u32,
    bond: u32,
    levers: u32,
}

impl Pair {
    #[inline(always)]
    fn of(contact: &Contact, problem: &Problem) -> Pair {
        let fixed = |body: u32| problem.records[body as usize].inverse_mass == 0.0;
        Pair {
            bodies: [contact.a, contact.b],
            fixed: [fixed(contact.a), fixed(contact.b)],
            glued: contact.glued,
            pair_law: contact.pair_law,
            bond: contact.bond,
            levers: contact.levers,
        }
    }
}

/// The contacts of a problem in the order in which they are swept.
#[derive(Clone, Debug, Default)]
pub struct Sweeper {
    /// The contacts that are sorted; the numbers of bodies, bonds, glued disks and feet, the first glued disk and the wheel.
    pairs: Vec<Pair>,
    counts: [usize; 6],
    subdomains: Vec<Subdomain<SweepList>>,
    /// Contacts between bodies of two subdomains.
    crossing: SweepList,
    /// Contacts of free grains with glued disks: turn of the disk, then contact, so that the contacts of a disk are consecutive.
    glued: Vec<(u32, u32)>,
    /// Contacts with a bond.
    bonded: SweepList,
    /// Contacts of the wheel, of clusters, and of pairs with a law of their own.
    wheel: Vec<u32>,
    clustered: Vec<u32>,
    grouping: Grouping,
    sorting: CountingSort,
}

impl Sweeper {
    /// Loads the contacts of a prepared problem. The same contacts as before keep their groups.
    pub fn load(&mut self, problem: &Problem) {
        let pairs = problem
            .contacts
            .iter()
            .map(|contact| Pair::of(contact, problem));
        let counts = [
            problem.records.len(),
            problem.bonds.len(),
            problem.boundary.disks(),
            problem.boundary.feet.len(),
            problem.first_glued,
            problem.wheel.unwrap_or(usize::MAX),
        ];
        if self.counts != counts || !self.pairs.iter().copied().eq(pairs.clone()) {
            self.counts = counts;
            self.pairs.clear();
            self.pairs.extend(pairs);
            self.sort(problem);
        }
        let inside = self.subdomains.iter_mut();
        let inside = inside.map(|subdomain| &mut subdomain.work);
        for list in inside.chain([&mut self.crossing]) {
            list.pack(problem, false);
        }
        self.bonded.pack(problem, true);
    }

    /// Puts the contacts into lists and groups.
    fn sort(&mut self, problem: &Problem) {
        let partition = Partition::new(problem.contacts.len(), problem.records.len());
        partition.assign(&mut self.subdomains);
        for subdomain in &mut self.subdomains {
            subdomain.work.clear(subdomain.bodies.start);
        }
        self.crossing.clear(0);
        self.glued.clear();
        self.bonded.clear(0);
        self.wheel.clear();
        self.clustered.clear();
        let loose = problem.bonds.is_empty();
        let parts = if loose { 1 } else { GLUED_PARTS };
        let places = problem.boundary.disks() + problem.boundary.feet.len();
        let length = places.div_ceil(parts);
        for (index, contact) in problem.contacts.iter().enumerate() {
            let plain = contact.glued || contact.bond != NO_BOND;
            let apart = contact.pair_law > 0 && !plain;
            let chosen = if apart || problem.levers.get(contact.levers as usize).is_some() {
                &mut self.clustered
            } else if problem.wheel == Some(contact.b as usize) {
                &mut self.wheel
            } else if contact.glued
                && let Some(disk) = problem.glued_index(contact.b as usize)
            {
                let turn = disk % length * parts + disk / length;
                self.glued.push((turn as u32, index as u32));
                continue;
            } else if problem.bonds.get(contact.bond as usize).is_some() {
                &mut self.bonded.chosen
            } else if let Some(shared) = partition.common(contact.a, contact.b) {
                &mut self.subdomains[shared].work.chosen
            } else {
                &mut self.crossing.chosen
            };
            chosen.push(index as u32);
        }
        self.sorting.sort(&mut self.glued);
        let inside = self.subdomains.iter_mut();
        let inside = inside.map(|subdomain| &mut subdomain.work);
        for list in inside.chain([&mut self.crossing, &mut self.bonded]) {
            list.sort(problem, &mut self.grouping);
        }
    }

    /// Loads the softer bonds of the loaded contacts.
    pub fn take_bonds(&mut self, problem: &Problem) {
        self.bonded.take_bonds(problem);
    }

    /// One pass over all contacts. Returns ||W dr||^2 and ||W r||^2, W the diagonal without springs.
    pub fn sweep(&mut self, problem: &mut Problem, parallel: bool) -> [f64; 2] {
        let mut squares = [0.0; 2];
        widest!({
            for run in self.glued.chunk_by(|one, next| one.0 == next.0) {
                solve_glued_disk(problem, run, &mut squares);
            }
        });
        let friction = (problem.friction > 0.0).then_some(problem.friction);
        let sweep = |subdomain: &mut Subdomain<SweepList>, records: &mut [BodyRecord]| {
            subdomain.work.sweep(records, friction)
        };
        for_each_subdomain(
            &mut self.subdomains,
            &mut problem.records[..],
            parallel,
            &sweep,
        );
        self.crossing.sweep(&mut problem.records, friction);
        self.bonded.sweep_bonded(&mut problem.records);
        for list in self.lists() {
            for (sum, lanes) in squares.iter_mut().zip(&list.squares) {
                *sum += lanes.sum();
            }
        }
        widest!({
            // Taken out for the pass: copying a contact instead of borrowing it costs as much as its arithmetic.
            let mut contacts = std::mem::take(&mut problem.contacts);
            for index in self.wheel.iter().chain(&self.clustered) {
                solve_contact(problem, &mut contacts[*index as usize], &mut squares);
            }
            problem.contacts = contacts;
        });
        if !problem.couples.is_empty() {
            self.store(problem);
            let (contacts, bodies) = (&problem.contacts, &mut problem.records);
            rolling::sweep(&mut problem.couples, contacts, bodies, &mut squares);
        }
        squares
    }

    /// Defect and criterion of the present impulses and velocities: [`super::residual::measured`] by groups.
    pub(super) fn measured(&mut self, problem: &mut Problem, parallel: bool) -> (Defect, Quad) {
        if !problem.couples.is_empty() {
            self.store(problem);
        }
        let friction = (problem.friction > 0.0).then_some(problem.friction);
        let records = &problem.records[..];
        let look = |subdomain: &mut Subdomain<SweepList>, ()| {
            let first = subdomain.bodies.start;
            subdomain.work.look(&records[first..], friction);
        };
        for_each_subdomain(&mut self.subdomains, (), parallel, &look);
        self.crossing.look(records, friction);
        self.bonded
            .look_at_bonds(records, problem.cohesion.as_ref());
        let mut sums = Sums::default();
        for list in self.lists() {
            sums.join(list.seen.map(lanes::Lanes::sum));
        }
        let glued = self.glued.iter().map(|(_, index)| index);
        for index in glued.chain(&self.wheel).chain(&self.clustered) {
            sums.add(problem, &problem.contacts[*index as usize]);
        }
        sums.measured(problem)
    }

    /// Contacts whose bonds may fall under the impulses of the last measurement; `None` where all bonds have to be tried.
    pub fn falling(&self, problem: &Problem) -> Option<Vec<u32>> {
        let mut falling = self.bonded.falling.clone()?;
        let glued = self.glued.iter().map(|(_, index)| index);
        let alone = glued.chain(&self.wheel).chain(&self.clustered);
        let bonded = |index: &&u32| problem.contacts[**index as usize].bond != NO_BOND;
        falling.extend(alone.filter(bonded));
        Some(falling)
    }

    /// Writes the impulses back.
    pub fn store(&self, problem: &mut Problem) {
        for list in self.lists() {
            list.store(&mut problem.contacts);
        }
    }

    fn lists(&self) -> impl Iterator<Item = &SweepList> {
        let inside = self.subdomains.iter().map(|subdomain| &subdomain.work);
        inside.chain([&self.crossing, &self.bonded])
    }
}

/// Buffers of a sort.
#[derive(Clone, Debug, Default)]
struct CountingSort {
    /// Position of the next pair of each first number.
    next: Vec<u32>,
    before: Vec<(u32, u32)>,
}

impl CountingSort {
    /// Sorts by the first numbers, which have a small range, and keeps the order of pairs with the same first number.
    fn sort(&mut self, pairs: &mut [(u32, u32)]) {
        let Some(least) = pairs.iter().map(|pair| pair.0).min() else {
            return;
        };
        self.next.clear();
        for (first, _) in &*pairs {
            let after = (first - least) as usize + 1;
            self.next.resize(self.next.len().max(after + 1), 0);
            self.next[after] += 1;
        }
        for key in 1..self.next.len() {
            self.next[key] += self.next[key - 1];
        }
        self.before.clear();
        self.before.extend_from_slice(pairs);
        for pair in &self.before {
            let next = &mut self.next[(pair.0 - least) as usize];
            pairs[*next as usize] = *pair;
            *next += 1;
        }
    }
}

/// Solves a contact by its prepared law, compliant boundary and wheel included.
#[inline(always)]
fn solve_contact(problem: &mut Problem, contact: &mut Contact, squares: &mut [f64; 2]) {
    let velocity = problem.relative_velocity(contact);
    let impulse = problem.local_solution(contact, velocity);
    let step = take_over(contact, impulse, squares);
    problem.apply(contact, step);
}

/// Solves the contacts of one glued disk in turn. Between them only the velocity of the disk itself is needed: the product with two columns of W_g is
/// computed once for all.
#[inline(always)]
fn solve_glued_disk(problem: &mut Problem, run: &[(u32, u32)], squares: &mut [f64; 2]) {
    let body = problem.contacts[run[0].1 as usize].b as usize;
    let Some(disk) = problem.glued_index(body) else {
        return;
    };
    let [vx, vy] = problem.boundary.velocity_of(disk);
    let block = problem.boundary.block(disk);
    let (mut velocity, mut total) = ([vx, vy, 0.0], [0.0; 2]);
    for (_, index) in run {
        let contact = &mut problem.contacts[*index as usize];
        let grain = &mut problem.records[contact.a as usize];
        let relative = contact.relative_velocity(grain.velocity, velocity);
        let b = contact.without_impulse(relative);
        let impulse = match problem.bonds.get(contact.bond as usize) {
            None => contact.law.impulse(b),
            Some(bond) => bond.law.impulse(&contact.block, &contact.law, b),
        };
        let step = take_over(contact, impulse, squares);
        let force = contact.in_xy(step);
        grain.push(contact.lever(), force, step);
        for row in 0..2 {
            velocity[row] -= block[row][0] * force[0] + block[row][1] * force[1];
            total[row] -= force[row];
        }
    }
    problem.boundary.apply(disk, total);
}

/// Gives the contact its new impulse and adds the squares of W dr and W r; returns the change dr.
#[inline(always)]
fn take_over(contact: &mut Contact, impulse: [f64; 2], squares: &mut [f64; 2]) -> [f64; 2] {
    let ([r_n, r_t], block) = (contact.impulse, contact.block);
    let step = [impulse[0] - r_n, impulse[1] - r_t];
    contact.impulse = impulse;
    squares[0] += (block.nn * step[0]).powi(2) + (block.tt * step[1]).powi(2);
    squares[1] += (block.nn * impulse[0]).powi(2) + (block.tt * impulse[1]).powi(2);
    step
}
