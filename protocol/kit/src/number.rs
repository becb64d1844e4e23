//! A number, or a word in its place.

use serde::de::{Deserialize, Deserializer, Error, Unexpected};
use serde_json::Value;

/// 1, for keys that multiply or count when they are absent.
pub fn one<T: From<u8>>() -> T {
    1.into()
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

/// A number in whose place a word may stand: `number_or_word! { /// What it is. Name, "word", "what is expected" }`.
#[macro_export]
macro_rules! number_or_word {
    ($(#[$about:meta])+ $name:ident, $word:literal, $expected:literal) => {
        $(#[$about])+
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct $name(
            /// The number; `None` for the word.
            pub Option<f64>,
        );

        impl schemars::JsonSchema for $name {
            fn schema_name() -> std::borrow::Cow<'static, str> {
                stringify!($name).into()
            }

            fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
                schemars::json_schema!({ "anyOf": [{ "type": "number" }, { "const": $word }] })
            }
        }

        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
                $crate::number::number_or_word(from, $word, $expected).map($name)
            }
        }
    };
}

number_or_word! {
    /// A component of a prescribed motion, force or traction: a number, or `"free"` if the equations of motion decide.
    PrescribedComponent, "free", "a number or \"free\""
}
