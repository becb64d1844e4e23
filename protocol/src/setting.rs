//! The setting that a participant is launched with, and the checked reading of its own keys.

use std::path::PathBuf;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// The name of the environment variable that holds the path of the session file of a launched participant.
pub const SESSION_VARIABLE: &str = "THIRDBODY_SESSION";

/// Values that are common to all participants of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Setting {
    /// Name of the participant, as the scenario gives it.
    pub participant: String,
    /// Seed of everything random in the run.
    pub seed: u64,
    /// Out-of-plane thickness (m).
    pub thickness_m: f64,
    /// Threads of the participant's own pool. Results never depend on it.
    pub threads: usize,
    /// Folder that the participant may write fields to; nothing is written when absent.
    pub fields: Option<PathBuf>,
    /// Folder in which what is long to prepare is kept for later runs; nothing is kept when absent. Results never depend on it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cache: Option<PathBuf>,
}

/// Way from the participant to the coordinator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Transport {
    /// Shared memory: iceoryx2 with its own root and prefix for each run.
    Shm {
        /// Folder of the service files.
        root: PathBuf,
        /// Prefix of everything that the run creates in shared memory.
        prefix: String,
    },
    /// A channel inside the coordinator's process.
    Channel,
}

/// Everything that a participant needs before the first frame; written by the coordinator as JSON,
/// its path stands in the environment variable [`SESSION_VARIABLE`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Session {
    /// [`crate::PROTOCOL_VERSION`] of the coordinator.
    pub protocol: u32,
    /// The run that all frames must name.
    pub run_id: u64,
    /// blake3 of the resolved scenario, in hexadecimal.
    pub scenario_hash: String,
    /// Process id of the coordinator.
    pub coordinator_pid: u32,
    /// Values that are common to all participants.
    pub setting: Setting,
    /// Way to the coordinator.
    pub transport: Transport,
    /// A participant that hears nothing for so long ends itself (s).
    pub idle_deadline_s: f64,
    /// The participant's own keys, opaque to everybody else.
    pub config: serde_json::Value,
}

/// A key of a participant's own configuration that cannot be used.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{key}: {problem}{}", .help.as_ref().map(|h| format!("; {h}")).unwrap_or_default())]
pub struct ConfigError {
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
            key: key.into(),
            problem: problem.into(),
            help: None,
        }
    }

    /// The same with a proposal.
    pub fn help(mut self, help: impl Into<String>) -> ConfigError {
        self.help = Some(help.into());
        self
    }
}

/// The candidate that `word` was perhaps meant to be, else all of them under the name that they have together.
pub fn proposal(word: &str, together: &str, candidates: &[&str]) -> String {
    match nearest(word, candidates) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("{together}: {}", candidates.join(", ")),
    }
}

/// Reads a participant's own keys into its configuration type. Unknown and missing keys and wrong types
/// are errors that name the key; for an unknown key the nearest valid one is proposed.
pub fn read_config<T: DeserializeOwned>(config: &serde_json::Value) -> Result<T, ConfigError> {
    serde_path_to_error::deserialize(config).map_err(|error| {
        let path = error.path().to_string();
        let message = error.inner().to_string();
        config_error(&path, &message)
    })
}

/// Reads a table whose form another of its keys decides, when that key has been read from it. Its errors reach
/// [`read_config`] as text, and keep the path of the key inside the table: "at `disks[3].radius_m`: invalid type".
pub fn read_part<T: DeserializeOwned, E: serde::de::Error>(
    table: serde_json::Value,
) -> Result<T, E> {
    serde_path_to_error::deserialize(table)
        .map_err(|error| E::custom(format!("at `{}`: {}", error.path(), error.inner())))
}

/// Turns serde's message about `path` into an error that names the key and proposes what to write instead.
pub fn config_error(path: &str, message: &str) -> ConfigError {
    let parent = path.trim_end_matches(['.', '?']);
    let part = message
        .strip_prefix("at `")
        .and_then(|part| part.split_once("`: "));
    if let Some((inside, message)) = part {
        let inside = inside.trim_matches('.');
        let path = if inside.is_empty() {
            parent
        } else {
            &format!("{parent}.{inside}")
        };
        return config_error(path, message);
    }
    // Some formats repeat the path on a second line.
    let message = message.lines().next().unwrap_or_default();
    let quoted: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    let join = |key: &str| match parent {
        "" => key.to_string(),
        _ if parent == key || parent.ends_with(&format!(".{key}")) => parent.to_string(),
        _ => format!("{parent}.{key}"),
    };
    if message.starts_with("unknown field") && !quoted.is_empty() {
        let error = ConfigError::new(&join(quoted[0]), "no such key");
        return match nearest(quoted[0], &quoted[1..]) {
            Some(near) => error.help(format!("did you mean `{near}`?")),
            None if quoted.len() > 1 => {
                error.help(format!("keys here: {}", quoted[1..].join(", ")))
            }
            None => error,
        };
    }
    if message.starts_with("missing field") && !quoted.is_empty() {
        let key = match parent {
            "" => quoted[0].to_string(),
            _ => format!("{parent}.{}", quoted[0]),
        };
        return ConfigError::new(&key, "this key is required and missing");
    }
    if message.starts_with("unknown variant") && !quoted.is_empty() {
        let error = ConfigError::new(parent, format!("`{}` is not one of the choices", quoted[0]));
        return error.help(format!("choices: {}", quoted[1..].join(", ")));
    }
    ConfigError::new(parent, message)
}

/// The candidate that a mistyped word most likely meant.
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
    fn a_mistyped_key_is_named_with_its_nearest_neighbour() {
        let error =
            read_config::<Outer>(&json!({"mesh": {"siez_m": 1.0}})).expect_err("it is mistyped");
        assert_eq!(error.key, "mesh.siez_m");
        assert_eq!(error.help.as_deref(), Some("did you mean `size_m`?"));
    }

    #[test]
    fn a_missing_key_is_named_with_its_table() {
        let error = read_config::<Outer>(&json!({"mesh": {}})).expect_err("size_m is missing");
        assert_eq!(error.key, "mesh.size_m");
    }

    #[test]
    fn a_wrong_type_is_named() {
        let error =
            read_config::<Outer>(&json!({"mesh": {"size_m": "big"}})).expect_err("a string");
        assert_eq!(error.key, "mesh.size_m");
        assert!(error.problem.contains("invalid type"), "{}", error.problem);
    }
}
