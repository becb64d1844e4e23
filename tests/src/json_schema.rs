//! A validator for the part of JSON Schema (draft 2020-12) that `check --schema` uses. A keyword that it does not know is
//! an error of the schema, so that none is passed over in silence.

use serde_json::{Map, Value};

/// Keywords that only describe.
const WORDS: [&str; 4] = ["$schema", "title", "description", "default"];

/// The places (JSON pointers) at which a value does not follow a schema; none if it does.
///
/// # Panics
/// The schema has a keyword that this validator does not know, or one with a value that means nothing.
pub fn faults(schema: &Value, value: &Value) -> Vec<String> {
    let mut found = Vec::new();
    visit(schema, value, "", &mut found);
    found
}

fn visit(schema: &Value, value: &Value, place: &str, found: &mut Vec<String>) {
    let keywords = match schema {
        Value::Bool(true) => return,
        Value::Bool(false) => return found.push(format!("{place}: nothing may stand here")),
        schema => schema
            .as_object()
            .expect("a schema is a table or a truth value"),
    };
    for (keyword, argument) in keywords {
        let holds = match keyword.as_str() {
            word if WORDS.contains(&word) => true,
            "type" => is_of_type(argument, value),
            "const" => same(argument, value),
            "enum" => list(argument).iter().any(|word| same(word, value)),
            "required" => {
                let has = |key: &Value| value.get(key.as_str().expect("a key")).is_some();
                !value.is_object() || list(argument).iter().all(has)
            }
            "oneOf" => passing(argument, value) == 1,
            "anyOf" => passing(argument, value) > 0,
            "minItems" => value
                .as_array()
                .is_none_or(|items| items.len() as f64 >= number(argument)),
            "maxItems" => value
                .as_array()
                .is_none_or(|items| items.len() as f64 <= number(argument)),
            "minimum" => value.as_f64().is_none_or(|value| value >= number(argument)),
            "maximum" => value.as_f64().is_none_or(|value| value <= number(argument)),
            "exclusiveMinimum" => value.as_f64().is_none_or(|value| value > number(argument)),
            "exclusiveMaximum" => value.as_f64().is_none_or(|value| value < number(argument)),
            "items" => {
                for (index, item) in value.as_array().into_iter().flatten().enumerate() {
                    visit(argument, item, &format!("{place}/{index}"), found);
                }
                true
            }
            "properties" | "additionalProperties" => true,
            other => panic!("{place}: the validator does not know the keyword `{other}`"),
        };
        if !holds {
            found.push(format!("{place}: {keyword} {argument}"));
        }
    }
    visit_members(keywords, value, place, found);
}

/// Members of a table, by `properties` and `additionalProperties`.
fn visit_members(
    keywords: &Map<String, Value>,
    value: &Value,
    place: &str,
    found: &mut Vec<String>,
) {
    let properties = keywords.get("properties").and_then(Value::as_object);
    for (key, member) in value.as_object().into_iter().flatten() {
        let own = properties.and_then(|properties| properties.get(key));
        if let Some(schema) = own.or(keywords.get("additionalProperties")) {
            visit(schema, member, &format!("{place}/{key}"), found);
        }
    }
}

fn passing(schemas: &Value, value: &Value) -> usize {
    let passes = |schema: &&Value| faults(schema, value).is_empty();
    list(schemas).iter().filter(passes).count()
}

fn is_of_type(words: &Value, value: &Value) -> bool {
    let is = |word: &str| match word {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "number" => value.is_number(),
        "integer" => value.is_i64() || value.is_u64(),
        other => panic!("no type is called `{other}`"),
    };
    match words {
        Value::String(word) => is(word),
        words => list(words)
            .iter()
            .any(|word| is(word.as_str().expect("a type"))),
    }
}

/// Numbers are the same by value: 1 is 1.0.
fn same(a: &Value, b: &Value) -> bool {
    a == b || a.as_f64().is_some() && a.as_f64() == b.as_f64()
}

fn list(value: &Value) -> &[Value] {
    value.as_array().expect("the keyword takes a list")
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("the keyword takes a number")
}
