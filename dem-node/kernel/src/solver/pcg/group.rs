//! Four contacts side by side, in the form that passes load.

use super::body_state::{BodyState, Products};
use crate::contact::bond::BondContact;
use crate::law::lanes;
use crate::law::vector::feasible;
use crate::solver::contact::Contact;

/// Contacts in a group.
pub const LANES: usize = 4;

/// Features of a problem: iterations are compiled without the others.
pub trait Features {
    /// Friction, which bonds need for their shear.
    const FRICTION: bool;
    /// Bonds.
    const BONDS: bool;
    /// Springs, or bonds.
    const SOFT: bool;
}

/// A problem with these features.
pub struct With<const FRICTION: bool, const BONDS: bool, const SOFT: bool>;

impl<const FRICTION: bool, const BONDS: bool, const SOFT: bool> Features
    for With<FRICTION, BONDS, SOFT>
{
    const FRICTION: bool = FRICTION;
    const BONDS: bool = BONDS;
    const SOFT: bool = SOFT;
}

/// A number of each contact of a group.
pub type Doubles = lanes::Lanes<LANES>;

/// The same with seven digits.
pub type Singles = lanes::ShortLanes<LANES>;

/// Bodies and normals of the contacts. A lane without contact has no normal: it adds zeros to the first body.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(32))]
pub struct ContactFrames {
    /// Bodies, counted from the first of the batch.
    pub a: [u32; LANES],
    /// See `a`.
    pub b: [u32; LANES],
    /// n_x and n_y.
    pub normal: [Doubles; 2],
}

/// Lever and threshold, for friction.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tangential {
    /// Levers of spin over the radius.
    pub lever: Doubles,
    /// Threshold s (N s), infinite for the shear of a bond.
    pub limit: Doubles,
}

/// Preconditioner D of one component. Any positive number would do, and seven digits are enough.
#[derive(Clone, Copy, Debug, Default)]
pub struct Preconditioner {
    /// Diagonal of W with springs (1/kg), which scales residuals.
    pub diagonal: Singles,
    /// 1/D (kg), 0 where nothing moves along this axis.
    pub inverse: Singles,
}

/// The vectors r, p and w of one component.
#[derive(Clone, Copy, Debug, Default)]
pub struct Iterate {
    /// r (N s).
    pub impulse: Doubles,
    /// p while the contacts advance, z once they are measured.
    pub direction: Doubles,
    /// w.
    pub gradient: Doubles,
}

/// Sums over contacts, of numbers or lane by lane.
#[derive(Clone, Copy, Debug, Default)]
pub struct PassSums<T> {
    /// u.w and u.z.
    pub uw: T,
    /// See `uw`.
    pub uz: T,
    /// w.(W + C) p, w.(W + C) w, w.(W + C) z and z.(W + C) z; lane by lane the part of C.
    pub products: Products<T>,
    /// Squares of the defect with thresholds held, of the true defect, and of D r.
    pub held: T,
    /// See `held`.
    pub defect: T,
    /// See `held`.
    pub size: T,
}

impl PassSums<f64> {
    /// Adds sums lane by lane.
    pub fn add(&mut self, lanes: &PassSums<Doubles>) {
        self.uw += lanes.uw.sum();
        self.uz += lanes.uz.sum();
        self.products.wp += lanes.products.wp.sum();
        self.products.ww += lanes.products.ww.sum();
        self.products.wz += lanes.products.wz.sum();
        self.products.zz += lanes.products.zz.sum();
        self.held += lanes.held.sum();
        self.defect += lanes.defect.sum();
        self.size += lanes.size.sum();
    }

    /// Adds the sums of other contacts.
    pub fn join(&mut self, other: &PassSums<f64>) {
        self.products.join(&other.products);
        kit::add_fields!(self, other; uw, uz, held, defect, size);
    }
}

/// Compliance along an axis (1/kg): the bond's own in shear, the spring's otherwise.
pub fn compliance(contact: &Contact, bond: Option<&BondContact>, axis: usize) -> f64 {
    match bond {
        // A bond without shear stiffness has no shear impulse either.
        Some(bond) if axis == 1 => Some(bond.law.compliance()[1])
            .filter(|compliance| compliance.is_finite())
            .unwrap_or(0.0),
        _ => contact.compliance[axis],
    }
}

/// b without the velocities of the bodies (m/s).
pub fn bias(contact: &Contact, bond: Option<&BondContact>, axis: usize) -> f64 {
    match bond {
        Some(bond) if axis == 1 => bond.law.slip,
        _ => contact.bias[axis],
    }
}

/// Threshold s of the tangential impulse (N s) at the impulse of a contact; `friction` is the coefficient without bond.
pub fn threshold(contact: &Contact, bond: Option<&BondContact>, friction: f64) -> f64 {
    match bond {
        None => friction * contact.impulse[0],
        Some(bond) if bond.law.compliance()[1].is_finite() => f64::INFINITY,
        Some(_) => 0.0,
    }
}

/// 1/D with seven digits. Where nothing moves along an axis, the impulse is not iterated.
#[inline(always)]
pub fn inverse(d: f64) -> f32 {
    if d > 0.0 { (1.0 / d) as f32 } else { 0.0 }
}

impl Preconditioner {
    /// Fills a lane.
    pub fn set(&mut self, k: usize, contact: &Contact, bond: Option<&BondContact>, axis: usize) {
        let block = [contact.block.nn, contact.block.tt][axis];
        self.diagonal.0[k] = contact.diagonal()[axis] as f32;
        self.inverse.0[k] = inverse(block + compliance(contact, bond, axis));
    }
}

impl Iterate {
    /// p = w + beta z and r' = P(r + alpha p) between the bounds; returns the change by the projection.
    #[inline(always)]
    pub fn advance(&mut self, [alpha, beta]: [Doubles; 2], [low, high]: [Doubles; 2]) -> Doubles {
        let p = self.gradient + beta * self.direction;
        let wanted = self.impulse + alpha * p;
        let allowed = wanted.clamp(low, high);
        self.direction = p;
        self.impulse = allowed;
        allowed - wanted
    }

    /// w from -u/D and the loss of p, and their sums; the compliances are for p and for the present branch.
    #[inline(always)]
    pub fn measure<F: Features>(
        &mut self,
        [u, back]: [Doubles; 2],
        [before, c]: [Doubles; 2],
        bounds: [Doubles; 2],
        sums: &mut PassSums<Doubles>,
    ) -> [Doubles; 2] {
        let (r, p) = (self.impulse, self.direction);
        let w = feasible(back, r, bounds);
        let z = feasible(p, r, bounds);
        self.gradient = w;
        sums.uw = sums.uw + u * w;
        sums.uz = sums.uz + u * z;
        if F::SOFT {
            let cw = c * w;
            let products = &mut sums.products;
            products.wp = products.wp + before * w * p;
            products.ww = products.ww + cw * w;
            products.wz = products.wz + cw * z;
            products.zz = products.zz + c * z * z;
        }
        [w, p - z]
    }
}

impl ContactFrames {
    /// (u_n, u_t) of the contact points, a against b.
    #[inline(always)]
    pub fn relative<F: Features>(&self, lever: Doubles, bodies: &[BodyState]) -> [Doubles; 2] {
        let (mut dx, mut dy, mut ds) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for k in 0..LANES {
            let a = &bodies[self.a[k] as usize].velocity;
            let b = &bodies[self.b[k] as usize].velocity;
            dx[k] = a[0] - b[0];
            dy[k] = a[1] - b[1];
            ds[k] = a[2] + b[2];
        }
        let ([nx, ny], dx, dy) = (self.normal, lanes::Lanes(dx), lanes::Lanes(dy));
        let tangential = if F::FRICTION {
            nx * dy - ny * dx - lever * lanes::Lanes(ds)
        } else {
            Doubles::default()
        };
        [nx * dx + ny * dy, tangential]
    }

    /// Adds w of the contacts, (w_n, w_t), to H w.
    #[inline(always)]
    pub fn scatter<F: Features>(
        &self,
        lever: Doubles,
        [n, t]: [Doubles; 2],
        bodies: &mut [BodyState],
    ) {
        let [nx, ny] = self.normal;
        let (mut px, mut py) = (n * nx, n * ny);
        let mut turn = Doubles::default();
        if F::FRICTION {
            px = px - t * ny;
            py = py + t * nx;
            turn = lever * t;
        }
        for k in 0..LANES {
            let (x, y, turn) = (px.0[k], py.0[k], turn.0[k]);
            let a = &mut bodies[self.a[k] as usize].h_w;
            *a = [a[0] + x, a[1] + y, a[2] - turn];
            let b = &mut bodies[self.b[k] as usize].h_w;
            *b = [b[0] - x, b[1] - y, b[2] - turn];
        }
    }
}
