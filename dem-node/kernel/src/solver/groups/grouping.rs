//! Grouping of contacts: eight that share no body go together.

use crate::solver::contact::{BodyRecord, Contact};

/// Contacts in a group.
pub const LANES: usize = 8;
/// A lane without contact.
pub const EMPTY: u32 = u32::MAX;

/// Number of open groups: a window of 256 contacts, in which nearly every contact finds seven others.
const OPEN: usize = 32;

/// Sorts contacts into groups, first fit among the open ones.
#[derive(Clone, Debug, Default)]
pub struct Grouping {
    /// Open groups that contain each body, one bit per group.
    pub taken: Vec<u32>,
    open: Vec<Vec<u32>>,
}

impl Grouping {
    /// Appends the groups of these contacts; bodies that nothing moves may be in all lanes.
    pub fn sort(
        &mut self,
        contacts: &[Contact],
        chosen: &[u32],
        records: &[BodyRecord],
        out: &mut Vec<[u32; LANES]>,
    ) {
        self.taken.resize(records.len().max(self.taken.len()), 0);
        self.open.resize(OPEN, Vec::new());
        for index in chosen {
            let contact = &contacts[*index as usize];
            let (a, b) = (contact.a as usize, contact.b as usize);
            let taken = self.taken[a] | self.taken[b];
            // A body has at most five neighbours of its own size, but any number of small ones.
            if taken == u32::MAX {
                self.close(contacts, 0, out);
            }
            let slot = (!(self.taken[a] | self.taken[b])).trailing_zeros() as usize;
            for body in [a, b] {
                if records[body].inverse_mass > 0.0 {
                    self.taken[body] |= 1 << slot;
                }
            }
            self.open[slot].push(*index);
            if self.open[slot].len() == LANES {
                self.close(contacts, slot, out);
            }
        }
        for slot in 0..OPEN {
            self.close(contacts, slot, out);
        }
    }

    fn close(&mut self, contacts: &[Contact], slot: usize, out: &mut Vec<[u32; LANES]>) {
        if self.open[slot].is_empty() {
            return;
        }
        let mut members = [EMPTY; LANES];
        for (k, index) in self.open[slot].drain(..).enumerate() {
            members[k] = index;
            let contact = &contacts[index as usize];
            for body in [contact.a as usize, contact.b as usize] {
                self.taken[body] &= !(1 << slot);
            }
        }
        out.push(members);
    }
}
