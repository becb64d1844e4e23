//! The random numbers of a sample.

use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

/// The random numbers of a sample. The generator is part of the recipe: PCG64 gives the same sample for a seed on every machine.
pub struct RandomNumbers(Pcg64);

impl RandomNumbers {
    /// The numbers that belong to a seed.
    pub fn new(seed: u64) -> RandomNumbers {
        RandomNumbers(Pcg64::seed_from_u64(seed))
    }

    /// Uniform in [0, 1): the upper 53 bits of a word.
    pub fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * 2f64.powi(-53)
    }

    /// Uniform in [low, high).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}
