//! The constrained bodies of the conjugate gradient, wheel, glued disks, feet on surfaces and clusters, whose W is not a disk's.
//!
//! Impulses move the wheel along y and turn it where it spins freely, an impulse on one glued disk moves all glued disks by W_g, and an impulse on a disk of a cluster turns the
//! cluster about its own centre. Their record among the bodies gathers impulses and has the inverse mass 0; their response is computed here.

use std::ops::Range;

use super::body_state::{BodyState, Momentum, Products};
use crate::bodies::surface::Foot;
use crate::contact::boundary::CompliantBoundary;
use crate::solver::contact::Contact;
use crate::solver::problem::Problem;

/// Vectors hold two components per glued disk and point, then y and spin of the wheel, and three components of each body that turns by levers.
#[derive(Clone, Debug, Default)]
pub struct ConstrainedBodies {
    glued: Range<usize>,
    first_foot: usize,
    feet: Vec<Foot>,
    wheel: Option<usize>,
    turning: Turning,
    /// Number of components before the wheel's, and the inverse masses of the components from there on (1/kg).
    boundary: usize,
    inverse: Vec<f64>,
    /// M^-1 H p, then M^-1 H z, and M^-1 H w (m/s).
    along: Vec<f64>,
    answer: Vec<f64>,
    /// Gathered impulses (N s), and true if there are any.
    gathered: Vec<f64>,
    touched: bool,
    /// Buffers for their velocities, and for impulses.
    spare: Vec<f64>,
    impulses: Vec<f64>,
}

/// Bodies of contacts with levers, and their points of contact, which are bodies of their own, after all others.
#[derive(Clone, Debug, Default)]
struct Turning {
    bodies: Vec<usize>,
    /// Index of each body of the problem in `bodies`, if it is there.
    places: Vec<Option<u32>>,
    first_point: usize,
    /// Two per lever: the index of its body, and the velocity of the point per unit of (spin times radius).
    points: Vec<Option<(u32, [f64; 2])>>,
}

/// The body that a contact moves on one of its sides, 0 for a and 1 for b: a point of its own with a lever.
#[inline(always)]
pub fn moved_by(problem: &Problem, contact: &Contact, side: usize) -> u32 {
    let body = [contact.a, contact.b][side];
    let levers = problem.levers.get(contact.levers as usize);
    if levers.is_none() || problem.is_constrained(body as usize) {
        return body;
    }
    problem.records.len() as u32 + 2 * contact.levers + side as u32
}

impl Turning {
    /// Loads the bodies and levers of a problem, and adds the inverse masses of the bodies (1/kg).
    fn load(&mut self, problem: &Problem, inverse: &mut Vec<f64>) {
        self.bodies.clear();
        self.places.clear();
        self.points.clear();
        self.first_point = problem.records.len();
        if problem.levers.is_empty() {
            return;
        }
        self.places.resize(self.first_point, None);
        self.points.resize(2 * problem.levers.len(), None);
        for contact in &problem.contacts {
            let Some(levers) = problem.levers.get(contact.levers as usize) else {
                continue;
            };
            let [nx, ny] = contact.normal;
            for (side, body) in [contact.a as usize, contact.b as usize]
                .into_iter()
                .enumerate()
            {
                let point = moved_by(problem, contact, side) as usize;
                if point == body {
                    continue;
                }
                let place = *self.places[body].get_or_insert_with(|| {
                    self.bodies.push(body);
                    inverse.extend(levers.inverse[side]);
                    self.bodies.len() as u32 - 1
                });
                let [n, t] = levers.lever[side];
                self.points[point - self.first_point] =
                    Some((place, [n * nx - t * ny, n * ny + t * nx]));
            }
        }
    }

    fn place(&self, body: usize) -> Option<usize> {
        Some((*self.places.get(body)?)? as usize)
    }

    fn point(&self, body: usize) -> Option<(u32, [f64; 2])> {
        *self.points.get(body.checked_sub(self.first_point)?)?
    }
}

impl ConstrainedBodies {
    /// Loads these bodies and their velocities; adds the points of levers to the bodies.
    pub fn load(&mut self, problem: &Problem, bodies: &mut Vec<BodyState>) {
        self.boundary = problem.boundary.velocity.len();
        let disks = self.boundary / 2 - problem.surface_points;
        self.glued = problem.first_glued..problem.first_glued + disks;
        self.first_foot = problem.first_foot;
        self.feet.clear();
        self.feet.extend_from_slice(&problem.boundary.feet);
        self.wheel = problem.wheel;
        self.inverse.clear();
        let wheel = self.wheel.map(|wheel| problem.records[wheel].inverse_mass);
        self.inverse.push(wheel.unwrap_or(0.0));
        self.inverse.push(problem.wheel_turn);
        self.turning.load(problem, &mut self.inverse);
        for vector in [
            &mut self.along,
            &mut self.answer,
            &mut self.gathered,
            &mut self.spare,
            &mut self.impulses,
        ] {
            vector.clear();
            vector.resize(self.boundary + self.inverse.len(), 0.0);
        }
        self.touched = false;
        let point = BodyState::default();
        bodies.resize(bodies.len() + self.turning.points.len(), point);
        self.impulses[..self.boundary].copy_from_slice(&problem.boundary.velocity);
        let places = self.turning.bodies.iter().enumerate();
        for (place, body) in places {
            let first = self.boundary + 2 + 3 * place;
            self.impulses[first..first + 3].copy_from_slice(&bodies[*body].velocity);
        }
        for body in self.all() {
            (bodies[body].inverse_mass, bodies[body].inner) = (0.0, 0.0);
            if self.wheel != Some(body) {
                bodies[body].velocity = self.velocity_of(body, &self.impulses);
            }
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
        let bounded = self.glued.contains(&body) || self.wheel == Some(body);
        bounded || self.foot(body).is_some() || self.turning.place(body).is_some()
    }

    fn foot(&self, body: usize) -> Option<Foot> {
        self.feet.get(body.wrapping_sub(self.first_foot)).copied()
    }

    /// All constrained bodies, points of levers included.
    fn all(&self) -> impl Iterator<Item = usize> {
        let feet = (self.first_foot..).take(self.feet.len());
        let turning = &self.turning;
        let points = (turning.first_point..).zip(&turning.points);
        let points = points.filter_map(|(body, point)| point.map(|_| body));
        let turning = turning.bodies.iter().copied();
        let bounded = self.glued.clone().chain(feet).chain(self.wheel);
        bounded.chain(turning).chain(points)
    }

    /// Gathers an impulse on a body, if it is one of these.
    pub fn gather(&mut self, body: usize, impulse: [f64; 3]) {
        let mut gathered = std::mem::take(&mut self.gathered);
        self.touched |= self.add(&mut gathered, body, impulse);
        self.gathered = gathered;
    }

    /// Adds an impulse on a body to the components; false if the body is not constrained.
    fn add(&self, into: &mut [f64], body: usize, impulse: [f64; 3]) -> bool {
        let [x, y, turn] = impulse;
        if self.glued.contains(&body) {
            let index = 2 * (body - self.glued.start);
            into[index] += x;
            into[index + 1] += y;
        } else if self.wheel == Some(body) {
            into[self.boundary] += y;
            into[self.boundary + 1] += turn;
        } else if let Some(foot) = self.foot(body) {
            for (point, part) in foot.parts([x, y]) {
                into[2 * point] += part[0];
                into[2 * point + 1] += part[1];
            }
        } else if let Some(place) = self.turning.place(body) {
            let of = &mut into[self.boundary + 2 + 3 * place..][..3];
            of.iter_mut()
                .zip(impulse)
                .for_each(|(sum, part)| *sum += part);
        } else if let Some((place, [along_x, along_y])) = self.turning.point(body) {
            let turn = along_x * x + along_y * y;
            let of = &mut into[self.boundary + 2 + 3 * place as usize..][..3];
            of.iter_mut()
                .zip([x, y, turn])
                .for_each(|(sum, part)| *sum += part);
        } else {
            return false;
        }
        true
    }

    /// Velocity of a body, from the components (m/s).
    fn velocity_of(&self, body: usize, of: &[f64]) -> [f64; 3] {
        let of_turning = |place: usize| &of[self.boundary + 2 + 3 * place..][..3];
        if self.glued.contains(&body) {
            let index = 2 * (body - self.glued.start);
            [of[index], of[index + 1], 0.0]
        } else if let Some(foot) = self.foot(body) {
            let [x, y] = foot.mean(of);
            [x, y, 0.0]
        } else if let Some(place) = self.turning.place(body) {
            std::array::from_fn(|k| of_turning(place)[k])
        } else if let Some((place, [along_x, along_y])) = self.turning.point(body) {
            let v = of_turning(place as usize);
            [v[0] + along_x * v[2], v[1] + along_y * v[2], 0.0]
        } else {
            [0.0, of[self.boundary], of[self.boundary + 1]]
        }
    }

    /// Moves by the step alpha along M^-1 H p = M^-1 H w + beta M^-1 H z.
    pub fn follow(&mut self, bodies: &mut [BodyState], alpha: f64, beta: f64) {
        for (along, answer) in self.along.iter_mut().zip(&self.answer) {
            *along = answer + beta * *along;
        }
        self.move_bodies(bodies, alpha, &self.along);
    }

    /// Moves by the velocities of the gathered impulses.
    pub fn settle(&mut self, boundary: &CompliantBoundary, bodies: &mut [BodyState]) {
        if self.answer_gathered(boundary) {
            self.move_bodies(bodies, 1.0, &self.spare);
        }
    }

    /// Computes M^-1 H w, subtracts the gathered losses from M^-1 H p, and adds the products of these bodies.
    pub fn measure(
        &mut self,
        boundary: &CompliantBoundary,
        bodies: &[BodyState],
        momenta: &[Momentum],
        products: &mut Products<f64>,
    ) {
        let mut impulses = std::mem::take(&mut self.impulses);
        self.collect(&mut impulses, |body| bodies[body].h_w);
        respond(boundary, &self.inverse, &impulses, &mut self.answer);
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

    /// Writes the impulses on the glued disks and points back, `outside` being the contacts that may act on them.
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

    /// Computes M^-1 of the gathered impulses into `spare`, and clears them; false if there were no impulses.
    fn answer_gathered(&mut self, boundary: &CompliantBoundary) -> bool {
        if !std::mem::take(&mut self.touched) {
            return false;
        }
        respond(boundary, &self.inverse, &self.gathered, &mut self.spare);
        self.gathered.fill(0.0);
        true
    }

    fn move_bodies(&self, bodies: &mut [BodyState], factor: f64, change: &[f64]) {
        for body in self.all() {
            let change = self.velocity_of(body, change);
            let velocity = bodies[body].velocity.iter_mut();
            velocity
                .zip(change)
                .for_each(|(v, change)| *v += factor * change);
        }
    }

    fn collect(&self, into: &mut [f64], of: impl Fn(usize) -> [f64; 3]) {
        into.fill(0.0);
        for body in self.all() {
            self.add(into, body, of(body));
        }
    }
}

/// M^-1 of impulses: W_g p of the glued disks, and the inverse masses of the components after theirs.
fn respond(
    boundary: &CompliantBoundary,
    inverse: &[f64],
    impulses: &[f64],
    velocities: &mut [f64],
) {
    let glued = impulses.len() - inverse.len();
    boundary.times_compliance(&impulses[..glued], &mut velocities[..glued]);
    let others = velocities[glued..].iter_mut().zip(&impulses[glued..]);
    for ((velocity, impulse), inverse) in others.zip(inverse) {
        *velocity = inverse * impulse;
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
