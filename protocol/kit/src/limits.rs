//! Limits that the schema does not hold, because they depend on other keys: each refusal names the key, the value and a way out.

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
pub fn positive(key: &str, value: f64, unit: &str) -> Result<(), ConfigError> {
    let must = || format!("be above 0, got {value:e} ({unit})");
    check(key, value > 0.0 && value.is_finite(), must)
        .map_err(|error| error.help(format!("write a number above 0, in {unit}")))
}

/// Refuses what is below a minimum that depends on other keys, or not finite.
pub fn at_least(
    key: &str,
    value: impl Into<Option<f64>>,
    minimum: f64,
    unit: &str,
) -> Result<(), ConfigError> {
    let value = value.into().unwrap_or(f64::MAX);
    let holds = value >= minimum - ROUNDING * minimum.abs() && value.is_finite();
    let must = || format!("be at least {minimum:e}, got {value:e} ({unit})");
    check(key, holds, must)
}

/// Refuses what is not finite.
pub fn finite(key: &str, value: f64) -> Result<(), ConfigError> {
    let must = || format!("be a finite number, got {value}");
    check(key, value.is_finite(), must)
}

/// Refuses two sides that are not in order.
pub fn validate_sides(key: &str, [low, high]: [f64; 2]) -> Result<(), ConfigError> {
    refuse_if(
        low >= high,
        key,
        format!("{low:e} does not lie before {high:e}"),
        "write [low, high]",
    )
    .map_err(|error| error.because(Cause::OutOfRange))
}

fn check(key: &str, holds: bool, must: impl FnOnce() -> String) -> Result<(), ConfigError> {
    if holds {
        return Ok(());
    }
    Err(ConfigError::new(key, format!("must {}", must())).because(Cause::OutOfRange))
}

/// A number that is not written with a row of zeros.
pub(crate) fn plain(value: f64) -> String {
    if value != 0.0 && !(1e-4..1e6).contains(&value.abs()) {
        format!("{value:e}")
    } else {
        value.to_string()
    }
}
