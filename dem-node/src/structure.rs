//! Arrangement of the contacts of a state: coordination, fabric, and the distribution of forces.
//!
//! Computed once, from the state at the end of a run. Contacts are those that carry a compressive force.

use std::collections::BTreeMap;

use crate::bodies::Bodies;
use crate::positions::proximity;
use crate::state::State;

/// Forces on a grain below which it is a rattler: two contacts are the fewest that can hold a disk.
const HELD: usize = 2;

/// Numbers of the arrangement of contacts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Structure {
    /// Contacts per body that has at least two, counted on each of them; a cluster is one body.
    pub coordination: f64,
    /// The same over all bodies.
    pub coordination_with_rattlers: f64,
    /// Part of the bodies that have fewer than two.
    pub rattlers: f64,
    /// Mean of n (x) n over the contacts (Satake 1982): xx, xy, yy.
    pub fabric: [f64; 3],
    /// Mean, standard deviation and largest of the normal forces (N).
    pub force: [f64; 3],
    /// Part of the contacts that carry more than the mean: 0.39 in a broad distribution, 0.5 in a symmetric one.
    pub strong: f64,
}

impl Structure {
    /// The contacts of a state.
    pub fn new(bodies: &Bodies, state: &State) -> Structure {
        let slots = || state.list.slots.iter().filter(|slot| slot.force[0] > 0.0);
        let forces: Vec<f64> = slots().map(|slot| slot.force[0]).collect();
        if forces.is_empty() {
            return Structure {
                rattlers: 1.0,
                ..Structure::default()
            };
        }
        let degrees = degrees(bodies, state);
        let held: Vec<usize> = degrees.iter().copied().filter(|d| *d >= HELD).collect();
        let per = |sum: usize, count: usize| sum as f64 / count.max(1) as f64;
        let positions = state.positions(bodies);
        let mut fabric = [0.0; 3];
        for slot in slots() {
            let [x, y] = proximity(bodies, &positions, slot.a as usize, slot.b as usize).normal;
            for (sum, product) in fabric.iter_mut().zip([x * x, x * y, y * y]) {
                *sum += product / forces.len() as f64;
            }
        }
        let mean = forces.iter().sum::<f64>() / forces.len() as f64;
        let variance = forces.iter().map(|f| (f - mean).powi(2)).sum::<f64>() / forces.len() as f64;
        Structure {
            coordination: per(held.iter().sum(), held.len()),
            coordination_with_rattlers: per(degrees.iter().sum(), degrees.len()),
            rattlers: per(degrees.len() - held.len(), degrees.len()),
            fabric,
            force: [
                mean,
                variance.sqrt(),
                forces.iter().copied().fold(0.0, f64::max),
            ],
            strong: per(forces.iter().filter(|f| **f > mean).count(), forces.len()),
        }
    }

    /// Difference of the principal values of the fabric: 0 when all directions are alike, 1 when all contacts are parallel.
    pub fn anisotropy(&self) -> f64 {
        let [xx, xy, yy] = self.fabric;
        (xx - yy).hypot(2.0 * xy)
    }

    /// Direction in which most contacts point, from x towards y (rad).
    pub fn direction(&self) -> f64 {
        let [xx, xy, yy] = self.fabric;
        0.5 * (2.0 * xy).atan2(xx - yy)
    }

    /// Its numbers under their names in the results.
    pub fn results(&self) -> BTreeMap<String, f64> {
        let [mean, deviation, largest] = self.force;
        let over_mean = |force: f64| if mean > 0.0 { force / mean } else { 0.0 };
        let named = [
            ("coordination", self.coordination),
            (
                "coordination_with_rattlers",
                self.coordination_with_rattlers,
            ),
            ("rattlers_share", self.rattlers),
            ("fabric_anisotropy", self.anisotropy()),
            ("fabric_direction_deg", self.direction().to_degrees()),
            ("contact_force_mean_n", mean),
            ("contact_force_max_over_mean", over_mean(largest)),
            ("contact_force_deviation_over_mean", over_mean(deviation)),
            ("contact_force_above_mean_share", self.strong),
        ];
        let named = named.into_iter();
        named.map(|(name, x)| (name.to_string(), x)).collect()
    }
}

/// Contacts of each free body; clusters are counted once.
fn degrees(bodies: &Bodies, state: &State) -> Vec<usize> {
    let mut degree = vec![0usize; bodies.free];
    for slot in state.list.slots.iter().filter(|slot| slot.force[0] > 0.0) {
        for body in [slot.a as usize, slot.b as usize] {
            if let Some(count) = degree.get_mut(bodies.clusters.leader_of(body)) {
                *count += 1;
            }
        }
    }
    let leads = |body: &usize| bodies.clusters.leader_of(*body) == *body;
    (0..bodies.free).filter(leads).map(|i| degree[i]).collect()
}
