//! The keys of a configuration as a JSON Schema (draft 2020-12), for editors.

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema};
use serde_json::{Map, Value};

/// The schema of a type, complete and without references, so that it can stand inside another schema. Descriptions are doc
/// comments.
pub fn schema_of<T: JsonSchema>() -> Value {
    let settings = SchemaSettings::draft2020_12().with(|settings| {
        settings.inline_subschemas = true;
        settings.meta_schema = None;
    });
    let generator = settings.into_generator();
    let mut schema = generator.into_root_schema_for::<T>().to_value();
    tidy(&mut schema);
    schema
}

/// The schema of a table in which one key decides the other keys: one of these schemas of tables, each with its word of
/// that key.
pub fn one_of_kinds<const N: usize>(key: &str, kinds: [(&str, Schema); N]) -> Schema {
    let tables = kinds.map(|(word, mut schema)| {
        let table = schema.ensure_object();
        let properties = table
            .entry("properties")
            .or_insert_with(|| Map::new().into());
        properties[key] = serde_json::json!({ "const": word });
        let required = table
            .entry("required")
            .or_insert_with(|| Value::Array(Vec::new()));
        if let Value::Array(required) = required {
            required.push(key.into());
        }
        schema.to_value()
    });
    schemars::json_schema!({ "oneOf": tables.to_vec() })
}

/// Removes null, which TOML does not have, Rust's own parts (formats of numbers, titles of types), and the brackets of links
/// between doc comments.
fn tidy(schema: &mut Value) {
    match schema {
        Value::Array(schemas) => schemas.iter_mut().for_each(tidy),
        Value::Object(schema) => tidy_object(schema),
        _ => {}
    }
}

fn tidy_object(schema: &mut Map<String, Value>) {
    only_choice(schema);
    if let Some(Value::Object(properties)) = schema.get_mut("properties") {
        properties.values_mut().for_each(tidy);
    }
    if let Some(Value::Array(types)) = schema.get_mut("type") {
        types.retain(|word| word != "null");
        if let [one] = &types[..] {
            let one = one.clone();
            schema.insert("type".into(), one);
        }
    }
    if let Some(Value::Array(words)) = schema.get_mut("enum") {
        words.retain(|word| !word.is_null());
    }
    if schema.get("default").is_some_and(Value::is_null) {
        schema.shift_remove("default");
    }
    for rust in ["format", "title"] {
        if schema.get(rust).is_some_and(Value::is_string) {
            schema.shift_remove(rust);
        }
    }
    if let Some(Value::String(text)) = schema.get_mut("description") {
        *text = text
            .replace("[`", "`")
            .replace("`]", "`")
            .replace('\n', " ");
    }
    for (key, value) in schema.iter_mut() {
        if !["properties", "default", "enum", "const", "required"].contains(&key.as_str()) {
            tidy(value);
        }
    }
}

/// Replaces a list of choices by its only choice other than null.
fn only_choice(schema: &mut Map<String, Value>) {
    let Some(Value::Array(choices)) = schema.get_mut("anyOf") else {
        return;
    };
    choices.retain(|choice| *choice != serde_json::json!({ "type": "null" }));
    let [Value::Object(one)] = &choices[..] else {
        return;
    };
    let one = one.clone();
    schema.shift_remove("anyOf");
    for (key, value) in one {
        schema.entry(key).or_insert(value);
    }
}
