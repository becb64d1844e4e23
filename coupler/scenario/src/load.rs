//! Reads a scenario: file, `--set`, checks.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use kit::ConfigError;
use kit::keys::read_table;
use kit::limits::finite;
use kit::ranges;
use serde::de::DeserializeOwned;
use serde_json::json;

use crate::check::check;
use crate::error::{Code, Error, Refusal, Result, ScenarioError};
use crate::keys::Scenario;
use crate::overrides::{Changes, apply, changes, leaves};
use crate::paths;
use crate::schema::schema;
use crate::source::{ScenarioSource, decimal_comma};
use scenes::kept;

/// A scenario that passed all checks that need no solver.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The scenario with overrides applied.
    pub scenario: Scenario,
    /// Its text after overrides, as in `scenario.toml` of the run directory.
    pub resolved: String,
    /// blake3 of `resolved`, in hexadecimal.
    pub hash: String,
    /// The original file, for error messages.
    pub source: ScenarioSource,
    /// Folder of the scenario when it first ran (absolute); the commands of participants start there.
    pub folder: PathBuf,
    /// Files that the solvers' keys name (absolute).
    pub files: Vec<String>,
    /// The keys that were overridden, or that differ from the shipped scene of which this is a copy.
    pub changed: Changes,
}

impl Loaded {
    /// The name in `run.derived_from` if no shipped scene has it, and the name that was perhaps meant.
    pub fn unknown_origin(&self) -> Option<(&str, Option<String>)> {
        let name = self.scenario.run.derived_from.as_deref()?;
        let unknown = scenes::scene_file(name).is_none();
        unknown.then(|| (name, scenes::meant(name, false).map(String::from)))
    }
}

/// Key of the manifest for [`Loaded::changed`].
pub const CHANGED_KEY: &str = "changed";

/// Key of the manifest for [`Loaded::folder`], for a run that is resumed or repeated.
pub const FOLDER_KEY: &str = "scenario_folder";

/// The value of a key in the text of a manifest.
pub fn of_manifest<T: DeserializeOwned>(manifest: &str, key: &str) -> Option<T> {
    let mut manifest: serde_json::Value = serde_json::from_str(manifest).ok()?;
    serde_json::from_value(manifest.get_mut(key)?.take()).ok()
}

/// Longest scenario (bytes); a listed disk takes about 100.
const LONGEST_FILE: u64 = 64 << 20;

/// Reads a scenario by folder, by file, by name under `scenarios/` or by the name of a shipped scene, and applies
/// `KEY=VALUE` overrides in order.
pub fn load(scenario: &str, overrides: &[String]) -> Result<Loaded> {
    match find(scenario)? {
        Found::File(path) => read(&path, overrides),
        Found::Shipped(file) if scenes::stands_alone(&file) => parse(ScenarioSource {
            name: format!("{scenario} (built in)"),
            text: scenes::text(&file).unwrap_or_default().into(),
            overrides: overrides.to_vec(),
        }),
        Found::Shipped(file) => read(&kept::all(scenario)?.join(file), overrides),
    }
}

/// The table that describes a scenario to its readers. Runs and the scenario's hash do not depend on it.
const ABOUT: &str = "about";

/// The keys of a scenario, without its solvers' keys.
static SCHEMA: LazyLock<serde_json::Value> = LazyLock::new(|| schema(&[]));

/// Reads the file of a scenario.
fn read(path: &Path, overrides: &[String]) -> Result<Loaded> {
    let length = path.metadata().map_or(0, |file| file.len());
    if length > LONGEST_FILE {
        let problem =
            format!("a scenario has at most {LONGEST_FILE} bytes, this file has {length}");
        return Err(Refusal::file(path, problem).into());
    }
    let text = std::fs::read_to_string(path).map_err(Error::input(path.display()))?;
    let beside = path.parent().unwrap_or(Path::new(""));
    let manifest = std::fs::read_to_string(beside.join("manifest.json")).unwrap_or_default();
    let kept = of_manifest(&manifest, FOLDER_KEY);
    let changed = of_manifest(&manifest, CHANGED_KEY).unwrap_or_default();
    let loaded = parse(ScenarioSource::new(path.display(), text, overrides))?;
    Ok(Loaded {
        folder: kept.unwrap_or_else(|| absolute(beside)),
        changed: since(changed, loaded.changed),
        ..loaded
    })
}

/// All changes of a scenario that was changed before and is changed again.
fn since(mut first: Changes, again: Changes) -> Changes {
    for (key, [before, now]) in again {
        let known = first.entry(key).or_insert([before, None]);
        known[1] = now;
    }
    first.retain(|_, [before, now]| before != now);
    first
}

/// The absolute path of a folder; an empty path is the current folder.
pub fn absolute(folder: &Path) -> PathBuf {
    let here = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    std::path::absolute(here).unwrap_or_else(|_| here.to_path_buf())
}

/// Reads a scenario from a text with its overrides.
pub fn parse(source: ScenarioSource) -> Result<Loaded> {
    let table: Result<toml::Table, _> = source.text.parse();
    let mut table = table.map_err(|error| syntax_error(&source, &error))?;
    if table.contains_key("study") {
        let problem = "is a study of many runs: `thirdbody study plan` shows its plan, `thirdbody study run` runs it";
        return Err(Refusal::file(&source.name, problem).into());
    }
    let mut origin = table.clone();
    for set in &source.overrides {
        apply(&mut table, set)?;
    }
    let folder = Path::new(&source.name).parent();
    let files = paths::make_absolute(&mut table, folder.unwrap_or(Path::new("")));
    let refused = |error: ConfigError| source.error(&error.key.clone(), error);
    let mut numbers = leaves(&table).into_iter();
    let finite = numbers.try_for_each(|(key, value)| finite(&key, value.as_float().unwrap_or(0.0)));
    finite.map_err(refused)?;
    let scenario: Scenario = read_table(table.clone()).map_err(refused)?;
    check(&scenario).map_err(refused)?;
    ranges::check(&SCHEMA, &json!(table)).map_err(refused)?;
    table.remove(ABOUT);
    let name = scenario.run.derived_from.as_deref();
    let shipped = name.and_then(scenes::scene_file);
    if let Some(shipped) = shipped.and_then(|file| scenes::text(&file)?.parse().ok()) {
        origin = shipped;
    }
    paths::make_absolute(&mut origin, folder.unwrap_or(Path::new("")));
    origin.remove(ABOUT);
    let mut changed = changes([&origin, &table]);
    changed.retain(|key, _| key != "run.name" && key != "run.derived_from");
    let resolved = toml::to_string(&table)
        .map_err(|error| Refusal::file(&source.name, format!("cannot be written back: {error}")))?;
    let hash = blake3::hash(resolved.as_bytes()).to_hex().to_string();
    Ok(Loaded {
        folder: absolute(folder.unwrap_or(Path::new(""))),
        scenario,
        resolved,
        hash,
        source,
        files,
        changed,
    })
}

/// Reads the text of another TOML file of ours, with errors that name the key.
///
/// # Errors
/// It is not TOML, or a key is unknown, missing or of the wrong type.
pub fn from_toml<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    let table: Result<toml::Table, _> = text.parse();
    let table = table.map_err(|error: toml::de::Error| error.to_string())?;
    read_table(table).map_err(|error| error.to_string())
}

/// The place where a scenario was found.
enum Found {
    File(PathBuf),
    /// Its file among the shipped scenes.
    Shipped(String),
}

/// A folder with `scenario.toml`, a file, or a name under `scenarios/`; otherwise a shipped scene.
fn find(scenario: &str) -> Result<Found> {
    let given = Path::new(scenario);
    let named = Path::new("scenarios").join(scenario);
    for candidate in [given, &named] {
        for path in [candidate.to_path_buf(), candidate.join("scenario.toml")] {
            if path.is_file() {
                return Ok(Found::File(path));
            }
            if path.exists() && !path.is_dir() {
                let problem =
                    "is a pipe or a device; a scenario must be a file that can be read twice";
                return Err(Refusal::file(path, problem).into());
            }
        }
    }
    if let Some(file) = scenes::scene_file(scenario) {
        return Ok(Found::Shipped(file));
    }
    let meant = scenes::meant(scenario, false);
    let meant = meant.map_or(String::new(), |near| format!("; did you mean `{near}`?"));
    let text = format!(
        "no scenario `{scenario}`: give a folder with scenario.toml, a file, a name under scenarios/, or a name that `thirdbody scenes` lists{meant}"
    );
    Err(Refusal::other(Code::NoScenario, text).into())
}

fn syntax_error(source: &ScenarioSource, error: &toml::de::Error) -> Error {
    let span = error.span();
    Error::Scenario(Box::new(ScenarioError {
        code: Code::TomlSyntax,
        key: source.name.clone(),
        problem: format!("not valid TOML: {}", error.message()),
        help: span
            .as_ref()
            .and_then(|span| decimal_comma(&source.text, span.start)),
        source_file: Some(miette::NamedSource::new(&source.name, source.text.clone())),
        span: span.map(Into::into),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: &str = r#"
[run]
name = "small"
thickness_m = 1e-3
[[participant]]
name = "rail"
kind = "fem"
[participant.config.wheel]
load_n = 8000.0
"#;

    fn read(text: &str, overrides: &[&str]) -> Result<Loaded> {
        let source = ScenarioSource {
            name: "small.toml".into(),
            text: text.into(),
            overrides: overrides.iter().map(|s| s.to_string()).collect(),
        };
        parse(source)
    }

    fn key_of(error: Error) -> String {
        match error {
            Error::Scenario(error) => {
                assert!(error.span.is_some(), "{error} points nowhere");
                error.key
            }
            other => panic!("expected a scenario error, got {other}"),
        }
    }

    #[test]
    fn overrides_reach_named_participants_and_keep_every_bit() {
        let loaded = read(
            SMALL,
            &["participant.rail.config.wheel.load_n=8000.000000000001"],
        )
        .expect("valid");
        let wheel = &loaded.scenario.participant[0].config["wheel"];
        assert_eq!(wheel["load_n"].as_float(), Some(8000.000000000001));
        assert_ne!(loaded.hash, read(SMALL, &[]).expect("valid").hash);
    }

    #[test]
    fn a_value_that_is_not_toml_is_a_string() {
        let loaded = read(SMALL, &["run.transport=channel"]).expect("valid");
        assert_eq!(
            loaded.scenario.run.transport,
            crate::keys::TransportKind::Channel
        );
    }

    #[test]
    fn an_unknown_key_is_reported_with_its_position() {
        let error = read(&SMALL.replace("thickness_m", "thikness_m"), &[]).expect_err("mistyped");
        assert_eq!(key_of(error), "run.thikness_m");
    }

    #[test]
    fn a_number_that_is_not_finite_is_reported() {
        let error = read(&SMALL.replace("8000.0", "nan"), &[]).expect_err("not a number");
        assert_eq!(key_of(error), "participant.rail.config.wheel.load_n");
    }

    #[test]
    fn a_decimal_comma_is_reported() {
        let Err(Error::Scenario(error)) = read(SMALL, &["run.thickness_m=0,3"]) else {
            panic!("a comma")
        };
        let help = error.help.as_deref();
        assert_eq!(help, Some("numbers have a decimal point: write 0.3"));
        for text in ["thickness_m = 0,3", "law = { friction = -0,3, k = 1 }"] {
            let error = read(&SMALL.replace("thickness_m = 1e-3", text), &[]).expect_err("a comma");
            let Error::Scenario(error) = error else {
                panic!("{error}")
            };
            let help = error.help.unwrap_or_default();
            assert!(help.ends_with("0.3"), "{text}: {help}");
        }
        let error = read(&SMALL.replace("= 1e-3", "= [1,"), &[]).expect_err("no end");
        assert!(matches!(error, Error::Scenario(error) if error.help.is_none()));
    }

    #[test]
    fn a_negative_thickness_is_refused() {
        let error = read(&SMALL.replace("1e-3", "-1e-3"), &[]).expect_err("negative");
        assert_eq!(key_of(error), "run.thickness_m");
    }
}
