//! Plausibility: a value at the end of a run that lies beyond its bound.

use serde::{Deserialize, Serialize};

/// A value beyond its bound: look at the cause before you use the results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// Word for scripts, for instance `wheel_at_rest`.
    pub code: String,
    /// The fault in words, and what to do about it.
    pub text: String,
    /// The value; the largest finite number in place of infinity or NaN.
    pub value: f64,
    /// The bound that it passed.
    pub bound: f64,
    /// True beyond the second bound: the results are not to be trusted.
    pub suspect: bool,
}

/// The larger of two numbers; NaN if either is NaN, which `f64::max` would drop.
#[inline]
pub fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b <= a { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nan_is_larger_than_any_number() {
        assert_eq!([larger(1.0, 2.0), larger(2.0, 1.0)], [2.0, 2.0]);
        for pair in [[f64::NAN, 1.0], [1.0, f64::NAN], [f64::NAN, f64::INFINITY]] {
            assert!(larger(pair[0], pair[1]).is_nan(), "{pair:?}");
        }
    }
}
