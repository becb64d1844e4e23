//! Numbers: their ranges, and a number or a word in its place.

use std::fmt;

use kit::ConfigError;
use protocol::Cause;
use schemars::{Schema, json_schema};
use serde::de::{self, Deserializer, Visitor};

/// Refuses what is given and not a positive finite number.
pub(crate) fn positive(
    key: &str,
    value: impl Into<Option<f64>>,
    unit: &str,
) -> Result<(), ConfigError> {
    let wrong = |value: &f64| *value <= 0.0 || !value.is_finite();
    let Some(value) = value.into().filter(wrong) else {
        return Ok(());
    };
    let problem = format!("must be positive and finite, got {value:?} ({unit})");
    Err(ConfigError::new(key, problem)
        .because(Cause::OutOfRange)
        .help(format!("write a number above 0, in {unit}")))
}

/// Refuses what is given and negative or not finite.
pub(super) fn not_negative(
    key: &str,
    value: impl Into<Option<f64>>,
    unit: &str,
) -> Result<(), ConfigError> {
    let wrong = |value: &f64| *value < 0.0 || !value.is_finite();
    let Some(value) = value.into().filter(wrong) else {
        return Ok(());
    };
    let problem = format!("must be finite and not negative, got {value:?} ({unit})");
    Err(ConfigError::new(key, problem)
        .because(Cause::OutOfRange)
        .help("leave the key out to have none"))
}

/// The schema of what [`number_or_word`] reads.
pub(super) fn number_or_word_schema(word: &str) -> Schema {
    json_schema!({ "anyOf": [{ "type": "number" }, { "const": word }] })
}

/// Reads a number, or this word for none. By hand, because serde's message for an untagged enum does not say what would
/// be right; `expected` does.
pub(super) fn number_or_word<'de, D: Deserializer<'de>>(
    deserializer: D,
    word: &'static str,
    expected: &'static str,
) -> Result<Option<f64>, D::Error> {
    deserializer.deserialize_any(NumberOrWord { word, expected })
}

struct NumberOrWord {
    word: &'static str,
    expected: &'static str,
}

impl Visitor<'_> for NumberOrWord {
    type Value = Option<f64>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.expected)
    }

    fn visit_f64<E: de::Error>(self, value: f64) -> Result<Option<f64>, E> {
        Ok(Some(value))
    }

    fn visit_i64<E: de::Error>(self, value: i64) -> Result<Option<f64>, E> {
        Ok(Some(value as f64))
    }

    fn visit_u64<E: de::Error>(self, value: u64) -> Result<Option<f64>, E> {
        Ok(Some(value as f64))
    }

    fn visit_str<E: de::Error>(self, value: &str) -> Result<Option<f64>, E> {
        if value == self.word {
            return Ok(None);
        }
        Err(E::invalid_value(de::Unexpected::Str(value), &self))
    }
}
