//! The two branches of a bond's normal law: tension, and compression.

use super::group::{LANES, Lanes, ShortLanes, inverse};
use crate::bond::BondContact;
use crate::law::local::in_tension;
use crate::solver::Contact;

/// The branches on which four contacts are.
#[derive(Clone, Copy, Debug)]
pub struct Branches {
    /// True for a contact with a bond.
    bonded: [bool; LANES],
    /// Bounds of r_n on its branch (N s).
    pub bounds: [Lanes; 2],
    /// Part of the bodies in D (1/kg), and what the spring of compression and the bond in tension add to it.
    block: [f64; LANES],
    spring: [f64; LANES],
    tension: [f64; LANES],
}

impl Default for Branches {
    fn default() -> Branches {
        Branches {
            bonded: [false; LANES],
            bounds: [Lanes::splat(0.0), Lanes::splat(f64::INFINITY)],
            block: [0.0; LANES],
            spring: [0.0; LANES],
            tension: [f64::INFINITY; LANES],
        }
    }
}

impl Branches {
    /// Fills a lane: compression, until the first impulse is looked at.
    pub fn set(&mut self, k: usize, contact: &Contact, bond: Option<&BondContact>) {
        self.bonded[k] = bond.is_some();
        self.block[k] = contact.block.nn;
        self.spring[k] = contact.compliance[0];
        self.tension[k] = bond.map_or(f64::INFINITY, |bond| bond.law.compliance()[0]);
    }

    /// Takes the branches of impulses r under u without its compliance; writes compliance and 1/D there, of bonds.
    #[inline(always)]
    pub fn take(
        &mut self,
        impulse: Lanes,
        velocity: Lanes,
        compliance: &mut Lanes,
        inverse_d: &mut ShortLanes,
    ) {
        let [low, high] = &mut self.bounds;
        for k in (0..LANES).filter(|k| self.bonded[*k]) {
            let pulls = in_tension(impulse.0[k], velocity.0[k]);
            compliance.0[k] = if pulls && self.tension[k].is_finite() {
                (low.0[k], high.0[k]) = (f64::NEG_INFINITY, 0.0);
                self.tension[k]
            } else {
                (low.0[k], high.0[k]) = (0.0, f64::INFINITY);
                self.spring[k]
            };
            inverse_d.0[k] = inverse(self.block[k] + compliance.0[k]);
        }
    }

    /// Numbers of bonds where there are any, the others elsewhere.
    #[inline(always)]
    pub fn select(&self, bonded: Lanes, others: Lanes) -> Lanes {
        let mut lanes = others;
        for k in (0..LANES).filter(|k| self.bonded[*k]) {
            lanes.0[k] = bonded.0[k];
        }
        lanes
    }
}
