//! Bonded contacts inside a subdomain in single precision: the change dr of their impulses since the start of a solve, and the change dv of their
//! bodies' velocities.
//!
//! ```text
//! bodies     m  = H w + beta m      dv += alpha M^-1 m
//! contacts   p  = w + beta p        dr += alpha p        u = b0 + H^T dv + C dr        w = -u/D
//! ```
//! is an iteration, with b0 = H^T v0 + bias + C r0 computed in double precision. Nothing is projected: the energy of a bond is smooth at r_n = 0,
//! where C changes. C is the compliance of tension or compression by the sign of r0 + dr; where it differs from the compliance at r0, u also has the
//! change of C times r0 + dr.
//!
//! Contacts are treated by chunks, in loops over rows of numbers: gathered from the bodies, advanced, scattered to the bodies.

use std::array::from_fn;
use std::ops::Range;

use super::body_state::Products;
use super::group::{PassSums, bias, compliance};
use crate::contact::bond::BondContact;
use crate::solver::contact::{BodyRecord, Contact};

/// Contacts in a chunk: with their data they fill a third of the smallest cache.
const CHUNK: usize = 128;
/// Contacts of a chunk that are scattered one after the other are this far apart, so that they have no body in common and no sum waits for the one
/// before.
const STRIDE: usize = 16;
/// Numbers of bodies whose products are summed side by side.
const WIDTH: usize = 64;

/// Largest compliance of tension over the diagonal of W with the spring of compression.
const SOFT: f64 = 10.0;

/// A number of each contact of a chunk.
type Row = [f32; CHUNK];

/// Numbers of a body: along x, along y, of its spin, and 0, since four fill a register.
pub type BodyRow = [f32; 4];

/// Signs of b's numbers relative to a's: the force on b is opposed to the force on a, and both disks turn the same way.
const OPPOSITE: BodyRow = [1.0, 1.0, -1.0, -1.0];

/// All bodies of a problem.
#[derive(Clone, Debug, Default)]
pub struct SingleBodies {
    /// dv: v_x, v_y and spin times radius (m/s).
    velocities: Vec<BodyRow>,
    /// H w (N s).
    h_w: Vec<BodyRow>,
    /// m = H p (N s).
    momenta: Vec<BodyRow>,
    /// Diagonal of M^-1 (1/kg): 0 for a body with contacts from outside, which move it.
    inverse: Vec<BodyRow>,
}

/// Consecutive bodies: dv and H w, m and M^-1.
pub type BodySlice<'a> = (
    (&'a mut [BodyRow], &'a mut [BodyRow]),
    (&'a mut [BodyRow], &'a [BodyRow]),
);

/// One component of the contacts of a chunk.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Component {
    /// dr, p and w (N s).
    change: Row,
    direction: Row,
    gradient: Row,
    /// The part of dr that has been reported to the problem.
    reported: Row,
    /// b0 (m/s).
    bias: Row,
    /// Diagonal of W (1/kg).
    block: Row,
    /// C (1/kg), along the normal for compression.
    compliance: Row,
}

/// Bonded contacts side by side. A place without contact has no normal: it adds zeros to the first body.
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

/// u.w, u.p, w.C p, w.C w, w.C p under the new branches, p.C p and the square of the defect, place by place of the chunks.
type RowSums = [Row; 7];

/// Bonded contacts of one subdomain, or across all of them.
#[derive(Clone, Debug, Default)]
pub struct BondedBatch {
    /// Indices of the contacts in the problem.
    members: Vec<u32>,
    chunks: Vec<BondedChunk>,
    /// Square of D r0, which scales residuals.
    size: f64,
}

/// True for a bond that this form can treat: the stiffnesses in compression and tension must not differ too much.
pub fn suits_bond(contact: &Contact, bond: &BondContact) -> bool {
    let [tension, shear] = bond.law.compliance();
    tension < SOFT * contact.diagonal()[0] && shear < f64::from(f32::MAX)
}

impl BondedBatch {
    /// Forgets its contacts.
    pub fn start(&mut self) {
        self.members.clear();
        self.size = 0.0;
    }

    /// Adds a contact at the relative velocity u (m/s); bodies count from `first`.
    pub fn push(&mut self, index: u32, pair: (&Contact, &BondContact), u: [f64; 2], first: usize) {
        let (chunk, i) = (self.members.len() / CHUNK, self.members.len() % CHUNK);
        if chunk == self.chunks.len() {
            self.chunks.push(BondedChunk::empty());
        }
        self.members.push(index);
        self.chunks[chunk].set(i, pair, u, first as u32);
        let (contact, _) = pair;
        let (d, r) = (contact.diagonal(), contact.impulse);
        self.size += (d[0] * r[0]).powi(2) + (d[1] * r[1]).powi(2);
    }

    /// Ends the list of contacts: the rest of the last chunk is from an earlier problem.
    pub fn end(&mut self) {
        self.chunks.truncate(self.members.len().div_ceil(CHUNK));
        let places = self.members.len()..self.chunks.len() * CHUNK;
        if let Some(last) = self.chunks.last_mut() {
            places.for_each(|place| last.leave_out(place % CHUNK));
        }
    }

    /// Loads the softer bond of a contact, at the relative velocity u of the bodies of the problem (m/s), which has received all changes; false if
    /// the contact is in another batch.
    pub fn soften(
        &mut self,
        index: u32,
        (contact, bond): (&Contact, &BondContact),
        u: [f64; 2],
        velocities: &[BodyRow],
    ) -> bool {
        let Ok(member) = self.members.binary_search(&index) else {
            return false;
        };
        let (chunk, i) = (&mut self.chunks[member / CHUNK], member % CHUNK);
        let moved = |body: u32| velocities[body as usize].map(f64::from);
        let [[ax, ay, at, _], [bx, by, bt, _]] = [chunk.a[i], chunk.b[i]].map(moved);
        let moved = contact.relative_velocity([ax, ay, at], [bx, by, bt]);
        let change: [f64; 2] = from_fn(|axis| f64::from(chunk.axes[axis].change[i]));
        let start = Contact {
            impulse: from_fn(|axis| contact.impulse[axis] - change[axis]),
            ..*contact
        };
        chunk.set_law(i, (&start, bond), from_fn(|axis| u[axis] - moved[axis]));
        true
    }

    /// Changes of the impulses (N s) since the last call, by contact of the problem.
    pub fn changes(&mut self) -> impl Iterator<Item = (u32, [f64; 2])> {
        let chunks = &mut self.chunks;
        let members = self.members.iter().enumerate();
        members.map(move |(i, member)| {
            let chunk = &mut chunks[i / CHUNK];
            let change = chunk.axes.each_mut().map(|axis| axis.report(i % CHUNK));
            (*member, change)
        })
    }

    /// The contacts' part of an iteration with alpha and beta; returns its sums.
    #[inline(always)]
    pub fn iterate(
        &mut self,
        factors: [f32; 2],
        ((velocities, h_w), _): &mut BodySlice,
    ) -> PassSums<f64> {
        let mut sums: RowSums = [[0.0; CHUNK]; 7];
        let mut rows = [BodyRow::default(); CHUNK];
        for chunk in &mut self.chunks {
            chunk.gather(velocities, &mut rows);
            chunk.advance(factors, &mut rows, &mut sums);
            chunk.scatter(&rows, h_w);
        }
        let [uw, uz, wp, ww, wz, zz, defect] = sums.map(|sum| total(&sum));
        PassSums {
            uw,
            uz,
            products: Products { wp, ww, wz, zz },
            held: 0.0,
            defect,
            size: self.size,
        }
    }

    /// The same for a subdomain, with the products of its bodies.
    #[inline(always)]
    pub fn iterate_inside(&mut self, factors: [f32; 2], mut bodies: BodySlice) -> PassSums<f64> {
        let mut sums = self.iterate(factors, &mut bodies);
        let ((_, h_w), (momenta, inverse)) = bodies;
        sums.products.join(&products(h_w, momenta, inverse));
        sums
    }
}

impl SingleBodies {
    /// Loads the bodies of a problem at the start of a solve.
    pub fn load(&mut self, records: &[BodyRecord]) {
        for rows in [&mut self.velocities, &mut self.h_w, &mut self.momenta] {
            rows.clear();
            rows.resize(records.len(), BodyRow::default());
        }
        self.inverse.clear();
        self.inverse.extend(records.iter().map(|record| {
            let inverse = record.inverse_mass as f32;
            [inverse, inverse, 2.0 * inverse, 0.0]
        }));
    }

    /// All bodies.
    pub fn all(&mut self) -> BodySlice<'_> {
        (
            (&mut self.velocities, &mut self.h_w),
            (&mut self.momenta, &self.inverse),
        )
    }

    /// Marks a body that only contacts from outside move.
    pub fn leave(&mut self, body: u32) {
        self.inverse[body as usize] = BodyRow::default();
    }

    /// Sets dv of a body that contacts from outside move (m/s).
    pub fn place(&mut self, body: u32, [x, y, turn]: [f64; 3]) {
        self.velocities[body as usize] = [x as f32, y as f32, turn as f32, 0.0];
    }

    /// dv of some bodies.
    pub fn velocities(&self, bodies: Range<usize>) -> &[BodyRow] {
        &self.velocities[bodies]
    }

    /// H w of a body (N s).
    pub fn h_w(&self, body: u32) -> [f64; 3] {
        let h_w = self.h_w[body as usize];
        from_fn(|axis| f64::from(h_w[axis]))
    }
}

/// Takes the step alpha along m = H w + beta m, and forgets H w.
#[inline(always)]
pub fn follow(((velocities, h_w), (momenta, inverse)): BodySlice, [alpha, beta]: [f32; 2]) {
    let moved = velocities.as_flattened_mut().iter_mut();
    let moved = moved.zip(inverse.as_flattened());
    let along = momenta.as_flattened_mut().iter_mut();
    let along = along.zip(h_w.as_flattened_mut());
    for ((v, inverse), (m, w)) in moved.zip(along) {
        *m = *w + beta * *m;
        *v += alpha * *inverse * *m;
        *w = 0.0;
    }
}

/// Products of w and p by M^-1.
#[inline(always)]
fn products(h_w: &[BodyRow], momenta: &[BodyRow], inverse: &[BodyRow]) -> Products<f64> {
    let [mut wp, mut ww, mut pp] = [[0.0; WIDTH]; 3];
    let h_w = h_w.as_flattened().chunks(WIDTH);
    let momenta = momenta.as_flattened().chunks(WIDTH);
    let inverse = inverse.as_flattened().chunks(WIDTH);
    for ((w, m), inverse) in h_w.zip(momenta).zip(inverse) {
        let sums = wp.iter_mut().zip(&mut ww).zip(&mut pp);
        for (((w, m), inverse), ((wp, ww), pp)) in w.iter().zip(m).zip(inverse).zip(sums) {
            *wp += inverse * w * m;
            *ww += inverse * w * w;
            *pp += inverse * m * m;
        }
    }
    let [wp, ww, zz] = [wp, ww, pp].map(|sum| total(&sum));
    Products { wp, ww, wz: wp, zz }
}

impl BondedChunk {
    /// A chunk without contacts.
    fn empty() -> BondedChunk {
        let none = [0.0; CHUNK];
        let component = Component {
            change: none,
            direction: none,
            gradient: none,
            reported: none,
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
        (self.a[i], self.b[i]) = (contact.a - first, contact.b - first);
        let [nx, ny] = contact.normal;
        (self.normal[0][i], self.normal[1][i]) = (nx as f32, ny as f32);
        self.lever[i] = contact.lever() as f32;
        self.axes
            .iter_mut()
            .for_each(|component| component.begin(i));
        self.set_law(i, (contact, bond), u);
    }

    /// Impulse r0, compliances and b0 of a contact at the relative velocity u (m/s).
    fn set_law(&mut self, i: usize, (contact, bond): (&Contact, &BondContact), u: [f64; 2]) {
        let [tension, _] = bond.law.compliance();
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

    fn leave_out(&mut self, i: usize) {
        (self.a[i], self.b[i]) = (0, 0);
        for row in self
            .normal
            .iter_mut()
            .chain([&mut self.lever, &mut self.start])
        {
            row[i] = 0.0;
        }
        for component in &mut self.axes {
            component.begin(i);
            (component.bias[i], component.block[i]) = (0.0, 1.0);
        }
    }

    /// Change of the velocities of a against b, spins added.
    #[inline(always)]
    fn gather(&self, velocities: &[BodyRow], rows: &mut [BodyRow; CHUNK]) {
        for (row, (a, b)) in rows.iter_mut().zip(self.a.iter().zip(&self.b)) {
            let (a, b) = (velocities[*a as usize], velocities[*b as usize]);
            *row = from_fn(|k| a[k] - OPPOSITE[k] * b[k]);
        }
    }

    /// Moves the contacts, and measures them; the rows hold the velocities of the bodies, and then H w of a.
    #[inline(always)]
    fn advance(
        &mut self,
        [alpha, beta]: [f32; 2],
        rows: &mut [BodyRow; CHUNK],
        sums: &mut RowSums,
    ) {
        let [normal, tangent] = &mut self.axes;
        let [uw, up, wp, ww, wz, pp, defect] = sums;
        for (i, row) in rows.iter_mut().enumerate() {
            // All four numbers of a row are read, or the compiler would treat the last contacts of the chunk one by one.
            let [x, y, turn, nothing] = *row;
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
            uw[i] += u * w + v * t;
            up[i] += u * p + v * q;
            wp[i] += before * w * p + s * t * q;
            ww[i] += c * w * w + s * t * t;
            wz[i] += c * w * p + s * t * q;
            pp[i] += c * p * p + s * q * q;
            let off = [(normal.block[i] + spring) * w, tangent.block[i] * t];
            defect[i] += off[0] * off[0] + off[1] * off[1];
            *row = [w * nx - t * ny, w * ny + t * nx, lever * t, 0.0];
        }
    }

    /// Adds H w of the contacts to the bodies'.
    #[inline(always)]
    fn scatter(&self, rows: &[BodyRow; CHUNK], h_w: &mut [BodyRow]) {
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
    /// Starts without changes.
    fn begin(&mut self, i: usize) {
        (self.change[i], self.reported[i]) = (0.0, 0.0);
        (self.direction[i], self.gradient[i]) = (0.0, 0.0);
    }

    /// The change of dr since the last report.
    fn report(&mut self, i: usize) -> f64 {
        let change = f64::from(self.change[i]) - f64::from(self.reported[i]);
        self.reported[i] = self.change[i];
        change
    }

    /// p = w + beta p and dr += alpha p.
    #[inline(always)]
    fn step(&mut self, i: usize, [alpha, beta]: [f32; 2]) -> (f32, f32) {
        let p = self.gradient[i] + beta * self.direction[i];
        let change = self.change[i] + alpha * p;
        (self.direction[i], self.change[i]) = (p, change);
        (p, change)
    }
}

fn total<const N: usize>(row: &[f32; N]) -> f64 {
    row.iter().map(|x| f64::from(*x)).sum()
}
