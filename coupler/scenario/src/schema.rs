//! The keys of a scenario as a JSON Schema (draft 2020-12), for editors.

use kit::schema::schema_of;
use serde_json::{Map, Value, json};

use crate::keys::{Participant, RunKeys};
use scenes::listing::About;
use scheme::keys::Interface;

/// The schema for solvers of these kinds, with the schemas of their own keys if they have one.
pub fn schema(solvers: &[(&str, Option<Value>)]) -> Value {
    let described = solvers.iter();
    let described = described.filter_map(|(kind, keys)| Some((kind.to_string(), keys.clone()?)));
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Scenario of thirdbody",
        "type": "object",
        "properties": {
            "about": schema_of::<About>(),
            "run": schema_of::<RunKeys>(),
            "participant": {
                "description": "The solvers.",
                "type": "array",
                "minItems": 1,
                "items": participant(solvers),
            },
            "interface": {
                "description": "Interfaces that join them; a single participant without an interface runs alone.",
                "type": "array",
                "items": schema_of::<Interface>(),
            },
        },
        "required": ["run", "participant"],
        "additionalProperties": false,
        "$defs": described.collect::<Map<String, Value>>(),
    })
}

/// A participant. Without a command its kind is one of the built-in kinds and decides which keys it has. A foreign
/// program has any keys.
fn participant(solvers: &[(&str, Option<Value>)]) -> Value {
    let mut schema = schema_of::<Participant>();
    let described = solvers.iter().filter(|(_, keys)| keys.is_some());
    let described: Vec<&str> = described.map(|(kind, _)| *kind).collect();
    let kinds: Vec<&str> = solvers.iter().map(|(kind, _)| *kind).collect();
    let built_in = json!({
        "if": { "not": { "required": ["command"] } },
        "then": { "properties": { "kind": { "enum": kinds } } },
    });
    let by_kind = described.iter().map(|kind| {
        let of_kind = json!({ "kind": { "const": kind } });
        json!({
            "if": { "properties": of_kind, "not": { "required": ["command"] } },
            "then": { "properties": config_of(kind), "required": ["config"] },
        })
    });
    let rules: Vec<Value> = by_kind.chain([built_in]).collect();
    // Editors based on taplo validate by conditions, but propose keys only from lists of choices; the last choice
    // always holds.
    let proposed = described.iter();
    let proposed = proposed.map(|kind| json!({ "properties": config_of(kind) }));
    let proposed: Vec<Value> = proposed.chain([json!(true)]).collect();
    let table = schema.as_object_mut().expect("a participant is a table");
    table.insert("allOf".into(), rules.into());
    table.insert("anyOf".into(), proposed.into());
    schema
}

fn config_of(kind: &str) -> Value {
    json!({ "config": { "$ref": format!("#/$defs/{kind}") } })
}
