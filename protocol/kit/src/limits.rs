//! Limits that are not in the schema because they depend on other keys. Each refusal names the key, the value and a remedy.

use protocol::Cause;

use crate::keys::{ConfigError, refuse_if};

/// Relative error of a computed length: 3.5 x 0.1 is 0.35000000000000003.
pub const ROUNDING: f64 = 1e-9;

/// Refuses the first given key of these.
pub fn refuse_given<'a>(
    keys: impl IntoIterator<Item = (&'a str, bool)>,
    why: &str,
    help: &str,
) -> Result<(), ConfigError> {
    let mut keys = keys.into_iter();
    keys.try_for_each(|(key, given)| refuse_if(given, key, why, help))
}

/// The value of a key that another key needs.
pub fn required(key: &str, value: Option<f64>, by: &str) -> Result<f64, ConfigError> {
    let missing = || ConfigError::new(key, format!("{by} need it and it is missing"));
    value.ok_or_else(|| missing().because(Cause::MissingKey))
}

/// Refuses a value that is not positive and finite.
pub fn positive(key: &str, value: f64, unit: &str) -> Result<(), ConfigError> {
    let must = || format!("be above 0, got {value:e} ({unit})");
    check(key, value > 0.0 && value.is_finite(), must)
        .map_err(|error| error.help(format!("write a number above 0, in {unit}")))
}

/// Refuses a value that is not finite or lies below a minimum that depends on other keys.
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

/// Refuses a value that is not finite.
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

/// A number in text, with an exponent instead of a row of zeros.
pub(crate) fn plain(value: f64) -> String {
    if value != 0.0 && !(1e-4..1e6).contains(&value.abs()) {
        format!("{value:e}")
    } else {
        value.to_string()
    }
}
