//! Limits of single values, and refusals that name the key, the value and a way out. A value that is absent passes.

use protocol::Cause;

use crate::keys::{ConfigError, refuse_if};

/// Part of a length by which one that was computed may miss the one that was meant: 3.5 x 0.1 is 0.35000000000000003.
pub const ROUNDING: f64 = 1e-9;

/// Refuses the first of these keys that is given.
pub fn refuse_given<'a>(
    keys: impl IntoIterator<Item = (&'a str, bool)>,
    why: &str,
    help: &str,
) -> Result<(), ConfigError> {
    let mut keys = keys.into_iter();
    keys.try_for_each(|(key, given)| refuse_if(given, key, why, help))
}

/// The value of a key that another one needs.
pub fn required(key: &str, value: Option<f64>, by: &str) -> Result<f64, ConfigError> {
    let missing = || ConfigError::new(key, format!("{by} need it and it is missing"));
    value.ok_or_else(|| missing().because(Cause::MissingKey))
}

/// Refuses what is no positive finite number.
pub fn positive(key: &str, value: impl Into<Option<f64>>, unit: &str) -> Result<(), ConfigError> {
    let holds = |value: f64| value > 0.0 && value.is_finite();
    let must = |value| format!("be positive, got {}", with_unit(value, unit));
    check(key, value.into(), holds, must).map_err(|error| match unit {
        "" => error.help("write a number above 0"),
        unit => error.help(format!("write a number above 0, in {unit}")),
    })
}

/// Refuses what is below a minimum, or not finite.
pub fn at_least(
    key: &str,
    value: impl Into<Option<f64>>,
    minimum: f64,
    unit: &str,
) -> Result<(), ConfigError> {
    let holds = |value: f64| value >= minimum - ROUNDING * minimum.abs() && value.is_finite();
    let must = |value| format!("be at least {minimum:e}, got {}", with_unit(value, unit));
    check(key, value.into(), holds, must)
}

/// Refuses what is negative or not finite.
pub fn not_negative(
    key: &str,
    value: impl Into<Option<f64>>,
    unit: &str,
) -> Result<(), ConfigError> {
    let holds = |value: f64| value >= 0.0 && value.is_finite();
    let must = |value| format!("be at least 0, got {}", with_unit(value, unit));
    check(key, value.into(), holds, must).map_err(|error| error.help("write 0 to have none"))
}

/// Refuses what does not lie between two ends, or on one of them.
pub fn within(
    key: &str,
    value: impl Into<Option<f64>>,
    [low, high]: [f64; 2],
) -> Result<(), ConfigError> {
    let must = |value| {
        format!(
            "lie between {} and {high}, got {}",
            plain(low),
            plain(value)
        )
    };
    check(key, value.into(), |x| (low..=high).contains(&x), must)
}

/// Refuses what is not finite.
pub fn finite(key: &str, value: f64) -> Result<(), ConfigError> {
    let must = |value| format!("be a finite number, got {value}");
    check(key, Some(value), f64::is_finite, must)
}

/// Refuses two sides that are no numbers or not in order.
pub fn validate_sides(key: &str, [low, high]: [f64; 2]) -> Result<(), ConfigError> {
    finite(key, low)?;
    finite(key, high)?;
    refuse_if(
        low >= high,
        key,
        format!("{low:e} does not lie before {high:e}"),
        "write [low, high]",
    )
    .map_err(|error| error.because(Cause::OutOfRange))
}

fn check(
    key: &str,
    value: Option<f64>,
    holds: impl Fn(f64) -> bool,
    must: impl Fn(f64) -> String,
) -> Result<(), ConfigError> {
    match value.filter(|value| !holds(*value)) {
        None => Ok(()),
        Some(value) => {
            let problem = format!("must {}", must(value));
            Err(ConfigError::new(key, problem).because(Cause::OutOfRange))
        }
    }
}

/// A number that is not written with a row of zeros.
fn plain(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-4 {
        format!("{value:e}")
    } else {
        value.to_string()
    }
}

fn with_unit(value: f64, unit: &str) -> String {
    match unit {
        "" => format!("{value:e}"),
        unit => format!("{value:e} ({unit})"),
    }
}
