//! Distance of a guess from the solution: the true residual, and LMGC90's incremental criterion.

use serde::{Deserialize, Serialize};

use super::contact::{Contact, NO_BOND};
use super::partition::in_pieces;
use super::problem::Problem;
use super::rolling;
use crate::law::local::coulomb_projection;
use crate::solver::criteria::Criteria;

/// Convergence of a solver at its end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Convergence {
    /// Iterations done.
    pub iterations: usize,
    /// Relative true natural-map residual.
    pub residual: f64,
    /// LMGC90's incremental criterion, the largest of its three norms.
    pub quad: f64,
    /// True if the residual is within the tolerance.
    pub converged: bool,
    /// True if the residual is within the tolerance only because it is measured against rounding, not against the impulses.
    pub rounding: bool,
}

/// LMGC90's criterion "Quad" (Core/kernel/mod_nlgs.f90, solve_nlgs with i_check; theory in Jean 1999): all contacts are
/// offered the impulse r' that their own law wants while all others are held. With W the bodies' part of the local block,
/// dv = W (r' - r) and s = (r + r')/2, summed over the N contacts with s other than 0,
/// ```text
/// QuadDV  = sqrt(sum dv.dv / N) / sqrt(sum WR.WR / N)                WR.WR = (|W r|^2 + |W r'|^2)/2
/// QuadDVR = sqrt(sum (dv.dv)(s.s) / N) / (sum WRR / N)               WRR   = (r.W r + r'.W r')/2
/// MeanDVoR = sum s.dv / sum WRR
/// ```
/// and the criterion is met when the absolute values of all three are below the tolerance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Quad {
    /// QuadDV, QuadDVR and |MeanDVoR|.
    pub norms: [f64; 3],
}

impl Quad {
    /// The largest of the norms.
    pub fn largest(&self) -> f64 {
        // Written so that a NaN stays NaN.
        self.norms.iter().fold(
            0.0,
            |largest, norm| if *norm <= largest { largest } else { *norm },
        )
    }
}

/// Sums of [`Quad`].
#[derive(Clone, Copy, Debug, Default)]
struct QuadSums {
    active: f64,
    dv_dv: f64,
    wr_wr: f64,
    dv_dv_rr: f64,
    wrr: f64,
    dv_r: f64,
}

impl QuadSums {
    fn join(&mut self, other: &QuadSums) {
        kit::add_fields!(self, other; active, dv_dv, wr_wr, dv_dv_rr, wrr, dv_r);
    }

    fn add(&mut self, contact: &Contact, wanted: [f64; 2]) {
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let r = contact.impulse;
        let mean = [0.5 * (r[0] + wanted[0]), 0.5 * (r[1] + wanted[1])];
        let dv = contact.block.times([wanted[0] - r[0], wanted[1] - r[1]]);
        let (old, new) = (contact.block.times(r), contact.block.times(wanted));
        self.active += f64::from(mean != [0.0; 2]);
        self.dv_dv += dot(dv, dv);
        self.wr_wr += 0.5 * (dot(old, old) + dot(new, new));
        self.dv_dv_rr += dot(dv, dv) * dot(mean, mean);
        self.wrr += 0.5 * (dot(old, r) + dot(new, wanted));
        self.dv_r += dot(mean, dv);
    }

    fn quad(&self, problem: &Problem) -> Quad {
        if self.dv_dv == 0.0 || self.wrr == 0.0 {
            return Quad::default();
        }
        let size = self.wr_wr.sqrt();
        let floored = size / size.max(problem.least_size);
        let energy = floored / self.wrr;
        Quad {
            norms: [
                problem.relative(self.dv_dv.sqrt(), size),
                (self.active * self.dv_dv_rr).sqrt() * energy,
                self.dv_r.abs() * energy,
            ],
        }
    }
}

/// Convergence of the solve after these iterations, with this defect. The true residual alone decides.
pub(super) fn convergence(
    problem: &Problem,
    (left, quad): (Defect, Quad),
    iterations: usize,
    criteria: &Criteria,
) -> Convergence {
    let residual = left.residual(problem);
    Convergence {
        iterations,
        residual,
        quad: quad.largest(),
        converged: residual <= criteria.tolerance,
        rounding: residual <= criteria.tolerance && left.defect > criteria.tolerance * left.size,
    }
}

/// Sums of defect and criterion over contacts.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    /// ||D (r - P(r - U/D))||^2 and ||D r||^2.
    squares: [f64; 2],
    quad: QuadSums,
}

impl Sums {
    /// Adds a contact.
    #[inline(always)]
    pub fn add(&mut self, problem: &Problem, contact: &Contact) {
        let velocity = problem.relative_velocity(contact);
        let wanted = problem.local_solution(contact, velocity);
        add_defect(&mut self.squares, contact, (velocity, wanted));
        self.quad.add(contact, wanted);
    }

    /// Adds the sums of other contacts: squares, then the sums of [`Quad`].
    pub fn join(&mut self, [defect, size, active, dv_dv, wr_wr, dv_dv_rr, wrr, dv_r]: [f64; 8]) {
        self.squares = [self.squares[0] + defect, self.squares[1] + size];
        self.quad.join(&QuadSums {
            active,
            dv_dv,
            wr_wr,
            dv_dv_rr,
            wrr,
            dv_r,
        });
    }

    /// Defect and LMGC90's incremental criterion. Like the residual, the criterion is relative to no less than the size set by rounding.
    pub fn measured(mut self, problem: &Problem) -> (Defect, Quad) {
        add_couples(&mut self.squares, problem);
        (Defect::of(self.squares), self.quad.quad(problem))
    }
}

/// Defect and criterion of the present impulses and velocities, contact by contact: the reference of [`super::groups::Sweeper::measured`].
pub(super) fn measured(problem: &Problem, parallel: bool) -> (Defect, Quad) {
    let contacts = &problem.contacts[..];
    let pieces = in_pieces(contacts.len(), contacts, parallel, |_, contacts| {
        let mut sums = Sums::default();
        contacts
            .iter()
            .for_each(|contact| sums.add(problem, contact));
        sums
    });
    let mut sums = Sums::default();
    for Sums { squares, quad } in pieces {
        sums.squares = [sums.squares[0] + squares[0], sums.squares[1] + squares[1]];
        sums.quad.join(&quad);
    }
    sums.measured(problem)
}

/// The true natural-map residual ||D (r - P(r - U/D))|| / ||D r||, D the diagonal of W with its springs and P the projection
/// on the Coulomb sector ([`coulomb_projection`]; Alart and Curnier 1991), which bonds replace by the exact local solution.
/// It is zero at the solution only, even if a solver creeps.
pub fn residual(problem: &Problem) -> f64 {
    measured(problem, false).0.residual(problem)
}

/// Numerator and denominator of the [`residual`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Defect {
    /// ||D (r - P(r - U/D))|| (m/s).
    defect: f64,
    /// ||D r|| (m/s).
    size: f64,
}

impl Defect {
    fn of([defect, size]: [f64; 2]) -> Defect {
        Defect {
            defect: defect.sqrt(),
            size: size.sqrt(),
        }
    }

    /// ||D r|| (m/s).
    #[cfg(test)]
    pub fn size(self) -> f64 {
        self.size
    }

    /// The true residual.
    pub fn residual(self, problem: &Problem) -> f64 {
        problem.relative(self.defect, self.size)
    }
}

fn add_couples(squares: &mut [f64; 2], problem: &Problem) {
    rolling::add_defects(
        &problem.couples,
        &problem.contacts,
        &problem.records,
        squares,
    );
}

/// Adds the squares of D (r - P(r - U/D)) and of D r of a contact under this relative velocity u; its own law wants the impulse `wanted`.
#[inline(always)]
fn add_defect([defect, size]: &mut [f64; 2], contact: &Contact, (u, wanted): ([f64; 2], [f64; 2])) {
    let (d, r) = (contact.diagonal(), contact.impulse);
    let term = |axis: usize, wanted: f64| (d[axis] * (r[axis] - wanted)).powi(2);
    if contact.bond == NO_BOND {
        let full = [0, 1].map(|k| u[k] + contact.bias[k] + contact.compliance[k] * r[k]);
        let x_t = if d[1] > 0.0 {
            r[1] - full[1] / d[1]
        } else {
            r[1]
        };
        let [r_n, r_t] = coulomb_projection([r[0] - full[0] / d[0], x_t], contact.law.friction);
        *defect += term(0, r_n);
        *defect += term(1, r_t);
    } else {
        *defect += term(0, wanted[0]) + term(1, wanted[1]);
    }
    *size += term(0, 0.0) + term(1, 0.0);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::local::{DelassusBlock, LocalLaw};
    use crate::solver::contact::BodyRecord;

    /// A grain of mass 1/2 on a wall, falling at 1.4 m/s, and at 1 m/s under an impulse of 0.2.
    fn resting(contacts: usize) -> Problem {
        let block = DelassusBlock {
            nn: 2.0,
            nt: 0.0,
            tt: 6.0,
        };
        let contact = |i: usize| Contact {
            a: 2 * i as u32,
            b: 2 * i as u32 + 1,
            normal: [0.0, 1.0],
            impulse: [0.2, 0.0],
            bond: NO_BOND,
            block,
            law: LocalLaw::new(block, 0.0, (0, 1)).expect("it is well posed"),
            ..Contact::default()
        };
        let grain = BodyRecord {
            velocity: [0.0, -1.0, 0.0],
            inverse_mass: 2.0,
        };
        Problem {
            contacts: (0..contacts).map(contact).collect(),
            records: (0..contacts)
                .flat_map(|_| [grain, BodyRecord::default()])
                .collect(),
            first_glued: 2 * contacts,
            ..Problem::default()
        }
    }

    /// By hand: r = 0.2, r' = 0.2 + 1/2 = 0.7, dv = 1, WR.WR = (0.16 + 1.96)/2, WRR = (0.08 + 0.98)/2, s = 0.45.
    #[test]
    fn the_three_norms_agree_with_lmgc90() {
        for contacts in [1, 3] {
            let mut problem = resting(contacts);
            // A contact without force does not count among the N.
            problem.contacts.push(Contact {
                impulse: [0.0; 2],
                bias: [5.0, 0.0],
                ..problem.contacts[0]
            });
            let expected = [1.0 / 1.06f64.sqrt(), 0.45 / 0.53, 0.45 / 0.53];
            for (norm, expected) in measured(&problem, false).1.norms.iter().zip(expected) {
                assert!((norm - expected).abs() < 1e-14, "{norm} {expected}");
            }
        }
    }

    /// The grain, of radius 1 with 2/(m r^2) = 4, turns at 0.2 rad/s, which a couple of 0.05 within mu_r r r_n = 0.1 would stop: the defect is 4 x
    /// 0.05.
    #[test]
    fn a_missing_couple_is_a_defect() {
        let mut problem = resting(1);
        problem.records[0].velocity[2] = 0.2;
        let without = measured(&problem, false).0;
        problem.couples.push(rolling::Couple {
            curvature: [1.0, 0.0],
            inverse: [4.0, 0.0],
            radius: 1.0,
            coefficient: 0.5,
            ..rolling::Couple::default()
        });
        let with = measured(&problem, false).0;
        let added = with.defect.powi(2) - without.defect.powi(2);
        assert!((added - 0.04).abs() < 1e-15, "{added}");
    }

    #[test]
    fn an_empty_problem_meets_the_criterion() {
        assert_eq!(measured(&Problem::default(), false).1.largest(), 0.0);
    }
}
