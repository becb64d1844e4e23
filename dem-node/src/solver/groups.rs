//! Gauss-Seidel sweeps over contacts in groups of eight that share no body.
//!
//! Contacts of a group do not see each other, so solving them side by side is the same as one after the other, and the
//! compiler can use whole vector registers. Contacts of glued disks, of bonds and of the wheel are solved one by one.
//!
//! Contacts inside a block of [`super::blocks`] come first, block beside block, then those across.

mod sorter;
#[cfg(test)]
mod tests;

use super::blocks::{self, Block, Cut};
use super::lanes::{self, widest};
use super::{Contact, Mover, Problem, project};
use sorter::Sorter;

/// Contacts in a group.
const LANES: usize = 8;
/// A lane without contact.
const EMPTY: u32 = u32::MAX;

/// A number of each contact of a group.
type Lanes = lanes::Lanes<LANES>;

/// Eight contacts side by side.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Group {
    /// Bodies, counted from the first of the block.
    a: [u32; LANES],
    b: [u32; LANES],
    normal: [Lanes; 2],
    bias: [Lanes; 2],
    /// Lever of spin over the radius.
    lever: Lanes,
    /// 1/(W_nn + c_n) and 1/(W_tt + c_t); 0 in a lane without contact.
    inverse: [Lanes; 2],
    impulse: [Lanes; 2],
}

/// Squares of a sweep, lane by lane: ||W dr||^2 and ||W r||^2.
type Squares = [Lanes; 2];

impl Group {
    /// A lane without contact gets no impulse: it adds zeros to the first body of the block.
    fn new(contacts: &[Contact], members: &[u32; LANES], first: u32) -> Group {
        let mut group = Group {
            a: [0; LANES],
            b: [0; LANES],
            normal: [Lanes::default(); 2],
            bias: [Lanes::default(); 2],
            lever: Lanes::default(),
            inverse: [Lanes::default(); 2],
            impulse: [Lanes::default(); 2],
        };
        for (k, member) in members.iter().enumerate() {
            if *member == EMPTY {
                continue;
            }
            let contact = &contacts[*member as usize];
            (group.a[k], group.b[k]) = (contact.a - first, contact.b - first);
            for axis in 0..2 {
                group.normal[axis].0[k] = contact.normal[axis];
                group.bias[axis].0[k] = contact.bias[axis];
                group.impulse[axis].0[k] = contact.impulse[axis];
            }
            group.lever.0[k] = contact.lever();
            group.inverse[0].0[k] = 1.0 / (contact.block.nn + contact.compliance[0]);
            group.inverse[1].0[k] = 1.0 / (contact.block.tt + contact.compliance[1]);
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
        let [mut dx, mut dy, mut ds, mut w] = [[0.0; LANES]; 4];
        for k in 0..LANES {
            let (a, b) = (&movers[self.a[k] as usize], &movers[self.b[k] as usize]);
            dx[k] = a.velocity[0] - b.velocity[0];
            dy[k] = a.velocity[1] - b.velocity[1];
            ds[k] = a.velocity[2] + b.velocity[2];
            w[k] = a.inverse_mass + b.inverse_mass;
        }
        let [dx, dy, ds, w] = [dx, dy, ds, w].map(lanes::Lanes);
        let ([nx, ny], [old_n, old_t]) = (self.normal, self.impulse);
        let b_n = nx * dx + ny * dy + self.bias[0] - w * old_n;
        // Written so that a NaN stays one.
        let r_n = b_n.zip(
            -b_n * self.inverse[0],
            |b, r| if b >= 0.0 { 0.0 } else { r },
        );
        let step_n = r_n - old_n;
        let (mut px, mut py, mut turn) = (step_n * nx, step_n * ny, Lanes::default());
        note(squares, w, [step_n, r_n]);
        self.impulse[0] = r_n;
        if FRICTION {
            let (one, two) = (Lanes::splat(1.0), Lanes::splat(2.0));
            let lever = self.lever;
            let w_t = (one + two * lever * lever) * w;
            let b_t = nx * dy - ny * dx - lever * ds + self.bias[1] - w_t * old_t;
            let limit = Lanes::splat(friction) * r_n;
            let r_t = (-b_t * self.inverse[1]).clamp(-limit, limit);
            let step_t = r_t - old_t;
            px = px - step_t * ny;
            py = py + step_t * nx;
            turn = two * lever * step_t;
            note(squares, w_t, [step_t, r_t]);
            self.impulse[1] = r_t;
        }
        for k in 0..LANES {
            let (px, py, turn) = (px.0[k], py.0[k], turn.0[k]);
            let a = &mut movers[self.a[k] as usize];
            a.velocity[0] += a.inverse_mass * px;
            a.velocity[1] += a.inverse_mass * py;
            if FRICTION {
                a.velocity[2] -= a.inverse_mass * turn;
            }
            let b = &mut movers[self.b[k] as usize];
            b.velocity[0] -= b.inverse_mass * px;
            b.velocity[1] -= b.inverse_mass * py;
            if FRICTION {
                b.velocity[2] -= b.inverse_mass * turn;
            }
        }
    }
}

/// Adds the squares of W dr and W r.
#[inline(always)]
fn note(squares: &mut Squares, w: Lanes, [step, r]: [Lanes; 2]) {
    let [change, size] = [w * step, w * r];
    squares[0] = squares[0] + change * change;
    squares[1] = squares[1] + size * size;
}

/// Groups that are swept one after the other.
#[derive(Clone, Debug, Default)]
struct Batch {
    /// Body from which on the groups count.
    first: usize,
    /// Contacts, then the groups that they make.
    chosen: Vec<u32>,
    members: Vec<[u32; LANES]>,
    groups: Vec<Group>,
    squares: Squares,
}

impl Batch {
    fn clear(&mut self, first: usize) {
        self.first = first;
        self.chosen.clear();
        self.members.clear();
        self.groups.clear();
    }

    fn pack(&mut self, contacts: &[Contact], movers: &[Mover], sorter: &mut Sorter) {
        sorter.sort(contacts, &self.chosen, movers, &mut self.members);
        let first = self.first as u32;
        let group = |members| Group::new(contacts, members, first);
        self.groups.extend(self.members.iter().map(group));
    }

    /// `movers` are those of the bodies from the first on.
    fn sweep(&mut self, movers: &mut [Mover], friction: Option<f64>) {
        self.squares = match friction {
            Some(friction) => widest(
                #[inline(always)]
                || self.relax::<true>(movers, friction),
            ),
            None => widest(
                #[inline(always)]
                || self.relax::<false>(movers, 0.0),
            ),
        };
    }

    #[inline(always)]
    fn relax<const FRICTION: bool>(&mut self, movers: &mut [Mover], friction: f64) -> Squares {
        let mut squares = Squares::default();
        for group in &mut self.groups {
            group.relax::<FRICTION>(movers, friction, &mut squares);
        }
        squares
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

/// The contacts of a problem in the order in which they are swept.
#[derive(Clone, Debug, Default)]
pub struct Sweeper {
    blocks: Vec<Block<Batch>>,
    /// Contacts between bodies of two blocks.
    across: Batch,
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
        let cut = Cut::new(problem);
        cut.lay(&mut self.blocks);
        for block in &mut self.blocks {
            block.work.clear(block.bodies.start);
        }
        self.across.clear(0);
        self.glued.clear();
        self.bonded.clear();
        self.wheel.clear();
        self.armed.clear();
        for (index, contact) in problem.contacts.iter().enumerate() {
            let chosen = if problem.arms.get(contact.arms as usize).is_some() {
                &mut self.armed
            } else if problem.wheel == Some(contact.b as usize) {
                &mut self.wheel
            } else if contact.glued {
                &mut self.glued
            } else if problem.bonds.get(contact.bond as usize).is_some() {
                &mut self.bonded
            } else if let Some(block) = cut.common(contact.a, contact.b) {
                &mut self.blocks[block].work.chosen
            } else {
                &mut self.across.chosen
            };
            chosen.push(index as u32);
        }
        self.glued
            .sort_by_key(|i| (problem.contacts[*i as usize].b, *i));
        let inside = self.blocks.iter_mut().map(|block| &mut block.work);
        for batch in inside.chain([&mut self.across]) {
            batch.pack(&problem.contacts, &problem.movers, &mut self.sorter);
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
        let sweep =
            |block: &mut Block<Batch>, movers: &mut [Mover]| block.work.sweep(movers, friction);
        blocks::each(&mut self.blocks, &mut problem.movers[..], parallel, &sweep);
        self.across.sweep(&mut problem.movers, friction);
        for batch in self.batches() {
            for (sum, lanes) in squares.iter_mut().zip(&batch.squares) {
                *sum += lanes.sum();
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
        for batch in self.batches() {
            batch.store(&mut problem.contacts);
        }
    }

    fn batches(&self) -> impl Iterator<Item = &Batch> {
        let inside = self.blocks.iter().map(|block| &block.work);
        inside.chain([&self.across])
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
