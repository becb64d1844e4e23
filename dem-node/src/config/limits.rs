//! Limits of single values, and refusals that name the key, the value and a way out.

use protocol::ConfigError;

/// The key of a strip that repeats, in both kinds of sample.
pub(super) const PERIOD: &str = "sample.periodic_x_m";

/// Refuses a key for a reason, with a help.
pub(super) fn refuse<T>(
    key: &str,
    why: impl Into<String>,
    help: impl Into<String>,
) -> Result<T, ConfigError> {
    Err(ConfigError::new(key, why).help(help))
}

/// Refuses the first of these keys that is given.
pub(super) fn refuse_given(
    keys: impl IntoIterator<Item = (&'static str, bool)>,
    why: &str,
    help: &str,
) -> Result<(), ConfigError> {
    match keys.into_iter().find(|(_, given)| *given) {
        None => Ok(()),
        Some((key, _)) => refuse(key, why, help),
    }
}

pub(super) fn required(key: &str, value: Option<f64>, by: &str) -> Result<f64, ConfigError> {
    value.ok_or_else(|| ConfigError::new(key, format!("{by} need it and it is missing")))
}

pub(super) fn positive(key: &str, value: f64, unit: &str) -> Result<(), ConfigError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(ConfigError::new(
        key,
        format!("must be positive, got {value:e}{}", in_brackets(unit)),
    ))
}

pub(super) fn at_least(key: &str, value: f64, minimum: f64, unit: &str) -> Result<(), ConfigError> {
    if value >= minimum && value.is_finite() {
        return Ok(());
    }
    Err(ConfigError::new(
        key,
        format!(
            "must be at least {minimum:e}, got {value:e}{}",
            in_brackets(unit)
        ),
    ))
}

pub(super) fn within(key: &str, value: f64, low: f64, high: f64) -> Result<(), ConfigError> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(ConfigError::new(
        key,
        format!("must lie between {low} and {high}, got {value}"),
    ))
}

pub(super) fn finite(key: &str, value: f64) -> Result<(), ConfigError> {
    if value.is_finite() {
        return Ok(());
    }
    Err(ConfigError::new(
        key,
        format!("must be a finite number, got {value}"),
    ))
}

fn in_brackets(unit: &str) -> String {
    match unit {
        "" => String::new(),
        unit => format!(" ({unit})"),
    }
}
