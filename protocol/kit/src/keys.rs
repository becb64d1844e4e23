//! Checked reading of a participant's own keys.

use protocol::{Cause, NodeError};
use serde::Deserializer;
use serde::de::DeserializeOwned;
use thiserror::Error;

/// A key of a participant's own configuration that cannot be used.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{key}: {problem}{}", .help.as_ref().map(|h| format!("; {h}")).unwrap_or_default())]
pub struct ConfigError {
    /// Its cause.
    pub cause: Cause,
    /// Dotted path of the key below `participant.config`, for instance `mesh.size_m`.
    pub key: String,
    /// The fault, and its cause.
    pub problem: String,
    /// Advice to the user.
    pub help: Option<String>,
}

impl ConfigError {
    /// A problem with the value of `key`.
    pub fn new(key: &str, problem: impl Into<String>) -> ConfigError {
        ConfigError {
            cause: Cause::InvalidValue,
            key: key.into(),
            problem: problem.into(),
            help: None,
        }
    }

    /// This error with a cause.
    pub fn because(mut self, cause: Cause) -> ConfigError {
        self.cause = cause;
        self
    }

    /// This error with a proposal.
    pub fn help(mut self, help: impl Into<String>) -> ConfigError {
        self.help = Some(help.into());
        self
    }
}

impl From<ConfigError> for NodeError {
    fn from(error: ConfigError) -> NodeError {
        NodeError::of(error.cause, format!("participant.config.{error}"))
    }
}

/// The candidate nearest to `word`, or all candidates under their common name `together`.
pub fn proposal(word: &str, together: &str, candidates: &[&str]) -> String {
    match nearest(word, candidates) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("{together}: {}", candidates.join(", ")),
    }
}

/// Reads a table of keys into its type. Unknown and missing keys and wrong types are errors that name the key; for an unknown key the
/// error proposes the nearest valid one.
pub fn read_table<'a, T: DeserializeOwned>(table: impl Deserializer<'a>) -> Result<T, ConfigError> {
    serde_path_to_error::deserialize(table).map_err(|error| {
        let path = error.path().to_string();
        let message = error.inner().to_string();
        config_error(&path, &message)
    })
}

/// Reads a table after the key that decides its form. Its errors reach
/// [`read_table`] as text, and keep the path of the key inside the table: "at `disks[3].radius_m`: invalid type".
pub fn read_part<T: DeserializeOwned, E: serde::de::Error>(
    table: serde_json::Value,
) -> Result<T, E> {
    serde_path_to_error::deserialize(table)
        .map_err(|error| E::custom(format!("at `{}`: {}", error.path(), error.inner())))
}

/// Refuses a key with a reason and advice if a condition holds. The cause is that two keys do not go together, unless the caller names
/// another cause.
///
/// # Errors
/// Names the `key`, why it is refused, and what to write instead.
pub fn refuse_if(
    holds: bool,
    key: &str,
    why: impl Into<String>,
    help: impl Into<String>,
) -> Result<(), ConfigError> {
    if holds {
        return Err(ConfigError::new(key, why)
            .because(Cause::ConflictingKeys)
            .help(help));
    }
    Ok(())
}

/// An error about a key below serde's present key, as a text from which [`config_error`] reads key and cause:
/// "at `path` (file-unreadable): it is a folder".
pub fn error_inside<E: serde::de::Error>(key: &str, error: &ConfigError) -> E {
    let help = error.help.as_ref().map(|help| format!("; {help}"));
    E::custom(format!(
        "at `{key}` ({}): {}{}",
        error.cause.word(),
        error.problem,
        help.unwrap_or_default()
    ))
}

/// Turns serde's message about `path` into an error that names the key and proposes what to write instead.
pub fn config_error(path: &str, message: &str) -> ConfigError {
    let parent = path.trim_end_matches(['.', '?']);
    if let Some((inside, cause, message)) = inside(message) {
        let inside = inside.trim_matches('.');
        let path = if inside.is_empty() {
            parent
        } else {
            &format!("{parent}.{inside}")
        };
        return match cause {
            Some(cause) => ConfigError::new(path, message).because(cause),
            None => config_error(path, message),
        };
    }
    // Some formats repeat the path on a second line.
    let message = message.lines().next().unwrap_or_default();
    let quoted: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    let begins = |words: &str| message.starts_with(words);
    match &quoted[..] {
        [key, known @ ..] if begins("unknown field") => unknown_key(parent, key, known),
        [key, ..] if begins("missing field") => {
            let help = format!("add `{key} = ...`; the shipped scenes show usual values");
            let key = match parent {
                "" => key.to_string(),
                _ => format!("{parent}.{key}"),
            };
            let error = ConfigError::new(&key, "this key is required and missing");
            error.because(Cause::MissingKey).help(help)
        }
        [word, known @ ..] if begins("unknown variant") => {
            let problem = format!("`{word}` is not one of the choices");
            let error = ConfigError::new(parent, problem).because(Cause::UnknownWord);
            error.help(format!("choices: {}", known.join(", ")))
        }
        _ => ConfigError::new(parent, in_words(message)).because(cause_of(message)),
    }
}

/// Key, cause and message of an error inside the text of another error.
fn inside(message: &str) -> Option<(&str, Option<Cause>, &str)> {
    let (key, rest) = message.strip_prefix("at `")?.split_once('`')?;
    if let Some(message) = rest.strip_prefix(": ") {
        return Some((key, None, message));
    }
    let (word, message) = rest.strip_prefix(" (")?.split_once("): ")?;
    Some((key, Cause::of_word(word), message))
}

fn unknown_key(parent: &str, key: &str, known: &[&str]) -> ConfigError {
    let path = match parent {
        "" => key.to_string(),
        _ if parent == key || parent.ends_with(&format!(".{key}")) => parent.to_string(),
        _ => format!("{parent}.{key}"),
    };
    let error = ConfigError::new(&path, "no such key").because(Cause::UnknownKey);
    if let Some(own) = known.iter().find(|known| differ_in_unit(key, known)) {
        return error.help(format!(
            "did you mean `{own}`? The unit belongs to the key and is an SI unit: convert the number"
        ));
    }
    match nearest(key, known) {
        Some(near) => error.help(format!("did you mean `{near}`?")),
        None if known.is_empty() => error,
        None => error.help(format!("keys here: {}", known.join(", "))),
    }
}

/// Units at the end of keys; the first of each list is the program's unit.
const UNITS: [&[&str]; 6] = [
    &["m", "mm", "um", "cm", "km"],
    &["s", "ms", "us", "ns"],
    &["n", "kn", "mn"],
    &["pa", "kpa", "mpa", "gpa"],
    &["kg", "g", "t"],
    &["hz", "khz"],
];

/// True if a key is this known one with another unit of the same kind, or without a unit.
fn differ_in_unit(key: &str, known: &str) -> bool {
    let Some((stem, unit)) = known.rsplit_once('_') else {
        return false;
    };
    let Some(others) = UNITS.iter().find(|units| units[0] == unit) else {
        return false;
    };
    let own = key.strip_prefix(stem);
    own.is_some_and(|rest| {
        rest.is_empty()
            || rest
                .strip_prefix('_')
                .is_some_and(|own| others.contains(&own))
    })
}

/// The cause of serde's message about a value.
fn cause_of(message: &str) -> Cause {
    let begins = |words: &str| message.starts_with(words);
    if begins("invalid value: integer") {
        Cause::OutOfRange
    } else if begins("invalid value: string") {
        Cause::UnknownWord
    } else if ["invalid type", "invalid length", "expected"]
        .iter()
        .any(|words| begins(words))
    {
        Cause::WrongType
    } else {
        Cause::InvalidValue
    }
}

/// serde's message with words in place of Rust's type names.
fn in_words(message: &str) -> String {
    let Some((got, expected)) = message.split_once(", expected ") else {
        return message.to_string();
    };
    let in_words = match expected {
        "f64" => "a number",
        "u32" | "u64" | "usize" => "a whole number, 0 or above",
        "a boolean" => "true or false",
        "a sequence" => "a list",
        "a map" => "a table",
        "a string" | "path string" => "a text in quotation marks",
        "an array of length 2" => "a list of two",
        other if other.starts_with("struct ") => "a table",
        other => other,
    };
    format!("{got}, expected {in_words}")
}

/// The candidate that a mistyped word most likely stands for.
pub fn nearest<'a>(word: &str, candidates: &[&'a str]) -> Option<&'a str> {
    candidates
        .iter()
        .map(|candidate| (strsim::damerau_levenshtein(word, candidate), *candidate))
        .filter(|(distance, candidate)| *distance <= 1 + candidate.len() / 3)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;
    use serde_json::json;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code)]
    struct Outer {
        mesh: Mesh,
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code)]
    struct Mesh {
        size_m: f64,
        crown_radius_m: Option<f64>,
    }

    #[test]
    fn the_error_names_a_mistyped_key_and_the_nearest_valid_one() {
        let error =
            read_table::<Outer>(&json!({"mesh": {"siez_m": 1.0}})).expect_err("it is mistyped");
        assert_eq!(error.key, "mesh.siez_m");
        assert_eq!(error.help.as_deref(), Some("did you mean `size_m`?"));
    }

    #[test]
    fn the_error_names_the_right_unit_of_a_key() {
        for wrong in ["size_mm", "size", "size_um"] {
            let config = json!({"mesh": {wrong: 1.0}});
            let error = read_table::<Outer>(&config).expect_err("it is in another unit");
            let help = error.help.expect("a proposal");
            assert!(help.contains("`size_m`") && help.contains("SI"), "{help}");
        }
        assert!(!differ_in_unit("size_s", "size_m"));
        assert!(!differ_in_unit("sizes_mm", "size_m"));
    }

    #[test]
    fn an_error_inside_another_keeps_key_and_cause() {
        let error = ConfigError::new("any", "is a folder").because(Cause::FileUnreadable);
        let text = error_inside::<serde_json::Error>("path", &error).to_string();
        let read = config_error("sample", &text);
        assert_eq!(
            (read.key.as_str(), read.cause),
            ("sample.path", Cause::FileUnreadable)
        );
        assert_eq!(read.problem, "is a folder");
    }

    #[test]
    fn the_error_names_a_missing_key_with_its_table() {
        let error = read_table::<Outer>(&json!({"mesh": {}})).expect_err("size_m is missing");
        assert_eq!(error.key, "mesh.size_m");
    }

    #[test]
    fn the_error_names_a_wrong_type() {
        let error = read_table::<Outer>(&json!({"mesh": {"size_m": "big"}})).expect_err("a string");
        assert_eq!(error.key, "mesh.size_m");
        assert!(error.problem.contains("invalid type"), "{}", error.problem);
    }
}
