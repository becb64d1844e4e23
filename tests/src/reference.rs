//! Tables of the book's reference that are written from the schema of a scenario and from the command line.

use clap::{Arg, Command};
use serde_json::Value;

/// The keys of a part of a scenario: `run`, `participant`, `interface`, or the `config` of a `fem` or `dem` participant.
pub fn keys(part: &str) -> String {
    let solvers = [
        ("fem", Some(fem_node::schema())),
        ("dem", Some(dem_node::schema())),
    ];
    let schema = scenario::schema::schema(&solvers);
    let object = match part {
        "fem" | "dem" => &schema["$defs"][part],
        other => &schema["properties"][other],
    };
    let mut rows = Vec::new();
    below(object, "", &mut rows);
    // A key of several kinds of a table stands once.
    rows.dedup();
    let head = "| key | value | when absent | meaning |\n|---|---|---|---|\n";
    head.to_string() + &rows.concat()
}

/// Rows of the keys below an object, of each entry of a list, and of each kind of a table.
fn below(object: &Value, path: &str, rows: &mut Vec<String>) {
    for kind in object["oneOf"].as_array().into_iter().flatten() {
        below(kind, path, rows);
    }
    if object["items"].is_object() {
        return below(&object["items"], path, rows);
    }
    let required = object["required"].as_array();
    for (name, value) in object["properties"].as_object().into_iter().flatten() {
        let key = match path {
            "" => name.clone(),
            path => format!("{path}.{name}"),
        };
        let needed = required.is_some_and(|names| names.iter().any(|one| one == name));
        let absent = match (&value["default"], needed) {
            (Value::Null, true) => "refused".into(),
            (Value::Null, false) => String::new(),
            (default, _) => format!("`{}`", default.to_string().replace('|', "\\|")),
        };
        let row = format!(
            "| `{key}` | {} | {absent} | {} |\n",
            kind_of(value),
            meaning(value)
        );
        if !rows.contains(&row) {
            rows.push(row);
        }
        below(value, &key, rows);
    }
}

/// The sentence of a key, and those of its words.
fn meaning(value: &Value) -> String {
    let sentence = |of: &Value| {
        of["description"]
            .as_str()
            .unwrap_or_default()
            .replace('\n', " ")
    };
    let words = value["oneOf"].as_array().into_iter().flatten();
    let words = words.filter_map(|word| {
        Some(format!(
            " `{}`: {}",
            word["const"].as_str()?,
            sentence(word)
        ))
    });
    (sentence(value) + &words.collect::<String>()).replace('|', "\\|")
}

/// Type and range of a value, in words.
fn kind_of(value: &Value) -> String {
    let number = |key: &str| {
        value[key].as_f64().map(|x| {
            if x != 0.0 && !(1e-3..1e6).contains(&x.abs()) {
                format!("{x:e}")
            } else {
                x.to_string()
            }
        })
    };
    let name = match value["type"].as_str() {
        Some("number") => "number",
        Some("integer") => "whole number",
        Some("boolean") => "true or false",
        Some("string") => "text",
        Some("array") => "list",
        Some("object") => "table",
        _ if value["oneOf"][0]["const"].is_string() => "word",
        _ => "one of several",
    };
    let bounds = [
        ("minimum", "from"),
        ("exclusiveMinimum", "above"),
        ("maximum", "to"),
        ("exclusiveMaximum", "below"),
    ];
    let bounds =
        bounds.map(|(key, word)| number(key).map_or(String::new(), |x| format!(" {word} {x}")));
    name.to_string() + &bounds.concat()
}

/// The verbs of the command with their arguments.
pub fn verbs(command: &Command) -> String {
    let of = |verb: &Command, name: String| {
        let about = verb
            .get_about()
            .map(ToString::to_string)
            .unwrap_or_default();
        let arguments = verb
            .get_arguments()
            .filter(|argument| !argument.is_hide_set());
        let rows: String = arguments
            .filter(|argument| !["help", "version"].contains(&argument.get_id().as_str()))
            .map(argument)
            .collect();
        let table = if rows.is_empty() {
            rows
        } else {
            format!("\n| argument | meaning |\n|---|---|\n{rows}")
        };
        format!("\n## `{name}`\n\n{about}.\n{table}")
    };
    let mut text = of(command, "thirdbody".into());
    for verb in command.get_subcommands().filter(|verb| !verb.is_hide_set()) {
        let name = format!("thirdbody {}", verb.get_name());
        text += &of(verb, name.clone());
        for inner in verb.get_subcommands().filter(|inner| !inner.is_hide_set()) {
            text += &of(inner, format!("{name} {}", inner.get_name()));
        }
    }
    text + "\n"
}

/// The row of an argument: its form, and its help with its words.
fn argument(argument: &Arg) -> String {
    let value = argument.get_value_names().map(|names| {
        names
            .iter()
            .map(|name| name.as_str())
            .collect::<Vec<_>>()
            .join(" ")
    });
    let takes = argument.get_action().takes_values();
    let form = match (argument.get_long(), value.filter(|_| takes)) {
        (Some(long), Some(value)) => format!("--{long} {value}"),
        (Some(long), None) => format!("--{long}"),
        (None, value) => value.unwrap_or_default(),
    };
    let help = argument
        .get_help()
        .map(ToString::to_string)
        .unwrap_or_default();
    let words = argument.get_possible_values();
    let words: Vec<&str> = words.iter().map(|word| word.get_name()).collect();
    let words = if words.is_empty() || !takes {
        String::new()
    } else {
        format!(" ({})", words.join(", "))
    };
    format!(
        "| `{form}` | {}{words}. |\n",
        help.replace('|', "\\|").trim_end_matches('.')
    )
}
