//! A number, or a word in its place.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserialize, Deserializer, Error, Unexpected};
use serde_json::Value;

/// The schema of the values that [`number_or_word`] reads.
pub fn number_or_word_schema(word: &str) -> Schema {
    json_schema!({ "anyOf": [{ "type": "number" }, { "const": word }] })
}

/// Reads a number, or `None` for this word. By hand, because serde's message for an untagged enum does not say what to
/// write; `expected` does.
pub fn number_or_word<'de, D: Deserializer<'de>>(
    deserializer: D,
    word: &str,
    expected: &str,
) -> Result<Option<f64>, D::Error> {
    let value = Value::deserialize(deserializer)?;
    let got = match &value {
        Value::Number(number) => return Ok(number.as_f64()),
        Value::String(text) if text == word => return Ok(None),
        Value::String(text) => {
            return Err(D::Error::invalid_value(Unexpected::Str(text), &expected));
        }
        Value::Bool(truth) => Unexpected::Bool(*truth),
        Value::Array(_) => Unexpected::Seq,
        Value::Object(_) => Unexpected::Map,
        Value::Null => Unexpected::Unit,
    };
    Err(D::Error::invalid_type(got, &expected))
}

/// A component of a prescribed motion, force or traction: a number, or `"free"`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrescribedComponent(
    /// The prescribed number; `None` if the equations of motion decide.
    pub Option<f64>,
);

impl JsonSchema for PrescribedComponent {
    fn schema_name() -> Cow<'static, str> {
        "PrescribedComponent".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        number_or_word_schema("free")
    }
}

impl<'de> Deserialize<'de> for PrescribedComponent {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        number_or_word(deserializer, "free", "a number or \"free\"").map(PrescribedComponent)
    }
}
