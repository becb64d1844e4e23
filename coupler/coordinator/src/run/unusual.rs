//! Finds numbers of a scenario that no solid has: results alone do not reveal a wrong unit.

use kit::judge;
use runs::plausible::UNUSUAL_VALUE;
use runs::warning::Warning;
use scenario::load::Loaded;
use scenario::overrides::{leaves, number};

/// A quantity with a range for solids.
struct Quantity {
    /// Last parts of its keys.
    keys: &'static [&'static str],
    /// Its unit, and the least and the largest number of a solid in this unit. Sizes and speeds are judged without
    /// their signs.
    unit: &'static str,
    range: [f64; 2],
    /// Usual numbers, from which a wrong unit is guessed.
    usual: [f64; 2],
    /// Other units, with their factors to this unit.
    others: &'static [(&'static str, f64)],
}

/// Foams to diamond: Young's modulus and density by Ashby, Materials Selection in Mechanical Design (2011), chapter 4;
/// yield stresses up to diamond's, contact stiffnesses up to five times the largest modulus, speeds up to a wave's in
/// steel; bonds by the limits beside them.
const QUANTITIES: [Quantity; 9] = [
    of(&["young_pa"], "Pa", [1e6, 2e12], [1e9, 2e12], &PRESSURES),
    of(&CONTACT_KEYS, "Pa", [1e6, 1e13], [1e9, 2e12], &PRESSURES),
    of(&["yield_pa"], "Pa", [1e5, 1e11], [1e7, 1e10], &PRESSURES),
    of(&DENSITY_KEYS, "kg/m3", [1e1, 3e4], [5e2, 2.3e4], &DENSITIES),
    // A modulus over the distance of two atoms is the most, over a millimetre the least.
    of(&BOND_KEYS, "Pa/m", [1e9, 1e22], [1e11, 1e20], &STIFFNESSES),
    // Van der Waals attraction to the toughest metals.
    of(&["w_j_per_m2"], "J/m2", [1e-4, 1e6], [1e-2, 1e6], &[]),
    // The viscosity of pitch.
    of(&["b_pa_m_s"], "Pa m s^p", [0.0, 1e9], [0.0, 1e3], &[]),
    of(&SPEED_KEYS, "m/s", [0.0, 6e3], [0.0, 1e2], &SPEEDS),
    of(&SIZE_KEYS, "m", [1e-9, 1e1], [1e-7, 1e0], &LENGTHS),
];

const CONTACT_KEYS: [&str; 1] = ["contact_stiffness_pa"];
const DENSITY_KEYS: [&str; 1] = ["density_kg_per_m3"];
const BOND_KEYS: [&str; 2] = ["cn_pa_per_m", "ct_pa_per_m"];
const SPEED_KEYS: [&str; 4] = [
    "velocity_m_per_s",
    "speed_m_per_s",
    "vx_m_per_s",
    "vy_m_per_s",
];
const SIZE_KEYS: [&str; 8] = [
    "radius_m",
    "radius_min_m",
    "radius_max_m",
    "size_m",
    "width_m",
    "height_m",
    "half_width_m",
    "thickness_m",
];
const DENSITIES: [(&str, f64); 3] = [("g/cm3", 1e3), ("kg/mm3", 1e9), ("t/mm3", 1e12)];
const PRESSURES: [(&str, f64); 3] = [("GPa", 1e9), ("MPa", 1e6), ("kPa", 1e3)];
const STIFFNESSES: [(&str, f64); 2] = [("GPa/m", 1e9), ("MPa/m", 1e6)];
const LENGTHS: [(&str, f64); 2] = [("mm", 1e-3), ("um", 1e-6)];
const SPEEDS: [(&str, f64); 2] = [("mm/s", 1e-3), ("um/s", 1e-6)];

const fn of(
    keys: &'static [&'static str],
    unit: &'static str,
    range: [f64; 2],
    usual: [f64; 2],
    others: &'static [(&'static str, f64)],
) -> Quantity {
    Quantity {
        keys,
        unit,
        range,
        usual,
        others,
    }
}

impl Quantity {
    /// The factor by which a number is outside the range; 1 inside.
    fn outside(&self, number: f64) -> f64 {
        let [least, most] = self.range;
        (least / number).max(number / most).max(1.0)
    }

    /// The unit that was perhaps meant.
    fn meant(&self, number: f64) -> String {
        let [least, most] = self.usual;
        let is_usual = |(_, factor): &&(&str, f64)| (least..=most).contains(&(factor * number));
        let meant = |(unit, factor): &(&str, f64)| {
            let (own, value) = (self.unit, factor * number);
            format!("; was {number} {unit} meant, {value:e} {own}?")
        };
        let other = self.others.iter().find(is_usual);
        other.map_or(String::new(), meant)
    }
}

/// Warnings about numbers of built-in solvers that no solid has, the first of each key.
pub(super) fn unusual(loaded: &Loaded) -> Vec<Warning> {
    let scenario = &loaded.scenario;
    let all = scenario.participant.iter();
    let shipped = all.filter(|of| of.command.is_none());
    let names = shipped.map(|of| format!("participant.{}.config.", of.name));
    let names: Vec<String> = names.collect();
    let table: toml::Table = loaded.resolved.parse().unwrap_or_default();
    let mut seen = Vec::new();
    let found = leaves(&table).into_iter().filter_map(|(key, value)| {
        // The components of a list have their numbers as names.
        let is_name = |part: &&str| part.parse::<usize>().is_err();
        let own = key.rsplit('.').find(is_name)?;
        let quantity = QUANTITIES.iter().find(|of| of.keys.contains(&own))?;
        let is_own = names.iter().any(|name| key.starts_with(name)) || key.starts_with("run.");
        let number = number(value)?.abs();
        let (outside, [least, most]) = (quantity.outside(number), quantity.range);
        let finding = judge!(scenario.run.plausible => UNUSUAL_VALUE, outside;
            "{number:e} {} is outside the range of solids, {least:e} to {most:e} {}{}",
            quantity.unit, quantity.unit, quantity.meant(number))?;
        let is_new = is_own && number != 0.0 && !seen.contains(&own.to_string());
        seen.extend(is_new.then(|| own.to_string()));
        is_new.then(|| Warning::of(&key, finding))
    });
    found.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_unit_is_guessed() {
        let guess = |key: &str, number: f64| {
            let mut all = QUANTITIES.iter();
            let quantity = all.find(|of| of.keys.contains(&key)).expect("it is one");
            let guess = quantity.meant(number);
            let unit = guess
                .split(" meant")
                .next()
                .and_then(|text| text.rsplit(' ').next());
            (
                quantity.outside(number) > 1.0,
                unit.unwrap_or_default().to_string(),
            )
        };
        let cases = [
            ("young_pa", 70.0, "GPa"),
            ("young_pa", 210e3, "MPa"),
            ("yield_pa", 500.0, "MPa"),
            ("density_kg_per_m3", 7.8, "g/cm3"),
            ("density_kg_per_m3", 7.8e-9, "t/mm3"),
            ("width_m", 20.0, "mm"),
            ("vx_m_per_s", 1e4, "mm/s"),
            ("young_pa", 1e20, ""),
            ("cn_pa_per_m", 6.4e6, "GPa/m"),
            ("w_j_per_m2", 1e9, ""),
            ("b_pa_m_s", 1e12, ""),
        ];
        for (key, number, unit) in cases {
            assert_eq!(guess(key, number), (true, unit.into()), "{key} = {number}");
        }
        for (key, number) in [
            ("young_pa", 2.1e11),
            ("density_kg_per_m3", 7800.0),
            ("radius_m", 5e-5),
        ] {
            assert!(!guess(key, number).0, "{key} = {number}");
        }
    }
}
