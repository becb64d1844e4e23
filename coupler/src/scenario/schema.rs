//! The keys of a scenario as a JSON Schema (draft 2020-12), for editors.

use protocol::schema::schema_of;
use serde_json::{Map, Value, json};

use super::interface::InterfaceKeys;
use super::{Participant, Run};

/// The schema, for solvers of these kinds with the schemas of their own keys where they have one.
pub fn schema(solvers: &[(&str, Option<Value>)]) -> Value {
    let shipped = solvers
        .iter()
        .map(|(kind, keys)| shipped(kind, keys.as_ref()));
    let participants: Vec<Value> = shipped.chain([foreign()]).collect();
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Scenario of thirdbody",
        "type": "object",
        "properties": {
            "run": schema_of::<Run>(),
            "participant": {
                "description": "The solvers.",
                "type": "array",
                "minItems": 1,
                "items": { "oneOf": participants },
            },
            "interface": {
                "description": "Joints between them; without any, the one participant runs alone.",
                "type": "array",
                "items": schema_of::<InterfaceKeys>(),
            },
        },
        "required": ["run", "participant"],
        "additionalProperties": false,
    })
}

/// A participant that the program serves itself: its kind decides which keys it has.
fn shipped(kind: &str, keys: Option<&Value>) -> Value {
    let mut schema = schema_of::<Participant>();
    let properties = properties(&mut schema);
    properties.shift_remove("command");
    properties["kind"] = json!({ "description": "Kind of the solver.", "const": kind });
    if let Some(keys) = keys {
        properties["config"] = keys.clone();
        require(&mut schema, "config");
    }
    schema
}

/// A program of another make: its kind and keys are its own.
fn foreign() -> Value {
    let mut schema = schema_of::<Participant>();
    require(&mut schema, "command");
    schema
}

fn properties(schema: &mut Value) -> &mut Map<String, Value> {
    let properties = schema.get_mut("properties").and_then(Value::as_object_mut);
    properties.expect("a participant is a table")
}

fn require(schema: &mut Value, key: &str) {
    let required = schema.get_mut("required").and_then(Value::as_array_mut);
    required
        .expect("name and kind are required")
        .push(key.into());
}
