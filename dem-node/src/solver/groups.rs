//! Gauss-Seidel sweeps over contacts in groups of eight that share no body.
//!
//! Contacts of a group do not see each other, so solving them side by side is the same as one after the other, and the
//! compiler can use whole vector registers. Contacts of glued disks, of bonds and of the wheel are solved one by one.
//!
//! Large problems are cut into blocks of consecutive bodies, which a sample numbers column by column; contacts inside
//! a block come first, block beside block in as many threads as there are, then those across. The cut depends on the
//! problem only: the same bits come out of any number of threads.

use std::ops::Range;

use super::{Contact, Mover, Problem, project};

/// Contacts in a group.
const LANES: usize = 8;
/// Groups that are being filled at a time: a window of 256 contacts, in which nearly all find seven others.
const OPEN: usize = 32;
/// Contacts per block below which threads cost more than they bring.
const BLOCK: usize = 4096;
/// Most blocks. A power of two halves evenly; each cut makes some 0.1 % of the contacts of a square pack serial.
const MOST_BLOCKS: usize = 8;
/// A lane without contact.
const EMPTY: u32 = u32::MAX;

/// Eight contacts side by side.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Group {
    /// Bodies, counted from the first of the block.
    a: [u32; LANES],
    b: [u32; LANES],
    normal: [[f64; LANES]; 2],
    bias: [[f64; LANES]; 2],
    /// Lever of spin over the radius.
    lever: [f64; LANES],
    /// 1/(W_nn + c_n) and 1/(W_tt + c_t); 0 in a lane without contact.
    inverse: [[f64; LANES]; 2],
    impulse: [[f64; LANES]; 2],
}

/// Squares of a sweep, lane by lane: ||W dr||^2 and ||W r||^2.
type Squares = [[f64; LANES]; 2];

impl Group {
    /// A lane without contact gets no impulse: it adds zeros to the first body of the block.
    fn new(contacts: &[Contact], members: &[u32; LANES], first: u32) -> Group {
        let mut group = Group {
            a: [0; LANES],
            b: [0; LANES],
            normal: [[0.0; LANES]; 2],
            bias: [[0.0; LANES]; 2],
            lever: [0.0; LANES],
            inverse: [[0.0; LANES]; 2],
            impulse: [[0.0; LANES]; 2],
        };
        for (k, member) in members.iter().enumerate() {
            if *member == EMPTY {
                continue;
            }
            let contact = &contacts[*member as usize];
            (group.a[k], group.b[k]) = (contact.a - first, contact.b - first);
            for axis in 0..2 {
                group.normal[axis][k] = contact.normal[axis];
                group.bias[axis][k] = contact.bias[axis];
                group.impulse[axis][k] = contact.impulse[axis];
            }
            group.lever[k] = contact.lever();
            group.inverse[0][k] = 1.0 / (contact.block.nn + contact.compliance[0]);
            group.inverse[1][k] = 1.0 / (contact.block.tt + contact.compliance[1]);
        }
        group
    }

    /// Solves each contact for its own impulse. With W_nt = 0 the closed solution of [`crate::law::LocalLaw`] is
    /// r_n = max(0, -b_n / D_n), r_t = -b_t / D_t within +-mu r_n, D the diagonal of W with its springs and
    /// b = u + bias - W r.
    #[inline(always)]
    fn relax<const FRICTION: bool>(
        &mut self,
        movers: &mut [Mover],
        friction: f64,
        squares: &mut Squares,
    ) {
        let (mut dx, mut dy, mut ds, mut w) =
            ([0.0; LANES], [0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for k in 0..LANES {
            let (a, b) = (&movers[self.a[k] as usize], &movers[self.b[k] as usize]);
            dx[k] = a.velocity[0] - b.velocity[0];
            dy[k] = a.velocity[1] - b.velocity[1];
            ds[k] = a.velocity[2] + b.velocity[2];
            w[k] = a.inverse_mass + b.inverse_mass;
        }
        let (mut px, mut py, mut turn) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for k in 0..LANES {
            let (nx, ny) = (self.normal[0][k], self.normal[1][k]);
            let old_n = self.impulse[0][k];
            let b_n = nx * dx[k] + ny * dy[k] + self.bias[0][k] - w[k] * old_n;
            // Written so that a NaN stays one.
            let r_n = if b_n >= 0.0 {
                0.0
            } else {
                -b_n * self.inverse[0][k]
            };
            let step_n = r_n - old_n;
            self.impulse[0][k] = r_n;
            px[k] = step_n * nx;
            py[k] = step_n * ny;
            squares[0][k] += (w[k] * step_n) * (w[k] * step_n);
            squares[1][k] += (w[k] * r_n) * (w[k] * r_n);
            if FRICTION {
                let lever = self.lever[k];
                let w_t = (1.0 + 2.0 * lever * lever) * w[k];
                let old_t = self.impulse[1][k];
                let b_t = nx * dy[k] - ny * dx[k] - lever * ds[k] + self.bias[1][k] - w_t * old_t;
                let stick = -b_t * self.inverse[1][k];
                let limit = friction * r_n;
                let low = if stick < -limit { -limit } else { stick };
                let r_t = if low > limit { limit } else { low };
                let step_t = r_t - old_t;
                self.impulse[1][k] = r_t;
                px[k] -= step_t * ny;
                py[k] += step_t * nx;
                turn[k] = 2.0 * lever * step_t;
                squares[0][k] += (w_t * step_t) * (w_t * step_t);
                squares[1][k] += (w_t * r_t) * (w_t * r_t);
            }
        }
        for k in 0..LANES {
            let a = &mut movers[self.a[k] as usize];
            a.velocity[0] += a.inverse_mass * px[k];
            a.velocity[1] += a.inverse_mass * py[k];
            if FRICTION {
                a.velocity[2] -= a.inverse_mass * turn[k];
            }
            let b = &mut movers[self.b[k] as usize];
            b.velocity[0] -= b.inverse_mass * px[k];
            b.velocity[1] -= b.inverse_mass * py[k];
            if FRICTION {
                b.velocity[2] -= b.inverse_mass * turn[k];
            }
        }
    }
}

/// Sorts contacts into groups, first fit among the open ones.
#[derive(Clone, Debug, Default)]
struct Sorter {
    /// In which open groups each body is already.
    taken: Vec<u32>,
    open: Vec<Vec<u32>>,
}

impl Sorter {
    /// Appends the groups of these contacts; bodies that nothing moves may be in all lanes.
    fn sort(
        &mut self,
        contacts: &[Contact],
        chosen: &[u32],
        movers: &[Mover],
        out: &mut Vec<[u32; LANES]>,
    ) {
        self.taken.resize(movers.len().max(self.taken.len()), 0);
        self.open.resize(OPEN, Vec::new());
        for index in chosen {
            let contact = &contacts[*index as usize];
            let (a, b) = (contact.a as usize, contact.b as usize);
            let taken = self.taken[a] | self.taken[b];
            // A body has at most five neighbours of its own size, but any number of small ones.
            if taken == u32::MAX {
                self.close(contacts, 0, out);
            }
            let slot = (!(self.taken[a] | self.taken[b])).trailing_zeros() as usize;
            for body in [a, b] {
                if movers[body].inverse_mass > 0.0 {
                    self.taken[body] |= 1 << slot;
                }
            }
            self.open[slot].push(*index);
            if self.open[slot].len() == LANES {
                self.close(contacts, slot, out);
            }
        }
        for slot in 0..OPEN {
            self.close(contacts, slot, out);
        }
    }

    fn close(&mut self, contacts: &[Contact], slot: usize, out: &mut Vec<[u32; LANES]>) {
        if self.open[slot].is_empty() {
            return;
        }
        let mut members = [EMPTY; LANES];
        for (k, index) in self.open[slot].drain(..).enumerate() {
            members[k] = index;
            let contact = &contacts[index as usize];
            for body in [contact.a as usize, contact.b as usize] {
                self.taken[body] &= !(1 << slot);
            }
        }
        out.push(members);
    }
}

/// Groups over a range of bodies.
#[derive(Clone, Debug, Default)]
struct Block {
    bodies: Range<usize>,
    /// Contacts of the block, then the groups that they make.
    chosen: Vec<u32>,
    members: Vec<[u32; LANES]>,
    groups: Vec<Group>,
    squares: Squares,
}

impl Block {
    fn clear(&mut self, bodies: Range<usize>) {
        self.bodies = bodies;
        self.chosen.clear();
        self.members.clear();
        self.groups.clear();
    }

    fn pack(&mut self, contacts: &[Contact], movers: &[Mover], sorter: &mut Sorter) {
        sorter.sort(contacts, &self.chosen, movers, &mut self.members);
        let first = self.bodies.start as u32;
        let group = |members| Group::new(contacts, members, first);
        self.groups.extend(self.members.iter().map(group));
    }

    /// `movers` are those of the block's bodies.
    fn sweep(&mut self, movers: &mut [Mover], friction: Option<f64>) {
        let mut squares = Squares::default();
        match friction {
            Some(friction) => {
                for group in &mut self.groups {
                    group.relax::<true>(movers, friction, &mut squares);
                }
            }
            None => {
                for group in &mut self.groups {
                    group.relax::<false>(movers, 0.0, &mut squares);
                }
            }
        }
        self.squares = squares;
    }

    fn store(&self, contacts: &mut [Contact]) {
        for (group, members) in self.groups.iter().zip(&self.members) {
            for (k, member) in members.iter().enumerate() {
                if *member != EMPTY {
                    contacts[*member as usize].impulse = [group.impulse[0][k], group.impulse[1][k]];
                }
            }
        }
    }
}

/// The contacts of a problem in the order in which they are swept.
#[derive(Clone, Debug, Default)]
pub struct Sweeper {
    blocks: Vec<Block>,
    /// Contacts between bodies of two blocks.
    across: Block,
    /// Contacts of free grains with glued disks, those of a glued disk one after the other.
    glued: Vec<u32>,
    /// Contacts with a bond, then those of the wheel and of clusters.
    bonded: Vec<u32>,
    wheel: Vec<u32>,
    armed: Vec<u32>,
    sorter: Sorter,
}

impl Sweeper {
    /// Takes over the contacts of a prepared problem.
    pub fn load(&mut self, problem: &Problem) {
        let count = (problem.contacts.len() / BLOCK).clamp(1, MOST_BLOCKS);
        let bodies = problem.movers.len();
        self.blocks.resize_with(count, Block::default);
        let per_block = bodies.div_ceil(count).max(1);
        for (i, block) in self.blocks.iter_mut().enumerate() {
            block.clear((i * per_block).min(bodies)..((i + 1) * per_block).min(bodies));
        }
        self.across.clear(0..bodies);
        self.glued.clear();
        self.bonded.clear();
        self.wheel.clear();
        self.armed.clear();
        for (index, contact) in problem.contacts.iter().enumerate() {
            let (a, b) = (contact.a as usize, contact.b as usize);
            let chosen = if problem.arms.get(contact.arms as usize).is_some() {
                &mut self.armed
            } else if problem.wheel == Some(b) {
                &mut self.wheel
            } else if contact.glued {
                &mut self.glued
            } else if problem.bonds.get(contact.bond as usize).is_some() {
                &mut self.bonded
            } else if a / per_block == b / per_block {
                &mut self.blocks[a / per_block].chosen
            } else {
                &mut self.across.chosen
            };
            chosen.push(index as u32);
        }
        self.glued
            .sort_by_key(|i| (problem.contacts[*i as usize].b, *i));
        for block in self.blocks.iter_mut().chain([&mut self.across]) {
            block.pack(&problem.contacts, &problem.movers, &mut self.sorter);
        }
    }

    /// One pass over all contacts. Returns ||W dr||^2 and ||W r||^2, W the diagonal without springs.
    pub fn sweep(&mut self, problem: &mut Problem, parallel: bool) -> [f64; 2] {
        let mut squares = [0.0; 2];
        // Taken out for the pass: a contact that is copied instead of borrowed costs as much as its arithmetic.
        let mut contacts = std::mem::take(&mut problem.contacts);
        let mut rest = &self.glued[..];
        while let Some(first) = rest.first() {
            let disk = contacts[*first as usize].b;
            let same = rest
                .iter()
                .take_while(|i| contacts[**i as usize].b == disk)
                .count();
            let (run, after) = rest.split_at(same);
            relax_glued_disk(problem, &mut contacts, run, &mut squares);
            rest = after;
        }
        problem.contacts = contacts;
        let friction = (problem.friction > 0.0).then_some(problem.friction);
        sweep_blocks(&mut self.blocks, &mut problem.movers, friction, parallel);
        self.across.sweep(&mut problem.movers, friction);
        for block in self.blocks.iter().chain([&self.across]) {
            for (sum, lanes) in squares.iter_mut().zip(&block.squares) {
                *sum += lanes.iter().sum::<f64>();
            }
        }
        let mut contacts = std::mem::take(&mut problem.contacts);
        let single = self.bonded.iter().chain(&self.wheel).chain(&self.armed);
        for index in single {
            relax_one(problem, &mut contacts[*index as usize], &mut squares);
        }
        problem.contacts = contacts;
        squares
    }

    /// Writes the impulses back.
    pub fn store(&self, problem: &mut Problem) {
        for block in self.blocks.iter().chain([&self.across]) {
            block.store(&mut problem.contacts);
        }
    }
}

/// Blocks side by side, halves of halves: `movers` are those of all of them.
fn sweep_blocks(blocks: &mut [Block], movers: &mut [Mover], friction: Option<f64>, parallel: bool) {
    if let [block] = blocks {
        return block.sweep(movers, friction);
    }
    let (left, right) = blocks.split_at_mut(blocks.len() / 2);
    let (Some(first), Some(cut)) = (left.first(), right.first()) else {
        return;
    };
    let (low, high) = movers.split_at_mut(cut.bodies.start - first.bodies.start);
    let mut lower = || sweep_blocks(left, low, friction, parallel);
    let mut upper = || sweep_blocks(right, high, friction, parallel);
    if parallel {
        rayon::join(lower, upper);
    } else {
        lower();
        upper();
    }
}

/// Solves a contact by its prepared law, wall and wheel included.
pub fn relax_one(problem: &mut Problem, contact: &mut Contact, squares: &mut [f64; 2]) {
    let velocity = problem.relative_velocity(contact);
    let step = renew(problem, contact, velocity, squares);
    problem.apply(contact, step);
}

/// Solves the contacts of one glued disk in turn. Between them only the disk itself needs to know how the wall
/// yields: the dense product with two columns of W_g is made once for all.
fn relax_glued_disk(
    problem: &mut Problem,
    contacts: &mut [Contact],
    run: &[u32],
    squares: &mut [f64; 2],
) {
    let disk = contacts[run[0] as usize].b as usize - problem.first_glued;
    let ([vx, vy], response) = (problem.wall.velocity_of(disk), problem.wall.response(disk));
    let (mut velocity, mut total) = ([vx, vy, 0.0], [0.0; 2]);
    for index in run {
        let contact = &mut contacts[*index as usize];
        let a = contact.a as usize;
        let lever = contact.lever();
        let relative = project(contact.normal, lever, problem.movers[a].velocity, velocity);
        let step = renew(problem, contact, relative, squares);
        let [nx, ny] = contact.normal;
        let push = [step[0] * nx - step[1] * ny, step[0] * ny + step[1] * nx];
        problem.kick(contact, 0, push, step);
        for row in 0..2 {
            velocity[row] -= response[row][0] * push[0] + response[row][1] * push[1];
            total[row] -= push[row];
        }
    }
    problem.wall.push(disk, total);
}

/// Gives the contact the impulse that its law wants under this relative velocity; returns what it changed.
fn renew(
    problem: &Problem,
    contact: &mut Contact,
    velocity: [f64; 2],
    squares: &mut [f64; 2],
) -> [f64; 2] {
    let ([r_n, r_t], block) = (contact.impulse, contact.block);
    let impulse = problem.wanted(contact, velocity);
    let step = [impulse[0] - r_n, impulse[1] - r_t];
    contact.impulse = impulse;
    squares[0] += (block.nn * step[0]).powi(2) + (block.tt * step[1]).powi(2);
    squares[1] += (block.nn * impulse[0]).powi(2) + (block.tt * impulse[1]).powi(2);
    step
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::grading::Dice;
    use crate::wall::Wall;

    const GRAINS: usize = 60;
    const GLUED: usize = 6;

    /// Grains that touch at random, a wheel over some, a yielding wall under others; the law is friction 0.3 and
    /// springs. Grain 0 touches all others: more neighbours than there are open groups.
    fn problem() -> Problem {
        let mut dice = Dice::new(7);
        let wheel = GRAINS + GLUED;
        let mut contact = |a: usize, b: usize| {
            let angle = dice.between(0.0, std::f64::consts::TAU);
            Contact {
                a: a as u32,
                b: b as u32,
                glued: (GRAINS..wheel).contains(&b) || a >= GRAINS,
                normal: [angle.cos(), angle.sin()],
                stretch: dice.between(-0.05, 0.05),
                bias: [dice.between(-0.3, 0.1), dice.between(-0.1, 0.1)],
                compliance: [0.2, 0.4],
                impulse: [dice.between(0.0, 0.1), 0.0],
                ..Contact::default()
            }
        };
        let mut contacts = Vec::new();
        for a in 0..GRAINS {
            let neighbours = if a == 0 { 1..GRAINS } else { a + 1..a + 4 };
            contacts.extend(neighbours.filter(|b| *b < GRAINS).map(|b| contact(a, b)));
            if a % 3 == 0 {
                contacts.push(contact(a, GRAINS + a % GLUED));
            }
            if a % 5 == 0 {
                contacts.push(contact(a, wheel));
            }
        }
        contacts.push(contact(GRAINS + 1, wheel));
        let mover = |i: usize| Mover {
            velocity: [0.01 * i as f64, -0.02, 0.03],
            inverse_mass: if (GRAINS..wheel).contains(&i) {
                0.0
            } else {
                1.0 + 0.1 * (i % 7) as f64
            },
        };
        let at = |i: usize, j: usize| if i == j { 2.0 } else { 0.1 };
        let components = 0..4 * GLUED * GLUED;
        let compliance: Vec<f64> = components
            .map(|k| at(k / (2 * GLUED), k % (2 * GLUED)))
            .collect();
        let mut wall = Wall::compliant(GLUED, compliance);
        wall.start(&[0.05; 2 * GLUED]);
        let mut problem = Problem {
            contacts,
            movers: (0..=wheel).map(mover).collect(),
            first_glued: GRAINS,
            wheel: Some(wheel),
            wall,
            friction: 0.3,
            ..Problem::default()
        };
        problem.prepare().expect("it is well posed");
        problem
    }

    /// The contacts in the order in which a sweep treats them.
    fn order(sweeper: &Sweeper) -> Vec<u32> {
        let blocks = sweeper.blocks.iter().chain([&sweeper.across]);
        let grouped = blocks.flat_map(|block| block.members.iter().flatten());
        let all = sweeper
            .glued
            .iter()
            .chain(grouped)
            .chain(&sweeper.bonded)
            .chain(&sweeper.wheel)
            .chain(&sweeper.armed);
        all.copied().filter(|index| *index != EMPTY).collect()
    }

    #[test]
    fn every_contact_is_swept_once_and_groups_share_no_body() {
        let problem = problem();
        let mut sweeper = Sweeper::default();
        sweeper.load(&problem);
        let mut all = order(&sweeper);
        all.sort_unstable();
        assert!(all.iter().copied().eq(0..problem.contacts.len() as u32));
        for members in &sweeper.blocks[0].members {
            let mut bodies: Vec<u32> = members
                .iter()
                .filter(|index| **index != EMPTY)
                .map(|index| &problem.contacts[*index as usize])
                .flat_map(|contact| [contact.a, contact.b])
                .collect();
            let count = bodies.len();
            bodies.sort_unstable();
            bodies.dedup();
            assert_eq!(bodies.len(), count);
        }
        assert!(sweeper.sorter.taken.iter().all(|taken| *taken == 0));
    }

    #[test]
    fn a_sweep_in_groups_is_the_sweep_one_by_one() {
        for friction in [0.0, 0.3] {
            let mut fast = problem();
            fast.friction = friction;
            fast.contacts.iter_mut().for_each(|c| c.impulse[1] = 0.0);
            let mut plain = fast.clone();
            for contact in &mut plain.contacts {
                let softened = crate::law::Block {
                    nn: contact.block.nn + contact.compliance[0],
                    nt: contact.block.nt,
                    tt: contact.block.tt + contact.compliance[1],
                };
                contact.law =
                    crate::law::LocalLaw::new(softened, friction, (0, 0)).expect("well posed");
            }
            fast.contacts.clone_from(&plain.contacts);
            let mut sweeper = Sweeper::default();
            sweeper.load(&fast);
            let order = order(&sweeper);
            for _ in 0..5 {
                let squares = sweeper.sweep(&mut fast, false);
                let mut expected = [0.0; 2];
                let mut contacts = std::mem::take(&mut plain.contacts);
                for index in &order {
                    relax_one(&mut plain, &mut contacts[*index as usize], &mut expected);
                }
                plain.contacts = contacts;
                for (square, expected) in squares.into_iter().zip(expected) {
                    assert!((square - expected).abs() <= 1e-12 * expected);
                }
            }
            sweeper.store(&mut fast);
            for (fast, plain) in fast.contacts.iter().zip(&plain.contacts) {
                for (r, expected) in fast.impulse.into_iter().zip(plain.impulse) {
                    assert!((r - expected).abs() < 1e-13, "{r} instead of {expected}");
                }
            }
            for (fast, plain) in fast.movers.iter().zip(&plain.movers) {
                for (v, expected) in fast.velocity.into_iter().zip(plain.velocity) {
                    assert!((v - expected).abs() < 1e-12, "{v} instead of {expected}");
                }
            }
            for (v, expected) in fast.wall.velocity.iter().zip(&plain.wall.velocity) {
                assert!((v - expected).abs() < 1e-12, "{v} instead of {expected}");
            }
        }
    }
}
