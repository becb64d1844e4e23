//! Parameters of the scheme, and its predictor.

use serde::{Deserialize, Serialize};

use crate::pack::lanes::Pack;

/// Parameters of the scheme.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct NewmarkScheme {
    /// Step h (s).
    pub step: f64,
    /// Damping parameter b.
    pub damping: f64,
    /// Mass damping c (1/s).
    pub mass_damping: f64,
    /// Stiffness damping beta (s).
    pub stiffness_damping: f64,
}

impl NewmarkScheme {
    /// h (1-b) and h b, in every lane.
    #[inline(always)]
    pub(crate) fn weights(&self) -> (Pack, Pack) {
        let (h, b) = (self.step, self.damping);
        (Pack::splat(h * (1.0 - b)), Pack::splat(h * b))
    }

    /// u' = u + h v + h^2/2 a
    #[inline(always)]
    pub(crate) fn predicted(&self, u: f64, v: f64, a: f64) -> f64 {
        u + self.increment(v, a)
    }

    /// h v + h^2/2 a
    #[inline(always)]
    pub fn increment(&self, v: f64, a: f64) -> f64 {
        self.step * v + 0.5 * self.step * self.step * a
    }
}

/// Mass damping c at the two ends of a step (1/s); it differs where the damping of a start phase ends, and then
/// D = [(1-b) c_n v + b c_n+1 v'] M du.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Damping {
    /// At its start.
    pub start: f64,
    /// At its end.
    pub end: f64,
}

impl Damping {
    pub(crate) fn acts(self) -> bool {
        self.start > 0.0 || self.end > 0.0
    }
}

/// Scheme and mass damping of a step.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    pub(crate) scheme: NewmarkScheme,
    /// Mass damping, the start phase's included.
    pub damping: Damping,
}
