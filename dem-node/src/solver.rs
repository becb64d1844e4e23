//! The contact problem of one step and its solvers.
//!
//! Unknown are the contact impulses r (N s) and the velocities v after the step:
//! v = v_free + M^-1 H r, u = H^T v, and at each contact U = u + (g/h, d_t/h) + r/(k h^2) obeys Signorini-Coulomb.

mod arms;
mod average;
mod blocks;
mod check;
mod groups;
pub(crate) mod lanes;
mod nsgs;
mod pcg;

pub use check::Quad;

use serde::{Deserialize, Serialize};

use crate::bond::BondContact;
use crate::error::DemError;
use crate::law::{Block, LocalLaw};
use crate::wall::Wall;

pub use arms::Arms;

/// Velocity and inertia of a body in the contact problem: one aligned record, so that a contact loads each of its
/// bodies as a whole.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(32))]
pub struct Mover {
    /// v_x, v_y and spin times radius (m/s).
    pub velocity: [f64; 3],
    /// 1/m (1/kg). A disk turns with r^2/I = 2/m, the wheel moves by impulses along y only; 0 where all motion is
    /// prescribed.
    pub inverse_mass: f64,
}

/// The bond of a contact that has none.
pub const UNBONDED: u32 = u32::MAX;

/// The arms of a contact of two disks, or of a disk with a wall or the wheel.
pub const UNARMED: u32 = u32::MAX;

/// A contact of the problem.
#[derive(Clone, Copy, Debug, Default)]
pub struct Contact {
    /// Candidate; the normal points to it.
    pub a: u32,
    /// Antagonist.
    pub b: u32,
    /// Whether a or b is a glued disk.
    pub glued: bool,
    /// Unit normal; the tangent is (-n_y, n_x).
    pub normal: [f64; 2],
    /// Gap at detection (m), that of a bond over its reference.
    pub gap: f64,
    /// Distance of the centres of two disks over the sum of their radii, less 1. Both turn about the point that divides the
    /// line between the centres like their radii: one point for both, or a gap or an overlap would make angular momentum.
    pub stretch: f64,
    /// What the law adds to u in U, for instance g/h and d_t/h (m/s).
    pub bias: [f64; 2],
    /// Springs on the diagonal, 1/(k h^2) (1/kg).
    pub compliance: [f64; 2],
    /// Impulse, normal and tangential (N s).
    pub impulse: [f64; 2],
    /// Place of its bond in [`Problem::bonds`], or [`UNBONDED`].
    pub bond: u32,
    /// Place of its levers in [`Problem::arms`], or [`UNARMED`].
    pub arms: u32,
    /// What the solver itself fills in: the bodies' part of W,
    pub(crate) block: Block,
    /// and the law prepared for it.
    pub(crate) law: LocalLaw,
}

impl Contact {
    /// Lever of each disk over its radius.
    #[inline(always)]
    pub(crate) fn lever(&self) -> f64 {
        1.0 + self.stretch
    }
}

/// All contacts and bodies of a step.
#[derive(Clone, Debug, Default)]
pub struct Problem {
    /// Contacts, sorted by (a, b).
    pub contacts: Vec<Contact>,
    /// The bonds among them.
    pub bonds: Vec<BondContact>,
    /// The levers of those that have a body in a cluster.
    pub arms: Vec<Arms>,
    /// Bodies; the entries of glued disks are not used.
    pub movers: Vec<Mover>,
    /// First glued disk; the glued disks end where `wall` does.
    pub first_glued: usize,
    /// The wheel: impulses move it along y only, its sideways velocity is prescribed.
    pub wheel: Option<usize>,
    /// The wall under the glued disks.
    pub wall: Wall,
    /// Coefficient of friction.
    pub friction: f64,
    /// What rounding leaves of a gap over the step (m/s): no residual can be smaller.
    pub rounding: f64,
    /// Least size that residuals are measured against (m/s).
    least_size: f64,
    /// Buffers of the solvers.
    sweeper: groups::Sweeper,
    conjugate: pcg::Vectors,
}

/// The algorithm that solves the problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Algorithm {
    /// Block non-linear Gauss-Seidel.
    Nsgs,
    /// Projected conjugate gradient.
    Pcg,
}

/// When a solver may stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Criteria {
    /// The algorithm.
    pub algorithm: Algorithm,
    /// Bound on the true residual.
    pub tolerance: f64,
    /// Fewest iterations.
    pub min_iterations: usize,
    /// Most iterations.
    pub max_iterations: usize,
    /// Whether the rayon pool of the caller may be used. The answer has the same bits either way.
    pub parallel: bool,
}

/// How a solver ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Iterations done.
    pub iterations: usize,
    /// True natural-map residual, relative.
    pub residual: f64,
    /// LMGC90's incremental criterion, the largest of its three norms.
    pub quad: f64,
    /// Whether the residual is within the tolerance.
    pub converged: bool,
}

impl Problem {
    /// Solves for impulses and velocities. The impulses found in the contacts are the first guess; the velocities
    /// must be the free ones. `converged = false` is an answer, NaN is an error.
    ///
    /// Residuals are relative to ||D r||, but to no less than what makes a defect of pure rounding pass: a group of
    /// grains that just moves on has impulses near zero, and would never converge relative to them.
    pub fn solve(&mut self, criteria: &Criteria) -> Result<Verdict, DemError> {
        let contacts = self.contacts.len().max(1) as f64;
        self.least_size = self.rounding * contacts.sqrt() / criteria.tolerance;
        self.prepare()?;
        let verdict = match criteria.algorithm {
            Algorithm::Nsgs => nsgs::solve(self, criteria),
            Algorithm::Pcg => pcg::solve(self, criteria),
        };
        self.wall.settle();
        if verdict.residual.is_finite() {
            return Ok(verdict);
        }
        Err(DemError::NotFinite {
            iterations: verdict.iterations,
        })
    }

    /// Local blocks, local laws, and the effect of the first guess on the velocities.
    fn prepare(&mut self) -> Result<(), DemError> {
        let mut contacts = std::mem::take(&mut self.contacts);
        for contact in &mut contacts {
            contact.block = self.block(contact);
            let softened = Block {
                nn: contact.block.nn + contact.compliance[0],
                nt: contact.block.nt,
                tt: contact.block.tt + contact.compliance[1],
            };
            let pair = (contact.a, contact.b);
            match self.bonds.get_mut(contact.bond as usize) {
                None => contact.law = LocalLaw::new(softened, self.friction, pair)?,
                Some(bond) => bond.prepare(contact.block, contact.compliance[0], pair)?,
            }
            self.start_from(contact);
        }
        self.contacts = contacts;
        self.wall.settle();
        Ok(())
    }

    /// Applies the first guess of a contact. Glued disks only take note: the wall follows all of them at once.
    fn start_from(&mut self, contact: &Contact) {
        let ([nx, ny], [r_n, r_t]) = (contact.normal, contact.impulse);
        let push = [r_n * nx - r_t * ny, r_n * ny + r_t * nx];
        let sides = [(contact.a, push), (contact.b, [-push[0], -push[1]])];
        for (side, (body, push)) in sides.into_iter().enumerate() {
            match self.glued_index(body as usize) {
                Some(disk) => self.wall.note(disk, push),
                None => self.kick(contact, side, push, [r_n, r_t]),
            }
        }
    }

    /// W_nn = n.M^-1 n and so on, summed over both bodies; the spin of a disk adds its inverse inertia to W_tt, that of a
    /// cluster adds to all.
    fn block(&self, contact: &Contact) -> Block {
        let [nx, ny] = contact.normal;
        let mut block = Block::default();
        let arms = self.arms.get(contact.arms as usize);
        for (side, body) in [contact.a as usize, contact.b as usize]
            .into_iter()
            .enumerate()
        {
            let mut spin = 0.0;
            let [xx, xy, yy] = match (self.glued_index(body), arms) {
                (Some(disk), _) => self.wall.block(disk),
                (None, None) => {
                    let [x, y, turn] = self.inverse_mass(body);
                    spin = turn * contact.lever().powi(2);
                    [x, 0.0, y]
                }
                (None, Some(arms)) => {
                    let turning = arms.turning(side);
                    block.nn += turning.nn;
                    block.nt += turning.nt;
                    spin = turning.tt;
                    let [x, y, _] = arms.inverse[side];
                    [x, 0.0, y]
                }
            };
            block.nn += nx * nx * xx + 2.0 * nx * ny * xy + ny * ny * yy;
            block.nt += nx * ny * (yy - xx) + (nx * nx - ny * ny) * xy;
            block.tt += ny * ny * xx - 2.0 * nx * ny * xy + nx * nx * yy + spin;
        }
        block
    }

    /// What a unit impulse changes of (v_x, v_y, spin times radius) of a body that is not glued, nor in a cluster (1/kg).
    #[inline(always)]
    pub(crate) fn inverse_mass(&self, body: usize) -> [f64; 3] {
        let inverse = self.movers[body].inverse_mass;
        if Some(body) == self.wheel {
            [0.0, inverse, 0.0]
        } else {
            [inverse, inverse, 2.0 * inverse]
        }
    }

    fn glued_index(&self, body: usize) -> Option<usize> {
        let index = body.checked_sub(self.first_glued)?;
        (2 * index < self.wall.velocity.len()).then_some(index)
    }

    /// Relative velocity (u_n, u_t) of the contact points, a against b (m/s).
    #[inline(always)]
    pub fn relative_velocity(&self, contact: &Contact) -> [f64; 2] {
        let a = self.velocity(contact, contact.a as usize);
        let b = self.velocity(contact, contact.b as usize);
        self.project(contact, a, b)
    }

    /// Whether it is large enough for several threads.
    pub fn is_cut(&self) -> bool {
        blocks::Cut::new(self).several()
    }

    /// Relative velocity (u_n, u_t) of the contact points if the bodies had these velocities (m/s).
    #[inline(always)]
    pub fn project(&self, contact: &Contact, a: [f64; 3], b: [f64; 3]) -> [f64; 2] {
        match self.arms.get(contact.arms as usize) {
            None => project(contact.normal, contact.lever(), a, b),
            Some(arms) => arms.project(contact.normal, a, b),
        }
    }

    #[inline(always)]
    fn velocity(&self, contact: &Contact, body: usize) -> [f64; 3] {
        if contact.glued
            && let Some(disk) = self.glued_index(body)
        {
            let [x, y] = self.wall.velocity_of(disk);
            return [x, y, 0.0];
        }
        self.movers[body].velocity
    }

    /// Adds an impulse (r_n, r_t) at a contact to the velocities of both bodies.
    #[inline(always)]
    fn apply(&mut self, contact: &Contact, impulse: [f64; 2]) {
        let ([nx, ny], [r_n, r_t]) = (contact.normal, impulse);
        let push = [r_n * nx - r_t * ny, r_n * ny + r_t * nx];
        self.kick(contact, 0, push, impulse);
        self.kick(contact, 1, [-push[0], -push[1]], impulse);
    }

    #[inline(always)]
    fn kick(&mut self, contact: &Contact, side: usize, push: [f64; 2], impulse: [f64; 2]) {
        let body = if side == 0 { contact.a } else { contact.b } as usize;
        if contact.glued
            && let Some(disk) = self.glued_index(body)
        {
            self.wall.push(disk, push);
            return;
        }
        if let Some(arms) = self.arms.get(contact.arms as usize) {
            arms.kick(side, &mut self.movers[body].velocity, push, impulse);
            return;
        }
        let inverse = self.inverse_mass(body);
        let velocity = &mut self.movers[body].velocity;
        velocity[0] += inverse[0] * push[0];
        velocity[1] += inverse[1] * push[1];
        // The lever is -r n on a and +r n on b, and the impulses are opposite: both disks turn the same way.
        velocity[2] -= inverse[2] * contact.lever() * impulse[1];
    }

    /// The impulse that the law of a contact wants under the velocities of the moment, its own share taken out.
    #[inline(always)]
    pub(crate) fn wanted(&self, contact: &Contact, velocity: [f64; 2]) -> [f64; 2] {
        let ([u_n, u_t], [r_n, r_t]) = (velocity, contact.impulse);
        let block = contact.block;
        let b = [
            u_n + contact.bias[0] - block.nn * r_n - block.nt * r_t,
            u_t + contact.bias[1] - block.nt * r_n - block.tt * r_t,
        ];
        match self.bonds.get(contact.bond as usize) {
            None => contact.law.impulse(b),
            Some(bond) => bond.impulse(b),
        }
    }

    /// A defect over the size of the problem; nothing is no defect, even of a problem without contacts.
    pub(crate) fn relative(&self, defect: f64, size: f64) -> f64 {
        if defect == 0.0 {
            return 0.0;
        }
        defect / size.max(self.least_size)
    }
}

/// u_n = n.(v_a - v_b), u_t = t.(v_a - v_b) - l (w_a + w_b), with w the spin times the radius and l the lever over the
/// radius.
#[inline(always)]
pub fn project(normal: [f64; 2], lever: f64, a: [f64; 3], b: [f64; 3]) -> [f64; 2] {
    let (dx, dy) = (a[0] - b[0], a[1] - b[1]);
    [
        normal[0] * dx + normal[1] * dy,
        normal[0] * dy - normal[1] * dx - lever * (a[2] + b[2]),
    ]
}
