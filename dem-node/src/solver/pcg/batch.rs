//! Contacts that are treated one after the other, and the passes over them.

use super::body::{Body, Loss};
use super::group::{Grip, Kind, LaneSums, Motion, Place, Weight, bias, compliance};
use super::group::{LANES, Lanes};
use super::side::Sides;
use crate::solver::Problem;

/// Contacts with all that belongs to them, in groups.
#[derive(Clone, Debug, Default)]
pub struct Batch {
    /// Body from which on they count.
    pub first: usize,
    /// Their places in the problem.
    pub members: Vec<u32>,
    /// Where they are.
    pub places: Vec<Place>,
    grips: Vec<Grip>,
    weights: [Vec<Weight>; 2],
    /// b without the velocities of the bodies (m/s); none along the tangent where all of it is 0.
    biases: [Vec<Lanes>; 2],
    motions: [Vec<Motion>; 2],
    /// C (1/kg), where anything is soft.
    springs: [Vec<Lanes>; 2],
    /// Of bonds, one a group or none at all.
    sides: Vec<Sides>,
    /// What p lost when the contacts were measured.
    pub losses: Vec<Loss>,
    /// Of the contacts measured since they were cleared.
    pub sums: LaneSums,
}

impl Batch {
    /// Forgets its contacts; those to come count their bodies from here.
    pub fn clear(&mut self, first: usize) {
        self.first = first;
        self.members.clear();
        self.losses.clear();
    }

    /// Takes over its members.
    pub fn load<K: Kind>(&mut self, problem: &Problem) {
        let groups = self.members.len().div_ceil(LANES);
        let some = |wanted: bool| if wanted { groups } else { 0 };
        let axes = if K::FRICTION { 2 } else { 1 };
        renew(&mut self.places, groups);
        renew(&mut self.grips, some(K::FRICTION));
        for axis in 0..2 {
            renew(&mut self.weights[axis], some(axis < axes));
            renew(&mut self.biases[axis], some(axis < axes));
            renew(&mut self.motions[axis], some(axis < axes));
            renew(&mut self.springs[axis], some(K::SOFT && axis < axes));
        }
        renew(&mut self.sides, some(K::BONDS));
        for (i, member) in self.members.iter().enumerate() {
            let (g, k) = (i / LANES, i % LANES);
            let contact = &problem.contacts[*member as usize];
            let bond = problem.bonds.get(contact.bond as usize);
            let place = &mut self.places[g];
            place.a[k] = contact.a - self.first as u32;
            place.b[k] = contact.b - self.first as u32;
            let [nx, ny] = &mut place.normal;
            [nx.0[k], ny.0[k]] = contact.normal;
            for axis in 0..axes {
                self.weights[axis][g].set(k, contact, bond, axis);
                self.biases[axis][g].0[k] = bias(contact, bond, axis);
                self.motions[axis][g].impulse.0[k] = contact.impulse[axis];
                if K::SOFT {
                    self.springs[axis][g].0[k] = compliance(contact, bond, axis);
                }
            }
            if K::FRICTION {
                self.grips[g].set(k, contact, bond, problem.friction);
            }
            if K::BONDS {
                self.sides[g].set(k, contact, bond);
            }
        }
        if !self.biases[1].iter().any(|bias| bias.any()) {
            self.biases[1].clear();
        }
    }

    /// Writes the impulses back.
    pub fn store(&self, problem: &mut Problem) {
        for (i, member) in self.members.iter().enumerate() {
            let lanes = |axis: usize| self.motions[axis].get(i / LANES);
            let impulse = |axis: usize| lanes(axis).map_or(0.0, |m| m.impulse.0[i % LANES]);
            problem.contacts[*member as usize].impulse = [impulse(0), impulse(1)];
        }
    }

    /// p = w + beta z and r' = P(r + alpha p); `give` gets what the projection adds, body by body.
    #[inline(always)]
    pub fn advance<K: Kind>(
        &mut self,
        g: usize,
        [alpha, beta]: [f64; 2],
        give: impl FnMut(usize, [f64; 3]),
    ) {
        let (alpha, beta) = (Lanes::splat(alpha), Lanes::splat(beta));
        let [low, high] = self.bounds::<K>(g);
        let surplus_n = self.motions[0][g].advance(alpha, beta, low, high);
        let mut surplus_t = Lanes::default();
        if K::FRICTION {
            let limit = self.grips[g].limit;
            surplus_t = self.motions[1][g].advance(alpha, beta, -limit, limit);
        }
        if surplus_n.any() || surplus_t.any() {
            self.spread(g, [surplus_n, surplus_t], give);
        }
    }

    /// Takes the thresholds anew, s = mu r_n, and brings r_t within them; `give` gets what that adds.
    #[inline(always)]
    pub fn renew_limits<K: Kind>(
        &mut self,
        g: usize,
        friction: f64,
        give: impl FnMut(usize, [f64; 3]),
    ) {
        if !K::FRICTION {
            return;
        }
        let mut limit = Lanes::splat(friction) * self.motions[0][g].impulse;
        if K::BONDS {
            limit = self.sides[g].select(self.grips[g].limit, limit);
        }
        self.grips[g].limit = limit;
        let tangent = &mut self.motions[1][g].impulse;
        let allowed = tangent.clamp(-limit, limit);
        let surplus = allowed - *tangent;
        *tangent = allowed;
        if surplus.any() {
            self.spread(g, [Lanes::default(), surplus], give);
        }
    }

    /// u, w and z at the impulses reached, H w and the sums. `friction` is the coefficient.
    #[inline(always)]
    pub fn measure<K: Kind>(&mut self, g: usize, friction: f64, bodies: &mut [Body]) {
        let place = self.places[g];
        let lever = if K::FRICTION {
            self.grips[g].lever
        } else {
            Lanes::default()
        };
        let [u_n, u_t] = place.relative::<K>(lever, bodies);
        let ([w_n, lost_n], cone) = self.measure_normal::<K>(g, friction, u_n);
        let [mut w_t, mut lost_t] = [Lanes::default(); 2];
        if K::FRICTION {
            [w_t, lost_t] = self.measure_tangent::<K>(g, cone, u_t);
        }
        place.scatter::<K>(lever, [w_n, w_t], bodies);
        if lost_n.any() || lost_t.any() {
            self.lose(g, [lost_n, lost_t]);
        }
    }

    /// Also returns the thresholds of friction that belong to P(r - u/D).
    #[inline(always)]
    fn measure_normal<K: Kind>(
        &mut self,
        g: usize,
        friction: f64,
        u: Lanes,
    ) -> ([Lanes; 2], Lanes) {
        let r = self.motions[0][g].impulse;
        let weight = &mut self.weights[0][g];
        let mut u = u + self.biases[0][g];
        let [mut c, mut before] = [Lanes::default(); 2];
        if K::SOFT {
            let compliance = &mut self.springs[0][g];
            before = *compliance;
            if K::BONDS {
                self.sides[g].take(r, u, compliance, &mut weight.inverse);
            }
            c = *compliance;
            u = u + c * r;
        }
        let (diagonal, inverse) = (weight.diagonal.wide(), weight.inverse.wide());
        let bounds = self.bounds::<K>(g);
        let back = -u * inverse;
        let sums = &mut self.sums;
        let found = self.motions[0][g].measure::<K>([u, back], [before, c], bounds, sums);
        // D (r - P(r - u/D)), as in Problem::residual.
        let scaled = diagonal * r;
        let mut off = u.least(scaled);
        if K::BONDS {
            let bonded = diagonal * (r - (r + back).clamp(bounds[0], bounds[1]));
            off = self.sides[g].select(bonded, off);
        }
        let square = off * off;
        sums.held = sums.held + square;
        sums.defect = sums.defect + square;
        sums.size = sums.size + scaled * scaled;
        (found, Lanes::splat(friction) * (r - off * inverse))
    }

    #[inline(always)]
    fn measure_tangent<K: Kind>(&mut self, g: usize, mut cone: Lanes, u: Lanes) -> [Lanes; 2] {
        let r = self.motions[1][g].impulse;
        let limit = self.grips[g].limit;
        let weight = &self.weights[1][g];
        let (diagonal, inverse) = (weight.diagonal.wide(), weight.inverse.wide());
        let bias = self.biases[1].get(g);
        let mut u = bias.map_or(u, |bias| u + *bias);
        let mut c = Lanes::default();
        if K::SOFT {
            c = self.springs[1][g];
            u = u + c * r;
        }
        if K::BONDS {
            cone = self.sides[g].select(limit, cone);
        }
        let back = -u * inverse;
        let sums = &mut self.sums;
        let found = self.motions[1][g].measure::<K>([u, back], [c, c], [-limit, limit], sums);
        let held = diagonal * (r - (r + back).clamp(-limit, limit));
        let defect = diagonal * (r - (r + back).clamp(-cone, cone));
        let scaled = diagonal * r;
        sums.held = sums.held + held * held;
        sums.defect = sums.defect + defect * defect;
        sums.size = sums.size + scaled * scaled;
        found
    }

    /// Bounds of r_n; both are 0 on one side of a bond.
    #[inline(always)]
    fn bounds<K: Kind>(&self, g: usize) -> [Lanes; 2] {
        if K::BONDS {
            self.sides[g].bounds
        } else {
            [Lanes::splat(0.0), Lanes::splat(f64::INFINITY)]
        }
    }

    /// Gives both bodies their part of impulses (r_n, r_t), of the lanes that have any.
    #[inline(never)]
    fn spread(&self, g: usize, impulses: [Lanes; 2], mut give: impl FnMut(usize, [f64; 3])) {
        let place = &self.places[g];
        let [nx, ny] = place.normal;
        let grip = self.grips.get(g).copied().unwrap_or_default();
        for k in 0..LANES {
            let (n, t) = (impulses[0].0[k], impulses[1].0[k]);
            if n == 0.0 && t == 0.0 {
                continue;
            }
            let (x, y) = (n * nx.0[k] - t * ny.0[k], n * ny.0[k] + t * nx.0[k]);
            let turn = grip.lever.0[k] * t;
            give(place.a[k] as usize, [x, y, -turn]);
            give(place.b[k] as usize, [-x, -y, -turn]);
        }
    }

    /// Leaves z of p, and notes what the bodies lose.
    #[inline(never)]
    fn lose(&mut self, g: usize, lost: [Lanes; 2]) {
        for (motions, lost) in self.motions.iter_mut().zip(lost) {
            if let Some(motion) = motions.get_mut(g) {
                motion.direction = motion.direction - lost;
            }
        }
        let mut losses = std::mem::take(&mut self.losses);
        self.spread(g, lost, |body, impulse| {
            losses.push(Loss {
                body: body as u32,
                impulse,
            });
        });
        self.losses = losses;
    }
}

fn renew<T: Clone + Default>(vector: &mut Vec<T>, count: usize) {
    vector.clear();
    vector.resize(count, T::default());
}
