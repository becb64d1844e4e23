//! Dampers that share a landing: what restitution the contacts of a cluster leave that meet another body at once.
//!
//! ```text
//!     zeta' = zeta sum sqrt(m_i) / sqrt(n M)    1/m_i = 1/M + a_i^2/I
//! ```
//!
//! A damper is made for the mass m_i that its own contact has, as if it were alone. Where n contacts with springs k stop a body that does
//! not turn, the sum of the dampers c_i = 2 zeta sqrt(k m_i) meets the spring n k and the mass M of the pair: zeta' is the damping ratio of
//! that oscillator, and e(zeta') what the body leaves with ([`Springs::restitution`]).

use super::{StepInput, Stepper};
use crate::law::{Springs, relaxation};
use crate::solver::contact::{Contact, NO_BOND, NO_LEVERS};
use crate::step::state::GrainState;

/// Cosine between normals that count as one direction.
const PARALLEL: f64 = 0.99;

/// A damped contact of a cluster in a step.
struct Damped<'a> {
    contact: &'a Contact,
    /// Bodies that move for its disks; all that no grain moves are one.
    pair: [usize; 2],
    springs: Springs,
    /// 1/m_i, and 1/M (1/kg).
    mobility: [f64; 2],
    /// Loss (J).
    loss: f64,
}

impl Stepper {
    /// Loss in the dampers of contacts that shared a landing in this step (J), and its products with e(zeta), which the law asks for, with
    /// e(zeta'), and with the restitution to ask for in order to have e(zeta).
    pub(super) fn shared_damping(&self, state: &GrainState, input: &StepInput) -> [f64; 4] {
        let bodies = input.bodies;
        if bodies.clusters.list.is_empty() || !bodies.any_law(|law| law.is_damped()) {
            return [0.0; 4];
        }
        let mut damped: Vec<Damped> = self.damped(state, input).collect();
        damped.sort_by_key(|one| one.pair);
        let mut sums = [0.0; 4];
        for group in damped.chunk_by(|one, next| one.pair == next.pair) {
            let [nx, ny] = group[0].contact.normal;
            let along = |one: &&Damped| {
                let [x, y] = one.contact.normal;
                nx * x + ny * y > PARALLEL
            };
            let count = group.iter().filter(along).count();
            if count < 2 {
                continue;
            }
            let (zeta, [_, pair]) = (group[0].springs.damping, group[0].mobility);
            let dampers = group.iter().filter(along);
            let dampers: f64 = dampers.map(|one| (pair / one.mobility[0]).sqrt()).sum();
            let ratio = dampers / (count as f64).sqrt();
            let loss: f64 = group.iter().filter(along).map(|one| one.loss).sum();
            let ratios = [zeta, zeta * ratio, zeta / ratio];
            sums[0] += loss;
            for (sum, zeta) in sums[1..].iter_mut().zip(ratios) {
                *sum += loss * Springs::restitution(zeta);
            }
        }
        sums
    }

    fn damped(&self, state: &GrainState, input: &StepInput) -> impl Iterator<Item = Damped<'_>> {
        let (bodies, h) = (input.bodies, input.step);
        let contacts = self.problem.contacts.iter().zip(&self.slots);
        contacts.filter_map(move |(contact, index)| {
            let closed = contact.bond == NO_BOND && contact.gap < 0.0;
            let springs = bodies.law_at(contact.pair_law).springs?;
            if !closed || contact.levers == NO_LEVERS || springs.damping == 0.0 {
                return None;
            }
            let slot = &state.list.slots[*index as usize];
            let disks = [slot.a, slot.b].map(|disk| disk as usize);
            let (mut own, mut pair) = (0.0, 0.0);
            for (disk, pushed) in disks.into_iter().zip([contact.a, contact.b]) {
                let (of_contact, of_body) = match bodies.clusters.of(disk) {
                    None => (
                        self.problem.records[pushed as usize].inverse_mass,
                        self.problem.records[pushed as usize].inverse_mass,
                    ),
                    Some((index, cluster)) => {
                        let (pose, normal) = (&state.clusters[index], contact.normal);
                        let at = |point| cluster.mobility(pose, normal, point);
                        (at(state.centres[disk]), at(pose.centre))
                    }
                };
                (own, pair) = (own + of_contact, pair + of_body);
            }
            let damper = relaxation(springs.damping, springs.normal, own) * springs.normal;
            let [u_n, _] = self.problem.relative_velocity(contact);
            Some(Damped {
                contact,
                pair: disks.map(|disk| bodies.clusters.leader_of(disk).min(bodies.free)),
                springs,
                mobility: [own, pair],
                loss: h * damper * u_n * u_n,
            })
        })
    }
}
