//! The constrained bodies of the conjugate gradient, wheel, glued disks and feet on surfaces: W of theirs is no mass.
//!
//! Impulses move the wheel along y only, and an impulse on one glued disk moves all of them by W_g. Their record among
//! the bodies gathers impulses and has the inverse mass 0; here is what answers instead.

use std::ops::Range;

use super::body_state::{BodyState, Momentum, Products};
use crate::bodies::surface::Foot;
use crate::contact::boundary::CompliantBoundary;
use crate::solver::contact::Contact;
use crate::solver::problem::Problem;

/// Vectors hold two components a glued disk and point, and then y of the wheel.
#[derive(Clone, Debug, Default)]
pub struct ConstrainedBodies {
    glued: Range<usize>,
    first_foot: usize,
    feet: Vec<Foot>,
    wheel: Option<usize>,
    wheel_inverse: f64,
    /// M^-1 H p, then M^-1 H z, and M^-1 H w (m/s).
    along: Vec<f64>,
    answer: Vec<f64>,
    /// Impulses gathered (N s), and true if there are any.
    gathered: Vec<f64>,
    touched: bool,
    /// Room for the velocities that they make, and for impulses.
    spare: Vec<f64>,
    impulses: Vec<f64>,
}

impl ConstrainedBodies {
    /// Takes over wheel and glued disks, and their velocities.
    pub fn load(&mut self, problem: &Problem, bodies: &mut [BodyState]) {
        let components = problem.boundary.velocity.len();
        let disks = components / 2 - problem.surface_points;
        self.glued = problem.first_glued..problem.first_glued + disks;
        self.first_foot = problem.first_foot;
        self.feet.clear();
        self.feet.extend_from_slice(problem.boundary.feet());
        self.wheel = problem.wheel;
        self.wheel_inverse = self
            .wheel
            .map_or(0.0, |wheel| problem.records[wheel].inverse_mass);
        for vector in [
            &mut self.along,
            &mut self.answer,
            &mut self.gathered,
            &mut self.spare,
            &mut self.impulses,
        ] {
            vector.clear();
            vector.resize(components + 1, 0.0);
        }
        self.touched = false;
        let glued = &mut bodies[self.glued.clone()];
        for (body, v) in glued
            .iter_mut()
            .zip(problem.boundary.velocity.chunks_exact(2))
        {
            body.velocity = [v[0], v[1], 0.0];
        }
        for (foot, body) in self.feet.iter().zip(&mut bodies[self.first_foot..]) {
            let [x, y] = foot.mean(&problem.boundary.velocity);
            body.velocity = [x, y, 0.0];
        }
        let feet = self.first_foot..self.first_foot + self.feet.len();
        for body in self.glued.clone().chain(feet).chain(self.wheel) {
            (bodies[body].inverse_mass, bodies[body].inner) = (0.0, 0.0);
        }
    }

    /// Forgets p and w.
    pub fn restart(&mut self) {
        for vector in [&mut self.along, &mut self.answer, &mut self.gathered] {
            vector.fill(0.0);
        }
        self.touched = false;
    }

    /// True if a body is one of these.
    pub fn holds(&self, body: usize) -> bool {
        self.glued.contains(&body) || self.wheel == Some(body) || self.foot(body).is_some()
    }

    fn foot(&self, body: usize) -> Option<Foot> {
        self.feet.get(body.wrapping_sub(self.first_foot)).copied()
    }

    /// Gathers an impulse on a body, if it is one of these.
    pub fn gather(&mut self, body: usize, impulse: [f64; 3]) {
        if self.glued.contains(&body) {
            let index = 2 * (body - self.glued.start);
            self.gathered[index] += impulse[0];
            self.gathered[index + 1] += impulse[1];
        } else if self.wheel == Some(body)
            && let Some(y) = self.gathered.last_mut()
        {
            *y += impulse[1];
        } else if let Some(foot) = self.foot(body) {
            add_parts(&mut self.gathered, foot, impulse);
        } else {
            return;
        }
        self.touched = true;
    }

    /// Moves by the step alpha along M^-1 H p = M^-1 H w + beta M^-1 H z.
    pub fn follow(&mut self, bodies: &mut [BodyState], alpha: f64, beta: f64) {
        for (along, answer) in self.along.iter_mut().zip(&self.answer) {
            *along = answer + beta * *along;
        }
        self.move_bodies(bodies, alpha, &self.along);
    }

    /// Moves by the velocities that the gathered impulses make.
    pub fn settle(&mut self, boundary: &CompliantBoundary, bodies: &mut [BodyState]) {
        if self.answer_gathered(boundary) {
            self.move_bodies(bodies, 1.0, &self.spare);
        }
    }

    /// Finds M^-1 H w, takes what is gathered as lost from M^-1 H p, and adds the products of these bodies.
    pub fn measure(
        &mut self,
        boundary: &CompliantBoundary,
        bodies: &[BodyState],
        momenta: &[Momentum],
        products: &mut Products<f64>,
    ) {
        let mut impulses = std::mem::take(&mut self.impulses);
        self.collect(&mut impulses, |body| bodies[body].h_w);
        respond(boundary, self.wheel_inverse, &impulses, &mut self.answer);
        products.wp += dot(&impulses, &self.along);
        products.ww += dot(&impulses, &self.answer);
        if self.answer_gathered(boundary) {
            let lost = self.spare.iter();
            self.along.iter_mut().zip(lost).for_each(|(v, d)| *v -= d);
        }
        // Measured compliances are not quite symmetric.
        products.wz += 0.5 * dot(&impulses, &self.along);
        self.collect(&mut impulses, |body| momenta[body]);
        products.wz += 0.5 * dot(&impulses, &self.answer);
        products.zz += dot(&impulses, &self.along);
        self.impulses = impulses;
    }

    /// Writes the impulses on the glued disks and points back, `outside` being the contacts that may have one.
    pub fn store(&self, problem: &mut Problem, outside: impl Iterator<Item = usize>) {
        problem.boundary.impulse.fill(0.0);
        let attracting = (0..problem.attractions.len()).map(|index| problem.attracting(index));
        let outside = outside.map(|index| problem.contacts[index]);
        let loads: Vec<Contact> = outside.chain(attracting).filter(|c| c.glued).collect();
        for contact in loads {
            let force = contact.in_xy(contact.impulse);
            for (body, force) in [(contact.a, force), (contact.b, [-force[0], -force[1]])] {
                if let Some(index) = problem.glued_index(body as usize) {
                    problem.boundary.gather(index, force);
                }
            }
        }
        problem.boundary.evaluate();
    }

    /// M^-1 of the gathered impulses into `spare`, and forgets them; false if there were none.
    fn answer_gathered(&mut self, boundary: &CompliantBoundary) -> bool {
        if !std::mem::take(&mut self.touched) {
            return false;
        }
        respond(
            boundary,
            self.wheel_inverse,
            &self.gathered,
            &mut self.spare,
        );
        self.gathered.fill(0.0);
        true
    }

    fn move_bodies(&self, bodies: &mut [BodyState], factor: f64, change: &[f64]) {
        let glued = &mut bodies[self.glued.clone()];
        for (body, v) in glued.iter_mut().zip(change.chunks_exact(2)) {
            body.velocity[0] += factor * v[0];
            body.velocity[1] += factor * v[1];
        }
        for (foot, body) in self.feet.iter().zip(&mut bodies[self.first_foot..]) {
            let v = foot.mean(change);
            body.velocity[0] += factor * v[0];
            body.velocity[1] += factor * v[1];
        }
        if let (Some(wheel), Some(v)) = (self.wheel, change.last()) {
            bodies[wheel].velocity[1] += factor * v;
        }
    }

    fn collect(&self, into: &mut [f64], of: impl Fn(usize) -> [f64; 3]) {
        into.fill(0.0);
        for (pair, body) in into.chunks_exact_mut(2).zip(self.glued.clone()) {
            pair.copy_from_slice(&of(body)[..2]);
        }
        for (foot, body) in self.feet.iter().zip(self.first_foot..) {
            add_parts(into, *foot, of(body));
        }
        if let (Some(wheel), Some(y)) = (self.wheel, into.last_mut()) {
            *y = of(wheel)[1];
        }
    }
}

/// Adds an impulse to the components of the two points of a foot.
fn add_parts(into: &mut [f64], foot: Foot, [x, y, _]: [f64; 3]) {
    for (point, part) in foot.parts([x, y]) {
        into[2 * point] += part[0];
        into[2 * point + 1] += part[1];
    }
}

/// M^-1 of impulses: W_g p of the glued disks, and 1/m along y of the wheel.
fn respond(boundary: &CompliantBoundary, wheel: f64, impulses: &[f64], velocities: &mut [f64]) {
    if let (Some((y, on_glued)), Some((v, of_glued))) =
        (impulses.split_last(), velocities.split_last_mut())
    {
        boundary.times_compliance(on_glued, of_glued);
        *v = wheel * y;
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
