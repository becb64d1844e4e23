//! Operations on vectors over components.

/// a - b, entry by entry.
pub fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// H v (m), entry by entry.
pub fn motion_of(velocity: &[f64], window_s: f64) -> Vec<f64> {
    velocity.iter().map(|v| v * window_s).collect()
}
