//! Laws by pair: contacts between two named groups of bodies have a law of their own.

use crate::law::Law;

/// Name of the group of all grains without cluster.
pub const GRAINS: &str = "grains";
/// Names of the groups of glued disks.
pub const ROWS: [&str; 2] = ["base", "lid"];
/// Name of the group of the surface, if it has a friction of its own; else it belongs to a row.
pub const SURFACE: &str = "surface";
/// Name of the wheel's group.
pub const WHEEL: &str = "wheel";

/// The groups of the bodies, and the laws of pairs of groups; empty where all contacts have the same law.
#[derive(Clone, Debug, Default)]
pub struct Pairs {
    /// Group of each body.
    groups: Vec<u16>,
    /// Number of groups.
    count: usize,
    /// Law of a pair of groups, its index in `laws` plus one; 0 for the law of all others.
    table: Vec<u16>,
    laws: Vec<Law>,
}

impl Pairs {
    /// The laws between groups by their names; `names` holds the name of each body's group.
    pub fn new(names: &[String], laws: &[([String; 2], Law)]) -> Pairs {
        if laws.is_empty() {
            return Pairs::default();
        }
        let mut known: Vec<&String> = names.iter().collect();
        known.sort();
        known.dedup();
        let count = known.len();
        let number = |name: &String| known.binary_search(&name).ok();
        let mut table = vec![0; count * count];
        for (index, (between, _)) in laws.iter().enumerate() {
            // A group without bodies has no contacts.
            if let [Some(a), Some(b)] = [0, 1].map(|side| number(&between[side])) {
                (table[a * count + b], table[b * count + a]) = (index as u16 + 1, index as u16 + 1);
            }
        }
        let groups = names.iter().filter_map(number);
        Pairs {
            groups: groups.map(|group| group as u16).collect(),
            count,
            table,
            laws: laws.iter().map(|(_, law)| *law).collect(),
        }
    }

    /// The law at an index, counted from one.
    #[inline]
    pub fn law(&self, index: u32) -> Option<&Law> {
        self.laws.get((index as usize).wrapping_sub(1))
    }

    /// The law between two bodies with its index, if they have one of their own.
    #[inline]
    pub fn of(&self, a: usize, b: usize) -> Option<(u32, &Law)> {
        let (a, b) = (*self.groups.get(a)?, *self.groups.get(b)?);
        let index = u32::from(self.table[a as usize * self.count + b as usize]);
        self.law(index).map(|law| (index, law))
    }

    /// The laws in the order of their indices.
    pub fn laws(&self) -> &[Law] {
        &self.laws
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pair_has_its_law_in_either_order_and_other_pairs_have_none() {
        let names = ["grains", "top", "grains", "wheel"].map(String::from);
        let law = |friction: f64| Law {
            friction,
            ..Law::default()
        };
        let between = |a: &str, b: &str| [a.to_string(), b.to_string()];
        let laws = [
            (between("grains", "top"), law(0.3)),
            (between("wheel", "grains"), law(0.7)),
        ];
        let pairs = Pairs::new(&names, &laws);
        let friction = |a: usize, b: usize| pairs.of(a, b).map(|(_, law)| law.friction);
        assert_eq!((friction(0, 1), friction(1, 2)), (Some(0.3), Some(0.3)));
        assert_eq!((friction(0, 3), friction(3, 2)), (Some(0.7), Some(0.7)));
        assert_eq!((friction(0, 2), friction(1, 3)), (None, None));
        assert!(Pairs::new(&names, &[]).of(0, 1).is_none());
    }
}
