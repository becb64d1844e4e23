//! Contacts of bodies that turn about another point than the centre of the touching disk.
//!
//! A disk has the lever -r n (as a) or r n (as b): spin moves its contact points along the tangent only, and W_nt = 0. In a
//! cluster the lever has any direction: spin moves the contact along both, and W_nt is not 0.

use crate::law::local::DelassusBlock;

/// Levers and inertia of both bodies of a contact, a before b.
#[derive(Clone, Copy, Debug, Default)]
pub struct Levers {
    /// Lever over radius: velocity of the contact point along normal and tangent by a unit of (spin times radius).
    pub lever: [[f64; 2]; 2],
    /// Change by a unit impulse of (v_x, v_y, spin times radius) (1/kg); 0 where all motion is prescribed.
    pub inverse: [[f64; 3]; 2],
}

impl Levers {
    /// (u_n, u_t) of the contact points, a against b (m/s).
    #[inline(always)]
    pub fn project(&self, normal: [f64; 2], a: [f64; 3], b: [f64; 3]) -> [f64; 2] {
        let (dx, dy) = (a[0] - b[0], a[1] - b[1]);
        let turn = |axis: usize| self.lever[0][axis] * a[2] - self.lever[1][axis] * b[2];
        [
            normal[0] * dx + normal[1] * dy + turn(0),
            normal[0] * dy - normal[1] * dx + turn(1),
        ]
    }

    /// Adds the change by the impulse (r_n, r_t) of the contact to a velocity; `force` is this impulse in x and y on the body, `side` 0 for a and 1
    /// for b (N s).
    #[inline(always)]
    pub fn apply(&self, side: usize, velocity: &mut [f64; 3], force: [f64; 2], impulse: [f64; 2]) {
        let (inverse, lever) = (self.inverse[side], self.lever[side]);
        let turn = lever[0] * impulse[0] + lever[1] * impulse[1];
        velocity[0] += inverse[0] * force[0];
        velocity[1] += inverse[1] * force[1];
        velocity[2] += inverse[2] * if side == 0 { turn } else { -turn };
    }

    /// The part of the block of W that comes from spin, of one body.
    pub fn turning(&self, side: usize) -> DelassusBlock {
        let ([n, t], spin) = (self.lever[side], self.inverse[side][2]);
        DelassusBlock {
            nn: n * n * spin,
            nt: n * t * spin,
            tt: t * t * spin,
        }
    }
}
