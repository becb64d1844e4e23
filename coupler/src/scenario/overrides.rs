//! `KEY=VALUE` of the command line, put into the table of a scenario.

use super::source::segments;
use crate::error::{Error, Refusal};

/// Applies one `KEY=VALUE`. VALUE is TOML; what does not parse as TOML is a string. Entries of
/// `[[participant]]` and `[[interface]]` are addressed by name.
pub(super) fn apply(table: &mut toml::Table, set: &str) -> Result<(), Error> {
    let refuse = |why: &str| Refusal::argument(format!("--set {set}"), why);
    let (key, value) = set
        .split_once('=')
        .ok_or_else(|| refuse("write it as KEY=VALUE, for instance --set run.seed=2"))?;
    let value = parse_value(value.trim());
    let parts = segments(key.trim());
    let (last, parents) = parts
        .split_last()
        .ok_or_else(|| refuse("the key is empty"))?;
    let mut current = table;
    let mut parents = parents.iter();
    while let Some(part) = parents.next() {
        let child = current
            .entry(part.clone())
            .or_insert_with(|| toml::Value::Table(toml::Table::new()));
        current = match child {
            toml::Value::Table(inner) => inner,
            toml::Value::Array(entries) => {
                let unnamed = || refuse(&format!("`{part}` is a list, name one of its entries"));
                let name = parents.next().ok_or_else(unnamed)?;
                entry_by_name(entries, name)
                    .ok_or_else(|| refuse(&format!("no `{part}` is named `{name}`")))?
            }
            _ => {
                let why = format!("`{part}` is a value and has no keys of its own");
                return Err(refuse(&why).into());
            }
        };
    }
    current.insert(last.clone(), value);
    Ok(())
}

fn parse_value(text: &str) -> toml::Value {
    format!("value = {text}")
        .parse::<toml::Table>()
        .ok()
        .and_then(|mut table| table.remove("value"))
        .unwrap_or_else(|| toml::Value::String(text.to_string()))
}

fn entry_by_name<'a>(entries: &'a mut [toml::Value], name: &str) -> Option<&'a mut toml::Table> {
    entries
        .iter_mut()
        .filter_map(toml::Value::as_table_mut)
        .find(|table| table.get("name").and_then(toml::Value::as_str) == Some(name))
}
