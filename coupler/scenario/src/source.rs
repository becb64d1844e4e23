//! Positions of keys in the scenario file, for messages that point at them.

use std::fmt::Display;

use kit::ConfigError;
use miette::NamedSource;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::{Code, Error, ScenarioError};

/// The text of a scenario with its name.
#[derive(Clone, Debug)]
pub struct ScenarioSource {
    /// Path as the user gave it.
    pub name: String,
    /// The whole text.
    pub text: String,
    /// `KEY=VALUE` overrides of the text.
    pub overrides: Vec<String>,
}

impl ScenarioSource {
    /// A text with its name and its overrides.
    pub fn new(name: impl Display, text: String, overrides: &[String]) -> ScenarioSource {
        ScenarioSource {
            name: name.to_string(),
            text,
            overrides: overrides.to_vec(),
        }
    }

    /// An error about `key`, a dotted path from the top of the scenario with named or numbered list entries
    /// (`participant.rail.config.mesh.size_m`, `participant[0].kind`). It points at the nearest part of the path that
    /// the file contains.
    pub fn error(&self, key: &str, error: ConfigError) -> Error {
        let key = self.named(key);
        let set = self.overriding(&key);
        let problem = set.map_or(error.problem.clone(), |(set, inside)| {
            let origin = if inside { "perhaps from" } else { "from" };
            format!("{} ({origin} --set {set})", error.problem)
        });
        let comma = || set.and_then(|(set, _)| decimal_comma(set, set.len()));
        let file = || NamedSource::new(&self.name, self.text.clone()).with_language("TOML");
        let span = self.span(&key).filter(|_| set.is_none());
        Error::Scenario(Box::new(ScenarioError {
            code: Code::Of(error.cause),
            // A user's name may contain control sequences of a terminal.
            key: key.replace(char::is_control, "?"),
            problem,
            help: error.help.or_else(comma),
            source_file: set.is_none().then(file),
            span: span.map(Into::into),
        }))
    }

    /// The key with list entries by their names, if they have one: `participant[0].kind` is `participant.rail.kind`.
    fn named(&self, key: &str) -> String {
        let name_of = |list: &str, entry: &str| -> Option<String> {
            let position: usize = entry.parse().ok()?;
            let table: toml::Table = self.text.parse().ok()?;
            let name = table.get(list)?.get(position)?.get("name")?;
            name.as_str().map(String::from)
        };
        let parts = segments(key);
        match parts.as_slice() {
            [list, entry, rest @ ..] => {
                let entry = name_of(list, entry).unwrap_or_else(|| entry.clone());
                [&[list.clone(), entry], rest].concat().join(".")
            }
            _ => key.to_string(),
        }
    }

    /// The last override of this key or of a table around it, else one inside it. An error about a table may be about
    /// any of its keys: then the second value is true.
    fn overriding(&self, key: &str) -> Option<(&String, bool)> {
        let wanted = segments(key);
        let same = |(position, (a, b)): (usize, (&String, &String))| {
            // Entries of a list have numbers in serde's paths and names in overrides.
            a == b || (position == 1 && b.parse::<usize>().is_ok())
        };
        let written = |set: &String| segments(set.split('=').next().unwrap_or_default().trim());
        let agrees = |set: &&String| written(set).iter().zip(&wanted).enumerate().all(same);
        let mut candidates: Vec<&String> = self.overrides.iter().rev().filter(agrees).collect();
        candidates.sort_by_key(|set| written(set).len() > wanted.len());
        let first = candidates.first()?;
        Some((first, written(first).len() > wanted.len()))
    }

    fn span(&self, key: &str) -> Option<std::ops::Range<usize>> {
        let document = DeTable::parse(&self.text).ok()?;
        let (mut found, mut table) = (None, document.get_ref());
        let segments = segments(key);
        let mut rest = segments.iter();
        while let Some(segment) = rest.next() {
            let Some((name, value)) = table.get_key_value(segment.as_str()) else {
                break;
            };
            found = Some(name.span());
            let below = match value.get_ref() {
                DeValue::Array(entries) => rest.next().and_then(|entry| pick(entries, entry)),
                _ => Some(value),
            };
            let Some(DeValue::Table(inner)) = below.map(Spanned::get_ref) else {
                break;
            };
            table = inner;
        }
        found
    }
}

/// An entry of a list of tables, by its position or by its `name`.
fn pick<'a, 'i>(
    entries: &'a [Spanned<DeValue<'i>>],
    segment: &str,
) -> Option<&'a Spanned<DeValue<'i>>> {
    if let Ok(position) = segment.parse::<usize>() {
        return entries.get(position);
    }
    entries.iter().find(|entry| {
        let name = entry.get_ref().get("name");
        name.and_then(|name| name.get_ref().as_str()) == Some(segment)
    })
}

/// Splits `participant[0].config.mesh` into its parts; an index is a part of its own.
pub fn segments(key: &str) -> Vec<String> {
    let parts = key.split(['.', '[']).map(|part| part.trim_end_matches(']'));
    parts
        .filter(|part| !part.is_empty())
        .map(String::from)
        .collect()
}

/// The help for a number with a decimal comma, if an error is at the number or behind it.
pub(crate) fn decimal_comma(text: &str, at: usize) -> Option<String> {
    let line = text.get(..at)?.lines().count().checked_sub(1)?;
    let line = text.lines().nth(line)?;
    let is_number = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    let mut values = line.split('=').skip(1).map(str::trim_start);
    values.find_map(|value| {
        let (whole, rest) = value.split_once(',')?;
        let end = rest.find(|c: char| !c.is_ascii_digit());
        let part = &rest[..end.unwrap_or(rest.len())];
        let is_one = is_number(whole.trim_start_matches(['-', '+'])) && is_number(part);
        is_one.then(|| format!("numbers have a decimal point: write {whole}.{part}"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "[run]\nname = \"x\"\n\n[[participant]]\nname = \"rail\"\n[participant.config.mesh]\nsize = 1\n";

    fn source() -> ScenarioSource {
        ScenarioSource {
            name: "scenario.toml".into(),
            text: TEXT.into(),
            overrides: vec!["participant.rail.config.mesh.size=-1".into()],
        }
    }

    #[test]
    fn a_key_of_a_named_participant_is_found() {
        let range = source()
            .span("participant.rail.config.mesh.size")
            .expect("it is there");
        assert_eq!(&TEXT[range], "size");
    }

    #[test]
    fn an_error_in_an_overridden_key_names_its_override() {
        let blamed = |key: &str| source().overriding(key).is_some_and(|(_, inside)| !inside);
        assert!(blamed("participant.rail.config.mesh.size"));
        assert!(blamed("participant[0].config.mesh.size"));
        assert!(!blamed("participant.rail.config.mesh.height_m"));
        let table = source();
        assert!(
            table
                .overriding("participant.rail.config.mesh")
                .is_some_and(|(_, inside)| inside)
        );
    }

    #[test]
    fn keys_show_entries_by_their_names() {
        assert_eq!(
            source().named("participant[0].config.mesh"),
            "participant.rail.config.mesh"
        );
        assert_eq!(source().named("run.seed"), "run.seed");
    }

    #[test]
    fn a_missing_key_points_at_its_table() {
        let range = source()
            .span("participant[0].config.mesh.height_m")
            .expect("the table is there");
        assert_eq!(&TEXT[range], "mesh");
    }
}
