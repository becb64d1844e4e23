//! Bonded contacts inside a subdomain in single precision: the change dr of their impulses since a solve began, and dv of their bodies.
//!
//! ```text
//! bodies     m  = H w + beta m      dv += alpha M^-1 m
//! contacts   p  = w + beta p        dr += alpha p        u = b0 + H^T dv + C dr        w = -u/D
//! ```
//! is an iteration, with b0 = H^T v0 + bias + C r0 formed in double precision. Nothing is projected: the energy of a bond is smooth at
//! r_n = 0, where C changes. C is that of tension or compression by the sign of r0 + dr; where it is another one than that of r0, u has the
//! change of C times r0 + dr besides.
//!
//! Contacts are treated by chunks, in loops over rows of numbers: gathered from the bodies, advanced, scattered to the bodies.

use std::array::from_fn;

use super::body_state::Products;
use super::group::{PassSums, bias, compliance};
use crate::contact::bond::BondContact;
use crate::solver::contact::{BodyRecord, Contact};

/// Contacts in a chunk: with all that belongs to them they fill a third of the smallest cache.
const CHUNK: usize = 128;
/// Contacts of a chunk that are scattered one after the other are so far apart that they have no body in common, or a sum would have
/// to wait for the one before.
const STRIDE: usize = 16;
/// Numbers of bodies whose products are summed side by side.
const WIDTH: usize = 64;

/// A number of each contact of a chunk.
type Row = [f32; CHUNK];

/// Numbers of a body: along x, along y, of its spin, and 0, for four fill a register.
type Quad = [f32; 4];

/// What b takes where a gets: both disks turn the same way.
const OPPOSITE: Quad = [1.0, 1.0, -1.0, -1.0];

/// The bodies of a subdomain.
#[derive(Clone, Debug, Default)]
struct SingleBodies {
    /// dv: v_x, v_y and spin times radius (m/s).
    velocities: Vec<Quad>,
    /// H w (N s).
    h_w: Vec<Quad>,
    /// m = H p (N s).
    momenta: Vec<Quad>,
    /// Diagonal of M^-1 (1/kg): 0 for a body on which contacts from outside act, and which they move.
    inverse: Vec<Quad>,
}

/// One component of the contacts of a chunk.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Component {
    /// dr, p and w (N s).
    change: Row,
    direction: Row,
    gradient: Row,
    /// b0 (m/s).
    bias: Row,
    /// Diagonal of W (1/kg).
    block: Row,
    /// C (1/kg), along the normal that of compression.
    compliance: Row,
}

/// Bonded contacts side by side. What has no contact has no normal either: it adds zeros to the first body.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct BondedChunk {
    a: [u32; CHUNK],
    b: [u32; CHUNK],
    normal: [Row; 2],
    /// Levers of spin over the radius.
    lever: Row,
    /// r_n of r0 (N s), and C there (1/kg).
    start: Row,
    held: Row,
    /// C of tension (1/kg).
    tension: Row,
    axes: [Component; 2],
}

/// Sums of an iteration, place by place of the chunks.
struct RowSums {
    uw: Row,
    up: Row,
    wp: Row,
    ww: Row,
    wz: Row,
    pp: Row,
    defect: Row,
}

/// Bonded contacts of one subdomain, and its bodies.
#[derive(Clone, Debug, Default)]
pub struct BondedBatch {
    /// Indices of the contacts in the problem.
    members: Vec<u32>,
    chunks: Vec<BondedChunk>,
    bodies: SingleBodies,
    /// Square of D r0, by which residuals are scaled.
    size: f64,
}

/// True for a bond that holds something along both axes: its compliances are numbers in single precision, too.
pub fn holds(bond: &BondContact) -> bool {
    let single = |compliance: &f64| *compliance < f64::from(f32::MAX);
    bond.law.compliance().iter().all(single)
}

impl BondedBatch {
    /// Forgets its contacts, and takes over bodies.
    pub fn start(&mut self, records: &[BodyRecord]) {
        self.members.clear();
        self.chunks.clear();
        self.size = 0.0;
        let SingleBodies {
            velocities,
            h_w,
            momenta,
            inverse,
        } = &mut self.bodies;
        let padded = records.len().next_multiple_of(WIDTH / 4);
        for quads in [velocities, h_w, momenta] {
            quads.clear();
            quads.resize(padded, Quad::default());
        }
        inverse.clear();
        inverse.extend(records.iter().map(|record| {
            let inverse = record.inverse_mass as f32;
            [inverse, inverse, 2.0 * inverse, 0.0]
        }));
        inverse.resize(padded, Quad::default());
    }

    /// Adds a contact at the relative velocity u (m/s); bodies count from `first`.
    pub fn push(&mut self, index: u32, pair: (&Contact, &BondContact), u: [f64; 2], first: usize) {
        let i = self.members.len() % CHUNK;
        if i == 0 {
            self.chunks.push(BondedChunk::empty());
        }
        self.members.push(index);
        if let Some(chunk) = self.chunks.last_mut() {
            chunk.set(i, pair, u, first as u32);
        }
        let (contact, _) = pair;
        let (d, r) = (contact.diagonal(), contact.impulse);
        self.size += (d[0] * r[0]).powi(2) + (d[1] * r[1]).powi(2);
    }

    /// Lets a body follow contacts from outside alone.
    pub fn leave(&mut self, body: usize) {
        self.bodies.inverse[body] = Quad::default();
    }

    /// Moves a body that contacts from outside move: dv (m/s).
    pub fn place(&mut self, body: usize, [x, y, turn]: [f64; 3]) {
        self.bodies.velocities[body] = [x as f32, y as f32, turn as f32, 0.0];
    }

    /// H w of a body (N s).
    pub fn h_w(&self, body: usize) -> [f64; 3] {
        let h_w = self.bodies.h_w[body];
        from_fn(|axis| f64::from(h_w[axis]))
    }

    /// Changes of the impulses (N s), by contact of the problem.
    pub fn changes(&self) -> impl Iterator<Item = (u32, [f64; 2])> {
        let change = |i: usize, axis: usize| self.chunks[i / CHUNK].axes[axis].change[i % CHUNK];
        let members = self.members.iter().enumerate();
        members.map(move |(i, member)| (*member, from_fn(|axis| f64::from(change(i, axis)))))
    }

    /// An iteration with alpha and beta; returns its sums, with the products of the bodies on which nothing acts from outside.
    #[inline(always)]
    pub fn iterate(&mut self, factors: [f32; 2]) -> PassSums<f64> {
        self.bodies.follow(factors);
        let mut sums = RowSums::new();
        let mut rows = [Quad::default(); CHUNK];
        for chunk in &mut self.chunks {
            chunk.gather(&self.bodies.velocities, &mut rows);
            chunk.advance(factors, &mut rows, &mut sums);
            chunk.scatter(&rows, &mut self.bodies.h_w);
        }
        let mut products = self.bodies.products();
        products.join(&Products {
            wp: total(&sums.wp),
            ww: total(&sums.ww),
            wz: total(&sums.wz),
            zz: total(&sums.pp),
        });
        PassSums {
            uw: total(&sums.uw),
            uz: total(&sums.up),
            products,
            held: 0.0,
            defect: total(&sums.defect),
            size: self.size,
        }
    }
}

impl SingleBodies {
    /// Takes the step alpha along m = H w + beta m, and forgets H w.
    #[inline(always)]
    fn follow(&mut self, [alpha, beta]: [f32; 2]) {
        let moved = self.velocities.as_flattened_mut().iter_mut();
        let moved = moved.zip(self.inverse.as_flattened());
        let along = self.momenta.as_flattened_mut().iter_mut();
        let along = along.zip(self.h_w.as_flattened_mut());
        for ((v, inverse), (m, w)) in moved.zip(along) {
            *m = *w + beta * *m;
            *v += alpha * *inverse * *m;
            *w = 0.0;
        }
    }

    /// Products of w and p by M^-1.
    #[inline(always)]
    fn products(&self) -> Products<f64> {
        let [mut wp, mut ww, mut pp] = [[0.0; WIDTH]; 3];
        let h_w = self.h_w.as_flattened().chunks_exact(WIDTH);
        let momenta = self.momenta.as_flattened().chunks_exact(WIDTH);
        let inverse = self.inverse.as_flattened().chunks_exact(WIDTH);
        for ((w, m), inverse) in h_w.zip(momenta).zip(inverse) {
            for i in 0..WIDTH {
                wp[i] += inverse[i] * w[i] * m[i];
                ww[i] += inverse[i] * w[i] * w[i];
                pp[i] += inverse[i] * m[i] * m[i];
            }
        }
        let wp = total(&wp);
        Products {
            wp,
            ww: total(&ww),
            wz: wp,
            zz: total(&pp),
        }
    }
}

impl BondedChunk {
    /// A chunk without contacts.
    fn empty() -> BondedChunk {
        let none = [0.0; CHUNK];
        let component = Component {
            change: none,
            direction: none,
            gradient: none,
            bias: none,
            block: [1.0; CHUNK],
            compliance: none,
        };
        BondedChunk {
            a: [0; CHUNK],
            b: [0; CHUNK],
            normal: [none; 2],
            lever: none,
            start: none,
            held: none,
            tension: none,
            axes: [component; 2],
        }
    }

    fn set(
        &mut self,
        i: usize,
        (contact, bond): (&Contact, &BondContact),
        u: [f64; 2],
        first: u32,
    ) {
        let [tension, _] = bond.law.compliance();
        (self.a[i], self.b[i]) = (contact.a - first, contact.b - first);
        let [nx, ny] = contact.normal;
        (self.normal[0][i], self.normal[1][i]) = (nx as f32, ny as f32);
        self.lever[i] = contact.lever() as f32;
        self.start[i] = contact.impulse[0] as f32;
        self.tension[i] = tension as f32;
        let blocks = [contact.block.nn, contact.block.tt];
        for (axis, component) in self.axes.iter_mut().enumerate() {
            let (r, spring) = (contact.impulse[axis], compliance(contact, Some(bond), axis));
            let pulls = axis == 0 && r < 0.0;
            let c = if pulls { tension } else { spring };
            component.bias[i] = (u[axis] + bias(contact, Some(bond), axis) + c * r) as f32;
            component.block[i] = blocks[axis] as f32;
            component.compliance[i] = spring as f32;
            if axis == 0 {
                self.held[i] = c as f32;
            }
        }
    }

    /// Change of the velocities of a against b, spins added.
    #[inline(always)]
    fn gather(&self, velocities: &[Quad], rows: &mut [Quad; CHUNK]) {
        for i in 0..CHUNK {
            let (a, b) = (
                velocities[self.a[i] as usize],
                velocities[self.b[i] as usize],
            );
            rows[i] = from_fn(|k| a[k] - OPPOSITE[k] * b[k]);
        }
    }

    /// Moves the contacts, and measures where they are; the rows hold the velocities of the bodies, and then H w of a.
    #[inline(always)]
    fn advance(&mut self, [alpha, beta]: [f32; 2], rows: &mut [Quad; CHUNK], sums: &mut RowSums) {
        let [normal, tangent] = &mut self.axes;
        for i in 0..CHUNK {
            // All four numbers of a row are read, or the last contacts of the chunk would be treated one by one.
            let [x, y, turn, nothing] = rows[i];
            let (nx, ny, lever) = (self.normal[0][i], self.normal[1][i], self.lever[i]);
            let (spring, tension) = (normal.compliance[i], self.tension[i]);
            let branch = |r: f32, u: f32| {
                let pulls = (r < 0.0) | ((r == 0.0) & (u > 0.0));
                if pulls { tension } else { spring }
            };
            let before = branch(self.start[i] + normal.change[i], -normal.gradient[i]);
            let (p, dr) = normal.step(i, [alpha, beta]);
            let r = self.start[i] + dr;
            let changed = branch(r, 0.0) - self.held[i];
            let u = normal.bias[i] + (nx * x + ny * y) + self.held[i] * dr + changed * r;
            let c = branch(r, u);
            let w = -u / (normal.block[i] + c);
            normal.gradient[i] = w;
            let (q, ds) = tangent.step(i, [alpha, beta]);
            let s = tangent.compliance[i];
            let slip = nx * y - ny * x - lever * (turn + nothing);
            let v = tangent.bias[i] + slip + s * ds;
            let t = -v / (tangent.block[i] + s);
            tangent.gradient[i] = t;
            sums.uw[i] += u * w + v * t;
            sums.up[i] += u * p + v * q;
            sums.wp[i] += before * w * p + s * t * q;
            sums.ww[i] += c * w * w + s * t * t;
            sums.wz[i] += c * w * p + s * t * q;
            sums.pp[i] += c * p * p + s * q * q;
            let off = [(normal.block[i] + spring) * w, tangent.block[i] * t];
            sums.defect[i] += off[0] * off[0] + off[1] * off[1];
            rows[i] = [w * nx - t * ny, w * ny + t * nx, lever * t, 0.0];
        }
    }

    /// Adds H w of the contacts to that of the bodies.
    #[inline(always)]
    fn scatter(&self, rows: &[Quad; CHUNK], h_w: &mut [Quad]) {
        for place in 0..CHUNK {
            let i = place * STRIDE % CHUNK + place * STRIDE / CHUNK;
            let a = &mut h_w[self.a[i] as usize];
            *a = from_fn(|k| a[k] + OPPOSITE[k] * rows[i][k]);
            let b = &mut h_w[self.b[i] as usize];
            *b = from_fn(|k| b[k] - rows[i][k]);
        }
    }
}

impl Component {
    /// p = w + beta p and dr += alpha p.
    #[inline(always)]
    fn step(&mut self, i: usize, [alpha, beta]: [f32; 2]) -> (f32, f32) {
        let p = self.gradient[i] + beta * self.direction[i];
        let change = self.change[i] + alpha * p;
        (self.direction[i], self.change[i]) = (p, change);
        (p, change)
    }
}

impl RowSums {
    fn new() -> RowSums {
        let none = [0.0; CHUNK];
        RowSums {
            uw: none,
            up: none,
            wp: none,
            ww: none,
            wz: none,
            pp: none,
            defect: none,
        }
    }
}

fn total<const N: usize>(row: &[f32; N]) -> f64 {
    row.iter().map(|x| f64::from(*x)).sum()
}
