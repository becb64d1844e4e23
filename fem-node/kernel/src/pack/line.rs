//! Numbers that begin on a cache line.

use std::ops::{Deref, DerefMut};

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use pulp::bytemuck::{Zeroable, cast_slice, cast_slice_mut};

/// A cache line. The register of this size is the only type with its alignment that may be read as numbers.
#[cfg(target_arch = "x86_64")]
type Line = std::arch::x86_64::__m512d;
#[cfg(not(target_arch = "x86_64"))]
type Line = [f64; LINE];

/// Numbers in a cache line.
pub(crate) const LINE: usize = 8;

/// Numbers that begin on a cache line: a vector across two lines takes two accesses to read or write.
#[derive(Clone, Debug, Default)]
pub struct Lines(Vec<Line>);

impl Lines {
    /// At least this many zeros.
    pub(crate) fn zeros(count: usize) -> Lines {
        Lines(vec![Line::zeroed(); count.div_ceil(LINE)])
    }

    /// Makes it as long as [`zeros`](Lines::zeros) would; new numbers are zero.
    pub fn resize(&mut self, count: usize) {
        self.0.resize(count.div_ceil(LINE), Line::zeroed());
    }
}

impl PartialEq for Lines {
    fn eq(&self, other: &Lines) -> bool {
        self[..] == other[..]
    }
}

impl Serialize for Lines {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self[..].serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Lines {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Lines, D::Error> {
        let numbers = Vec::<f64>::deserialize(deserializer)?;
        let mut lines = Lines::zeros(numbers.len());
        if lines.len() != numbers.len() {
            return Err(D::Error::invalid_length(
                numbers.len(),
                &"whole lines of 8 numbers",
            ));
        }
        lines.copy_from_slice(&numbers);
        Ok(lines)
    }
}

impl<'a> IntoIterator for &'a Lines {
    type Item = &'a f64;
    type IntoIter = std::slice::Iter<'a, f64>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl Deref for Lines {
    type Target = [f64];

    #[inline(always)]
    fn deref(&self) -> &[f64] {
        cast_slice(&self.0)
    }
}

impl DerefMut for Lines {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [f64] {
        cast_slice_mut(&mut self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_begin_on_a_cache_line() {
        for count in [0, 1, 8, 9, 1000] {
            let mut lines = Lines::zeros(count);
            assert_eq!(lines.len(), count.next_multiple_of(LINE));
            assert!(lines.iter().all(|number| *number == 0.0));
            lines.fill(1.5);
            assert_eq!(lines.iter().sum::<f64>(), 1.5 * lines.len() as f64);
            if cfg!(target_arch = "x86_64") {
                assert_eq!(lines.as_ptr().addr() % (8 * LINE), 0);
            }
        }
    }
}
