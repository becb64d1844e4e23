//! The ranges of numbers and the lengths of lists in the schema of a type.

use std::any::TypeId;
use std::borrow::Borrow;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use protocol::Cause;
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::keys::{ConfigError, read_table};
use crate::limits::{ROUNDING, plain};
use crate::schema::schema_of;

/// Reads the configuration of a participant into its type, and refuses values that its schema excludes.
///
/// # Errors
/// As [`read_table`] and [`check`].
pub fn read_config<T: DeserializeOwned + JsonSchema + 'static>(
    config: impl Borrow<Value>,
) -> Result<T, ConfigError> {
    /// One schema per type: generating it takes milliseconds.
    static SCHEMAS: Mutex<BTreeMap<TypeId, Arc<Value>>> = Mutex::new(BTreeMap::new());
    let config = config.borrow();
    let read = read_table(config)?;
    let mut schemas = SCHEMAS.lock().unwrap_or_else(PoisonError::into_inner);
    let schema = schemas.entry(TypeId::of::<T>());
    let schema = schema.or_insert_with(|| schema_of::<T>().into()).clone();
    drop(schemas);
    check(&schema, config)?;
    Ok(read)
}

/// Refuses the first number outside the schema's range for its key, and the first list that is too short. The table has already been
/// read into its type, which refuses wrong types and unknown keys. The schema has no references: [`schema_of`] makes it so.
///
/// # Errors
/// Names the key, its value, its range, and what the key means.
pub fn check(schema: &Value, value: &Value) -> Result<(), ConfigError> {
    // Keys of any type, such as a foreign participant's, have no ranges.
    if !schema.is_object() {
        return Ok(());
    }
    let forms = ["oneOf", "anyOf"].map(|forms| schema[forms].as_array());
    let mut forms = forms.into_iter().flatten().flatten();
    if let Some(form) = forms.find(|form| fits(form, value)) {
        check(form, value)?;
    }
    match value {
        Value::Number(number) => check_number(schema, number.as_f64().unwrap_or(f64::MAX)),
        Value::Array(entries) => check_entries(schema, entries),
        Value::Object(table) => table.iter().try_for_each(|(key, value)| {
            let known = schema["properties"].get(key);
            let known = known.unwrap_or(&schema["additionalProperties"]);
            check(known, value).map_err(|error| below(key, meaning(known, error)))
        }),
        _ => Ok(()),
    }
}

/// True if a form knows all keys of this table. A value that is no table fits any form but another word.
fn fits(form: &Value, value: &Value) -> bool {
    let is = |form: &Value, value| form.get("const").is_none_or(|word| word == value);
    let knows = |key: &String, value| {
        let known = form["properties"].get(key);
        known.is_some_and(|known| is(known, value))
    };
    let mut keys = value.as_object().into_iter().flatten();
    is(form, value) && keys.all(|(key, value)| knows(key, value))
}

fn check_entries(schema: &Value, entries: &[Value]) -> Result<(), ConfigError> {
    let least = schema["minItems"].as_u64().unwrap_or(0) as usize;
    if entries.len() < least {
        return Err(refused(format!(
            "must have a length of at least {least}, got {}",
            entries.len()
        )));
    }
    let mut entries = entries.iter().enumerate();
    entries.try_for_each(|(index, entry)| {
        check(&schema["items"], entry).map_err(|error| below(&format!("[{index}]"), error))
    })
}

fn check_number(schema: &Value, value: f64) -> Result<(), ConfigError> {
    let bound = |word: &str| schema[word].as_f64();
    // Arithmetic may round a value at a lower bound, 3 x 0.1 / 0.3; the ends of a range are exact.
    let exact = bound("maximum").is_some();
    let rounding = if exact { 0.0 } else { ROUNDING };
    let holds = |word: &str, bound: f64| match word {
        "at least" => value >= bound - rounding * bound.abs(),
        "above" => value > bound,
        "at most" => value <= bound,
        _ => value < bound,
    };
    let bounds = [
        ("at least", bound("minimum")),
        ("above", bound("exclusiveMinimum")),
        ("at most", bound("maximum")),
        ("below", bound("exclusiveMaximum")),
    ];
    let given = || {
        bounds
            .iter()
            .filter_map(|(word, bound)| Some((*word, (*bound)?)))
    };
    if given().all(|(word, bound)| holds(word, bound)) {
        return Ok(());
    }
    let range = given().map(|(word, bound)| format!("{word} {}", plain(bound)));
    let range = Vec::from_iter(range).join(" and ");
    Err(refused(format!("must be {range}, got {}", plain(value))))
}

fn refused(problem: String) -> ConfigError {
    ConfigError::new("", problem).because(Cause::OutOfRange)
}

/// The error with the key of its table or list, `parent`, in front of its own.
fn below(parent: &str, error: ConfigError) -> ConfigError {
    let is_key = !error.key.is_empty() && !error.key.starts_with('[');
    let dot = if is_key { "." } else { "" };
    let key = format!("{parent}{dot}{}", error.key);
    ConfigError { key, ..error }
}

/// The error with the first sentence of the key's description, which states the unit, as its help.
fn meaning(schema: &Value, error: ConfigError) -> ConfigError {
    let text = schema["description"]
        .as_str()
        .filter(|_| error.help.is_none());
    let Some(text) = text else {
        return error;
    };
    let sentence = text.split(". ").next().unwrap_or_default();
    error.help(format!("the key means: {}", sentence.trim_end_matches('.')))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;
    use serde_json::json;

    #[derive(Debug, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code)]
    struct Body {
        /// Density (kg/m3). It is never scaled.
        #[schemars(extend("exclusiveMinimum" = 0))]
        density_kg_per_m3: f64,
        /// Share.
        #[schemars(extend("exclusiveMinimum" = 0), range(max = 1.0))]
        share: Option<f64>,
        #[schemars(range(min = 0.5, max = 1.0))]
        theta: Option<f64>,
        #[schemars(range(min = 1.0))]
        mass_scale: Option<f64>,
        /// Pressures (Pa).
        #[serde(default)]
        #[schemars(length(min = 1), inner(range(min = 0.5)))]
        press_pa: Option<Vec<f64>>,
        #[serde(default)]
        sets: BTreeMap<String, Set>,
        #[serde(default)]
        parts: Vec<Form>,
    }

    #[derive(Debug, Deserialize, JsonSchema)]
    #[allow(dead_code)]
    struct Set {
        /// Ramp (s).
        #[schemars(range(min = 0.0))]
        ramp_s: f64,
    }

    #[derive(Debug, Deserialize, JsonSchema)]
    #[serde(tag = "kind", rename_all = "snake_case")]
    #[allow(dead_code)]
    enum Form {
        Disk {
            #[schemars(range(min = 1))]
            count: u32,
        },
        Block {
            #[schemars(range(max = 6))]
            count: u32,
        },
    }

    fn read(change: Value) -> Result<Body, ConfigError> {
        let mut config = json!({"density_kg_per_m3": 1.0});
        for (key, value) in change.as_object().expect("a table") {
            config[key] = value.clone();
        }
        read_config(config)
    }

    #[test]
    fn a_value_out_of_its_range_is_refused_by_its_key() {
        for (change, text) in [
            (
                json!({"density_kg_per_m3": -1.0}),
                "density_kg_per_m3: must be above 0, got -1; the key means: Density (kg/m3)",
            ),
            (
                json!({"share": 0}),
                "share: must be above 0 and at most 1, got 0; the key means: Share",
            ),
            (
                json!({"theta": 0.4999999999}),
                "theta: must be at least 0.5 and at most 1, got 0.4999999999",
            ),
            (
                json!({"mass_scale": 0.5}),
                "mass_scale: must be at least 1, got 0.5",
            ),
            (
                json!({"press_pa": [1.0, 0.0]}),
                "press_pa[1]: must be at least 0.5, got 0; the key means: Pressures (Pa)",
            ),
            (
                json!({"press_pa": []}),
                "press_pa: must have a length of at least 1, got 0; the key means: Pressures (Pa)",
            ),
            (
                json!({"sets": {"top": {"ramp_s": -2e-6}}}),
                "sets.top.ramp_s: must be at least 0, got -2e-6; the key means: Ramp (s)",
            ),
            (
                json!({"parts": [{"kind": "block", "count": 0}, {"kind": "disk", "count": 0}]}),
                "parts[1].count: must be at least 1, got 0",
            ),
            (
                json!({"parts": [{"kind": "block", "count": 7}]}),
                "parts[0].count: must be at least 0 and at most 6, got 7",
            ),
        ] {
            let error = read(change).expect_err("it is out of range");
            assert_eq!(
                (error.to_string(), error.cause),
                (text.into(), Cause::OutOfRange)
            );
        }
    }

    #[test]
    fn ends_of_ranges_and_absent_keys_pass() {
        for change in [
            json!({}),
            json!({"share": 1.0, "theta": 0.5, "press_pa": [0.5]}),
            json!({"mass_scale": 1.0 - 1e-10, "sets": {"top": {"ramp_s": 0}}}),
        ] {
            read(change).expect("it is within its range");
        }
    }
}
