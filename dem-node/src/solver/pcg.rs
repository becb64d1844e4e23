//! Projected conjugate gradient (Renouf and Alart, Comput. Methods Appl. Mech. Engrg. 194, 2005, algorithm CPG),
//! scaled by the diagonal.
//!
//! Without friction the impulses minimise r.(W + C) r / 2 + r.b over r_n >= 0, C the springs and b the free relative
//! velocities with their bias. With friction |r_t| <= s is held at s = mu r_n, the box problem is solved, s is taken
//! anew, and so on: a fixed point of Coulomb's law (Panagiotopoulos 1975). With u = (W + C) r + b, D the diagonal of
//! W + C and P the projection on the box, an iteration is
//! ```text
//! alpha = -u.p / p.q,  q = (W + C) p          r' = P(r + alpha p)
//! w = -u'/D where r' may move that way         z = p where r' may move that way
//! beta = -w.q / p.q                            p' = w + beta z
//! ```
//! A bond pulls: below r_n = 0 it has the compliance 1/kappa instead of that of its spring. Both branches have the same u
//! at r_n = 0, so the energy stays convex and smooth; a contact is on the side of its impulse, and at 0 on the side where u
//! pushes it, and its direction ends at 0 as at any bound. The bond's shear has 1/kappa_t and no threshold.
//!
//! W is never formed: a product scatters impulses to the bodies and gathers their velocities. The velocities of r' are
//! v + alpha dv plus what the projection took away, which few contacts feel, so an iteration needs one product.

use super::{Contact, Criteria, Mover, Problem, Verdict};
use crate::bond::BondContact;

/// Part of the true residual below which the box problem is solved well enough to take its thresholds anew. At 10 000
/// disks 0.1 costs a fifth more iterations, and 1, anew in every iteration, five times as many.
const INNER: f64 = 0.5;

/// Buffers of the solver. Vectors of contacts hold a component each, normal and tangential: a pass loads only what it
/// needs.
#[derive(Clone, Debug, Default)]
pub struct Vectors {
    pairs: Vec<[u32; 2]>,
    normals: Vec<[f64; 2]>,
    /// Levers of spin over the radius.
    levers: Vec<f64>,
    lines: [Lines; 2],
    /// Threshold of friction, s (N s); none on the shear of a bond.
    limits: Vec<f64>,
    /// Bonds, one a contact or none at all.
    bonds: Vec<Side>,
    /// v of all bodies, glued ones included.
    speeds: Vec<Mover>,
    /// Impulses H p on the bodies, then the velocities M^-1 H p that they make.
    pushes: Vec<Mover>,
    wall_impulse: Vec<f64>,
    wall_change: Vec<f64>,
    first_glued: usize,
    wheel: Option<usize>,
    friction: f64,
}

/// The two branches of a bond's normal law.
#[derive(Clone, Copy, Debug)]
struct Side {
    /// Whether the contact has a bond.
    bonded: bool,
    /// Bounds of r_n on the side where it is (N s).
    low: f64,
    high: f64,
    /// Part of the bodies in D (1/kg), and what spring and bond add to it.
    block: f64,
    spring: f64,
    tension: f64,
}

impl Side {
    fn new(contact: &Contact, bond: Option<&BondContact>) -> Side {
        Side {
            bonded: bond.is_some(),
            low: 0.0,
            high: f64::INFINITY,
            block: contact.block.nn,
            spring: contact.compliance[0],
            tension: bond.map_or(f64::INFINITY, |bond| bond.compliance()[0]),
        }
    }

    /// Takes the side of an impulse r under u without its compliance; returns compliance and 1/D there.
    #[inline]
    fn take(&mut self, impulse: f64, velocity: f64) -> [f64; 2] {
        let pulls = impulse < 0.0 || (impulse == 0.0 && velocity > 0.0);
        let compliance = if pulls && self.tension.is_finite() {
            (self.low, self.high) = (f64::NEG_INFINITY, 0.0);
            self.tension
        } else {
            (self.low, self.high) = (0.0, f64::INFINITY);
            self.spring
        };
        [compliance, 1.0 / (self.block + compliance)]
    }
}

/// One component of all contacts.
#[derive(Clone, Debug, Default)]
struct Lines {
    bias: Vec<f64>,
    compliance: Vec<f64>,
    /// D and 1/D.
    diagonal: Vec<f64>,
    inverse: Vec<f64>,
    /// r.
    impulse: Vec<f64>,
    /// u = (W + C) r + b.
    velocity: Vec<f64>,
    /// w, where r is pushed to.
    push: Vec<f64>,
    /// p and q = (W + C) p.
    direction: Vec<f64>,
    image: Vec<f64>,
}

/// What a pass over the contacts sums up.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    /// w.q.
    push_image: f64,
    /// Squares of the defect with thresholds held, of the true one, and of D r.
    held: f64,
    defect: f64,
    size: f64,
}

/// Iterates until the true residual is within the tolerance.
pub fn solve(problem: &mut Problem, criteria: &Criteria) -> Verdict {
    let mut vectors = std::mem::take(&mut problem.conjugate);
    vectors.load(problem);
    let iterations = if !problem.bonds.is_empty() {
        vectors.iterate::<2, true>(problem, criteria)
    } else if problem.friction > 0.0 {
        vectors.iterate::<2, false>(problem, criteria)
    } else {
        vectors.iterate::<1, false>(problem, criteria)
    };
    vectors.store(problem);
    problem.conjugate = vectors;
    problem.verdict(iterations, criteria)
}

impl Vectors {
    fn load(&mut self, problem: &Problem) {
        let contacts = &problem.contacts;
        let bond_of = |contact: &Contact| problem.bonds.get(contact.bond as usize);
        self.first_glued = problem.first_glued;
        self.wheel = problem.wheel;
        self.friction = problem.friction;
        refill(&mut self.pairs, contacts.iter().map(|c| [c.a, c.b]));
        refill(&mut self.normals, contacts.iter().map(|c| c.normal));
        refill(&mut self.levers, contacts.iter().map(Contact::lever));
        for (axis, lines) in self.lines.iter_mut().enumerate() {
            let block = |c: &Contact| [c.block.nn, c.block.tt][axis];
            let compliance = |c: &Contact| match bond_of(c) {
                // A bond without shear stiffness has no shear impulse either.
                Some(bond) if axis == 1 => finite(bond.compliance()[1]),
                _ => c.compliance[axis],
            };
            let bias = |c: &Contact| match bond_of(c) {
                Some(bond) if axis == 1 => bond.slip(),
                _ => c.bias[axis],
            };
            refill(&mut lines.bias, contacts.iter().map(bias));
            refill(&mut lines.compliance, contacts.iter().map(compliance));
            let diagonal = |c: &Contact| block(c) + c.compliance[axis];
            refill(&mut lines.diagonal, contacts.iter().map(diagonal));
            // Where nothing moves along an axis, no impulse is looked for.
            let inverse = |d: f64| if d > 0.0 { 1.0 / d } else { 0.0 };
            refill(
                &mut lines.inverse,
                contacts.iter().map(|c| inverse(block(c) + compliance(c))),
            );
            refill(&mut lines.impulse, contacts.iter().map(|c| c.impulse[axis]));
            for vector in [
                &mut lines.velocity,
                &mut lines.push,
                &mut lines.direction,
                &mut lines.image,
            ] {
                refill(vector, contacts.iter().map(|_| 0.0));
            }
        }
        let limit = |c: &Contact| match bond_of(c) {
            None => problem.friction * c.impulse[0],
            Some(bond) if bond.compliance()[1].is_finite() => f64::INFINITY,
            Some(_) => 0.0,
        };
        refill(&mut self.limits, contacts.iter().map(limit));
        let sides = contacts.iter().map(|c| Side::new(c, bond_of(c)));
        refill(&mut self.bonds, sides.filter(|_| !problem.bonds.is_empty()));
        self.speeds.clone_from(&problem.movers);
        for (disk, v) in problem.wall.velocity.chunks_exact(2).enumerate() {
            self.speeds[self.first_glued + disk].velocity = [v[0], v[1], 0.0];
        }
        refill(
            &mut self.pushes,
            problem.movers.iter().map(|_| Mover::default()),
        );
        refill(
            &mut self.wall_impulse,
            problem.wall.velocity.iter().map(|_| 0.0),
        );
        refill(
            &mut self.wall_change,
            problem.wall.velocity.iter().map(|_| 0.0),
        );
    }

    /// Returns the number of iterations. `COMPONENTS` is 2 with friction, 1 without.
    fn iterate<const COMPONENTS: usize, const BONDS: bool>(
        &mut self,
        problem: &Problem,
        criteria: &Criteria,
    ) -> usize {
        let mut sums = self.measure::<COMPONENTS, BONDS>();
        let mut beta = 0.0;
        for iteration in 0..criteria.max_iterations {
            let residual = problem.relative(sums.defect.sqrt(), sums.size.sqrt());
            if residual <= criteria.tolerance && iteration >= criteria.min_iterations {
                return iteration;
            }
            if COMPONENTS == 2 && sums.held.sqrt() <= INNER * sums.defect.sqrt() {
                self.renew_limits(problem);
                self.measure::<COMPONENTS, BONDS>();
                beta = 0.0;
            }
            let mut products = self.aim::<COMPONENTS, BONDS>(beta, problem);
            if products[0] <= 0.0 && beta != 0.0 {
                // The direction has lost its way: start again along the steepest one.
                self.pushes.fill(Mover::default());
                products = self.aim::<COMPONENTS, BONDS>(0.0, problem);
            }
            let [descent, curvature] = products;
            if !(descent > 0.0 && curvature > 0.0) {
                return iteration + 1;
            }
            self.advance::<COMPONENTS, BONDS>(descent / curvature, problem);
            sums = self.measure::<COMPONENTS, BONDS>();
            beta = -sums.push_image / curvature;
        }
        criteria.max_iterations
    }

    /// p = w + beta z and q = (W + C) p; returns -u.p and p.q.
    fn aim<const COMPONENTS: usize, const BONDS: bool>(
        &mut self,
        beta: f64,
        problem: &Problem,
    ) -> [f64; 2] {
        let pushes = &mut self.pushes[..];
        let (limits, bonds, levers) = (&self.limits[..], &self.bonds[..], &self.levers[..]);
        let [normal, tangent] = &mut self.lines;
        for (k, (pair, n)) in self.pairs.iter().zip(&self.normals).enumerate() {
            let [low, high] = normal_bounds::<BONDS>(bonds, k);
            let kept = held(normal.direction[k], normal.impulse[k], low, high);
            let p_n = normal.push[k] + beta * kept;
            normal.direction[k] = p_n;
            let mut p_t = 0.0;
            if COMPONENTS == 2 {
                let limit = limits[k];
                let kept = held(tangent.direction[k], tangent.impulse[k], -limit, limit);
                p_t = tangent.push[k] + beta * kept;
                tangent.direction[k] = p_t;
            }
            let lever = if COMPONENTS == 2 { levers[k] } else { 1.0 };
            scatter(pushes, *pair, *n, lever, [p_n, p_t]);
        }
        self.respond(problem);
        let [normal, tangent] = &mut self.lines;
        let mut sums = [0.0; 2];
        for (k, ([a, b], n)) in self.pairs.iter().zip(&self.normals).enumerate() {
            let (a, b) = (&self.pushes[*a as usize], &self.pushes[*b as usize]);
            let lever = if COMPONENTS == 2 { self.levers[k] } else { 1.0 };
            let [u_n, u_t] = relative::<COMPONENTS>(*n, lever, a, b);
            let p_n = normal.direction[k];
            let q_n = u_n + normal.compliance[k] * p_n;
            normal.image[k] = q_n;
            sums[0] -= normal.velocity[k] * p_n;
            sums[1] += p_n * q_n;
            if COMPONENTS == 2 {
                let p_t = tangent.direction[k];
                let q_t = u_t + tangent.compliance[k] * p_t;
                tangent.image[k] = q_t;
                sums[0] -= tangent.velocity[k] * p_t;
                sums[1] += p_t * q_t;
            }
        }
        sums
    }

    /// Turns the impulses on the bodies into velocities, in place.
    fn respond(&mut self, problem: &Problem) {
        let first = self.first_glued;
        let glued = first..first + self.wall_impulse.len() / 2;
        let parts = self.wall_impulse.chunks_exact_mut(2);
        for (p, push) in parts.zip(&self.pushes[glued.clone()]) {
            p.copy_from_slice(&push.velocity[..2]);
        }
        for (push, speed) in self.pushes.iter_mut().zip(&self.speeds) {
            let (inverse, [x, y, spin]) = (speed.inverse_mass, push.velocity);
            push.velocity = [inverse * x, inverse * y, 2.0 * inverse * spin];
        }
        if let Some(wheel) = self.wheel {
            (
                self.pushes[wheel].velocity[0],
                self.pushes[wheel].velocity[2],
            ) = (0.0, 0.0);
        }
        problem
            .wall
            .respond(&self.wall_impulse, &mut self.wall_change);
        let parts = self.wall_change.chunks_exact(2);
        for (v, push) in parts.zip(&mut self.pushes[glued]) {
            push.velocity = [v[0], v[1], 0.0];
        }
    }

    /// r' = P(r + alpha p) and the velocities that belong to it.
    fn advance<const COMPONENTS: usize, const BONDS: bool>(
        &mut self,
        alpha: f64,
        problem: &Problem,
    ) {
        for (speed, push) in self.speeds.iter_mut().zip(&mut self.pushes) {
            for (v, change) in speed.velocity.iter_mut().zip(&push.velocity) {
                *v += alpha * change;
            }
            *push = Mover::default();
        }
        let [normal, tangent] = &mut self.lines;
        let mut clipped = false;
        for (k, ([a, b], n)) in self.pairs.iter().zip(&self.normals).enumerate() {
            let wanted = normal.impulse[k] + alpha * normal.direction[k];
            let [low, high] = normal_bounds::<BONDS>(&self.bonds, k);
            let allowed = clamp(wanted, low, high);
            normal.impulse[k] = allowed;
            let mut surplus = [allowed - wanted, 0.0];
            if COMPONENTS == 2 {
                let wanted = tangent.impulse[k] + alpha * tangent.direction[k];
                let allowed = clamp(wanted, -self.limits[k], self.limits[k]);
                tangent.impulse[k] = allowed;
                surplus[1] = allowed - wanted;
            }
            if surplus != [0.0; 2] {
                clipped = true;
                let lever = self.levers[k];
                scatter(&mut self.pushes, [*a, *b], *n, lever, surplus);
            }
        }
        if clipped {
            self.settle(problem);
        }
    }

    /// Adds what the impulses in `pushes` do to the velocities.
    fn settle(&mut self, problem: &Problem) {
        self.respond(problem);
        for (speed, push) in self.speeds.iter_mut().zip(&mut self.pushes) {
            for (v, change) in speed.velocity.iter_mut().zip(&push.velocity) {
                *v += change;
            }
            *push = Mover::default();
        }
    }

    /// Takes the thresholds anew, s = mu r_n, and brings r_t within them.
    fn renew_limits(&mut self, problem: &Problem) {
        let [normal, tangent] = &mut self.lines;
        for (k, limit) in self.limits.iter_mut().enumerate() {
            if self.bonds.get(k).is_some_and(|side| side.bonded) {
                continue;
            }
            *limit = self.friction * normal.impulse[k];
            let allowed = clamp(tangent.impulse[k], -*limit, *limit);
            let surplus = [0.0, allowed - tangent.impulse[k]];
            tangent.impulse[k] = allowed;
            let lever = self.levers[k];
            scatter(
                &mut self.pushes,
                self.pairs[k],
                self.normals[k],
                lever,
                surplus,
            );
        }
        self.settle(problem);
    }

    /// u and w at the impulses reached, and the residuals.
    fn measure<const COMPONENTS: usize, const BONDS: bool>(&mut self) -> Sums {
        let mut sums = Sums::default();
        let (speeds, bonds, levers) = (&self.speeds[..], &mut self.bonds[..], &self.levers[..]);
        let [normal, tangent] = &mut self.lines;
        for (k, ([a, b], n)) in self.pairs.iter().zip(&self.normals).enumerate() {
            let lever = if COMPONENTS == 2 { levers[k] } else { 1.0 };
            let (a, b) = (&speeds[*a as usize], &speeds[*b as usize]);
            let [u_n, u_t] = relative::<COMPONENTS>(*n, lever, a, b);
            let r_n = normal.impulse[k];
            let u_n = u_n + normal.bias[k];
            if BONDS && bonds[k].bonded {
                [normal.compliance[k], normal.inverse[k]] = bonds[k].take(r_n, u_n);
            }
            let [low, high] = normal_bounds::<BONDS>(bonds, k);
            let u_n = u_n + normal.compliance[k] * r_n;
            normal.velocity[k] = u_n;
            let w_n = held(-u_n * normal.inverse[k], r_n, low, high);
            normal.push[k] = w_n;
            sums.push_image += w_n * normal.image[k];
            // D (r - P(r - u/D)), as in Problem::residual.
            let scaled_n = normal.diagonal[k] * r_n;
            let off_n = if BONDS && bonds[k].bonded {
                normal.diagonal[k] * (r_n - clamp(r_n - u_n * normal.inverse[k], low, high))
            } else if u_n > scaled_n {
                scaled_n
            } else {
                u_n
            };
            sums.held += off_n * off_n;
            sums.defect += off_n * off_n;
            sums.size += scaled_n * scaled_n;
            if COMPONENTS == 2 {
                let (r_t, limit) = (tangent.impulse[k], self.limits[k]);
                let u_t = u_t + tangent.bias[k] + tangent.compliance[k] * r_t;
                tangent.velocity[k] = u_t;
                let target = r_t - u_t * tangent.inverse[k];
                let w_t = held(-u_t * tangent.inverse[k], r_t, -limit, limit);
                tangent.push[k] = w_t;
                sums.push_image += w_t * tangent.image[k];
                let d_t = tangent.diagonal[k];
                let true_limit = if BONDS && bonds[k].bonded {
                    limit
                } else {
                    self.friction * (r_n - off_n * normal.inverse[k])
                };
                sums.held += (d_t * (r_t - clamp(target, -limit, limit))).powi(2);
                sums.defect += (d_t * (r_t - clamp(target, -true_limit, true_limit))).powi(2);
                sums.size += (d_t * r_t).powi(2);
            }
        }
        sums
    }

    fn store(&self, problem: &mut Problem) {
        let wall = self.first_glued..self.first_glued + self.wall_impulse.len() / 2;
        let [normal, tangent] = &self.lines;
        let mut loads = vec![Mover::default(); wall.len()];
        for (k, contact) in problem.contacts.iter_mut().enumerate() {
            contact.impulse = [normal.impulse[k], tangent.impulse[k]];
        }
        problem.movers.copy_from_slice(&self.speeds);
        for contact in problem.contacts.iter().filter(|c| c.glued) {
            let [nx, ny] = contact.normal;
            let [r_n, r_t] = contact.impulse;
            let push = [r_n * nx - r_t * ny, r_n * ny + r_t * nx];
            for (body, sign) in [(contact.a, 1.0), (contact.b, -1.0)] {
                if wall.contains(&(body as usize)) {
                    let load = &mut loads[body as usize - wall.start].velocity;
                    load[0] += sign * push[0];
                    load[1] += sign * push[1];
                }
            }
        }
        for (p, load) in problem.wall.impulse.chunks_exact_mut(2).zip(&loads) {
            p.copy_from_slice(&load.velocity[..2]);
        }
        problem.wall.settle();
    }
}

fn refill<T>(vector: &mut Vec<T>, values: impl Iterator<Item = T>) {
    vector.clear();
    vector.extend(values);
}

fn finite(compliance: f64) -> f64 {
    if compliance.is_finite() {
        compliance
    } else {
        0.0
    }
}

/// What is left of a direction where the impulse is at a bound: nothing if it points outwards.
#[inline(always)]
fn held(direction: f64, impulse: f64, low: f64, high: f64) -> f64 {
    // Without short cuts: whether a contact slides cannot be foretold, and a wrong guess costs as much as the arithmetic.
    let outwards = ((impulse <= low) & (direction < 0.0)) | ((impulse >= high) & (direction > 0.0));
    if outwards { 0.0 } else { direction }
}

/// Bounds of r_n; both are 0 on one side of a bond.
#[inline(always)]
fn normal_bounds<const BONDS: bool>(bonds: &[Side], k: usize) -> [f64; 2] {
    if BONDS {
        [bonds[k].low, bonds[k].high]
    } else {
        [0.0, f64::INFINITY]
    }
}

/// Written so that a NaN stays one.
#[inline(always)]
fn clamp(value: f64, low: f64, high: f64) -> f64 {
    let value = if value < low { low } else { value };
    if value > high { high } else { value }
}

/// (u_n, u_t) of the contact points, a against b.
#[inline(always)]
fn relative<const COMPONENTS: usize>(
    [nx, ny]: [f64; 2],
    lever: f64,
    a: &Mover,
    b: &Mover,
) -> [f64; 2] {
    let ([ax, ay, a_spin], [bx, by, b_spin]) = (a.velocity, b.velocity);
    let (dx, dy) = (ax - bx, ay - by);
    let tangential = if COMPONENTS == 2 {
        nx * dy - ny * dx - lever * (a_spin + b_spin)
    } else {
        0.0
    };
    [nx * dx + ny * dy, tangential]
}

/// Adds the impulse (r_n, r_t) of a contact to what its bodies get.
#[inline(always)]
fn scatter(
    pushes: &mut [Mover],
    [a, b]: [u32; 2],
    [nx, ny]: [f64; 2],
    lever: f64,
    [r_n, r_t]: [f64; 2],
) {
    let (px, py) = (r_n * nx - r_t * ny, r_n * ny + r_t * nx);
    let a = &mut pushes[a as usize].velocity;
    *a = [a[0] + px, a[1] + py, a[2] - lever * r_t];
    let b = &mut pushes[b as usize].velocity;
    *b = [b[0] - px, b[1] - py, b[2] - lever * r_t];
}
