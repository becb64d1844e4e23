//! Healing: adhesion of bonds that grows while their pairs are pressed together.
//!
//! The adhesion a of Raous, Cangemi and Cocou (1999) only falls; here it also grows, a' = 1/T, while the pressure r_n/(l h) is at least p, l being
//! the area of the bond. A pair that was never bonded counts the time for which it has been pressed without a break, and is bonded with the adhesion
//! for this time. A bond grows at rest: its shear force stays, and the slip of the stiffer spring becomes shorter. It gains the surface energy l w da
//! without any work; breaking it later takes this work.

/// The parameters of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Healing {
    /// T (s).
    pub time: f64,
    /// p (Pa).
    pub pressure: f64,
}

/// Adhesion of a new bond at its start: bonds with less count as broken.
const MADE: f64 = 0.01;

impl Healing {
    /// True for a pair of this area (m2) under a normal force (N).
    pub fn presses(&self, force: f64, area: f64) -> bool {
        force > 0.0 && force >= self.pressure * area
    }

    /// Adhesion after a step h (s) under pressure.
    pub fn grown(&self, adhesion: f64, h: f64) -> f64 {
        (adhesion + h / self.time).min(1.0)
    }

    /// Adhesion of a new bond after this time (s) under pressure, if it is time for one.
    pub fn made(&self, pressed: f64) -> Option<f64> {
        let adhesion = self.grown(0.0, pressed);
        (adhesion >= MADE).then_some(adhesion)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn adhesion_grows_with_the_time_under_pressure() {
        let law = Healing {
            time: 2.0,
            pressure: 5.0,
        };
        assert!(law.presses(10.0, 2.0) && !law.presses(9.9, 2.0) && !law.presses(0.0, 0.0));
        assert_eq!((law.grown(0.5, 0.5), law.grown(0.9, 0.5)), (0.75, 1.0));
        assert_eq!((law.made(0.01), law.made(0.5)), (None, Some(0.25)));
    }
}
