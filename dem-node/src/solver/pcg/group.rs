//! Four contacts side by side, as the passes over them load them.

use super::body::Body;
use crate::bond::BondContact;
use crate::solver::{Contact, lanes};

/// Contacts in a group.
pub const LANES: usize = 4;

/// A number of each contact of a group.
pub type Lanes = lanes::Lanes<LANES>;

/// A number of each contact of a group where seven digits are enough: half the bytes.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(16))]
pub struct Short(pub [f32; LANES]);

impl Short {
    /// All digits.
    #[inline(always)]
    pub fn wide(self) -> Lanes {
        lanes::Lanes(self.0.map(f64::from))
    }
}

/// What the passes are compiled for: each leaves out what its problem has not.
pub trait Kind: Sync {
    /// Friction, or shear of bonds.
    const FRICTION: bool;
    /// Springs or bonds.
    const SOFT: bool;
    /// Bonds.
    const BONDS: bool;
}

/// Where contacts are. A lane without contact has no normal: it adds zeros to the first body.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(32))]
pub struct Place {
    /// Bodies, counted from the first of the batch.
    pub a: [u32; LANES],
    /// See `a`.
    pub b: [u32; LANES],
    /// n_x and n_y.
    pub normal: [Lanes; 2],
}

/// What friction needs beside the tangential line.
#[derive(Clone, Copy, Debug, Default)]
pub struct Grip {
    /// Levers of spin over the radius.
    pub lever: Lanes,
    /// Threshold s (N s): none on the shear of a bond.
    pub limit: Lanes,
}

/// What weighs one component. Any positive number would do in place of D, and seven digits of it do.
#[derive(Clone, Copy, Debug, Default)]
pub struct Weight {
    /// Diagonal of W with springs (1/kg), by which residuals are scaled.
    pub diagonal: Short,
    /// 1/D (kg), 0 where nothing moves along this axis.
    pub inverse: Short,
}

/// What moves.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motion {
    /// r (N s).
    pub impulse: Lanes,
    /// p while the contacts advance, z once they are measured.
    pub direction: Lanes,
    /// w.
    pub push: Lanes,
}

/// What a measurement sums up, lane by lane.
#[derive(Clone, Copy, Debug, Default)]
pub struct LaneSums {
    /// u.w and u.z.
    pub uw: Lanes,
    /// See `uw`.
    pub uz: Lanes,
    /// Part of the springs in w.(W + C) p and so on.
    pub wp: Lanes,
    /// See `wp`.
    pub ww: Lanes,
    /// See `wp`.
    pub wz: Lanes,
    /// See `wp`.
    pub zz: Lanes,
    /// Squares of the defect with thresholds held, of the true one, and of D r.
    pub held: Lanes,
    /// See `held`.
    pub defect: Lanes,
    /// See `held`.
    pub size: Lanes,
}

/// Compliance along an axis (1/kg): the bond's own in shear, the spring's otherwise.
pub fn compliance(contact: &Contact, bond: Option<&BondContact>, axis: usize) -> f64 {
    match bond {
        // A bond without shear stiffness has no shear impulse either.
        Some(bond) if axis == 1 => Some(bond.compliance()[1])
            .filter(|compliance| compliance.is_finite())
            .unwrap_or(0.0),
        _ => contact.compliance[axis],
    }
}

/// b without the velocities of the bodies (m/s).
pub fn bias(contact: &Contact, bond: Option<&BondContact>, axis: usize) -> f64 {
    match bond {
        Some(bond) if axis == 1 => bond.slip(),
        _ => contact.bias[axis],
    }
}

impl Weight {
    /// Fills a lane.
    pub fn set(&mut self, k: usize, contact: &Contact, bond: Option<&BondContact>, axis: usize) {
        let block = [contact.block.nn, contact.block.tt][axis];
        self.diagonal.0[k] = (block + contact.compliance[axis]) as f32;
        self.inverse.0[k] = inverse(block + compliance(contact, bond, axis));
    }
}

/// 1/D to seven digits. Where nothing moves along an axis, no impulse is looked for.
#[inline(always)]
pub fn inverse(d: f64) -> f32 {
    if d > 0.0 { (1.0 / d) as f32 } else { 0.0 }
}

impl Grip {
    /// Fills a lane. `friction` is the coefficient of contacts without bond.
    pub fn set(&mut self, k: usize, contact: &Contact, bond: Option<&BondContact>, friction: f64) {
        self.lever.0[k] = contact.lever();
        self.limit.0[k] = match bond {
            None => friction * contact.impulse[0],
            Some(bond) if bond.compliance()[1].is_finite() => f64::INFINITY,
            Some(_) => 0.0,
        };
    }
}

impl Motion {
    /// p and r' along them; returns what the projection adds.
    #[inline(always)]
    pub fn advance(&mut self, alpha: Lanes, beta: Lanes, low: Lanes, high: Lanes) -> Lanes {
        let p = self.push + beta * self.direction;
        let wanted = self.impulse + alpha * p;
        let allowed = wanted.clamp(low, high);
        self.direction = p;
        self.impulse = allowed;
        allowed - wanted
    }

    /// w from -u/D and what p loses, and the sums that they enter; the compliances are that along p and the one now.
    #[inline(always)]
    pub fn measure<K: Kind>(
        &mut self,
        [u, back]: [Lanes; 2],
        [before, c]: [Lanes; 2],
        [low, high]: [Lanes; 2],
        sums: &mut LaneSums,
    ) -> [Lanes; 2] {
        let (r, p) = (self.impulse, self.direction);
        let w = back.held(r, low, high);
        let z = p.held(r, low, high);
        self.push = w;
        sums.uw = sums.uw + u * w;
        sums.uz = sums.uz + u * z;
        if K::SOFT {
            let cw = c * w;
            sums.wp = sums.wp + before * w * p;
            sums.ww = sums.ww + cw * w;
            sums.wz = sums.wz + cw * z;
            sums.zz = sums.zz + c * z * z;
        }
        [w, p - z]
    }
}

impl Place {
    /// (u_n, u_t) of the contact points, a against b.
    #[inline(always)]
    pub fn relative<K: Kind>(&self, lever: Lanes, bodies: &[Body]) -> [Lanes; 2] {
        let (mut dx, mut dy, mut ds) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for k in 0..LANES {
            let a = &bodies[self.a[k] as usize].velocity;
            let b = &bodies[self.b[k] as usize].velocity;
            dx[k] = a[0] - b[0];
            dy[k] = a[1] - b[1];
            ds[k] = a[2] + b[2];
        }
        let ([nx, ny], dx, dy) = (self.normal, lanes::Lanes(dx), lanes::Lanes(dy));
        let tangential = if K::FRICTION {
            nx * dy - ny * dx - lever * lanes::Lanes(ds)
        } else {
            Lanes::default()
        };
        [nx * dx + ny * dy, tangential]
    }

    /// Adds impulses (r_n, r_t) of the contacts to H w.
    #[inline(always)]
    pub fn scatter<K: Kind>(&self, lever: Lanes, [n, t]: [Lanes; 2], bodies: &mut [Body]) {
        let [nx, ny] = self.normal;
        let (mut px, mut py) = (n * nx, n * ny);
        let mut turn = Lanes::default();
        if K::FRICTION {
            px = px - t * ny;
            py = py + t * nx;
            turn = lever * t;
        }
        for k in 0..LANES {
            let (x, y, turn) = (px.0[k], py.0[k], turn.0[k]);
            let a = &mut bodies[self.a[k] as usize].push;
            *a = [a[0] + x, a[1] + y, a[2] - turn];
            let b = &mut bodies[self.b[k] as usize].push;
            *b = [b[0] - x, b[1] - y, b[2] - turn];
        }
    }
}
