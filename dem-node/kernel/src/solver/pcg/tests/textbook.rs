//! The projected conjugate gradient by the equations of [`super::super`] (Renouf and Alart 2005, algorithm CPG), with u, q and every velocity
//! computed again, contact after contact, without any shortcut. The tests compare every iteration of the fast form with it.

use crate::law::local::in_tension;
use crate::solver::contact::Contact;
use crate::solver::pcg::INNER;
use crate::solver::pcg::group::{compliance, inverse, threshold};
use crate::solver::problem::Problem;

/// A number of each component of all contacts.
type Field = Vec<[f64; 2]>;

/// The solver at an iteration.
pub struct Textbook<'a> {
    problem: &'a Problem,
    /// r at the start, whose effect the velocities of the problem include.
    first: Field,
    /// r.
    pub impulses: Field,
    directions: Field,
    /// q.
    images: Field,
    gradients: Field,
    /// u.
    velocities: Field,
    limits: Vec<f64>,
    /// True for a contact on the tensile branch of its bond.
    pulls: Vec<bool>,
    /// True for a contact whose r_n has no bound at the end of its branch.
    unbounded: Vec<bool>,
    curvature: f64,
}

impl<'a> Textbook<'a> {
    /// The start from a prepared problem; bonds that are `unbounded` pass from one branch to the other within an iteration.
    pub fn new(problem: &'a Problem, unbounded: impl Fn(&Contact) -> bool) -> Textbook<'a> {
        let contacts = &problem.contacts;
        let first: Field = contacts.iter().map(|c| c.impulse).collect();
        let bond = |i: usize| problem.bonds.get(contacts[i].bond as usize);
        let limit = |i: usize| threshold(&contacts[i], bond(i), problem.friction);
        let mut plain = Textbook {
            problem,
            limits: (0..contacts.len()).map(limit).collect(),
            pulls: vec![false; contacts.len()],
            unbounded: contacts.iter().map(unbounded).collect(),
            impulses: first.clone(),
            directions: vec![[0.0; 2]; contacts.len()],
            images: vec![[0.0; 2]; contacts.len()],
            gradients: vec![[0.0; 2]; contacts.len()],
            velocities: vec![[0.0; 2]; contacts.len()],
            curvature: 0.0,
            first,
        };
        plain.measure();
        plain
    }

    /// One iteration.
    pub fn step(&mut self) {
        let kept = self.kept();
        let mut beta = if self.curvature > 0.0 {
            -dot(&self.gradients, &self.images) / self.curvature
        } else {
            0.0
        };
        let [held, defect] = self.defects();
        if self.problem.friction > 0.0 && held <= INNER * defect {
            self.renew_limits();
            beta = 0.0;
        }
        let mut descent = self.turn(&kept, beta);
        if descent <= 0.0 {
            descent = self.turn(&kept, 0.0);
        }
        self.images = self.product(&self.directions);
        self.curvature = dot(&self.directions, &self.images);
        let alpha = descent / self.curvature;
        for i in 0..self.impulses.len() {
            for axis in 0..2 {
                let [low, high] = self.bounds(i, axis);
                let wanted = self.impulses[i][axis] + alpha * self.directions[i][axis];
                self.impulses[i][axis] = wanted.clamp(low, high);
            }
        }
        self.measure();
    }

    /// v of all bodies, then of the glued disks.
    pub fn speeds(&self) -> (Vec<[f64; 3]>, Vec<f64>) {
        let added: Field = (self.impulses.iter().zip(&self.first))
            .map(|(r, first)| [r[0] - first[0], r[1] - first[1]])
            .collect();
        let (mut bodies, mut wall) = self.answer(&added);
        for (v, record) in bodies.iter_mut().zip(&self.problem.records) {
            (0..3).for_each(|axis| v[axis] += record.velocity[axis]);
        }
        let before = &self.problem.boundary.velocity;
        wall.iter_mut().zip(before).for_each(|(v, w)| *v += w);
        (bodies, wall)
    }

    /// p = w + beta z; returns -u.p.
    fn turn(&mut self, kept: &Field, beta: f64) -> f64 {
        for (i, p) in self.directions.iter_mut().enumerate() {
            *p = [0, 1].map(|axis| self.gradients[i][axis] + beta * kept[i][axis]);
        }
        -dot(&self.velocities, &self.directions)
    }

    /// u = (W + C) r + b from the velocities of the bodies, the branches of bonds, and w.
    fn measure(&mut self) {
        let speeds = self.speeds();
        for i in 0..self.impulses.len() {
            let contact = &self.problem.contacts[i];
            let bond = self.problem.bonds.get(contact.bond as usize);
            let bias = [
                contact.bias[0],
                bond.map_or(contact.bias[1], |b| b.law.slip),
            ];
            let u = self.relative(i, &speeds);
            let u = [u[0] + bias[0], u[1] + bias[1]];
            let r = self.impulses[i];
            self.pulls[i] = bond.is_some_and(|bond| bond.law.compliance()[0].is_finite())
                && in_tension(r[0], u[0]);
            for axis in 0..2 {
                let full = u[axis] + self.compliance(i, axis) * r[axis];
                self.velocities[i][axis] = full;
                self.gradients[i][axis] = left(self.wanted(i, axis), r[axis], self.bounds(i, axis));
            }
        }
    }

    fn renew_limits(&mut self) {
        for (i, r) in self.impulses.iter_mut().enumerate() {
            if self.problem.contacts[i].bond as usize >= self.problem.bonds.len() {
                self.limits[i] = self.problem.friction * r[0];
            }
            r[1] = r[1].clamp(-self.limits[i], self.limits[i]);
        }
        self.measure();
    }

    /// z.
    fn kept(&self) -> Field {
        let kept = |i: usize| {
            [0, 1].map(|axis| {
                let r = self.impulses[i][axis];
                left(self.directions[i][axis], r, self.bounds(i, axis))
            })
        };
        (0..self.impulses.len()).map(kept).collect()
    }

    /// Norms of D (r - P(r - u/D)) with the thresholds held, and with the thresholds of the projected r_n.
    fn defects(&self) -> [f64; 2] {
        let mut squares = [0.0; 2];
        for (i, contact) in self.problem.contacts.iter().enumerate() {
            let d = [contact.block.nn, contact.block.tt];
            let d = [0, 1].map(|axis| d[axis] + contact.compliance[axis]);
            let target = [0, 1].map(|axis| self.impulses[i][axis] + self.wanted(i, axis));
            let [low, high] = self.bounds(i, 0);
            let r_n = target[0].clamp(low, high);
            let free = contact.bond as usize >= self.problem.bonds.len();
            let cone = if free {
                self.problem.friction * r_n
            } else {
                self.limits[i]
            };
            for (square, limit) in squares.iter_mut().zip([self.limits[i], cone]) {
                let r_t = target[1].clamp(-limit, limit);
                *square += (d[0] * (self.impulses[i][0] - r_n)).powi(2);
                *square += (d[1] * (self.impulses[i][1] - r_t)).powi(2);
            }
        }
        squares.map(f64::sqrt)
    }

    /// -u/D.
    fn wanted(&self, i: usize, axis: usize) -> f64 {
        let block = self.problem.contacts[i].block;
        let d = [block.nn, block.tt][axis] + self.compliance(i, axis);
        -self.velocities[i][axis] * f64::from(inverse(d))
    }

    fn bounds(&self, i: usize, axis: usize) -> [f64; 2] {
        match (axis, self.pulls[i]) {
            (0, _) if self.unbounded[i] => [f64::NEG_INFINITY, f64::INFINITY],
            (0, false) => [0.0, f64::INFINITY],
            (0, true) => [f64::NEG_INFINITY, 0.0],
            _ => [-self.limits[i], self.limits[i]],
        }
    }

    fn compliance(&self, i: usize, axis: usize) -> f64 {
        let contact = &self.problem.contacts[i];
        let bond = self.problem.bonds.get(contact.bond as usize);
        match (bond, axis) {
            (Some(bond), 0) if self.pulls[i] => bond.law.compliance()[0],
            _ => compliance(contact, bond, axis),
        }
    }

    /// (W + C) x.
    fn product(&self, x: &Field) -> Field {
        let speeds = self.answer(x);
        let image = |i: usize| {
            let u = self.relative(i, &speeds);
            [0, 1].map(|axis| u[axis] + self.compliance(i, axis) * x[i][axis])
        };
        (0..x.len()).map(image).collect()
    }

    /// M^-1 H x: velocities of all bodies, then of the glued disks.
    fn answer(&self, x: &Field) -> (Vec<[f64; 3]>, Vec<f64>) {
        let problem = self.problem;
        let mut bodies = vec![[0.0; 3]; problem.records.len()];
        let mut load = vec![0.0; problem.boundary.velocity.len()];
        for (contact, [n, t]) in problem.contacts.iter().zip(x) {
            let force = contact.in_xy([*n, *t]);
            let levers = problem.levers.get(contact.levers as usize);
            for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
                let body = [contact.a, contact.b][side] as usize;
                if let Some(disk) = problem.glued_index(body) {
                    load[2 * disk] += sign * force[0];
                    load[2 * disk + 1] += sign * force[1];
                    continue;
                }
                if let Some(levers) = levers {
                    levers.apply(side, &mut bodies[body], force.map(|f| sign * f), [*n, *t]);
                    continue;
                }
                let inverse = problem.inverse_mass(body);
                bodies[body][0] += sign * inverse[0] * force[0];
                bodies[body][1] += sign * inverse[1] * force[1];
                bodies[body][2] -= inverse[2] * contact.lever() * t;
            }
        }
        let mut wall = load.clone();
        problem.boundary.times_compliance(&load, &mut wall);
        (bodies, wall)
    }

    fn relative(&self, i: usize, (bodies, wall): &(Vec<[f64; 3]>, Vec<f64>)) -> [f64; 2] {
        let contact = &self.problem.contacts[i];
        let of = |body: u32| match self.problem.glued_index(body as usize) {
            Some(disk) => [wall[2 * disk], wall[2 * disk + 1], 0.0],
            None => bodies[body as usize],
        };
        self.problem.project(contact, of(contact.a), of(contact.b))
    }
}

/// A direction, or 0 where the impulse may not move along it.
fn left(direction: f64, impulse: f64, [low, high]: [f64; 2]) -> f64 {
    if (impulse <= low && direction < 0.0) || (impulse >= high && direction > 0.0) {
        0.0
    } else {
        direction
    }
}

fn dot(a: &Field, b: &Field) -> f64 {
    let products = a.iter().zip(b).map(|(a, b)| a[0] * b[0] + a[1] * b[1]);
    products.sum()
}
