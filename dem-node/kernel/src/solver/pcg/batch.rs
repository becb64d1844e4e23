//! Contacts that are treated one after the other, and the passes over them.

use super::body_state::{BodyState, DirectionLoss};
use super::branches::Branches;
use super::constrained::moved_by;
use super::group::{ContactFrames, Doubles, Iterate, LANES, PassSums, Preconditioner, Tangential};
use super::group::{Features, bias, compliance, threshold};
use crate::law::vector::{normal_defect, tangential_impulse};
use crate::solver::contact::Contact;
use crate::solver::problem::Problem;

/// The work of one pass over the contacts.
#[derive(Clone, Copy, Debug)]
pub enum Pass {
    /// Measure at the present impulses.
    Measure,
    /// Update the thresholds of friction, then measure.
    RenewThresholds,
    /// A step along p, then measure.
    Step {
        /// Length of the step.
        alpha: f64,
        /// p = w + beta z.
        beta: f64,
    },
}

/// Contacts with their data, in groups.
#[derive(Clone, Debug, Default)]
pub struct ContactBatch {
    /// First body, from which on they count.
    pub first: usize,
    /// Their indices in the problem.
    pub members: Vec<u32>,
    /// Their bodies and normals.
    pub frames: Vec<ContactFrames>,
    tangentials: Vec<Tangential>,
    preconditioners: [Vec<Preconditioner>; 2],
    /// b without the velocities of the bodies (m/s); empty along the tangent where it is all 0.
    biases: [Vec<Doubles>; 2],
    iterates: [Vec<Iterate>; 2],
    /// C (1/kg), for a bond in compression; empty along an axis where it is all 0.
    springs: [Vec<Doubles>; 2],
    /// Branches of bonds, one per group; empty without bonds.
    branches: Vec<Branches>,
    /// Losses of p when the contacts were measured.
    pub losses: Vec<DirectionLoss>,
    /// Sums of the last measurement.
    pub sums: PassSums<Doubles>,
}

impl ContactBatch {
    /// Forgets its contacts; the bodies of the next contacts count from `first`.
    pub fn clear(&mut self, first: usize) {
        self.first = first;
        self.members.clear();
        self.losses.clear();
    }

    /// Loads its members.
    pub fn load<F: Features>(&mut self, problem: &Problem) {
        let groups = self.members.len().div_ceil(LANES);
        let some = |wanted: bool| if wanted { groups } else { 0 };
        let axes = if F::FRICTION { 2 } else { 1 };
        renew(&mut self.frames, groups);
        renew(&mut self.tangentials, some(F::FRICTION));
        for axis in 0..2 {
            renew(&mut self.preconditioners[axis], some(axis < axes));
            renew(&mut self.biases[axis], some(axis < axes));
            renew(&mut self.iterates[axis], some(axis < axes));
            renew(&mut self.springs[axis], some(F::SOFT && axis < axes));
        }
        renew(&mut self.branches, some(F::BONDS));
        for (i, member) in self.members.iter().enumerate() {
            let (g, k) = (i / LANES, i % LANES);
            let contact = &problem.contacts[*member as usize];
            let bond = problem.bonds.get(contact.bond as usize);
            let frame = &mut self.frames[g];
            frame.a[k] = moved_by(problem, contact, 0) - self.first as u32;
            frame.b[k] = moved_by(problem, contact, 1) - self.first as u32;
            let [nx, ny] = &mut frame.normal;
            [nx.0[k], ny.0[k]] = contact.normal;
            for axis in 0..axes {
                self.preconditioners[axis][g].set(k, contact, bond, axis);
                self.biases[axis][g].0[k] = bias(contact, bond, axis);
                self.iterates[axis][g].impulse.0[k] = contact.impulse[axis];
                if F::SOFT {
                    self.springs[axis][g].0[k] = compliance(contact, bond, axis);
                }
            }
            if F::FRICTION {
                self.tangentials[g].lever.0[k] = contact.lever();
                self.tangentials[g].limit.0[k] = threshold(contact, bond, problem.friction);
            }
            if F::BONDS {
                self.branches[g].set(k, contact, bond);
            }
        }
        for lanes in [&mut self.biases[1], &mut self.springs[0]] {
            if !lanes.iter().any(|lanes| lanes.any()) {
                lanes.clear();
            }
        }
    }

    /// Loads the softer bond of a contact; false if the contact is in another batch.
    pub fn soften(&mut self, problem: &Problem, index: u32) -> bool {
        let Ok(member) = self.members.binary_search(&index) else {
            return false;
        };
        let (g, k) = (member / LANES, member % LANES);
        let contact = &problem.contacts[index as usize];
        let bond = problem.bonds.get(contact.bond as usize);
        for axis in 0..2 {
            if let Some(preconditioner) = self.preconditioners[axis].get_mut(g) {
                preconditioner.set(k, contact, bond, axis);
            }
            if let Some(springs) = self.springs[axis].get_mut(g) {
                springs.0[k] = compliance(contact, bond, axis);
            }
        }
        if let Some(tangential) = self.tangentials.get_mut(g) {
            tangential.limit.0[k] = threshold(contact, bond, problem.friction);
        }
        if let Some(branches) = self.branches.get_mut(g) {
            branches.set(k, contact, bond);
        }
        true
    }

    /// Forgets p and w.
    pub fn restart(&mut self) {
        for iterate in self.iterates.iter_mut().flatten() {
            iterate.direction = Doubles::default();
            iterate.gradient = Doubles::default();
        }
    }

    /// Writes the impulses back to contacts, which follow `passed` others.
    pub fn store(&self, contacts: &mut [Contact], passed: usize) {
        for (i, member) in self.members.iter().enumerate() {
            let lanes = |axis: usize| self.iterates[axis].get(i / LANES);
            let impulse = |axis: usize| lanes(axis).map_or(0.0, |m| m.impulse.0[i % LANES]);
            contacts[*member as usize - passed].impulse = [impulse(0), impulse(1)];
        }
    }

    /// The part of a pass before measuring; `give` receives the impulses that a projection adds, body by body.
    #[inline(always)]
    pub fn advance<F: Features>(
        &mut self,
        pass: Pass,
        friction: f64,
        mut give: impl FnMut(usize, [f64; 3]),
    ) {
        for g in 0..self.frames.len() {
            match pass {
                Pass::Measure => {}
                Pass::RenewThresholds => self.renew_thresholds::<F>(g, friction, &mut give),
                Pass::Step { alpha, beta } => self.step::<F>(g, [alpha, beta], &mut give),
            }
        }
    }

    /// p = w + beta z and r' = P(r + alpha p).
    #[inline(always)]
    fn step<F: Features>(
        &mut self,
        g: usize,
        factors: [f64; 2],
        give: impl FnMut(usize, [f64; 3]),
    ) {
        let factors = factors.map(Doubles::splat);
        let bounds = self.bounds::<F>(g);
        let surplus_n = self.iterates[0][g].advance(factors, bounds);
        let mut surplus_t = Doubles::default();
        if F::FRICTION {
            let limit = self.tangentials[g].limit;
            surplus_t = self.iterates[1][g].advance(factors, [-limit, limit]);
        }
        if surplus_n.any() || surplus_t.any() {
            self.spread(g, [surplus_n, surplus_t], give);
        }
    }

    /// Updates the thresholds, s = mu r_n, and brings r_t within them.
    #[inline(always)]
    fn renew_thresholds<F: Features>(
        &mut self,
        g: usize,
        friction: f64,
        give: impl FnMut(usize, [f64; 3]),
    ) {
        if !F::FRICTION {
            return;
        }
        let mut limit = Doubles::splat(friction) * self.iterates[0][g].impulse;
        if F::BONDS {
            limit = self.branches[g].select(self.tangentials[g].limit, limit);
        }
        self.tangentials[g].limit = limit;
        let tangent = &mut self.iterates[1][g].impulse;
        let allowed = tangential_impulse(*tangent, limit);
        let surplus = allowed - *tangent;
        *tangent = allowed;
        if surplus.any() {
            self.spread(g, [Doubles::default(), surplus], give);
        }
    }

    /// u, w and z at the present impulses, H w and the sums. `friction` is the coefficient.
    #[inline(always)]
    pub fn measure<F: Features>(&mut self, friction: f64, bodies: &mut [BodyState]) {
        let mut sums = PassSums::default();
        for g in 0..self.frames.len() {
            let frame = self.frames[g];
            let lever = if F::FRICTION {
                self.tangentials[g].lever
            } else {
                Doubles::default()
            };
            let [u_n, u_t] = frame.relative::<F>(lever, bodies);
            let ([w_n, lost_n], cone) = self.measure_normal::<F>(g, friction, u_n, &mut sums);
            let [mut w_t, mut lost_t] = [Doubles::default(); 2];
            if F::FRICTION {
                [w_t, lost_t] = self.measure_tangent::<F>(g, cone, u_t, &mut sums);
            }
            frame.scatter::<F>(lever, [w_n, w_t], bodies);
            if lost_n.any() || lost_t.any() {
                self.lose(g, [lost_n, lost_t]);
            }
        }
        self.sums = sums;
    }

    /// Normal part of the measurement; also returns the thresholds of friction at P(r - u/D).
    #[inline(always)]
    fn measure_normal<F: Features>(
        &mut self,
        g: usize,
        friction: f64,
        u: Doubles,
        sums: &mut PassSums<Doubles>,
    ) -> ([Doubles; 2], Doubles) {
        let r = self.iterates[0][g].impulse;
        let preconditioner = &self.preconditioners[0][g];
        let mut inverse = preconditioner.inverse.wide();
        let mut u = u + self.biases[0][g];
        let (mut before, mut c) = (Doubles::default(), Doubles::default());
        if F::SOFT {
            c = self.springs[0].get(g).copied().unwrap_or_default();
            before = c;
            if F::BONDS {
                let branches = &mut self.branches[g];
                before = branches.compliance(c);
                branches.take(r, u);
                c = branches.compliance(c);
                inverse = branches.inverse(preconditioner.inverse);
            }
            u = u + c * r;
        }
        let diagonal = preconditioner.diagonal.wide();
        let bounds = self.bounds::<F>(g);
        let back = -u * inverse;
        let found = self.iterates[0][g].measure::<F>([u, back], [before, c], bounds, sums);
        let scaled = diagonal * r;
        let mut off = normal_defect(u, scaled);
        if F::BONDS {
            let bonded = diagonal * (r - (r + back).clamp(bounds[0], bounds[1]));
            off = self.branches[g].select(bonded, off);
        }
        let square = off * off;
        sums.held = sums.held + square;
        sums.defect = sums.defect + square;
        sums.size = sums.size + scaled * scaled;
        (found, Doubles::splat(friction) * (r - off * inverse))
    }

    #[inline(always)]
    fn measure_tangent<F: Features>(
        &mut self,
        g: usize,
        mut cone: Doubles,
        u: Doubles,
        sums: &mut PassSums<Doubles>,
    ) -> [Doubles; 2] {
        let r = self.iterates[1][g].impulse;
        let limit = self.tangentials[g].limit;
        let preconditioner = &self.preconditioners[1][g];
        let diagonal = preconditioner.diagonal.wide();
        let bias = self.biases[1].get(g);
        let mut u = bias.map_or(u, |bias| u + *bias);
        let mut c = Doubles::default();
        if F::SOFT {
            c = self.springs[1].get(g).copied().unwrap_or_default();
            u = u + c * r;
        }
        if F::BONDS {
            cone = self.branches[g].select(limit, cone);
        }
        let back = -u * preconditioner.inverse.wide();
        let found = self.iterates[1][g].measure::<F>([u, back], [c, c], [-limit, limit], sums);
        let held = diagonal * (r - tangential_impulse(r + back, limit));
        let defect = diagonal * (r - tangential_impulse(r + back, cone));
        let scaled = diagonal * r;
        sums.held = sums.held + held * held;
        sums.defect = sums.defect + defect * defect;
        sums.size = sums.size + scaled * scaled;
        found
    }

    /// Bounds of r_n; both are 0 on one branch of a bond.
    #[inline(always)]
    fn bounds<F: Features>(&self, g: usize) -> [Doubles; 2] {
        if F::BONDS {
            self.branches[g].bounds()
        } else {
            [Doubles::splat(0.0), Doubles::splat(f64::INFINITY)]
        }
    }

    /// Gives both bodies their part of impulses (r_n, r_t), of the lanes that have any.
    #[inline(never)]
    fn spread(&self, g: usize, impulses: [Doubles; 2], mut give: impl FnMut(usize, [f64; 3])) {
        let frame = &self.frames[g];
        let [nx, ny] = frame.normal;
        let tangential = self.tangentials.get(g).copied().unwrap_or_default();
        for k in 0..LANES {
            let (n, t) = (impulses[0].0[k], impulses[1].0[k]);
            if n == 0.0 && t == 0.0 {
                continue;
            }
            let (x, y) = (n * nx.0[k] - t * ny.0[k], n * ny.0[k] + t * nx.0[k]);
            let turn = tangential.lever.0[k] * t;
            give(frame.a[k] as usize, [x, y, -turn]);
            give(frame.b[k] as usize, [-x, -y, -turn]);
        }
    }

    /// Reduces p to z, and records the losses of the bodies.
    #[inline(never)]
    fn lose(&mut self, g: usize, lost: [Doubles; 2]) {
        for (iterates, lost) in self.iterates.iter_mut().zip(lost) {
            if let Some(iterate) = iterates.get_mut(g) {
                iterate.direction = iterate.direction - lost;
            }
        }
        let mut losses = std::mem::take(&mut self.losses);
        self.spread(g, lost, |body, impulse| {
            let body = body as u32;
            losses.push(DirectionLoss { body, impulse });
        });
        self.losses = losses;
    }
}

fn renew<T: Clone + Default>(vector: &mut Vec<T>, count: usize) {
    vector.clear();
    vector.resize(count, T::default());
}
