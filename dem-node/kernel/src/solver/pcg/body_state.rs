//! The bodies' part of the directions, and of the products with W.

use crate::solver::contact::BodyRecord;

/// A body in the form that contacts use, in one line of the cache.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
pub struct BodyState {
    /// v_x, v_y and spin times radius (m/s).
    pub velocity: [f64; 3],
    /// 1/m (1/kg); 0 for the wheel and glued disks, whose response is in [`super::constrained`].
    pub inverse_mass: f64,
    /// H w (N s).
    pub h_w: [f64; 3],
    /// 1/m again, but 0 where contacts from outside its block act.
    pub inner: f64,
}

impl BodyState {
    /// A body without contacts from outside.
    pub fn new(record: &BodyRecord) -> BodyState {
        BodyState {
            velocity: record.velocity,
            inverse_mass: record.inverse_mass,
            h_w: [0.0; 3],
            inner: record.inverse_mass,
        }
    }

    /// v += M^-1 of an impulse.
    #[inline(always)]
    pub fn kick(&mut self, impulse: [f64; 3]) {
        let inverse = self.inverse_mass;
        self.velocity[0] += inverse * impulse[0];
        self.velocity[1] += inverse * impulse[1];
        self.velocity[2] += 2.0 * inverse * impulse[2];
    }

    /// Takes the step alpha along H p = H w + beta H z, and forgets H w.
    #[inline(always)]
    pub fn follow(&mut self, momentum: &mut Momentum, alpha: f64, beta: f64) {
        let inverse = alpha * self.inverse_mass;
        for (axis, inverse) in [inverse, inverse, 2.0 * inverse].into_iter().enumerate() {
            let along = self.h_w[axis] + beta * momentum[axis];
            momentum[axis] = along;
            self.velocity[axis] += inverse * along;
            self.h_w[axis] = 0.0;
        }
    }
}

/// H p, then H z (N s).
pub type Momentum = [f64; 3];

/// Loss of p on one of the bodies, where its contact has come to a bound.
#[derive(Clone, Copy, Debug)]
pub struct DirectionLoss {
    /// Number of the body, counted from the first of the batch.
    pub body: u32,
    /// Part of H (p - z) (N s).
    pub impulse: [f64; 3],
}

/// Products with W, or with its part by some bodies.
#[derive(Clone, Copy, Debug, Default)]
pub struct Products<T> {
    /// w.W p, p before its losses.
    pub wp: T,
    /// w.W w, w.W z and z.W z.
    pub ww: T,
    /// See `ww`.
    pub wz: T,
    /// See `ww`.
    pub zz: T,
}

impl Products<f64> {
    /// Adds the part of a body before its losses.
    #[inline(always)]
    pub fn add(&mut self, inverse_mass: f64, h_w: &[f64; 3], momentum: &Momentum) {
        let wp = inverse_mass * dot(h_w, momentum);
        self.wp += wp;
        self.wz += wp;
        self.ww += inverse_mass * dot(h_w, h_w);
        self.zz += inverse_mass * dot(momentum, momentum);
    }

    /// Subtracts a loss from H z.
    #[inline(always)]
    pub fn lose(
        &mut self,
        inverse_mass: f64,
        h_w: &[f64; 3],
        momentum: &mut Momentum,
        d: &[f64; 3],
    ) {
        self.wz -= inverse_mass * dot(h_w, d);
        self.zz += inverse_mass * (dot(d, d) - 2.0 * dot(momentum, d));
        for (momentum, lost) in momentum.iter_mut().zip(d) {
            *momentum -= lost;
        }
    }

    /// Adds the products of other bodies.
    pub fn join(&mut self, other: &Products<f64>) {
        kit::add_fields!(self, other; wp, ww, wz, zz);
    }
}

/// Spin has twice the inverse inertia.
#[inline(always)]
fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + 2.0 * a[2] * b[2]
}
