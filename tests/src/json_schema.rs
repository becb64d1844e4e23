//! A validator for the part of JSON Schema (draft 2020-12) that `check --schema` uses. An unknown keyword is an error of the
//! schema, so no keyword is ignored silently.

use serde_json::{Map, Value};

/// Keywords that only describe, and keywords that are handled together with another one.
const PASSED: [&str; 8] = [
    "$schema",
    "$defs",
    "title",
    "description",
    "default",
    "then",
    "properties",
    "additionalProperties",
];

/// The places (JSON pointers) at which a value does not follow a schema; empty if it follows the schema.
///
/// # Panics
/// The schema has an unknown keyword, or a keyword with an invalid value.
pub fn faults(schema: &Value, value: &Value) -> Vec<String> {
    let mut visit = Visit {
        root: schema,
        found: Vec::new(),
    };
    visit.value(schema, value, "");
    visit.found
}

struct Visit<'a> {
    /// The schema that references begin at.
    root: &'a Value,
    found: Vec<String>,
}

impl<'a> Visit<'a> {
    fn value(&mut self, schema: &'a Value, value: &Value, place: &str) {
        let keywords = match schema {
            Value::Bool(true) => return,
            Value::Bool(false) => {
                return self.found.push(format!("{place}: nothing may stand here"));
            }
            schema => schema
                .as_object()
                .expect("a schema is a table or a truth value"),
        };
        for (keyword, argument) in keywords {
            if !self.holds(keyword, argument, keywords, value, place) {
                self.found.push(format!("{place}: {keyword} {argument}"));
            }
        }
        self.members(keywords, value, place);
    }

    fn holds(
        &mut self,
        keyword: &str,
        argument: &'a Value,
        keywords: &'a Map<String, Value>,
        value: &Value,
        place: &str,
    ) -> bool {
        match keyword {
            "allOf" => list(argument)
                .iter()
                .for_each(|schema| self.value(schema, value, place)),
            "$ref" => self.value(self.target(argument), value, place),
            "if" if self.passes(argument, value) => {
                self.value(&keywords["then"], value, place);
            }
            "items" => {
                for (index, item) in value.as_array().into_iter().flatten().enumerate() {
                    self.value(argument, item, &format!("{place}/{index}"));
                }
            }
            "not" => return !self.passes(argument, value),
            "oneOf" => return self.passing(argument, value) == 1,
            "anyOf" => return self.passing(argument, value) > 0,
            "if" => {}
            passed if PASSED.contains(&passed) => {}
            other => return alone(other, argument, value),
        }
        true
    }

    /// Members of a table, by `properties` and `additionalProperties`.
    fn members(&mut self, keywords: &'a Map<String, Value>, value: &Value, place: &str) {
        let properties = keywords.get("properties").and_then(Value::as_object);
        for (key, member) in value.as_object().into_iter().flatten() {
            let own = properties.and_then(|properties| properties.get(key));
            if let Some(schema) = own.or(keywords.get("additionalProperties")) {
                self.value(schema, member, &format!("{place}/{key}"));
            }
        }
    }

    fn target(&self, reference: &Value) -> &'a Value {
        let pointer = reference.as_str().and_then(|text| text.strip_prefix('#'));
        let target = pointer.and_then(|pointer| self.root.pointer(pointer));
        target.expect("a reference into the schema itself")
    }

    fn passing(&self, schemas: &'a Value, value: &Value) -> usize {
        let schemas = list(schemas).iter();
        schemas.filter(|schema| self.passes(schema, value)).count()
    }

    fn passes(&self, schema: &'a Value, value: &Value) -> bool {
        let mut other = Visit {
            root: self.root,
            found: Vec::new(),
        };
        other.value(schema, value, "");
        other.found.is_empty()
    }
}

/// A keyword that needs only its argument.
fn alone(keyword: &str, argument: &Value, value: &Value) -> bool {
    let count = || value.as_array().map(|items| items.len() as f64);
    match keyword {
        "type" => is_of_type(argument, value),
        "const" => same(argument, value),
        "enum" => list(argument).iter().any(|word| same(word, value)),
        "required" => {
            let has = |key: &Value| value.get(key.as_str().expect("a key")).is_some();
            !value.is_object() || list(argument).iter().all(has)
        }
        "minItems" => count().is_none_or(|count| count >= number(argument)),
        "maxItems" => count().is_none_or(|count| count <= number(argument)),
        "minimum" => value.as_f64().is_none_or(|value| value >= number(argument)),
        "maximum" => value.as_f64().is_none_or(|value| value <= number(argument)),
        "exclusiveMinimum" => value.as_f64().is_none_or(|value| value > number(argument)),
        "exclusiveMaximum" => value.as_f64().is_none_or(|value| value < number(argument)),
        other => panic!("the validator does not know the keyword `{other}`"),
    }
}

/// The type of a value. A float with a fraction of zero is not an integer: TOML distinguishes the two.
fn is_of_type(word: &Value, value: &Value) -> bool {
    match word.as_str().expect("a type") {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "number" => value.is_number(),
        "integer" => value.is_i64() || value.is_u64(),
        other => panic!("no type is called `{other}`"),
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
