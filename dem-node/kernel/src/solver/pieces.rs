//! Contacts with their bonds, and bodies with the contacts of which they are candidates, which sweeps cut into pieces.

use super::contact::{Contact, NO_BOND};
use super::partition::Cut;
use crate::contact::bond::BondContact;

/// Consecutive contacts and their bonds, which come in the order of the contacts.
pub struct WithBonds<'a> {
    /// The contacts.
    pub contacts: &'a mut [Contact],
    /// Their bonds.
    pub bonds: &'a mut [BondContact],
    /// Number of the first of these bonds.
    pub first_bond: usize,
}

impl Cut for WithBonds<'_> {
    fn cut(self, count: usize) -> (Self, Self) {
        let (contacts, rest) = self.contacts.split_at_mut(count);
        let first_of_rest = first_bond(rest).unwrap_or(self.first_bond + self.bonds.len());
        let (bonds, bonds_of_rest) = self.bonds.split_at_mut(first_of_rest - self.first_bond);
        let left = WithBonds {
            contacts,
            bonds,
            first_bond: self.first_bond,
        };
        let right = WithBonds {
            contacts: rest,
            bonds: bonds_of_rest,
            first_bond: first_of_rest,
        };
        (left, right)
    }
}

/// Number of the first bond among these contacts.
pub fn first_bond(contacts: &[Contact]) -> Option<usize> {
    let bonded = contacts.iter().find(|contact| contact.bond != NO_BOND);
    bonded.map(|contact| contact.bond as usize)
}

/// Consecutive bodies, and the contacts of which they are the candidates; contacts are sorted by these.
pub struct ByCandidate<'a, B, C> {
    /// Items of the bodies.
    pub bodies: &'a mut [B],
    /// The contacts.
    pub contacts: C,
    /// Number of the first body.
    pub first: usize,
    /// Number of contacts before these.
    pub passed: usize,
}

impl<'a, B, C> ByCandidate<'a, B, C> {
    /// All bodies and contacts.
    pub fn all(bodies: &'a mut [B], contacts: C) -> ByCandidate<'a, B, C> {
        ByCandidate {
            bodies,
            contacts,
            first: 0,
            passed: 0,
        }
    }
}

impl<B: Send, C: Cut + AsRef<[Contact]>> Cut for ByCandidate<'_, B, C> {
    fn cut(self, count: usize) -> (Self, Self) {
        let next = self.first + count;
        let is_before = |contact: &Contact| (contact.a as usize) < next;
        let passed = self.contacts.as_ref().partition_point(is_before);
        let (contacts, rest) = self.contacts.cut(passed);
        let (bodies, bodies_of_rest) = self.bodies.split_at_mut(count);
        let left = ByCandidate {
            bodies,
            contacts,
            ..self
        };
        let right = ByCandidate {
            bodies: bodies_of_rest,
            contacts: rest,
            first: next,
            passed: left.passed + passed,
        };
        (left, right)
    }
}
