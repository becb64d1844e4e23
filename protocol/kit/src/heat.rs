//! Heat in what has no mesh: capacities that depend on temperature, and half-spaces.
//!
//! The surface of a half-space of effusivity b = sqrt(k rho c) under a flux q has risen by (Carslaw and Jaeger 1959, section 2.9)
//! ```text
//! T(t) = 1/(b sqrt(pi)) int q(s)/sqrt(t - s) ds,     1/sqrt(t) = 2/sqrt(pi) int exp(-l^2 t) dl,  l from 0 to infinity
//! ```
//! The trapezium rule in ln l, with 0.35 between two of 54 modes, is exact within 1e-5 for up to 1e9 steps: each mode forgets by itself, and memory
//! is bounded. Slower modes forget nothing, and are one; the flux of the last step, to which faster ones belong, adds 2 q sqrt(h/pi)/b.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use crate::keys::{ConfigError, refuse_if};
use crate::table::{check_table, load_at};

/// Distance of two modes in ln l, and their number.
const APART: f64 = 0.35;
const MODES: usize = 54;

/// l^2 of the fastest mode, times the first step.
const FASTEST: f64 = 2000.0;

/// A factor on a heat capacity over temperature: its entries as rises above the start (K), with the factor and the heat up to there over the
/// constant capacity (K).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CapacityTable(Vec<[f64; 3]>);

impl CapacityTable {
    /// Of entries `[temperature (K), factor above 0]` in ascending order, for rises above a temperature (K); a constant without entries.
    pub fn new(table: &[[f64; 2]], start: f64) -> CapacityTable {
        let mut entries: Vec<[f64; 3]> = table.iter().map(|[t, f]| [t - start, *f, 0.0]).collect();
        if !table.is_empty() {
            let zero = entries.partition_point(|[rise, ..]| *rise < 0.0);
            entries.insert(zero, [0.0, load_at(table, start), 0.0]);
            let heat = |[a, fa, _]: [f64; 3], [b, fb, _]: [f64; 3]| 0.5 * (fa + fb) * (b - a);
            for at in zero + 1..entries.len() {
                entries[at][2] = entries[at - 1][2] + heat(entries[at - 1], entries[at]);
            }
            for at in (0..zero).rev() {
                entries[at][2] = entries[at + 1][2] - heat(entries[at], entries[at + 1]);
            }
        }
        CapacityTable(entries)
    }

    /// True without entries.
    pub fn is_constant(&self) -> bool {
        self.0.is_empty()
    }

    /// The factor at this rise (K).
    pub fn factor(&self, rise: f64) -> f64 {
        let (from, slope) = self.stretch(0, rise);
        from.map_or(1.0, |[start, factor, _]| factor + slope * (rise - start))
    }

    /// Heat up to this rise (K), over the constant capacity (K).
    pub fn heat(&self, rise: f64) -> f64 {
        let (from, slope) = self.stretch(0, rise);
        from.map_or(rise, |[start, factor, heat]| {
            let x = rise - start;
            heat + x * (factor + 0.5 * slope * x)
        })
    }

    /// The rise (K) with this heat.
    pub fn rise(&self, heat: f64) -> f64 {
        let (from, slope) = self.stretch(2, heat);
        from.map_or(heat, |[start, factor, before]| {
            let more = heat - before;
            let root = (factor * factor + 2.0 * slope * more).max(0.0).sqrt();
            start + 2.0 * more / (factor + root)
        })
    }

    /// The entry before a value in a column and the slope of the factor beyond it; before the first one, the first.
    fn stretch(&self, column: usize, value: f64) -> (Option<[f64; 3]>, f64) {
        let next = self.0.partition_point(|entry| entry[column] <= value);
        let slope = |pair: &[[f64; 3]]| match (pair[1][1] - pair[0][1], pair[1][0] - pair[0][0]) {
            (_, 0.0) => 0.0,
            (factors, rises) => factors / rises,
        };
        let last = next.checked_sub(1).and_then(|last| self.0.get(last..=next));
        let from = self.0.get(next.saturating_sub(1)).copied();
        (from, last.map_or(0.0, slope))
    }
}

/// A factor at a temperature (K), 1 without entries.
pub fn factor_at(table: &[[f64; 2]], temperature: f64) -> f64 {
    if table.is_empty() {
        1.0
    } else {
        load_at(table, temperature)
    }
}

/// Refuses a table of factors over temperature that is wrong.
///
/// # Errors
/// As [`check_table`], and temperatures or factors below 0, or factors of 0 where they must be `positive`.
pub fn check_factors(key: &str, table: &[[f64; 2]], positive: bool) -> Result<(), ConfigError> {
    check_table(key, table)?;
    let least = if positive {
        "above 0"
    } else {
        "no less than 0"
    };
    let below = |factor: f64| factor < 0.0 || (positive && factor == 0.0);
    let wrong = table.iter().find(|[t, factor]| *t <= 0.0 || below(*factor));
    refuse_if(
        wrong.is_some(),
        key,
        format!(
            "has {:?}, and temperatures are above 0, and factors {least}",
            wrong.unwrap_or(&[0.0; 2])
        ),
        "write [[kelvins, factor], ...]",
    )
}

/// What the surface of a half-space remembers of its flux; nothing yet by default.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FluxMemory {
    /// Length of the first step (s).
    step: f64,
    /// int q exp(-l^2 (t - s)) ds of each mode (J/m2), the last one with l = 0: all heat so far.
    modes: Vec<f64>,
}

impl FluxMemory {
    /// b times the rise of the surface after a step of this length (s) without flux, and with a flux of 1 W/m2 in place of none.
    pub fn ahead(&self, time: f64) -> [f64; 2] {
        let each = self.modes.iter().enumerate();
        let sum: f64 = each
            .map(|(k, mode)| {
                let (rate, weight) = self.mode(k);
                weight * mode * (-rate * time).exp()
            })
            .sum();
        [2.0 / PI * sum, 2.0 * (time / PI).sqrt()]
    }

    /// Takes a step of this length (s) under a flux (W/m2).
    pub fn take(&mut self, flux: f64, time: f64) {
        if self.modes.is_empty() {
            (self.step, self.modes) = (time, vec![0.0; MODES + 1]);
        }
        for k in 0..MODES {
            let (rate, _) = self.mode(k);
            let lost = -(-rate * time).exp_m1();
            self.modes[k] += lost * (flux / rate - self.modes[k]);
        }
        self.modes[MODES] += flux * time;
    }

    /// Heat so far (J/m2).
    pub fn heat(&self) -> f64 {
        self.modes.last().copied().unwrap_or(0.0)
    }

    /// All numbers.
    pub fn numbers(&self) -> &[f64] {
        &self.modes
    }

    /// l^2 of a mode (1/s), and its weight in the integral over l.
    fn mode(&self, k: usize) -> (f64, f64) {
        let l = (FASTEST / self.step).sqrt() * (-APART * k as f64).exp();
        match k {
            // The sum over all slower modes.
            MODES => (0.0, APART * l / (1.0 - (-APART).exp())),
            _ => (l * l, APART * l),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2 q sqrt(t/pi) under a constant flux, in steps of one length and of changing ones; and the fall after it, 2 (sqrt(t) - sqrt(t - t1)) q/sqrt(pi).
    #[test]
    fn a_half_space_remembers_its_flux() {
        for changing in [false, true] {
            let (mut memory, mut t) = (FluxMemory::default(), 0.0);
            for k in 0..100_000 {
                let h = if changing && k % 3 == 0 { 0.5e-6 } else { 1e-6 };
                let [before, slope] = memory.ahead(h);
                t += h;
                let exact = 2.0 * (t / PI).sqrt();
                let error = (before + 3.0 * slope) / 3.0 / exact - 1.0;
                let allowed = if changing && k < 100 { 0.02 } else { 1e-4 };
                assert!(error.abs() < allowed, "{error} in step {k}");
                memory.take(3.0, h);
            }
            assert!((memory.heat() / (3.0 * t) - 1.0).abs() < 1e-10);
            for rest in [1e-5, 1e-3, 1.0] {
                let exact = 6.0 * (((t + rest) / PI).sqrt() - (rest / PI).sqrt());
                let error = memory.ahead(rest)[0] / exact - 1.0;
                assert!(error.abs() < 1e-4, "{error} after {rest} s");
            }
        }
    }

    /// A factor that grows from 1 at 300 K to 2 at 500 K: between them the heat is x + x^2/400.
    #[test]
    fn a_capacity_over_temperature_gives_its_heat_back() {
        let table = CapacityTable::new(&[[250.0, 1.0], [300.0, 1.0], [500.0, 2.0]], 300.0);
        for (rise, heat, factor) in [
            (-100.0, -100.0, 1.0),
            (-20.0, -20.0, 1.0),
            (0.0, 0.0, 1.0),
            (100.0, 125.0, 1.5),
            (200.0, 300.0, 2.0),
            (300.0, 500.0, 2.0),
        ] {
            assert!((table.heat(rise) - heat).abs() < 1e-10, "{rise}");
            assert!((table.rise(heat) - rise).abs() < 1e-10, "{rise}");
            assert!((table.factor(rise) - factor).abs() < 1e-12, "{rise}");
        }
        let constant = CapacityTable::new(&[], 300.0);
        assert!(constant.is_constant());
        let all = [constant.factor(7.0), constant.heat(7.0), constant.rise(7.0)];
        assert_eq!(all, [1.0, 7.0, 7.0]);
    }
}
