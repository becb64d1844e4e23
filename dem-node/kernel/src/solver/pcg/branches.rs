//! The two branches of a bond's normal law: tension, and compression.

use super::group::{Doubles, LANES, Singles, inverse};
use crate::contact::bond::BondContact;
use crate::law::local::in_tension;
use crate::solver::contact::Contact;

/// The branches of four contacts.
#[derive(Clone, Copy, Debug)]
pub struct Branches {
    /// Upper bound of r_n (N s): 0 in tension, infinite in compression.
    high: Doubles,
    /// Compliance of tension (1/kg), infinite for a contact that cannot pull, and 1/D with it.
    tension: Doubles,
    inverse: Singles,
    /// True for a contact with a bond.
    bonded: [bool; LANES],
}

impl Default for Branches {
    fn default() -> Branches {
        Branches {
            high: Doubles::splat(f64::INFINITY),
            tension: Doubles::splat(f64::INFINITY),
            inverse: Singles::default(),
            bonded: [false; LANES],
        }
    }
}

impl Branches {
    /// Fills a lane: compression, until the first measurement.
    pub fn set(&mut self, k: usize, contact: &Contact, bond: Option<&BondContact>) {
        let tension = bond.map_or(f64::INFINITY, |bond| bond.law.compliance()[0]);
        self.bonded[k] = bond.is_some();
        self.tension.0[k] = tension;
        self.inverse.0[k] = inverse(contact.block.nn + tension);
    }

    /// Sets the branches for impulses r and u without its compliance.
    #[inline(always)]
    pub fn take(&mut self, impulse: Doubles, velocity: Doubles) {
        for k in 0..LANES {
            let pulls =
                in_tension(impulse.0[k], velocity.0[k]) & (self.tension.0[k] < f64::INFINITY);
            self.high.0[k] = if pulls { 0.0 } else { f64::INFINITY };
        }
    }

    /// Bounds of r_n on the branches (N s).
    #[inline(always)]
    pub fn bounds(&self) -> [Doubles; 2] {
        let low = self.either(Doubles::splat(f64::NEG_INFINITY), Doubles::splat(0.0));
        [low, self.high]
    }

    /// Compliances on the branches (1/kg), with `spring` in compression.
    #[inline(always)]
    pub fn compliance(&self, spring: Doubles) -> Doubles {
        self.either(self.tension, spring)
    }

    /// 1/D on the branches (kg), with `spring` in compression.
    #[inline(always)]
    pub fn inverse(&self, spring: Singles) -> Doubles {
        self.either(self.inverse.wide(), spring.wide())
    }

    #[inline(always)]
    fn either(&self, tension: Doubles, compression: Doubles) -> Doubles {
        let mut lanes = compression;
        for k in 0..LANES {
            lanes.0[k] = if self.high.0[k] == 0.0 {
                tension.0[k]
            } else {
                compression.0[k]
            };
        }
        lanes
    }

    /// `bonded` for contacts with a bond, `others` elsewhere.
    #[inline(always)]
    pub fn select(&self, bonded: Doubles, others: Doubles) -> Doubles {
        let mut lanes = others;
        for k in 0..LANES {
            lanes.0[k] = if self.bonded[k] {
                bonded.0[k]
            } else {
                others.0[k]
            };
        }
        lanes
    }
}
