//! `KEY=VALUE` overrides of the command line, and the keys in which two tables differ.

use std::collections::{BTreeMap, BTreeSet};

use kit::keys::proposal;

use crate::error::{Error, Refusal, Result};
use crate::source::segments;

/// Applies one `KEY=VALUE`. VALUE is TOML; a value that does not parse as TOML is a string. Entries of
/// `[[participant]]` and `[[interface]]` are addressed by name.
pub(super) fn apply(table: &mut toml::Table, set: &str) -> Result<()> {
    let argument = format!("--set {}", set.escape_debug());
    let refuse = |why: &str| Error::from(Refusal::argument(&argument, why));
    if set.chars().any(|c| c.is_control() && c != '\t') {
        let why =
            "contains a line break or another control character: give one key with each --set";
        return Err(refuse(why));
    }
    let (key, value) = set
        .split_once('=')
        .ok_or_else(|| refuse("write it as KEY=VALUE, for instance --set run.seed=2"))?;
    let value = parse_value(value.trim());
    if key.trim().split('.').any(|part| part.trim().is_empty()) {
        let why = "the key has an empty part: write one point between two names";
        return Err(refuse(why));
    }
    let parts = segments(key.trim());
    if let Some(meant) = longer(table, key.trim(), &parts) {
        let why = format!("keys begin with run, participant or interface; did you mean `{meant}`?");
        return Err(refuse(&why));
    }
    let split = parts.split_last();
    let (last, parents) = split.ok_or_else(|| refuse("the key is empty"))?;
    let (mut current, mut parents) = (table, parents.iter());
    while let Some(part) = parents.next() {
        let child = current.entry(part.clone());
        current = match child.or_insert_with(|| toml::Table::new().into()) {
            toml::Value::Table(inner) => inner,
            toml::Value::Array(entries) => {
                let unnamed = || refuse(&format!("`{part}` is a list: name one of its entries"));
                let name = parents.next().ok_or_else(unnamed)?;
                if entry_by_name(entries, name).is_none() {
                    let known = entries.iter().filter_map(|entry| entry.get("name"));
                    let known: Vec<&str> = known.filter_map(toml::Value::as_str).collect();
                    let meant = proposal(name, "names", &known);
                    return Err(refuse(&format!("no `{part}` is named `{name}`; {meant}")));
                }
                entry_by_name(entries, name).ok_or_else(unnamed)?
            }
            _ => {
                let why = format!("`{part}` is a value and has no keys of its own");
                return Err(refuse(&why));
            }
        };
    }
    current.insert(last.clone(), value);
    Ok(())
}

/// The first key of the table that ends with this key, if the key begins with no section.
fn longer(table: &toml::Table, key: &str, parts: &[String]) -> Option<String> {
    if ["run", "participant", "interface"].contains(&parts.first()?.as_str()) {
        return None;
    }
    let end = format!(".{key}");
    let mut keys = leaves(table).into_iter().map(|(known, _)| known);
    keys.find(|known| known.ends_with(&end))
}

/// A number, whole or not.
pub fn number(value: &toml::Value) -> Option<f64> {
    value.as_float().or(value.as_integer().map(|n| n as f64))
}

/// The value of a key, with entries of `[[participant]]` and `[[interface]]` addressed by name; `None` if the table
/// does not have it.
pub fn value_at<'a>(table: &'a toml::Table, key: &str) -> Option<&'a toml::Value> {
    let parts = segments(key);
    let mut parts = parts.iter();
    let mut value = table.get(parts.next()?)?;
    for part in parts {
        value = match value {
            toml::Value::Array(entries) => entries.iter().find(|entry| is_named(entry, part))?,
            inner => inner.get(part)?,
        };
    }
    Some(value)
}

/// All values of a table by their keys; entries of lists by their names, if they have one.
pub fn leaves(table: &toml::Table) -> Vec<(String, &toml::Value)> {
    fn walk<'a>(key: String, value: &'a toml::Value, found: &mut Vec<(String, &'a toml::Value)>) {
        match value {
            toml::Value::Table(inner) => {
                for (name, value) in inner {
                    walk(format!("{key}.{name}"), value, found);
                }
            }
            toml::Value::Array(entries) => {
                for (index, entry) in entries.iter().enumerate() {
                    let name = entry.get("name").and_then(toml::Value::as_str);
                    let name = name.map_or(index.to_string(), String::from);
                    walk(format!("{key}.{name}"), entry, found);
                }
            }
            value => found.push((key, value)),
        }
    }
    let mut found = Vec::new();
    for (name, value) in table {
        walk(name.clone(), value, &mut found);
    }
    found
}

/// Keys in which two scenarios differ, with the values in the first and in the second; `None` where a key is missing.
pub type Changes = BTreeMap<String, [Option<String>; 2]>;

/// The keys in which two tables differ.
pub fn changes(tables: [&toml::Table; 2]) -> Changes {
    if tables[0] == tables[1] {
        return Changes::new();
    }
    let sides = tables.map(|table| leaves(table).into_iter().collect::<BTreeMap<_, _>>());
    let keys: BTreeSet<&String> = sides.iter().flat_map(BTreeMap::keys).collect();
    let values = |key| sides.each_ref().map(|side| side.get(key));
    let pairs = keys.into_iter().map(|key| (key, values(key)));
    let changed = pairs.filter(|(_, [one, other])| one != other);
    let text = |value: Option<&&toml::Value>| value.map(ToString::to_string);
    let shown = changed.map(|(key, values)| (key.clone(), values.map(text)));
    shown.collect()
}

/// Removes a key, with entries of lists addressed by name; does nothing if the key is missing.
pub fn remove_at(mut table: &mut toml::Table, key: &str) -> Option<toml::Value> {
    let parts = segments(key);
    let (last, parents) = parts.split_last()?;
    let mut parents = parents.iter();
    while let Some(part) = parents.next() {
        table = match table.get_mut(part)? {
            toml::Value::Table(inner) => inner,
            toml::Value::Array(entries) => entry_by_name(entries, parents.next()?)?,
            _ => return None,
        };
    }
    table.remove(last)
}

/// The key of an override.
pub fn key_of(set: &str) -> &str {
    set.split('=').next().unwrap_or_default().trim()
}

/// The value of an override: TOML, or otherwise a string.
pub fn parse_value(text: &str) -> toml::Value {
    let table = format!("value = {text}").parse::<toml::Table>();
    let value = table.ok().and_then(|mut table| table.remove("value"));
    value.unwrap_or_else(|| text.into())
}

fn entry_by_name<'a>(entries: &'a mut [toml::Value], name: &str) -> Option<&'a mut toml::Table> {
    let mut entries = entries.iter_mut();
    entries.find(|entry| is_named(entry, name))?.as_table_mut()
}

fn is_named(entry: &toml::Value, name: &str) -> bool {
    entry.get("name").and_then(toml::Value::as_str) == Some(name)
}
