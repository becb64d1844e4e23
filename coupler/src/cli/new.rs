//! `thirdbody new`: copy a built-in scene, to edit it.

use std::fs;
use std::path::{Path, PathBuf};

use super::common::{VerbResult, print};
use super::explain::keys;
use coordinator::participants::Registry;
use scenario::error::{Error, Refusal};
use scenario::overrides::leaves;
use scenes::{STUDY, kept};

/// Arguments of `new`.
#[derive(Debug, clap::Args)]
pub struct NewArguments {
    /// Scene or study to copy; `thirdbody scenes` lists them.
    name: String,
    /// Folder for the copy, new or empty (default: the last part of NAME, in the current folder).
    dir: Option<PathBuf>,
}

/// Copies a scene or a study with all its files, adds a comment to each key, and prints the next commands.
pub fn new(arguments: &NewArguments, registry: &Registry) -> VerbResult {
    let name = known(&arguments.name)?;
    let mut files = scenes::files_of(&name);
    // The stored results belong to the unchanged study.
    files.retain(|(file, _)| *file != "study.json");
    if files.iter().any(|(file, _)| *file == "Cargo.toml") {
        let problem = "is a crate that needs the source tree around it: `thirdbody new-node rust NAME` writes a similar one that finds its dependencies";
        return Err(Refusal::argument(name, problem).into());
    }
    let last = Path::new(&name).file_name().map(PathBuf::from);
    let folder = arguments.dir.clone().or(last).unwrap_or_default();
    require_empty(&folder)?;
    kept::write(&files, &folder)?;
    let path = folder.join("scenario.toml");
    if let Ok(text) = fs::read_to_string(&path) {
        let text = renamed(text, &name, &folder);
        let text = commented(&text, &keys(registry));
        fs::write(&path, text).map_err(Error::output(path.display()))?;
    }
    for (file, _) in &files {
        print(&folder.join(file).display().to_string())?;
    }
    print(&next(&files, &folder))
}

/// Names the run of a copied scene after its folder, and records the name of the original scene.
fn renamed(text: String, scene: &str, folder: &Path) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    let name = folder.file_name().and_then(|name| name.to_str());
    let name = name.filter(|name| name.chars().all(plain));
    let first = text.lines().find(|line| line.starts_with("name = "));
    match (name, first) {
        (Some(name), Some(line)) if line != format!("name = \"{name}\"") => {
            let new = format!("name = \"{name}\"\nderived_from = \"{scene}\"");
            text.replacen(line, &new, 1)
        }
        _ => text,
    }
}

/// A scenario with the first sentence on each key above the key's line.
fn commented(text: &str, keys: &[(String, String)]) -> String {
    let (mut section, mut kind) = (String::new(), String::new());
    let (mut all, mut statement) = (String::new(), String::new());
    for line in text.lines() {
        let header = statement.is_empty() && line.starts_with('[');
        statement += &format!("{line}\n");
        if header {
            let name = line.trim_start_matches('[').split(']').next();
            section = name.unwrap_or_default().to_string();
        }
        // The statement continues on the next line.
        let Ok(table) = statement.parse::<toml::Table>() else {
            continue;
        };
        if let Some(own) = table.get("kind").filter(|_| section == "participant") {
            kind = format!("config ({})", own.as_str().unwrap_or_default());
        }
        let path = match section.split_once('.') {
            Some(("participant", own)) => {
                format!("participant.NAME.{}", own.replacen("config", &kind, 1))
            }
            None if section != "run" => format!("{section}.NAME"),
            _ => section.clone(),
        };
        // All entries of a list share one key.
        let named = |key: &str| {
            let parts = key.split('.').filter(|part| part.parse::<usize>().is_err());
            parts.collect::<Vec<&str>>().join(".")
        };
        let mut own: Vec<String> = leaves(&table).iter().map(|(key, _)| named(key)).collect();
        own.dedup();
        for key in own.iter().filter(|_| !header) {
            let path = format!("{path}.{key}");
            let text = keys.iter().find(|(known, _)| *known == path);
            let sentence = text.and_then(|(_, text)| text.split_inclusive(". ").next());
            if let Some(sentence) = sentence.filter(|sentence| !sentence.is_empty()) {
                all += &format!("# {key}: {}\n", sentence.trim_end());
            }
        }
        all += &statement;
        statement.clear();
    }
    all + &statement
}

/// The folder of a built-in scene or study.
fn known(name: &str) -> Result<String, Error> {
    let plain = name.trim_end_matches('/');
    if scenes::names().contains(&plain) {
        return Ok(plain.into());
    }
    scenes::study_folder(plain).ok_or_else(|| {
        let meant = scenes::meant(plain, false).or_else(|| scenes::meant(plain, true));
        let meant = meant.map_or(String::new(), |near| format!("; did you mean `{near}`?"));
        let problem = format!("is no scene or study that `thirdbody scenes` lists{meant}");
        Refusal::argument(name, problem).into()
    })
}

fn require_empty(folder: &Path) -> Result<(), Error> {
    let empty = match fs::read_dir(folder) {
        Ok(mut entries) => entries.next().is_none(),
        Err(_) => !folder.exists(),
    };
    if empty {
        return Ok(());
    }
    let problem = "exists and is not empty: nothing is overwritten, give another folder as the second argument";
    Err(Refusal::file(folder, problem).into())
}

/// The next commands to run.
fn next(files: &[(&str, &[u8])], folder: &Path) -> String {
    // A folder takes precedence over a built-in scene of the same name.
    let place = folder.display();
    if files.iter().any(|(file, _)| *file == STUDY) {
        return format!(
            "next: edit {place}/{STUDY}, then\n  thirdbody study plan {place} --small\n  thirdbody study run {place} --small"
        );
    }
    format!(
        "next: edit {place}/scenario.toml, then\n  thirdbody check {place}\n  thirdbody run {place}\n  thirdbody report runs/latest"
    )
}
