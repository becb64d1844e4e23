//! `thirdbody explain`: cause and cure of an error or a warning; meaning of a key or a result.

use kit::keys::proposal;
use serde_json::Value;

use super::check::schema_of;
use super::common::{VerbResult, print};
use coordinator::participants::Registry;
use report::results;
use scenario::error::{Refusal, explanation, explanations};

/// Arguments of `explain`.
#[derive(Debug, clap::Args)]
pub struct ExplainArguments {
    /// Code from a message or from summary.json, a key or its last parts (law.friction), a result or a signal (default: list all codes).
    word: Option<String>,
}

/// Number of keys to print in full; the others are only counted.
const MANY: usize = 12;

/// Prints the explanation of a code, a key or a result; without a word, one line per code.
pub fn explain(arguments: &ExplainArguments, registry: &Registry) -> VerbResult {
    let Some(word) = &arguments.word else {
        for explanation in explanations() {
            print(&format!("{:24}{}", explanation.code, explanation.line()))?;
        }
        return Ok(0);
    };
    // The word may come from a message: error[unknown-key].
    let word = word
        .trim_start_matches("error[")
        .trim_start_matches("warning[")
        .trim_end_matches([']', ':']);
    let word = &general(word);
    // Or from a status: peer_lost.
    let hyphened = word.replace('_', "-");
    let code = explanation(word).or_else(|| explanation(&hyphened));
    let code = code.map(|of| format!("{}\n\n{}", of.code, of.text().trim()));
    let keys = keys(registry);
    // `law.contacts` is no key, and `law` no participant that has the result `contacts`.
    let table = word.rsplit_once('.').map(|(table, _)| format!(".{table}."));
    let is_table = table.is_some_and(|table| keys.iter().any(|(key, _)| key.contains(&table)));
    let result = results::explained(word).filter(|_| !is_table);
    let mut texts = Vec::from_iter(code.into_iter().chain(result));
    texts.extend(matching(&keys, word));
    if !texts.is_empty() {
        return print(&texts.join("\n\n"));
    }
    let explanations = explanations().into_iter();
    let mut all: Vec<&str> = explanations.map(|explanation| explanation.code).collect();
    let results = results::names();
    all.extend(results.iter().map(String::as_str));
    all.extend(keys.iter().filter_map(|(key, _)| key.rsplit('.').next()));
    all.sort_unstable();
    all.dedup();
    let containing = all.iter().filter(|name| name.contains(word.as_str()));
    let containing = Vec::from_iter(containing.take(MANY).map(|name| format!("`{name}`")));
    let problem = match proposal(word, "", &all) {
        _ if !containing.is_empty() => format!("did you mean {}?", containing.join(", ")),
        meant if meant.starts_with("did you mean") => meant,
        _ => "`thirdbody explain` lists all codes, the book's page `reference/results` all results, `check --schema` all keys".into(),
    };
    let problem = format!("no error, warning, key, result or signal has this name; {problem}");
    Err(Refusal::argument(format!("explain {word}"), problem).into())
}

/// The path of a key as a message prints it (`participant.third-body.config.law.friction`, `interface.layer-base.substeps`), without
/// the name of the participant or interface.
fn general(path: &str) -> String {
    if let Some((_, key)) = path.split_once(".config.") {
        return key.into();
    }
    match path.splitn(3, '.').collect::<Vec<_>>()[..] {
        [table @ ("participant" | "interface"), _, key] => format!("{table}.NAME.{key}"),
        _ => path.into(),
    }
}

/// Descriptions of the keys whose names end with a word.
fn matching(keys: &[(String, String)], word: &str) -> Vec<String> {
    let end = format!(".{word}");
    let same = |(key, _): &&(String, String)| key == word || key.ends_with(&end);
    let found: Vec<_> = keys.iter().filter(same).collect();
    let shown = found.iter().take(MANY);
    let mut lines: Vec<String> = shown.map(|(key, text)| format!("{key}: {text}")).collect();
    if found.len() > MANY {
        lines.push(format!(
            "and {} more keys with that name",
            found.len() - MANY
        ));
    }
    lines
}

/// All keys of a scenario with their descriptions, sorted by name; each solver's own keys are below `config`.
pub(super) fn keys(registry: &Registry) -> Vec<(String, String)> {
    let schema = schema_of(registry);
    let mut found = Vec::new();
    let properties = &schema["properties"];
    walk("run", &properties["run"], &mut found);
    for list in ["interface", "participant"] {
        let items = &properties[list]["items"];
        walk(&format!("{list}.NAME"), items, &mut found);
    }
    for (kind, own) in schema["$defs"].as_object().into_iter().flatten() {
        let path = format!("participant.NAME.config ({kind})");
        walk(&path, own, &mut found);
    }
    found.sort();
    found.dedup_by(|a, b| a.0 == b.0);
    found
}

/// Collects the keys of a part of the schema, from all its forms.
fn walk(path: &str, part: &Value, found: &mut Vec<(String, String)>) {
    for form in ["oneOf", "anyOf"] {
        for inner in part[form].as_array().into_iter().flatten() {
            walk(path, inner, found);
        }
    }
    if part["items"].is_object() {
        walk(path, &part["items"], found);
    }
    for (name, inner) in part["properties"].as_object().into_iter().flatten() {
        let path = format!("{path}.{name}");
        let text = inner["description"].as_str().unwrap_or_default();
        let default = match &inner["default"] {
            Value::Null => String::new(),
            Value::Object(fields) if fields.is_empty() => String::new(),
            default => format!(" Default: {default}."),
        };
        found.push((path.clone(), format!("{text}{default}")));
        walk(&path, inner, found);
    }
}
