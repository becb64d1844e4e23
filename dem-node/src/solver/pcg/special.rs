//! The wheel and the glued disks: W of theirs is no mass.
//!
//! Impulses move the wheel along y only, and an impulse on one glued disk moves all of them by W_g. Their record among
//! the bodies gathers impulses and has the inverse mass 0; here is what answers instead.

use std::ops::Range;

use super::body::{Body, Momentum, Products};
use crate::solver::Problem;
use crate::wall::Wall;

/// Vectors hold two components a glued disk and then y of the wheel.
#[derive(Clone, Debug, Default)]
pub struct Special {
    glued: Range<usize>,
    wheel: Option<usize>,
    wheel_inverse: f64,
    /// M^-1 H p, then M^-1 H z, and M^-1 H w (m/s).
    along: Vec<f64>,
    answer: Vec<f64>,
    /// Impulses noted (N s), and whether there are any.
    noted: Vec<f64>,
    touched: bool,
    /// Room for the velocities that they make, and for impulses.
    spare: Vec<f64>,
    pushes: Vec<f64>,
}

impl Special {
    /// Takes over wheel and glued disks, and their velocities.
    pub fn load(&mut self, problem: &Problem, bodies: &mut [Body]) {
        let components = problem.wall.velocity.len();
        self.glued = problem.first_glued..problem.first_glued + components / 2;
        self.wheel = problem.wheel;
        self.wheel_inverse = self
            .wheel
            .map_or(0.0, |wheel| problem.movers[wheel].inverse_mass);
        for vector in [
            &mut self.along,
            &mut self.answer,
            &mut self.noted,
            &mut self.spare,
            &mut self.pushes,
        ] {
            vector.clear();
            vector.resize(components + 1, 0.0);
        }
        self.touched = false;
        let glued = &mut bodies[self.glued.clone()];
        for (body, v) in glued.iter_mut().zip(problem.wall.velocity.chunks_exact(2)) {
            body.velocity = [v[0], v[1], 0.0];
        }
        for body in self.glued.clone().chain(self.wheel) {
            (bodies[body].inverse_mass, bodies[body].inner) = (0.0, 0.0);
        }
    }

    /// Whether a body is one of these.
    pub fn holds(&self, body: usize) -> bool {
        self.glued.contains(&body) || self.wheel == Some(body)
    }

    /// Notes an impulse on a body, if it is one of these.
    pub fn note(&mut self, body: usize, impulse: [f64; 3]) {
        if self.glued.contains(&body) {
            let place = 2 * (body - self.glued.start);
            self.noted[place] += impulse[0];
            self.noted[place + 1] += impulse[1];
        } else if self.wheel == Some(body)
            && let Some(y) = self.noted.last_mut()
        {
            *y += impulse[1];
        } else {
            return;
        }
        self.touched = true;
    }

    /// Moves by the step alpha along M^-1 H p = M^-1 H w + beta M^-1 H z.
    pub fn follow(&mut self, bodies: &mut [Body], alpha: f64, beta: f64) {
        for (along, answer) in self.along.iter_mut().zip(&self.answer) {
            *along = answer + beta * *along;
        }
        self.moved(bodies, alpha, &self.along);
    }

    /// Moves by what the noted impulses make.
    pub fn settle(&mut self, wall: &Wall, bodies: &mut [Body]) {
        if self.answer_noted(wall) {
            self.moved(bodies, 1.0, &self.spare);
        }
    }

    /// Finds M^-1 H w, takes what is noted as lost from M^-1 H p, and adds the products of these bodies.
    pub fn measure(
        &mut self,
        wall: &Wall,
        bodies: &[Body],
        momenta: &[Momentum],
        products: &mut Products,
    ) {
        let mut pushes = std::mem::take(&mut self.pushes);
        self.collect(&mut pushes, |body| bodies[body].push);
        self.respond(wall, &pushes, |special| &mut special.answer);
        products.wp += dot(&pushes, &self.along);
        products.ww += dot(&pushes, &self.answer);
        if self.answer_noted(wall) {
            let lost = self.spare.iter();
            self.along.iter_mut().zip(lost).for_each(|(v, d)| *v -= d);
        }
        // Measured walls are not quite symmetric.
        products.wz += 0.5 * dot(&pushes, &self.along);
        self.collect(&mut pushes, |body| momenta[body]);
        products.wz += 0.5 * dot(&pushes, &self.answer);
        products.zz += dot(&pushes, &self.along);
        self.pushes = pushes;
    }

    /// Writes the impulses on the glued disks back.
    pub fn store(&self, problem: &mut Problem) {
        let wall = &mut problem.wall;
        wall.impulse.fill(0.0);
        for contact in problem.contacts.iter().filter(|c| c.glued) {
            let ([nx, ny], [r_n, r_t]) = (contact.normal, contact.impulse);
            let push = [r_n * nx - r_t * ny, r_n * ny + r_t * nx];
            let sides = [(contact.a, push), (contact.b, [-push[0], -push[1]])];
            for (body, push) in sides {
                if self.glued.contains(&(body as usize)) {
                    wall.note(body as usize - self.glued.start, push);
                }
            }
        }
        wall.settle();
    }

    /// M^-1 of the noted impulses into `spare`, and forgets them; whether there were any.
    fn answer_noted(&mut self, wall: &Wall) -> bool {
        if !std::mem::take(&mut self.touched) {
            return false;
        }
        let mut noted = std::mem::take(&mut self.noted);
        self.respond(wall, &noted, |special| &mut special.spare);
        noted.fill(0.0);
        self.noted = noted;
        true
    }

    fn respond(
        &mut self,
        wall: &Wall,
        impulses: &[f64],
        into: impl Fn(&mut Special) -> &mut Vec<f64>,
    ) {
        let wheel = self.wheel_inverse;
        if let (Some((y, on_wall)), Some((v, of_wall))) =
            (impulses.split_last(), into(self).split_last_mut())
        {
            wall.respond(on_wall, of_wall);
            *v = wheel * y;
        }
    }

    fn moved(&self, bodies: &mut [Body], factor: f64, change: &[f64]) {
        let glued = &mut bodies[self.glued.clone()];
        for (body, v) in glued.iter_mut().zip(change.chunks_exact(2)) {
            body.velocity[0] += factor * v[0];
            body.velocity[1] += factor * v[1];
        }
        if let (Some(wheel), Some(v)) = (self.wheel, change.last()) {
            bodies[wheel].velocity[1] += factor * v;
        }
    }

    fn collect(&self, into: &mut [f64], of: impl Fn(usize) -> [f64; 3]) {
        for (pair, body) in into.chunks_exact_mut(2).zip(self.glued.clone()) {
            pair.copy_from_slice(&of(body)[..2]);
        }
        if let (Some(wheel), Some(y)) = (self.wheel, into.last_mut()) {
            *y = of(wheel)[1];
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
