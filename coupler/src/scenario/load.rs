//! Reading a scenario: file, `--set`, checks.

use std::path::{Path, PathBuf};

use protocol::ConfigError;
use protocol::setting::{config_error, nearest};

use super::paths;
use super::source::{Source, segments};
use super::{Interface, Scenario};
use crate::error::{Error, ScenarioError};

/// A scenario that passed all checks which need no solver.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The scenario with overrides applied.
    pub scenario: Scenario,
    /// Its text after overrides, as `scenario.toml` of the run directory keeps it.
    pub resolved: String,
    /// blake3 of `resolved`, in hexadecimal.
    pub hash: String,
    /// The original file, for messages.
    pub source: Source,
}

/// Reads a scenario by folder, file, or name under `scenarios/`, and applies `KEY=VALUE` overrides in order.
pub fn load(scenario: &str, overrides: &[String]) -> Result<Loaded, Error> {
    let path = find(scenario)?;
    let text = std::fs::read_to_string(&path).map_err(Error::io(path.display().to_string()))?;
    parse(Source {
        name: path.display().to_string(),
        text,
        overrides: overrides.to_vec(),
    })
}

/// The same from a text with its overrides.
pub fn parse(source: Source) -> Result<Loaded, Error> {
    let mut table: toml::Table = source
        .text
        .parse()
        .map_err(|error| syntax_error(&source, &error))?;
    for set in &source.overrides {
        apply(&mut table, set)?;
    }
    let folder = Path::new(&source.name).parent();
    paths::make_absolute(&mut table, folder.unwrap_or(Path::new("")));
    if let Some((key, value)) = not_finite(&toml::Value::Table(table.clone())) {
        let error = ConfigError::new(&key, format!("must be a finite number, got {value}"));
        return Err(source.error(&key, error));
    }
    let scenario: Scenario = serde_path_to_error::deserialize(table.clone()).map_err(|error| {
        let found = config_error(&error.path().to_string(), &error.inner().to_string());
        source.error(&found.key.clone(), found)
    })?;
    check(&scenario).map_err(|error| source.error(&error.key.clone(), error))?;
    let resolved = toml::to_string(&table).map_err(|error| {
        Error::Refused(format!("{}: cannot be written back: {error}", source.name))
    })?;
    let hash = blake3::hash(resolved.as_bytes()).to_hex().to_string();
    Ok(Loaded {
        scenario,
        resolved,
        hash,
        source,
    })
}

/// A folder with `scenario.toml`, a file, or a name under `scenarios/`.
fn find(scenario: &str) -> Result<PathBuf, Error> {
    let given = Path::new(scenario);
    let named = Path::new("scenarios").join(scenario);
    for candidate in [given, &named] {
        if candidate.is_file() {
            return Ok(candidate.to_path_buf());
        }
        let inside = candidate.join("scenario.toml");
        if inside.is_file() {
            return Ok(inside);
        }
    }
    Err(Error::Refused(format!(
        "no scenario `{scenario}`: give a folder with scenario.toml, a file, or a name under scenarios/{}",
        known_scenarios()
    )))
}

fn known_scenarios() -> String {
    let names: Vec<String> = std::fs::read_dir("scenarios")
        .into_iter()
        .flatten()
        .flatten()
        .filter(|entry| entry.path().join("scenario.toml").is_file())
        .filter_map(|entry| entry.file_name().into_string().ok())
        .collect();
    match names.is_empty() {
        true => String::new(),
        false => format!(" (here: {})", names.join(", ")),
    }
}

fn syntax_error(source: &Source, error: &toml::de::Error) -> Error {
    Error::Scenario(Box::new(ScenarioError {
        key: source.name.clone(),
        problem: format!("not valid TOML: {}", error.message()),
        help: None,
        source_file: Some(miette::NamedSource::new(&source.name, source.text.clone())),
        span: error.span().map(Into::into),
    }))
}

/// Applies one `KEY=VALUE`. VALUE is TOML; what does not parse as TOML is a string. Entries of
/// `[[participant]]` and `[[interface]]` are addressed by name.
fn apply(table: &mut toml::Table, set: &str) -> Result<(), Error> {
    let (key, value) = set.split_once('=').ok_or_else(|| {
        Error::Refused(format!(
            "--set {set}: write it as KEY=VALUE, for instance --set run.seed=2"
        ))
    })?;
    let value = parse_value(value.trim());
    let parts = segments(key.trim());
    let (last, parents) = parts
        .split_last()
        .ok_or_else(|| Error::Refused(format!("--set {set}: the key is empty")))?;
    let mut current = table;
    let mut parents = parents.iter();
    while let Some(part) = parents.next() {
        let child = current
            .entry(part.clone())
            .or_insert_with(|| toml::Value::Table(toml::Table::new()));
        current = match child {
            toml::Value::Table(inner) => inner,
            toml::Value::Array(entries) => {
                let name = parents.next().ok_or_else(|| {
                    Error::Refused(format!(
                        "--set {set}: `{part}` is a list, name one of its entries"
                    ))
                })?;
                entry_by_name(entries, name).ok_or_else(|| {
                    Error::Refused(format!("--set {set}: no `{part}` is named `{name}`"))
                })?
            }
            _ => {
                return Err(Error::Refused(format!(
                    "--set {set}: `{part}` is a value and has no keys of its own"
                )));
            }
        };
    }
    current.insert(last.clone(), value);
    Ok(())
}

/// The path and value of the first number that is not finite; entries of lists go by their name if they have one.
fn not_finite(value: &toml::Value) -> Option<(String, f64)> {
    let below = |name: String, value: &toml::Value| {
        let (key, found) = not_finite(value)?;
        Some((
            if key.is_empty() {
                name
            } else {
                format!("{name}.{key}")
            },
            found,
        ))
    };
    match value {
        toml::Value::Float(number) if !number.is_finite() => Some((String::new(), *number)),
        toml::Value::Table(table) => table
            .iter()
            .find_map(|(name, value)| below(name.clone(), value)),
        toml::Value::Array(entries) => entries.iter().enumerate().find_map(|(index, value)| {
            let name = value.get("name").and_then(toml::Value::as_str);
            below(name.map_or_else(|| index.to_string(), String::from), value)
        }),
        _ => None,
    }
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

/// Checks that need no solver: ranges, names, and who is joined to whom.
fn check(scenario: &Scenario) -> Result<(), ConfigError> {
    let run = &scenario.run;
    plain_name("run.name", &run.name)?;
    positive("run.thickness_m", run.thickness_m)?;
    if let Some(end) = run.end_s {
        positive("run.end_s", end)?;
    }
    positive("run.deadlines.setup_s", run.deadlines.setup_s)?;
    positive("run.deadlines.answer_s", run.deadlines.answer_s)?;
    positive("run.deadlines.idle_s", run.deadlines.idle_s)?;
    at_least_one(
        "run.output.signals_every_windows",
        run.output.signals_every_windows,
    )?;
    at_least_one(
        "run.output.flush_every_windows",
        run.output.flush_every_windows,
    )?;
    at_least_one("run.output.alone_steps", run.output.alone_steps.into())?;
    at_least_one("run.checkpoints_kept", run.checkpoints_kept)?;
    if run.checkpoint_every_windows.is_some_and(|every| every > 0) && !run.output.exchange {
        return Err(ConfigError::new(
            "run.checkpoint_every_windows",
            "a resumed run goes on with the log of the first, and run.output.exchange is false",
        )
        .help("let run.output.exchange be true, or write no checkpoints"));
    }
    check_participants(scenario)?;
    match (scenario.participant.len(), scenario.interface.as_slice()) {
        (1, []) => Ok(()),
        (count, []) => Err(ConfigError::new(
            "interface",
            format!("{count} participants and nothing that joins them"),
        )
        .help("add [[interface]], or keep one participant, which then runs alone")),
        (_, interfaces) => check_interfaces(scenario, interfaces),
    }
}

fn check_interfaces(scenario: &Scenario, interfaces: &[Interface]) -> Result<(), ConfigError> {
    for (index, interface) in interfaces.iter().enumerate() {
        check_interface(scenario, interface, index)?;
        for before in &interfaces[..index] {
            check_two_interfaces(before, interface, index)?;
        }
    }
    for (index, participant) in scenario.participant.iter().enumerate() {
        let joined = |interface: &Interface| interface.participants().contains(&&*participant.name);
        if !interfaces.iter().any(joined) {
            return Err(ConfigError::new(
                &format!("participant[{index}].name"),
                format!("no interface joins `{}`", participant.name),
            )
            .help("add an [[interface]] with one of its sets, or run it alone"));
        }
    }
    for group in scenario.groups() {
        for index in &group[1..] {
            check_one_solution(&interfaces[group[0]], &interfaces[*index], *index)?;
        }
    }
    Ok(())
}

/// Names and sets belong to one interface.
fn check_two_interfaces(
    before: &Interface,
    interface: &Interface,
    index: usize,
) -> Result<(), ConfigError> {
    if before.name == interface.name {
        return Err(ConfigError::new(
            &format!("interface[{index}].name"),
            format!("the name `{}` is taken", interface.name),
        ));
    }
    match interface
        .between
        .iter()
        .find(|side| before.between.contains(side))
    {
        None => Ok(()),
        Some(set) => Err(ConfigError::new(
            &format!("interface[{index}].between"),
            format!(
                "`{set}` is joined by the interface `{}` already",
                before.name
            ),
        )
        .help("one interface carries a set: name another set of the participant")),
    }
}

/// Connected interfaces are solved together, so that they have one value of each key that says how.
fn check_one_solution(
    first: &Interface,
    interface: &Interface,
    index: usize,
) -> Result<(), ConfigError> {
    let agree = [
        ("scheme", first.scheme == interface.scheme),
        ("repeats_max", first.repeats_max == interface.repeats_max),
        ("compliance", first.compliance == interface.compliance),
        ("acceleration", first.acceleration == interface.acceleration),
        ("relaxation", first.relaxation == interface.relaxation),
        (
            "on_not_converged",
            first.on_not_converged == interface.on_not_converged,
        ),
    ];
    match agree.iter().find(|(_, same)| !same) {
        None => Ok(()),
        Some((key, _)) => Err(ConfigError::new(
            &format!("interface[{index}].{key}"),
            format!(
                "differs from that of the interface `{}`, which is connected through participants and solved together with `{}`",
                first.name, interface.name
            ),
        )
        .help("give both the same value")),
    }
}

fn check_participants(scenario: &Scenario) -> Result<(), ConfigError> {
    if scenario.participant.is_empty() {
        return Err(ConfigError::new(
            "participant",
            "a run needs at least one participant",
        ));
    }
    for (index, participant) in scenario.participant.iter().enumerate() {
        let key = format!("participant[{index}].name");
        plain_name(&key, &participant.name)?;
        let twice = scenario.participant[..index]
            .iter()
            .any(|p| p.name == participant.name);
        if twice || participant.name == "coupler" || participant.name == "coordinator" {
            return Err(ConfigError::new(
                &key,
                format!("the name `{}` is taken", participant.name),
            ));
        }
        if participant
            .command
            .as_ref()
            .is_some_and(|command| command.is_empty())
        {
            return Err(ConfigError::new(
                &format!("participant[{index}].command"),
                "is empty: give the program and its arguments, or leave the key out",
            ));
        }
    }
    Ok(())
}

fn check_interface(
    scenario: &Scenario,
    interface: &Interface,
    index: usize,
) -> Result<(), ConfigError> {
    let key = |name: &str| format!("interface[{index}].{name}");
    plain_name(&key("name"), &interface.name)?;
    at_least_one(&key("substeps"), interface.substeps.into())?;
    at_least_one(&key("repeats_max"), interface.repeats_max.into())?;
    positive(&key("tolerance_rel"), interface.tolerance_rel)?;
    positive(&key("relaxation"), interface.relaxation)?;
    if let Some(bound) = interface.energy_defect_max_rel {
        positive(&key("energy_defect_max_rel"), bound)?;
    }
    if interface.relaxation > 1.0 {
        return Err(ConfigError::new(
            &key("relaxation"),
            format!("must be at most 1, got {}", interface.relaxation),
        ));
    }
    let mut joined = Vec::new();
    for side in &interface.between {
        let names: Vec<&str> = scenario
            .participant
            .iter()
            .map(|p| p.name.as_str())
            .collect();
        let Some((participant, _)) = side.split_once('.') else {
            return Err(ConfigError::new(
                &key("between"),
                format!("`{side}` must be written participant.set, for instance rail.top"),
            ));
        };
        if !names.contains(&participant) {
            let error = ConfigError::new(
                &key("between"),
                format!("no participant is named `{participant}`"),
            );
            return Err(match nearest(participant, &names) {
                Some(near) => error.help(format!("did you mean `{near}`?")),
                None => error.help(format!("participants: {}", names.join(", "))),
            });
        }
        joined.push(participant);
    }
    if joined[0] == joined[1] {
        return Err(ConfigError::new(
            &key("between"),
            "joins a participant with itself",
        ));
    }
    Ok(())
}

fn positive(key: &str, value: f64) -> Result<(), ConfigError> {
    match value > 0.0 && value.is_finite() {
        true => Ok(()),
        false => Err(ConfigError::new(
            key,
            format!("must be a positive number, got {value}"),
        )),
    }
}

fn at_least_one(key: &str, value: u64) -> Result<(), ConfigError> {
    match value {
        0 => Err(ConfigError::new(key, "must be at least 1, got 0")),
        _ => Ok(()),
    }
}

/// A name that can be a file name on any system: letters, digits, `-` and `_`.
fn plain_name(key: &str, name: &str) -> Result<(), ConfigError> {
    let plain = name
        .chars()
        .all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_');
    match plain && !name.is_empty() && name.len() <= 64 {
        true => Ok(()),
        false => Err(ConfigError::new(
            key,
            format!("`{name}` must be 1 to 64 letters, digits, `-` or `_`: it becomes a file name"),
        )),
    }
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

    fn read(text: &str, overrides: &[&str]) -> Result<Loaded, Error> {
        let source = Source {
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
    fn what_is_not_toml_is_a_string() {
        let loaded = read(SMALL, &["run.transport=channel"]).expect("valid");
        assert_eq!(
            loaded.scenario.run.transport,
            super::super::TransportKind::Channel
        );
    }

    #[test]
    fn an_unknown_key_is_named_where_it_stands() {
        let error = read(&SMALL.replace("thickness_m", "thikness_m"), &[]).expect_err("mistyped");
        assert_eq!(key_of(error), "run.thikness_m");
    }

    #[test]
    fn a_number_that_is_not_finite_is_named() {
        let error = read(&SMALL.replace("8000.0", "nan"), &[]).expect_err("not a number");
        assert_eq!(key_of(error), "participant.rail.config.wheel.load_n");
    }

    #[test]
    fn a_negative_thickness_is_refused() {
        let error = read(&SMALL.replace("1e-3", "-1e-3"), &[]).expect_err("negative");
        assert_eq!(key_of(error), "run.thickness_m");
    }
}
