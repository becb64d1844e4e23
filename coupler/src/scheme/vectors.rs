//! Operations on vectors over components.

/// a - b, entry by entry.
pub fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// H v (m), entry by entry.
pub fn motion_of(velocity: &[f64], window_s: f64) -> Vec<f64> {
    velocity.iter().map(|v| v * window_s).collect()
}

/// The larger of two numbers; not a number if either is none, which `f64::max` would drop.
pub fn larger(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_is_larger_than_any() {
        assert_eq!([larger(1.0, 2.0), larger(2.0, 1.0)], [2.0, 2.0]);
        for pair in [[f64::NAN, 1.0], [1.0, f64::NAN], [f64::NAN, f64::INFINITY]] {
            assert!(larger(pair[0], pair[1]).is_nan(), "{pair:?}");
        }
    }
}
