//! Numbers for readers: four digits, the unit from a name, prefixes.

/// Units by the endings of names, longer endings first.
const UNITS: [(&str, &str); 23] = [
    ("_kg_m_per_s", "kg m/s"),
    ("_pa_per_m", "Pa/m"),
    ("_j_per_m2", "J/m²"),
    ("_kg_per_m", "kg/m"),
    ("_n_per_m", "N/m"),
    ("_rad_per_s", "rad/s"),
    ("_m2_per_s2", "m²/s²"),
    ("_m_per_s2", "m/s²"),
    ("_m_per_s", "m/s"),
    ("_per_s", "1/s"),
    ("_kg_m2", "kg m²"),
    ("_bytes", "B"),
    ("_pct", "%"),
    ("_deg", "°"),
    ("_hz", "Hz"),
    ("_pa", "Pa"),
    ("_kg", "kg"),
    ("_rel", ""),
    ("_share", ""),
    ("_j", "J"),
    ("_n", "N"),
    ("_m", "m"),
    ("_s", "s"),
];

/// Units that take no prefix.
const PLAIN: [&str; 4] = ["", "%", "°", "kg m²"];

/// Prefixes from 10^-15 on.
const PREFIXES: [&str; 10] = ["f", "p", "n", "µ", "m", "", "k", "M", "G", "T"];
/// Index of the empty prefix.
const NONE: i32 = 5;

/// Unit from the ending of a name; empty for a dimensionless number.
pub fn unit(name: &str) -> &'static str {
    let found = UNITS.iter().find(|(ending, _)| name.ends_with(ending));
    found.map_or("", |(_, unit)| unit)
}

/// A value with the unit from its name: `92.87 µm`, `0.1933`, `188`.
pub fn with_unit_of(name: &str, value: f64) -> String {
    with_unit(value, unit(name))
}

/// A value with a unit (SI, without prefix): four digits, and the prefix that leaves one to three digits before the point.
pub fn with_unit(value: f64, unit: &str) -> String {
    if !value.is_finite() {
        return "not a number".into();
    }
    if value == 0.0 && !PLAIN.contains(&unit) {
        return format!("0 {unit}");
    }
    let (factor, shown) = prefixed(value, unit);
    let space = ["", " "][usize::from(!["", "°"].contains(&unit))];
    format!("{}{space}{shown}", four(value * factor))
}

/// The unit with the prefix that leaves one to three digits of this value before the point, after the factor from SI to that unit.
pub fn prefixed(value: f64, unit: &str) -> (f64, String) {
    if PLAIN.contains(&unit) || !value.is_finite() || value == 0.0 {
        return (1.0, unit.into());
    }
    // A kilogram already has a prefix.
    let (grams, unit) = match unit.strip_prefix("kg") {
        Some(rest) => (1e3, format!("g{rest}")),
        None => (1.0, unit.to_string()),
    };
    let value = grams * value;
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    let thousands = (rounded.abs().log10() / 3.0).floor() as i32;
    let thousands = thousands.clamp(-NONE, PREFIXES.len() as i32 - 1 - NONE);
    let prefix = PREFIXES[(thousands + NONE) as usize];
    let factor = grams * 10f64.powi(-3 * thousands);
    (factor, format!("{prefix}{unit}"))
}

/// Words with a unit in brackets, with a prefix for numbers of this size, after the factor from SI to it: `load (kN)`.
pub fn axis_words(words: &str, unit: &str, size: f64) -> (f64, String) {
    let (factor, unit) = prefixed(size, unit);
    if unit.is_empty() {
        return (factor, words.into());
    }
    (factor, format!("{words} ({unit})"))
}

/// Four significant digits; a whole number below 10^9 with all its digits, in groups of three.
pub fn four(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if value.fract() == 0.0 && value.abs() < 1e9 && value.abs() >= 1.0 {
        return grouped(value as i64);
    }
    let size = value.abs().log10().floor() as i32;
    if !(-4..=5).contains(&size) {
        return format!("{value:.3e}");
    }
    let decimals = (3 - size).max(0) as usize;
    let text = format!("{value:.decimals$}");
    if !text.contains('.') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').into()
}

/// A whole number with its digits in groups of three.
fn grouped(value: i64) -> String {
    let digits = value.unsigned_abs().to_string();
    let mut text = String::new();
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    if value < 0 { format!("-{text}") } else { text }
}

/// A name without its unit, in words.
pub fn words(name: &str) -> String {
    let endings = UNITS.iter().filter(|(_, unit)| !unit.is_empty());
    let mut endings = endings.filter_map(|(ending, _)| name.strip_suffix(ending));
    endings.next().unwrap_or(name).replace('_', " ")
}

/// A span of time in the unit that fits: `3.2 s`, `4 min 10 s`, `1 h 5 min`.
pub fn span(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match whole {
        0..100 => with_unit(seconds, "s"),
        100..3600 => format!("{} min {} s", whole / 60, whole % 60),
        _ => format!("{} h {} min", whole / 3600, whole % 3600 / 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits_and_the_unit_from_their_name() {
        let all = [
            ("approach_m", 0.000092867740966822, "92.87 µm"),
            ("traction_ratio_mean", 0.1933409417376614, "0.1933"),
            ("p_max_centroid_pa", 771024622.666381, "771 MPa"),
            ("p0_pa", 1.0533041e9, "1.053 GPa"),
            ("load_n", 8000.0, "8 kN"),
            ("loop_area_j", 0.09049096, "90.49 mJ"),
            ("q_wear_kg", 4.1234e-9, "4.123 µg"),
            ("q_wear_kg", 0.0, "0 kg"),
            ("third_body_per_length_kg_per_m", 2.5e-3, "2.5 g/m"),
            ("energy_balance_rel", 5.906349345575321e-7, "5.906e-7"),
            ("disks", 73823.0, "73\u{202f}823"),
            ("sn_reversal_pct", 2.1360398860399368, "2.136 %"),
            ("fabric_direction_deg", -72.28162326333104, "-72.28°"),
            ("wheel_y_range_over_r", 0.027203926183571984, "0.0272"),
            ("gap_m", 9.9999e-4, "1 mm"),
            ("approach_m", f64::NAN, "not a number"),
        ];
        for (name, value, expected) in all {
            assert_eq!(with_unit_of(name, value), expected, "{name}");
        }
        assert_eq!(words("p_max_centroid_pa"), "p max centroid");
        assert_eq!(words("energy_balance_rel"), "energy balance rel");
        assert_eq!(axis_words("load", "N", 1e4), (1e-3, "load (kN)".into()));
        assert_eq!(axis_words("friction", "", 0.3), (1.0, "friction".into()));
        let spans = [2.65, 250.0, 3900.0].map(span);
        assert_eq!(spans, ["2.65 s", "4 min 10 s", "1 h 5 min"]);
    }
}
