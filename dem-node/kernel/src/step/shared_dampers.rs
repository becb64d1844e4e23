//! Dampers that share a landing: the restitution of a cluster that meets another body with several contacts at once.
//!
//! ```text
//!     zeta' = zeta sum sqrt(m_i) / sqrt(n M)    1/m_i = 1/M + a_i^2/I
//! ```
//!
//! A damper is set for the mass m_i of its own contact alone. Where n contacts with springs k stop a body that does not turn, the sum of the dampers
//! c_i = 2 zeta sqrt(k m_i) acts with the spring n k and the mass M of the pair: zeta' is the damping ratio of this oscillator, and e(zeta') its
//! restitution ([`Springs::restitution`]).

use super::{StepInput, Stepper};
use crate::law::{PairMobility, Springs, relaxation};
use crate::solver::contact::{Contact, NO_BOND, NO_LEVERS};
use crate::step::state::GrainState;

/// Cosine between normals that count as one direction.
const PARALLEL: f64 = 0.99;

/// A damped contact of a cluster in a step.
struct Damped<'a> {
    contact: &'a Contact,
    /// Bodies that move in place of its disks; all bodies that are not grains count as one.
    pair: [usize; 2],
    /// zeta.
    damping: f64,
    /// 1/m_i, and 1/M (1/kg).
    mobility: [f64; 2],
    /// Loss (J).
    loss: f64,
}

impl Damped<'_> {
    fn is_along(&self, other: &Damped) -> bool {
        let ([nx, ny], [x, y]) = (self.contact.normal, other.contact.normal);
        nx * x + ny * y > PARALLEL
    }

    /// sqrt(m_i / M).
    fn share(&self) -> f64 {
        (self.mobility[1] / self.mobility[0]).sqrt()
    }
}

impl Stepper {
    /// Loss in the dampers of contacts that shared a landing in this step (J), and its products with e(zeta) of the law, with e(zeta') of the
    /// landing, and with the value of `law.damping` that would give e(zeta).
    pub(super) fn shared_damping(&self, state: &GrainState, input: &StepInput) -> [f64; 4] {
        let bodies = input.bodies;
        if bodies.clusters.list.is_empty() || !bodies.any_law(|law| law.is_damped()) {
            return [0.0; 4];
        }
        let mut damped: Vec<Damped> = self.damped(state, input).collect();
        damped.sort_by_key(|one| one.pair);
        let mut sums = [0.0; 4];
        for group in damped.chunk_by(|one, next| one.pair == next.pair) {
            let first = &group[0];
            let landing = group.iter().filter(|one| one.is_along(first));
            let landing: Vec<&Damped> = landing.collect();
            if landing.len() < 2 {
                continue;
            }
            let dampers = landing.iter().map(|one| one.share()).sum::<f64>();
            let (ratio, zeta) = (dampers / (landing.len() as f64).sqrt(), first.damping);
            let loss = landing.iter().map(|one| one.loss).sum::<f64>();
            sums[0] += loss;
            for (sum, zeta) in sums[1..].iter_mut().zip([zeta, zeta * ratio, zeta / ratio]) {
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
            let of = |disk: usize, pushed: u32| {
                let alone = self.problem.records[pushed as usize].inverse_mass;
                let own = state.mobility(bodies, disk, contact.normal);
                own.unwrap_or([alone; 3])
            };
            let both = [of(disks[0], contact.a), of(disks[1], contact.b)];
            let pair = PairMobility::of(both.map(|[own, _, free]| [own, free]));
            let mobility = [pair.along, both[0][1] + both[1][1]];
            let damper = relaxation(springs.damping, springs.normal, pair) * springs.normal;
            let [u_n, _] = self.problem.relative_velocity(contact);
            Some(Damped {
                contact,
                pair: disks.map(|disk| bodies.clusters.leader_of(disk).min(bodies.free)),
                damping: springs.damping,
                mobility,
                loss: h * damper * u_n * u_n,
            })
        })
    }
}
