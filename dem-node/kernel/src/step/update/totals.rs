//! Contacts at the end of a step with the data that they change, and sums over them.

use protocol::larger;

use crate::bodies::Bodies;
use crate::contact::bond::{Bond, BondContact};
use crate::contact::detect::Slot;
use crate::contact::loss::Loss;
use crate::law::lanes::{Lanes, Real};
use crate::solver::contact::Contact;
use crate::solver::partition::Cut;
use crate::solver::pieces::first_bond;
use crate::step::StepSummary;
use crate::step::ledger::GrainLedger;
use crate::step::temperature::PairHeat;

/// Contacts of a pack.
pub const LANES: usize = 4;

/// A number of each contact of a pack.
pub type Doubles = Lanes<LANES>;

/// Contacts with the data that a step changes: their slots, and the bonds of the state.
pub struct UpdatePiece<'a> {
    pub contacts: &'a [Contact],
    /// Slot of each contact.
    pub slot_indices: &'a [u32],
    pub slots: &'a mut [Slot],
    pub first_slot: usize,
    pub bonds: &'a mut [Bond],
    pub first_bond: usize,
    /// All bonds of the problem.
    pub bonded: &'a [BondContact],
}

impl UpdatePiece<'_> {
    #[inline(always)]
    pub fn slot(&self, contact: usize) -> &Slot {
        &self.slots[self.slot_indices[contact] as usize - self.first_slot]
    }

    #[inline(always)]
    pub fn slot_mut(&mut self, contact: usize) -> &mut Slot {
        &mut self.slots[self.slot_indices[contact] as usize - self.first_slot]
    }
}

impl Cut for UpdatePiece<'_> {
    fn cut(self, count: usize) -> (Self, Self) {
        let (contacts, right_contacts) = self.contacts.split_at(count);
        let (slot_indices, right_indices) = self.slot_indices.split_at(count);
        let slot = right_indices.first().map(|slot| *slot as usize);
        let slot = slot.unwrap_or(self.first_slot + self.slots.len());
        let bond = first_bond(right_contacts).map(|bond| self.bonded[bond].index as usize);
        let bond = bond.unwrap_or(self.first_bond + self.bonds.len());
        let (slots, right_slots) = self.slots.split_at_mut(slot - self.first_slot);
        let (bonds, right_bonds) = self.bonds.split_at_mut(bond - self.first_bond);
        let right = UpdatePiece {
            contacts: right_contacts,
            slot_indices: right_indices,
            slots: right_slots,
            first_slot: slot,
            bonds: right_bonds,
            first_bond: bond,
            bonded: self.bonded,
        };
        let left = UpdatePiece {
            contacts,
            slot_indices,
            slots,
            bonds,
            ..self
        };
        (left, right)
    }
}

/// Impulses between the free grains and everything else (N s).
#[derive(Clone, Debug, Default)]
pub struct OuterImpulses {
    /// On the grains.
    pub on_grains: [f64; 2],
    /// Half the sum of their absolute values.
    pub transmitted: f64,
    /// From the grains on the wheel, sideways.
    pub on_wheel: f64,
    /// From the wheel on the grains, along its face.
    pub turning_wheel: f64,
    /// Work of friction on segments of the surface, contact by contact (J).
    pub rubbed: Vec<(usize, f64)>,
    /// Heat of contacts by pair.
    pub warmed: Vec<PairHeat>,
}

impl OuterImpulses {
    pub fn add(&mut self, bodies: &Bodies, contact: &Contact) {
        if (contact.b as usize) < bodies.free {
            return;
        }
        let push = contact.in_xy(contact.impulse);
        if (contact.a as usize) < bodies.free {
            let [x, y] = self.on_grains;
            self.on_grains = [x + push[0], y + push[1]];
            self.transmitted += 0.5 * (push[0] * push[0] + push[1] * push[1]).sqrt();
        }
        if Some(contact.b as usize) == bodies.wheel() {
            self.on_wheel -= push[0];
            self.turning_wheel += contact.impulse[1];
        }
    }

    pub fn join(&mut self, mut other: OuterImpulses) {
        kit::add_fields!(self, other; transmitted, on_wheel, turning_wheel);
        let [x, y] = other.on_grains;
        self.on_grains = [self.on_grains[0] + x, self.on_grains[1] + y];
        self.rubbed.append(&mut other.rubbed);
        self.warmed.append(&mut other.warmed);
    }
}

/// Sums over contacts at the end of a step.
#[derive(Default)]
pub struct Totals {
    pub summary: StepSummary,
    pub ledger: GrainLedger,
    pub outer: OuterImpulses,
    /// Contacts of two grains, without and with a bond.
    pub packs: [PackSums; 2],
}

/// Sums over packs, lane by lane.
#[derive(Clone, Copy, Debug, Default)]
pub struct PackSums {
    /// Losses; of `unforeseen` the absolute values.
    pub losses: Loss<Doubles>,
    /// Number and overlaps of contacts that press, the sum and the largest overlap (m), and the largest travel of a step.
    pub closed: Doubles,
    pub overlap: [Doubles; 2],
    pub travel: Doubles,
    /// Largest D over w.
    pub load: Doubles,
}

impl PackSums {
    /// Adds losses.
    #[inline(always)]
    pub fn lose(&mut self, losses: Loss<Doubles>) {
        let unforeseen = losses.unforeseen.map(f64::abs);
        self.losses = self.losses.plus(&Loss {
            unforeseen,
            ..losses
        });
    }

    /// Adds loss and overlap (m) of one contact to a lane.
    pub fn add(&mut self, k: usize, loss: Loss, overlap: f64) {
        self.lose(loss.each(|x| {
            let mut lanes = Doubles::default();
            lanes.0[k] = x;
            lanes
        }));
        self.overlap[0].0[k] += overlap;
    }

    /// Adds the sums over the lanes.
    pub fn join(&self, totals: &mut Totals) {
        let largest = |lanes: Doubles| lanes.0.into_iter().fold(0.0, larger);
        let summary = &mut totals.summary;
        summary.closed += self.closed.sum() as usize;
        summary.overlap[0] += self.overlap[0].sum();
        summary.overlap[1] = larger(summary.overlap[1], largest(self.overlap[1]));
        summary.travel = larger(summary.travel, largest(self.travel));
        summary.bond_load_squared = larger(summary.bond_load_squared, largest(self.load));
        totals.ledger.lose(&self.losses.each(Lanes::sum));
    }
}
